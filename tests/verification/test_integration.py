# SPDX-License-Identifier: GPL-3.0-or-later
"""Members of the time integration, and supports that do not ring, on whole runs.

Their energy and transfer functions, their peaks, and the DDA member are validation cases.
"""

import numpy as np
import pytest
from model_text import tower

import sitedda
from sitedda.response import amplifications
from sitedda_evidence.validation.integration import base_and_record, soil_column_text

LISTENED = 45.0  # s: ten after the end of the record, when all has died out

# --- Supports -------------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=["theta", "backward_euler"])
def soil(request, tmp_path_factory):
    """A run of 30 m of soil at 10 ms; without damping, in midpoint steps, it would never rest."""
    file = tmp_path_factory.mktemp("soil") / "soil.nml"
    file.write_text(soil_column_text(10e-3, LISTENED, integration=request.param))
    return file, sitedda.run(file).history


def test_the_base_follows_the_record_and_rests_after_it(soil):
    base, record, rest = base_and_record(soil[1])
    assert abs(base).max() == pytest.approx(abs(record).max(), rel=0.03)
    assert rest < 1e-6


def test_the_soils_peak_is_that_of_the_transfer_function(soil):
    file, history = soil
    peak = amplifications(history)[0].peak
    near = np.linspace(peak.frequency - 0.1, peak.frequency + 0.1, 401)
    curve = abs(sitedda.transfer(file, near))
    assert abs(peak.frequency - near[np.argmax(curve)]) <= 2e-3
    assert peak.amplitude == pytest.approx(curve.max(), rel=1e-4)


def test_supports_of_any_stiffness_leave_the_base_its_motion(tmp_path):
    file = tmp_path / "soil.nml"
    file.write_text(soil_column_text(10e-3, 20.0))
    bases = [
        sitedda.run(file, contact={"fixed_point_ratio": ratio})
        .history.acceleration.sel(point="base")
        .isel(axis=0)
        .values
        for ratio in (10.0, 1e4)
    ]
    assert abs(bases[0] - bases[1]).max() < 1e-3 * abs(bases[1]).max()


# --- The same bits --------------------------------------------------------------------------------


@pytest.mark.parametrize("stop", [1, 35, 137])  # 35: within the pulse
def test_a_resumed_run_has_the_bits_of_one_left_alone(write_input, in_parts, same_bits, stop):
    """The supports' velocity of the motion is a state where χ > 1/2."""
    loose = {"name": "bedding", "friction_angle": 5.0}
    file = write_input(tower(4, 300, loose, gravity=[0.0, -9.81], integration="theta"))
    same_bits(sitedda.run(file).history, in_parts(file, stop))
