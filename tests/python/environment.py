# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs of the environment that runs the tests, and the time limit of waiting for them."""

import shutil
import subprocess
import sys
import time
from pathlib import Path

NAMES = ("chromium", "chromium-browser", "google-chrome")
BROWSER = next(filter(None, map(shutil.which, NAMES)), "")
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
DEADLINE = 900  # wall-clock limit of a test that hangs, s; also sufficient on a busy machine


def executable(name: str) -> str:
    """Return the path of a program in the environment of the tests, or in PATH."""
    beside = Path(sys.executable).parent / name
    path = str(beside) if beside.exists() else shutil.which(name)
    assert path, f"{name} is not installed"
    return path


def wait_for(condition, process: subprocess.Popen | None = None) -> None:
    """Wait until a condition is true; fail if the process ends before."""
    end = time.monotonic() + DEADLINE
    while not condition():
        assert process is None or process.poll() is None, process.communicate()
        assert time.monotonic() < end, "the condition remains false"
        time.sleep(0.02)


def captured(command, **options) -> subprocess.CompletedProcess:
    """Run a command to its end; return its status and output as text."""
    options = {"timeout": DEADLINE} | options
    return subprocess.run(command, capture_output=True, text=True, **options)
