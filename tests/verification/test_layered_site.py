# SPDX-License-Identifier: GPL-3.0-or-later
"""Time-domain amplification of the paper's layered sites (section 2.3, tables I and II)."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import sitedda
from sitedda.response import amplifications
from sitedda.site.column import refined_peak
from sitedda_evidence.paper.discrete import DiscreteModel

TIME_STEP = 1e-3


@pytest.fixture(scope="module", params=["layered_site.nml", "layered_site_table2.nml"])
def site(request):
    """Return the amplification of a run, its history, and the exact discrete theory."""
    file = Path(__file__).parents[2] / "inputs" / request.param
    history, model = sitedda.run(file).history, DiscreteModel.of(file)

    def ratio(frequency):
        return model.transfer_function(frequency, TIME_STEP, "surface", "base", "displacement")

    return amplifications(history)[0], history, ratio


def test_peak_is_that_of_the_exact_discrete_theory(site):
    peak, _, ratio = site
    exact = refined_peak(ratio, (12.0, 16.0), 30)
    assert abs(peak.peak.frequency - exact.frequency) <= 1e-4
    assert abs(peak.peak.amplitude / exact.amplitude - 1) <= 1e-5


def test_the_whole_curve_is_that_of_the_exact_discrete_theory(site):
    curve, _, ratio = site
    samples = np.linspace(0, curve.frequency.size - 1, 60).astype(int)
    assert_allclose(curve.ratio[samples], abs(ratio(curve.frequency[samples])), rtol=1e-4)


def test_a_bonded_stack_never_opens_or_slides(site):
    _, history, _ = site
    assert int(history.iterations.max()) == 1
    rounding = 1e-12 * float(history.energy_kinetic.max())
    assert float(abs(history.energy_friction).max()) < rounding
    assert float(history.energy_fracture[-1]) == 0.0


def test_the_energy_balance_is_closed(site):
    _, history, _ = site
    scale = float(history.energy_kinetic.max())
    assert float(abs(history.energy_balance).max()) < 1e-6 * scale
