# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs of the environment that runs the tests, and how long one may wait for them."""

import shutil
import sys
from pathlib import Path

BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), ""
)
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
DEADLINE = 900  # s of the clock: what hangs takes so long, nothing else, on a busy machine too


def executable(name: str) -> str:
    """A program of the environment that runs the tests, or of the PATH."""
    beside = Path(sys.executable).parent / name
    found = str(beside) if beside.exists() else shutil.which(name)
    assert found, f"{name} is not installed"
    return found
