# SPDX-License-Identifier: GPL-3.0-or-later
"""Free-field sides: level ground moves as its column, hills radiate, state and verdict."""

import numpy as np
import pytest
from lattices import DENSITY, MODULUS, lattice, moved

import sitedda

HILL = (5, 6)  # columns of an unsymmetric hill
WEIGHT = {"gravity": (0.0, -9.81), "settle": True}


BODIES = pytest.mark.parametrize("body", ["", "ground"], ids=["glued", "body"])
CONSTANT = {"damping_ratio": 0.03, "reference_frequency": 20.0}
RAYLEIGH = {"rayleigh_alpha": 3.0, "rayleigh_beta": 1e-4}


@BODIES
@pytest.mark.parametrize("integration", ["dda", "midpoint", "theta"])
@pytest.mark.parametrize("direction", ["x", "y"])
def test_level_ground_moves_as_its_column(integration, direction, body):
    """Ground ten times as wide as deep: each block within 1e-8 of the peak; not with free sides."""
    column = moved(lattice("tied", direction, 1, integration=integration, body=body), 1)
    ground = moved(lattice("free_field", direction, 30, integration=integration, body=body), 30)
    peak = abs(column).max()
    assert abs(ground - column).max() < 1e-8 * peak
    if integration == "dda":
        motion = moved(lattice("free", direction, 30, body=body), 30)
        assert abs(motion - column).max() > 0.01 * peak


@BODIES
@pytest.mark.parametrize("damping", [CONSTANT, RAYLEIGH], ids=["constant", "rayleigh"])
def test_damped_ground_moves_as_its_column(damping, body):
    column = moved(lattice("tied", columns=1, body=body, damping=damping, **WEIGHT), 1)
    ground = moved(lattice("free_field", body=body, damping=damping, **WEIGHT))
    assert abs(ground - column).max() < 1e-8 * abs(column).max()


@BODIES
@pytest.mark.parametrize("control", [WEIGHT, {"time_step_control": "adaptive"}])
def test_the_column_has_weight_and_steps_of_the_model(control, body):
    column = moved(lattice("tied", columns=1, body=body, **control), 1)
    ground = moved(lattice("free_field", body=body, **control))
    assert abs(ground - column).max() < 1e-8 * abs(column).max()


def test_the_column_ends_at_the_first_vertical_line_between_blocks():
    """With blocks of two widths, the column is one period."""

    def ground(periods: int, sides: str):
        model = lattice("free", columns=2 * periods, rows=2)
        for i in range(periods):
            x = 2 * i
            wide = [x, 2, x + 2, 2, x + 2, 3, x, 3]
            model.block(wide, name=f"wide_{i}", material="layer_1")
        for side in ("left", "right") if sides == "free_field" else (None,):
            model.boundary(kind=sides, side=side)
        return moved(model, 2 * periods, 2)

    column = ground(1, "tied")
    several = ground(4, "free_field").reshape(-1, 2, 4, 2, 2)
    assert abs(several - column[:, :, None]).max() < 1e-8 * abs(column).max()


def test_a_mirrored_hill_has_the_mirrored_motion():
    motion = moved(lattice("free_field", hill=HILL))
    mirrored = [9 - i for i in HILL]
    mirrored_motion = moved(lattice("free_field", order=-1, acceleration=-1.0, hill=mirrored))
    mirrored_motion = mirrored_motion[:, :, ::-1] * [-1, 1]
    np.testing.assert_allclose(motion, mirrored_motion, atol=1e-10 * abs(motion).max())


@BODIES
def test_waves_from_a_hill_leave_through_the_sides(body):
    """Ten columns move as in ground that is too wide for reflections from its sides."""
    hill = [30 + i for i in HILL]
    wide = moved(lattice("tied", columns=70, hill=hill, body=body), 70)[:, :, 30:40]
    error = {
        sides: abs(moved(lattice(sides, hill=HILL, body=body)) - wide).max() / abs(wide).max()
        for sides in ("free_field", "viscous", "free")
    }
    assert error["free_field"] < 0.04
    assert error["viscous"] > 5 * error["free_field"]
    assert error["free"] > 3 * error["free_field"]


