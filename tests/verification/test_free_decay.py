# SPDX-License-Identifier: GPL-3.0-or-later
"""Free decay of the paper's column in its lowest modes: the damping of the scheme, no other."""

import numpy as np
import pytest
from model_text import namelist, tower, without

import sitedda
from sitedda_evidence.paper.discrete import DiscreteModel
from sitedda_evidence.validation.waves import amplification_invariants, fit_invariants


def column(steps: int) -> list:
    """15 layers of table I on a base block that is held still."""
    groups = without(tower(15, steps), "motion")
    return [(name, values | {"motion_x": None}) for name, values in groups]


@pytest.fixture(scope="module")
def theory(tmp_path_factory) -> DiscreteModel:
    """The same column in numpy."""
    file = tmp_path_factory.mktemp("theory") / "column.nml"
    file.write_text(namelist(column(1)))
    return DiscreteModel.of(file)


def test_first_mode_is_the_one_of_the_paper(theory):
    # a hair below 13.961 Hz on a rigid base: here the base block and its springs give way
    assert theory.frequencies[0] == pytest.approx(13.961, abs=5e-3)


def test_no_damping_is_added_or_taken_by_the_penalty(write_input, theory):
    """Each of the five lowest modes decays as its own frequency says, at one step of 1e-3 s:
    x[n+1] = trace x[n] - determinant x[n-1] by Cayley and Hamilton, fitted to the whole decay."""
    omega = theory.omega
    file = write_input(column(400))
    for mode in range(5):
        shape = theory.mode(mode) / np.max(np.abs(theory.mode(mode)))
        points = [0.0]
        weight = theory.mass @ shape  # projects on this mode alone
        with sitedda.Simulation(file) as simulation:
            start = simulation.coordinates
            simulation.rates = (1e-6 * omega[mode] * shape).reshape(16, 6)
            for _ in range(200):
                simulation.advance()
                points.append(weight @ (simulation.coordinates - start).ravel())
        expected = amplification_invariants(1.0, 0.5, omega[mode] * 1e-3)
        assert fit_invariants(np.array(points)) == pytest.approx(expected, rel=1e-5), mode
