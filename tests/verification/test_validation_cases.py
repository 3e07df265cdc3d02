# SPDX-License-Identifier: GPL-3.0-or-later
"""Each validation case in its short form: all rows are within their tolerances."""

import pytest

from sitedda_evidence.catalogue import VALIDATION, run_case
from sitedda_evidence.report import terminal_text

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("name", list(VALIDATION.cases))
def test_case_passes_in_its_short_form(name):
    result = run_case(name, short=True)
    assert result.rows or result.engine_error, "a case without rows proves nothing"
    assert result.passed, terminal_text(result)


def test_required_cases_exist():
    required = {
        "incline", "newmark", "shaking_base", "rocking_decay", "rocking_onset", "overturning",
        "bounce", "bars", "slip_joint", "rotation", "tilt", "toppling", "arch", "many_blocks",
        "edge", "packing", "settlement", "damping", "cantilever", "supports",
        "integration", "crossings", "gravity_ramp",
    }  # fmt: skip
    assert required <= set(VALIDATION.cases)
