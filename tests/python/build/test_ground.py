# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshed ground around a core: waves, outline, boundaries, rejected input."""

import numpy as np
import pytest
import shapely

import sitedda
from sitedda.command import main as command

DENSITY, SPEED = 2400.0, {"x": 600.0, "y": 600.0 * 3**0.5}
WIDTH, DEPTH, SIZE = 80.0, 32.0, 4.0  # m
PEAK, MIDDLE, FREQUENCY = 1e-6, 0.3, 4.0  # of the outcrop motion: m, s, Hz
CORE = [-12, -16, 12, -16, 12, 0, -12, 0]
BURIED = [-12, -20, 12, -20, 12, -8, -12, -8]
THROUGH = [-12, -32, 12, -32, 12, 0, -12, 0]


def ricker(time):
    """Return a Ricker wavelet with a peak of 1."""
    phase = (np.pi * FREQUENCY * (time - MIDDLE)) ** 2
    return (1 - 2 * phase) * np.exp(-phase)


def ground(along="x", cells=None, joint=None, **values):
    """Ground 80 m wide and 32 m deep under a wavelet, with a core of separate cells."""
    model = sitedda.Model("ground", time_step=1e-3, duration=0.6, analysis="plane_strain",
                          integration="midpoint")  # fmt: skip
    model.material("rock", density=DENSITY, shear_velocity=SPEED["x"], pressure_velocity=SPEED["y"])
    if joint:
        model.joint("smooth", **joint)
    model.motion("wave", PEAK * ricker(np.arange(0.0, 0.8, 1e-3)), 1e-3, "displacement")
    extent = {"left": -WIDTH / 2, "right": WIDTH / 2, "bottom": -DEPTH, "size": SIZE}
    model.ground(**extent | {f"motion_{along}": "wave"} | values)
    if cells:
        model.mesh(regions="core", size=cells)
    return model


def moved(model):
    """Times (s), heights (m) and displacements (n, blocks, 2) of all blocks at every fifth step."""
    time, displacements = [], []
    with sitedda.Simulation(model) as simulation:
        first, at_end = simulation.coordinates.copy(), False
        while not at_end:
            at_end = simulation.advance(5)
            time.append(simulation.time)
            displacements.append((simulation.coordinates - first)[:, :2])
    return np.array(time)[:, None], first[:, 1] + DEPTH, np.array(displacements)


def exact(along, time, height):
    """Displacement of a half-space of one rock: upgoing wave plus downgoing wave."""
    speed = SPEED[along]
    up, down = ricker(time - height / speed), ricker(time - (2 * DEPTH - height) / speed)
    return 0.5 * PEAK * (up + down)


@pytest.mark.parametrize("along", ["x", "y"])
def test_ground_without_a_core_is_the_column(along):
    """It equals a periodic column to 1e-7 of the peak, and the closed form at each height."""
    time, height, motion = moved(ground(along, surface=[0, 0]))
    _, _, tied = moved(ground(along, surface=[0, 0], sides="tied"))
    assert abs(motion - tied).max() < 1e-7 * PEAK
    assert abs(motion[..., "xy".index(along)] - exact(along, time, height)).max() < 3e-3 * PEAK


@pytest.mark.parametrize("along", ["x", "y"])
@pytest.mark.parametrize(
    ("core", "cells", "limit"),
    [(CORE, 4.0, 4e-3), (CORE, 3.0, 4e-3), (BURIED, 3.0, 4e-3), (THROUGH, 2.5, 4e-3)],
    ids=["same cells", "other cells", "buried", "to the bottom"],
)
def test_a_core_of_the_same_rock_does_not_change_the_wave(along, core, cells, limit):
    surface = {"surface": [0, 0]} if core is BURIED else {}
    time, height, motion = moved(ground(along, cells, core=core, **surface))
    expected = exact(along, time, height)
    assert abs(motion[..., "xy".index(along)] - expected).max() < limit * PEAK
    assert abs(motion[..., "yx".index(along)]).max() < limit * PEAK


