# SPDX-License-Identifier: GPL-3.0-or-later
"""Instruction counts of the benchmarks: models, reports and limits."""

import json
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
import compare
import counts

STATED = json.loads(counts.FILE.read_text())["counts"]


def test_each_model_exists_and_has_a_stated_count():
    assert counts.STEPS.keys() <= compare.cases().keys()
    assert STATED.keys() == counts.STEPS.keys()
    assert all(number > 1000 for number in STATED.values())


@pytest.mark.parametrize(("growth", "lines"), [(0.5, 0), (1.019, 0), (1.021, 5)])
def test_only_growth_above_the_tolerance_is_an_error(growth, lines):
    assert (
        len(counts.excesses({name: int(growth * n) for name, n in STATED.items()}, STATED)) == lines
    )


def test_a_model_without_stated_count_is_an_error():
    assert counts.excesses({"new model": 1}, STATED) == [
        "new model: counts.json states no count; --write adds it"
    ]


def test_counts_are_read_from_the_report_of_callgrind():
    assert (
        counts.read_count("==7== Collected : 12\n==7== \n==7== I   refs:      989,893,039\n")
        == 989893039
    )
