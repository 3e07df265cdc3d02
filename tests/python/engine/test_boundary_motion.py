# SPDX-License-Identifier: GPL-3.0-or-later
"""Incoming waves and motions of boundaries; pictures; edges with two boundaries."""

import numpy as np
import pytest
from lattices import DENSITY, MODULUS, POISSON, SPEED, lattice
from test_boundaries import grid, stack

import sitedda
from sitedda.boundary_marks import draw_boundaries
from sitedda.pictures import draw
from sitedda.plot import run_picture
from sitedda.scene import Scene

STEP = 1e-3
PHASE = np.pi * np.arange(61) / 60
PULSE = np.sin(PHASE) ** 2 * np.sin(2 * PHASE)  # ends at rest
QUANTITIES = ("displacement", "velocity", "acceleration")


@pytest.mark.parametrize(("motion_is", "fraction"), [("outcrop", 0.5), ("incoming", 1.0)])
@pytest.mark.parametrize("axis", ["x", "y"])
def test_the_incoming_wave_is_that_of_the_record(motion_is, fraction, axis):
    model = stack(4, motion=PULSE, axis=axis, duration=0.1)
    model["boundary"][0](motion_is=motion_is)
    history = model.run().history.sel(boundary="base")
    record = np.interp(history.time, STEP * np.arange(PULSE.size), PULSE, right=0.0)
    acceleration = history.incoming_acceleration.sel(axis=axis).values
    np.testing.assert_allclose(acceleration, fraction * record, atol=1e-12)
    assert not np.any(history.incoming_acceleration.sel(axis="xy".strip(axis)))
    velocity = np.cumsum(acceleration[1:] + acceleration[:-1]) * STEP / 2
    np.testing.assert_allclose(history.incoming_velocity.sel(axis=axis)[1:], velocity, atol=1e-12)


def test_the_motion_of_a_base_is_the_mean_of_its_edges():
    history = stack(4, motion=PULSE, duration=0.05).run().history
    for name in QUANTITIES:
        motion_of_base = history[f"boundary_{name}"].sel(boundary="base").values
        middle = history[name].sel(point="base").values
        np.testing.assert_allclose(motion_of_base, middle, atol=1e-8 * abs(middle).max())


def test_a_matched_base_moves_as_the_incoming_plus_the_reflected_wave():
    """v(t) = v_in(t) + v_in(t − 2H/V_s) in layers with the material of the half-space."""
    height = 10.0
    model = stack(40, height, motion=PULSE, duration=0.25, integration="midpoint", penalty=2e4)
    model["boundary"][0](density=DENSITY, shear_velocity=SPEED, pressure_velocity=None)
    model["boundary"][0](motion_is="incoming")
    history = model.run().history.sel(boundary="base", axis="x")
    time, wave = history.time.values, history.incoming_velocity.values
    reflected_wave = np.interp(time - 2 * height / SPEED, time, wave, left=0.0)
    error = history.boundary_velocity.values - wave - reflected_wave
    assert abs(error).max() < 0.01 * abs(wave).max()


def test_level_ground_moves_as_the_incoming_free_field():
    history = lattice("free_field").run().history
    assert list(history.boundary.values) == ["base", "free field left", "free field right"]
    surface = lattice("tied", columns=1)
    for side, x in (("left", 0.0), ("right", 1.0)):
        surface.measured_point(side, x, 3.0)
    column = surface.run().history
    for side in ("left", "right"):
        pair = history.sel(boundary=f"free field {side}")
        for name in QUANTITIES:
            expected = column[name].sel(point=side).values
            bound = 5e-8 * abs(expected).max()
            np.testing.assert_allclose(pair[f"incoming_{name}"], expected, atol=bound)
            np.testing.assert_allclose(pair[f"boundary_{name}"], expected, atol=bound)


def test_displacements_count_from_the_stage_that_sets_them_to_zero():
    settlements = {}
    for zero in (False, True):
        model = lattice("free_field", duration=None, gravity=(0.0, -9.81))
        model.stage("rest", kind="static")
        model.stage("shaken", duration=0.02, zero_displacements=zero)
        end = model.run().history.isel(time=-1).sel(boundary="free field left", axis="y")
        settlements[zero] = [float(end[f"{kind}_displacement"])
                             for kind in ("boundary", "incoming")]  # fmt: skip
    np.testing.assert_allclose(settlements[False], -0.5 * DENSITY * 9.81 * 3.0**2 / MODULUS,
                               rtol=0.5)  # fmt: skip
    np.testing.assert_allclose(settlements[True], 0.0, atol=1e-3 * abs(settlements[False][0]))


def test_the_same_bits_from_both_programs_and_after_a_resume(tmp_path, same_everywhere):
    model = lattice("free_field", hill=(4, 5), gravity=(0.0, -9.81), settle=True)
    history = same_everywhere(model.write(tmp_path / "hill.nml"), 70)
    for name in QUANTITIES:
        assert np.any(history[f"incoming_{name}"]) and np.any(history[f"boundary_{name}"])