def test_ties_beside_joints_with_restitution():
    """Ties then use the stiffness of contacts, not a stiffness per area."""
    model = ground(cells=3.0, core=CORE, joint={"friction_angle": 30.0, "restitution": 0.0})
    time, height, motion = moved(model)
    assert abs(motion[..., 0] - exact("x", time, height)).max() < 1e-2 * PEAK


def shapes(model) -> list[shapely.Polygon]:
    """Outlines of all blocks."""
    return [shapely.Polygon(block.vertices) for block in model.build()["block"]]


@pytest.mark.parametrize("seed", range(6))
def test_ground_and_core_fill_what_is_below_the_surface(seed):
    """Random cores whose upper side is the surface leave no gap and no overlap."""
    random = np.random.default_rng(seed)
    low, x = -20 + 8 * random.random(), np.sort(random.uniform(-20, 20, 6))
    x += np.arange(6)
    top = random.uniform(-6, 6, 6)
    core = [x[0], low, x[-1], low, *np.column_stack([x, top])[::-1].ravel()]
    cells = shapes(ground(core=core, fine_size=1.5 if seed % 2 else None))
    area = (WIDTH * DEPTH) + np.trapezoid(top, x) + top[0] * (x[0] + 40) + top[-1] * (40 - x[-1])
    assert sum(cell.area for cell in cells) == pytest.approx(area, rel=1e-9)
    union = shapely.union_all(shapely.buffer(cells, 1e-9))
    assert union.area == pytest.approx(area, rel=1e-6) and not union.interiors
    corners = np.concatenate([shapely.get_coordinates(cell) for cell in cells])
    for side, level in ((-40, top[0]), (40, top[-1])):
        assert corners[abs(corners[:, 0] - side) < 1e-9, 1].max() == pytest.approx(level)


def test_a_written_model_runs_as_the_model_in_memory(tmp_path, binary, same_bits):
    """A jointed core: the native executable runs the file of built blocks."""
    model = ground(core=CORE, base="fixed", sides="roller", joint={"friction_angle": 35.0})
    model.joint_set("smooth", angle=20.0, spacing=4.0, region="core")
    model.joint_set("smooth", angle=-70.0, spacing=5.0, region="core")
    model.control(duration=0.05)
    file = tmp_path / "ground.nml"
    model.write(file)
    assert "&ground" in file.read_text()
    sitedda.run(file, output=tmp_path / "one.nc")
    assert command(["build", str(file), "-o", str(tmp_path / "built.nml")]) == 0
    binary.ok("run", tmp_path / "built.nml", "-o", tmp_path / "two.nc")
    same_bits(tmp_path / "one.nc", tmp_path / "two.nc")


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({}, "give `core`, or `surface`"),
        ({"core": CORE, "frequency": 10.0}, "either size or frequency"),
        ({"core": CORE, "size": None}, "give size or frequency"),
        ({"core": CORE, "right": -50.0}, "right = -50 must be above left = -40"),
        ({"core": [-50, -5, 12, -5, 12, 0]}, "ground on both sides"),
        ({"core": [-10, -50, 12, -5, 12, 0]}, "above bottom = -32"),
        ({"core": [-10, 0, 10, -10, 10, 0, -10, -10]}, "not a simple polygon"),
        ({"core": [0, 0, 1, 1]}, "not a simple polygon"),
        ({"surface": [0, 0, -1, 2]}, "x must increase"),
        ({"surface": [0, -40]}, "must lie below the surface"),
        ({"surface": [0, 0], "base": "none"}, "has no motion"),
        ({"surface": [0, 0], "base": "soft"}, "base = 'soft'"),
        ({"surface": [0, 0], "material": "rok"}, "did you mean 'rock'"),
        ({"surface": [0, 0], "size": 1e-3}, "choose a larger size"),
    ],
)
def test_invalid_ground_is_refused(values, message):
    with pytest.raises(sitedda.InputError, match=message):
        sitedda.check(ground(**values))


def test_an_error_in_a_generated_group_has_no_line_number():
    model = ground(core=CORE, sides="tied", base="fixed", motion_x="none")
    with pytest.raises(sitedda.InputError, match="a &boundary generated from another group"):
        sitedda.check(model)
