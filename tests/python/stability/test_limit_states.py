# SPDX-License-Identifier: GPL-3.0-or-later
"""Static stages of random arches and walls rest below the limit loads and fall above them.

Long modes are commands in tests/robustness: limit_states.py, limit_loads.py, removable_blocks.py.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "robustness"))

import removable_blocks  # noqa: E402
from limit_loads import BOUND, CLOSED, EXACT, bound, judged, unbalanced, wrong  # noqa: E402
from limit_models import assemblies  # noqa: E402
from limit_states import ABOVE, BELOW, slow_outcome, static_outcome  # noqa: E402


@pytest.fixture(scope="module")
def models():
    return list(assemblies(6))


def test_static_stages_rest_below_the_lower_limit(models):
    for assembly, limits in models:
        outcome = static_outcome(assembly, BELOW * limits.lower.factor)
        assert outcome.at_rest and not outcome.remarks, f"{assembly.name}: {outcome.remarks}"


def test_static_stages_fail_above_the_upper_limit(models):
    for assembly, limits in models:
        assert not static_outcome(assembly, ABOVE * limits.upper.factor).at_rest, assembly.name


def test_a_slowly_increasing_force_has_the_same_limits(models):
    for assembly, limits in models:
        assert slow_outcome(assembly, BELOW * limits.lower.factor).at_rest, assembly.name
        assert not slow_outcome(assembly, ABOVE * limits.upper.factor).at_rest, assembly.name


def test_limits_differ_if_blocks_are_wedged(models):
    ratios = [limits.lower.factor / limits.upper.factor for _, limits in models]
    assert max(ratios) <= 1 + 1e-6 and min(ratios) < 0.98


@pytest.mark.parametrize("number", [4, 6, 7])  # dry, bonded and crushing, with bolts and water
def test_loaded_models_rest_and_fail_at_their_limits(number):
    loaded, limits = next(judged(number + 1, number))
    assert not wrong(loaded, limits)


def test_wrong_proofs_of_limits_are_detected():
    loaded, limits = next(judged(5, 4))
    upper = limits.upper
    force = upper.normal_force * (1 + 1e-3 * (np.arange(len(upper.points)) == 0))
    assert unbalanced(loaded, replace(upper, normal_force=force)) > EXACT
    assert unbalanced(loaded, replace(upper, factor=1.001 * upper.factor)) > EXACT
    pulled = {name: 1.5 * force for name, force in upper.bolt_force.items()}
    assert pulled and unbalanced(loaded, replace(upper, bolt_force=pulled)) > EXACT
    ways = upper.displacement * (1 + 0.01 * (np.arange(3) == 0))
    factor, lacks = bound(loaded, replace(upper, displacement=ways))
    assert abs(factor / upper.factor - 1) > BOUND or lacks > CLOSED


def test_a_slope_moves_its_removable_blocks():
    description, agree = removable_blocks.compare(2)
    assert agree, description


def test_no_block_of_a_slope_falls_vertically():
    model, dip, _ = removable_blocks.random_slope(np.random.default_rng(1))
    polygons = [np.reshape(group.vertices, (-1, 2)) for group in model.of_kind("block")]
    assert removable_blocks.removable(polygons, dip).any()
    assert not removable_blocks.removable(polygons, 90.0).any()
