# SPDX-License-Identifier: GPL-3.0-or-later
"""Schemes of the time integration, and supports without spurious oscillation, in whole runs.

Validation cases test energies, transfer functions, peaks and the original DDA scheme.
"""

import pytest
from model_text import tower

import sitedda
from sitedda_evidence.validation.integration import soil_column_text

# --- Supports -------------------------------------------------------------------------------------


def test_supports_of_any_stiffness_do_not_change_the_base_motion(tmp_path):
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


# --- Resumed runs --------------------------------------------------------------------------------


@pytest.mark.parametrize("stop_step", [1, 35, 137])  # 35: within the pulse
def test_a_resumed_run_equals_an_uninterrupted_one(write_input, in_parts, same_bits, stop_step):
    """For χ > 1/2, the velocity of the supports' motion is part of the state."""
    bedding = {"name": "bedding", "friction_angle": 5.0}
    file = write_input(tower(4, 300, bedding, gravity=[0.0, -9.81], integration="theta"))
    same_bits(sitedda.run(file).history, in_parts(file, stop_step))
