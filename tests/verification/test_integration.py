# SPDX-License-Identifier: GPL-3.0-or-later
"""Members of the time integration, and supports that do not ring, on whole runs.

Their energy and transfer functions, their peaks, and the DDA member are validation cases.
"""

from pathlib import Path

import numpy as np
import pytest
from model_text import tower

import sitedda
from sitedda.response import amplifications
from sitedda_evidence.validation.integration import soil_column_text

INPUTS = Path(__file__).parents[2] / "inputs"
LISTENED = 45.0  # s: ten after the end of the record, when all has died out

# --- Supports -------------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=["theta", "backward_euler"])
def soil(request, tmp_path_factory):
    """A run of 30 m of soil at 10 ms; without damping, in midpoint steps, it would never rest."""
    file = tmp_path_factory.mktemp("soil") / "soil.nml"
    file.write_text(soil_column_text(10e-3, LISTENED, integration=request.param))
    return file, sitedda.run(file).history


def averaged_record(time: np.ndarray) -> np.ndarray:
    """Acceleration of the base (m/s²) averaged over the steps that end at these times."""
    record = sitedda.read_record(
        INPUTS / "records" / "LomaPrieta1989_USGS1002_APEEL2_133.smc", format="smc", unit="cm/s2"
    )
    velocity = np.interp(time, record.time.values, record.velocity.values, right=0.0)
    return np.diff(velocity) / np.diff(time)


def test_the_base_follows_the_record_and_rests_after_it(soil):
    _, history = soil
    time = history.time.values
    base = history.acceleration.sel(point="base").isel(axis=0).values[1:]
    record = averaged_record(time)
    after = time[1:] > 36.5  # s, the record has ended
    rest = np.sqrt(np.mean(base[after] ** 2)) / abs(base).max()
    print(f"base {abs(base).max():.4f}, record {abs(record).max():.4f} m/s², after it {rest:.1e}")
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
