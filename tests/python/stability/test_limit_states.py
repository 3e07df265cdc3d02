# SPDX-License-Identifier: GPL-3.0-or-later
"""Static stages of random arches and walls rest below the limits of equilibrium and fall above.

The long mode is a command: tests/robustness/limit_states.py.
"""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "robustness"))

from limit_models import assemblies  # noqa: E402
from limit_states import ABOVE, BELOW, slow_outcome, static_outcome  # noqa: E402

FEW = 20  # blocks of models that are let fall in static steps: larger ones fall for seconds


@pytest.fixture(scope="module")
def models():
    return list(assemblies(6))


def test_static_stages_rest_below_the_lower_limit(models):
    for assembly, limits in models:
        outcome = static_outcome(assembly, BELOW * limits.lower.factor)
        assert outcome.rests and not outcome.words, f"{assembly.name}: {outcome.words}"


def test_static_stages_fall_above_the_upper_limit(models):
    few = [one for one in models if len(one[0].polygons) <= FEW]
    assert len(few) >= 2
    for assembly, limits in few:
        assert not static_outcome(assembly, ABOVE * limits.upper.factor).rests, assembly.name


def test_a_force_that_grows_slowly_has_the_same_limits(models):
    for assembly, limits in models:
        assert slow_outcome(assembly, BELOW * limits.lower.factor).rests, assembly.name
        assert not slow_outcome(assembly, ABOVE * limits.upper.factor).rests, assembly.name


def test_limits_lie_apart_where_blocks_wedge_each_other(models):
    apart = [one.lower.factor / one.upper.factor for _, one in models]
    assert max(apart) <= 1 + 1e-6 and min(apart) < 0.98
