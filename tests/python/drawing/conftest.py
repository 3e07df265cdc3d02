# SPDX-License-Identifier: GPL-3.0-or-later
"""A run of sliding blocks with hostile names, for tests of pictures and pages."""

import pytest
from model_text import namelist

import sitedda


@pytest.fixture(scope="package")
def run(tmp_path_factory) -> sitedda.Run:
    """Run the sliding blocks; the name of their input is hostile as well."""
    from test_view import sliding_blocks

    file = tmp_path_factory.mktemp("sliding") / "a&'b<i>.nml"
    file.write_text(namelist(sliding_blocks()), encoding="utf-8")
    return sitedda.run(file)
