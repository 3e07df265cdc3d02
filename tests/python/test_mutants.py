# SPDX-License-Identifier: GPL-3.0-or-later
"""Mutants of the source: they exist in their files, and exclusions are needed."""

import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "robustness"))
import mutants


def test_each_mutant_changes_one_place_of_one_line():
    sample, _ = mutants.draw(35, 200)
    assert sample[:40] == mutants.draw(35, 40)[0] != mutants.draw(36, 40)[0]
    assert {mutant.kind for mutant in sample[:3]} == {"constant", "number", "operator"}
    for mutant in sample:
        before = (mutants.ROOT / "fortran" / mutant.file).read_text().splitlines()
        after = mutant.text().splitlines()
        changed = [pair for pair in zip(before, after, strict=True) if len(set(pair)) > 1]
        assert len(changed) == 1 and before[mutant.line - 1] == changed[0][0], mutant


def test_each_exclusion_is_needed():
    locations = [f"{file}:{name}:{kind} {match[group]}"
             for file, _, match, group, kind, name in mutants.places()]  # fmt: skip
    for why, pattern in mutants.EXCLUDED.items():
        assert any(re.match(pattern, location) for location in locations), why
    unexplained = [location for location in locations if not mutants.reason(location)]
    assert len(unexplained) > len(locations) // 2


def test_tests_that_mention_a_file_run_first():
    first = mutants.tests_of("elements/bolts.f90")[0]
    assert first.name == "test_bolts.py"
    assert mutants.times("1.0e-3_wp", 0.5) == "0.0005_wp" and mutants.times("3", 0.5) == "1"
