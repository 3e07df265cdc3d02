# SPDX-License-Identifier: GPL-3.0-or-later
"""The verification tests write their inputs with the helpers of the package's tests."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "python"))

from model_text import namelist  # noqa: E402


@pytest.fixture
def write_input(tmp_path):
    """Write groups as an input file in the test's own folder."""

    def write(groups, name: str = "model.nml") -> Path:
        file = tmp_path / name
        file.write_text(namelist(groups))
        return file

    return write


@pytest.fixture(scope="session")
def root() -> Path:
    """Top of the source tree."""
    return Path(__file__).parents[2]
