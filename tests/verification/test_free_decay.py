# SPDX-License-Identifier: GPL-3.0-or-later
"""Free decay of the paper's column in its lowest modes: only the scheme adds damping."""

import numpy as np
import pytest
from model_text import namelist, tower, without

import sitedda
from sitedda_evidence.paper.discrete import DiscreteModel
from sitedda_evidence.validation.waves import amplification_invariants, fit_invariants


def column(steps: int) -> list:
    """Return the 15 layers of table I on a fixed base block."""
    groups = without(tower(15, steps), "motion")
    return [(name, values | {"motion_x": None}) for name, values in groups]


@pytest.fixture(scope="module")
def theory(tmp_path_factory) -> DiscreteModel:
    """Return the discrete theory of the same column."""
    file = tmp_path_factory.mktemp("theory") / "column.nml"
    file.write_text(namelist(column(1)))
    return DiscreteModel.of(file)


def test_the_first_frequency_is_that_of_the_paper(theory):
    # slightly below 13.961 Hz on a rigid base, because base block and springs are elastic
    assert theory.frequencies[0] == pytest.approx(13.961, abs=5e-3)


def test_each_mode_decays_at_the_rate_of_its_frequency(write_input, theory):
    """Each of the five lowest modes decays with the rate of its frequency, with Δt = 1e-3 s:
    x[n+1] = trace x[n] - determinant x[n-1] (Cayley and Hamilton), fitted to the whole decay."""
    omega = theory.omega
    file = write_input(column(400))
    for mode in range(5):
        shape = theory.mode(mode) / np.max(np.abs(theory.mode(mode)))
        points = [0.0]
        weight = theory.mass @ shape  # projects on this mode only
        with sitedda.Simulation(file) as simulation:
            start = simulation.coordinates
            simulation.rates = (1e-6 * omega[mode] * shape).reshape(16, 6)
            for _ in range(200):
                simulation.advance()
                points.append(weight @ (simulation.coordinates - start).ravel())
        expected = amplification_invariants(1.0, 0.5, omega[mode] * 1e-3)
        assert fit_invariants(np.array(points)) == pytest.approx(expected, rel=1e-5), mode