def test_models_without_boundaries_have_no_such_variables():
    history = lattice("free", columns=2).run().history
    assert "boundary_edge" in history
    model = sitedda.Model("bare", time_step=STEP, steps=2)
    model.material("rock", density=DENSITY, young_modulus=MODULUS, poisson_ratio=POISSON)
    model.joint("dry", friction_angle=30.0)
    model.block([0, 0, 1, 0, 1, 1, 0, 1])
    history = model.run().history
    assert not [name for name in history.variables if "boundary" in name or "incoming" in name]


def every_kind() -> sitedda.Model:
    """A lattice with a boundary of each kind that edges can have, one on half an edge."""
    model = lattice("free", columns=4, rows=4)
    model["boundary"][0](side=None, blocks="b_0_0", edges=[1])
    model.boundary("still", "fixed", blocks="b_1_0", edges=[1])
    model.boundary("moved", "fixed", blocks="b_2_0", edges=[1], motion_x="rock")
    model.boundary("roller", "roller", along=[0.0, 0.0, 0.0, 2.5])
    model.boundary("viscous", "viscous", along=[0.0, 2.5, 0.0, 4.0])
    model.boundary("ground", "free_field", side="right")
    return model


def test_boundaries_are_drawn_where_they_are(tmp_path):
    """Each kind has a legend, lines on its edges, and symbols outside the blocks."""
    model = every_kind()
    scene = Scene.of(model.write(tmp_path / "kinds.nml"))
    boundaries = scene.boundaries(0)
    kinds_and_sizes = [(boundary["kind"], len(boundary["start"])) for boundary in boundaries]
    kinds = ["compliant", "fixed", "fixed", "roller", "viscous", "free_field"]
    assert kinds_and_sizes == list(zip(kinds, (1, 1, 1, 3, 2, 4), strict=True))
    assert [i for i, boundary in enumerate(boundaries) if boundary["moved"]] == [0, 2]
    for boundary, length in zip(boundaries, (1, 1, 1, 2.5, 1.5, 4), strict=True):
        lengths = np.linalg.norm(boundary["end"] - boundary["start"], axis=1)
        assert lengths.sum() == pytest.approx(length)
    axes = draw(scene)
    legend = [text.get_text().replace("\n", " ") for text in axes.get_legend().get_texts()]
    expected = ["compliant, incoming wave", "fixed", "fixed, moved", "roller", "viscous"]
    assert [w for w in legend if w in expected] == expected and "free field beyond" in legend
    before = len(axes.collections)
    assert len(draw_boundaries(axes, scene, 0)) == 6
    added = [np.concatenate(c.get_segments()) for c in axes.collections[before:]]
    for edges, signs in zip(added[::2], added[1::2], strict=True):
        assert np.all((edges >= -1e-9) & (edges <= 4 + 1e-9))
        assert np.all(((signs <= 1e-9) | (signs >= 4 - 1e-9)).any(axis=1))
    run = model.run()
    after = Scene.of(run).boundaries(0)
    np.testing.assert_allclose(after[3]["end"], boundaries[3]["end"])
    labels = [line.get_label() for axes in run_picture(grid(duration=0.05).run().history).axes
              for line in axes.get_lines()]  # fmt: skip
    assert "incoming: base, x" in labels


def twice(first: dict, second: dict) -> sitedda.Model:
    model = lattice("free", columns=3)
    for values in (first, second):
        model.boundary(**values)
    return model


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ({"kind": "viscous", "side": "left"}, {"kind": "viscous", "blocks": "b_0_1"}),
        ({"kind": "viscous", "side": "left"}, {"kind": "roller", "side": "left"}),
        ({"kind": "fixed", "side": "bottom"}, {"kind": "roller", "side": "top"}),
        ({"kind": "roller", "side": "left"},
         {"kind": "roller", "side": "left", "direction": "x"}),
        ({"kind": "roller", "along": [0, 0, 0, 1.5]}, {"kind": "fixed", "along": [0, 1.4, 0, 3]}),
        ({"kind": "free_field", "side": "left"}, {"kind": "fixed", "side": "left"}),
        ({"kind": "viscous", "side": "right"}, {"kind": "tied"}),
    ],
)  # fmt: skip
def test_an_edge_with_two_boundaries_is_refused(first, second):
    with pytest.raises(sitedda.InputError) as error_info:
        twice(first, second).check()
    message = str(error_info.value)
    assert "edge " in message and "of block 'b_0_" in message or "of block 'b_2_" in message
    assert message.count("Model.boundary(…), ") == 2 and "line" not in message


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ({"kind": "roller", "side": "left"},
         {"kind": "roller", "side": "left", "direction": "y"}),
        ({"kind": "roller", "along": [0, 0, 0, 1.5]}, {"kind": "fixed", "along": [0, 1.5, 0, 3]}),
    ],
)  # fmt: skip
def test_boundaries_of_other_directions_or_other_parts_of_an_edge_go_together(first, second):
    twice(first, second).check()