@BODIES
def test_nothing_moves_when_free_fields_replace_supports(body):
    """Less than 1e-9 of the settlement at the change of stage, beside a hill."""
    model = lattice("free_field", hill=HILL, acceleration=0.0, duration=0.5, body=body, **WEIGHT)
    sag = DENSITY * 9.81 * 3.0**2 / 2 / (1.2 * MODULUS)
    assert abs(moved(model)).max() < 1e-9 * sag


@BODIES
def test_energy_balances_and_runs_are_bit_identical(tmp_path, body, same_everywhere):
    damping = CONSTANT if body else None
    model = lattice("free_field", hill=HILL, body=body, damping=damping, **WEIGHT)
    model.measured_point("crest", 6.0, 4.0)
    history = same_everywhere(model.write(tmp_path / "hill.nml"), 77)
    work = history.energy_damping.values[-1] + abs(history.energy_input).values.max()
    assert abs(history.energy_balance.values).max() < 1e-6 * work


def test_changes_between_steps_reach_the_column():
    """Half of the weight is removed: ground and column rise equally."""
    rise = {}
    for sides, columns in (("tied", 1), ("free_field", 6)):
        with sitedda.Simulation(lattice(sides, columns=columns, **WEIGHT)) as simulation:
            simulation.advance(20)
            simulation.change({"gravity": (0.0, -4.9)})
            first = simulation.coordinates.copy()
            simulation.advance(20)
            rise[sides] = (simulation.coordinates - first)[:, 1].reshape(3, columns)
    assert abs(rise["free_field"] - rise["tied"]).max() < 1e-8 * abs(rise["tied"]).max()


def left_field(model):
    model.boundary(kind="free_field", side="left")


def left_field_beside(*vertices):
    """Add a block to the lattice, and a free field at its left side."""

    def change(model):
        model.block(vertices, material="layer_0")
        left_field(model)

    return change


STIFF = {"normal_stiffness_per_area": 1e10, "shear_stiffness_per_area": 1e10}
ORIGINAL = {"contact_rules": "original", "force_tolerance": None}


@pytest.mark.parametrize(
    ("sides", "values", "change", "message"),
    [
        ("free_field", {}, left_field, "already has a free field"),
        ("tied", {}, left_field, "both continue the ground beyond a side"),
        ("free", {"rows": 1}, left_field_beside(-0.5, 1, 3.5, 1, 3.5, 2, -0.5, 2),
         "no vertical line passes between the blocks"),
        ("free", {"rows": 1}, left_field_beside(0, 1, 1, 1, 1, 1.5, 0, 2),
         "does not match its own image"),
        ("free_field", {}, lambda m: m.contact(**ORIGINAL), "contact_rules = 'original'"),
        ("free_field", {"dynamic_factor": 0.9}, lambda m: None,
         "dynamic_factor of &control must be 1"),
        ("free_field", {}, lambda m: m["joint"][0](**STIFF),
         "give the edges at the sides another joint"),
        ("free_field", {}, lambda m: m.traction(side="top", normal=1e3), "leave out the blocks"),
        ("free_field", {"duration": None},
         lambda m: m.stage("dig", remove="b_0_2", duration=0.1), "excavate farther from this side"),
    ],
)  # fmt: skip
def test_unsupported_combinations_with_a_free_field_are_refused(sides, values, change, message):
    model = lattice(sides, columns=3, **values)
    change(model)
    with pytest.raises(sitedda.InputError, match=message) as error_info:
        model.check()
    assert str(error_info.value).startswith("Model.boundary(…), ")


def test_a_transfer_function_does_not_support_the_free_field():
    model = lattice("free_field", columns=3)
    model.measured_point("surface", 1.5, 3.0)
    with pytest.raises(sitedda.InputError, match="use kind = 'tied' for level ground"):
        sitedda.transfer(model, [5.0], base=None)
