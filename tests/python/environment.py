# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs of the environment that runs the tests."""

import shutil
import sys
from pathlib import Path


def executable(name: str) -> str:
    """A program of the environment that runs the tests, or of the PATH."""
    beside = Path(sys.executable).parent / name
    found = str(beside) if beside.exists() else shutil.which(name)
    assert found, f"{name} is not installed"
    return found
