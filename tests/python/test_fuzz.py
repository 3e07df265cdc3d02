# SPDX-License-Identifier: GPL-3.0-or-later
"""Random hostile files with fixed seeds, and files that once caused a failure.

The long mode is a command: tests/robustness/fuzz.py.
"""

import shutil
import sys
from collections import Counter
from pathlib import Path

import pytest

ROBUSTNESS = Path(__file__).parents[1] / "robustness"
sys.path.insert(0, str(ROBUSTNESS))

from attack import KINDS, attack, kept_case, spread  # noqa: E402
from fuzz import FILES, PYTHON_PROBE, Probe, Tally, ask_about, fuzz  # noqa: E402
from model_text import namelist  # noqa: E402
from mutations import models, unquoted  # noqa: E402

pytestmark = pytest.mark.slow

CASES = sorted(file for file in (ROBUSTNESS / "cases").iterdir() if file.is_file())
ATTACKS = sorted((ROBUSTNESS / "cases" / "attacks").iterdir())


@pytest.mark.parametrize("groups", models(), ids=lambda groups: groups[-1][0])
def test_models_are_valid_before_damage(groups, tmp_path):
    file = tmp_path / "good.nml"
    file.write_text(unquoted(namelist(groups)))
    with Probe(PYTHON_PROBE) as probe:
        tally = Tally()
        assert not ask_about(probe, "input", file, tally)
    assert tally.answers["ok"] == 1


@pytest.mark.parametrize(("kind", "count"), [("input", 400), ("record", 300)])
def test_hostile_files_are_refused_or_computed(kind, count):
    tally = fuzz(PYTHON_PROBE, kind, range(count))
    assert not tally.failures
    assert tally.answers["ok"] > count / 20
    assert tally.answers["refused"] > count / 4


@pytest.mark.parametrize("kind", FILES)
def test_hostile_files_of_lines_and_blocks_are_refused_with_a_reason(kind):
    tally = fuzz(PYTHON_PROBE, kind, range(80))
    assert not tally.failures
    assert tally.answers["refused"] > 10


@pytest.mark.parametrize("case", CASES, ids=[case.name for case in CASES])
def test_files_that_once_caused_failures(case, tmp_path):
    file = Path(shutil.copy(case, tmp_path))
    with Probe(PYTHON_PROBE) as probe:
        assert not ask_about(probe, "input" if case.suffix == ".nml" else "record", file, Tally())


def test_attacks_do_no_harm():
    counts, failures = attack(spread(90, 11, list(KINDS)))
    assert not failures
    assert set(counts) == set(KINDS)
    assert sum(outcomes["done"] for outcomes in counts.values()) >= 10


def test_attacks_that_once_succeeded():
    counts, failures = attack(lambda good: map(kept_case, ATTACKS))
    assert not failures
    assert sum(map(Counter.total, counts.values())) == len(ATTACKS) > 0
