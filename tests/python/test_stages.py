"""Models come to rest before they are shaken, and what comes after follows in stages."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr
from model_text import changed, flying_block, rectangle, tower

import sitedda

GRAVITY = 9.81
STONE = {"name": "stone", "density": 2500.0, "young_modulus": 10.0e9, "poisson_ratio": 0.25}


def model(blocks, friction=35.0, supports=(), points=(), **control) -> list:
    """Blocks by name with one material and one joint, at rest under gravity."""
    control = {"time_step": 1e-3, "steps": 20, "gravity": [0.0, -GRAVITY], "settle": True} | control
    return [
        ("control", control),
        ("material", dict(STONE)),
        ("joint", {"name": "dry", "friction_angle": friction}),
        *(("block", {"name": name, "vertices": vertices}) for name, vertices in blocks.items()),
        *(("fixed_point", {"x": x, "y": y, "block": block}) for block, x, y in supports),
        *(
            ("measured_point", {"name": name, "x": x, "y": y, "block": block})
            for name, block, x, y in points
        ),
        ("output", {"file": "stages.nc"}),
    ]


def column(drums: int = 10, **control) -> list:
    blocks = {"foot": rectangle(-1.0, -0.5, 2.0, 0.5)}
    blocks |= {f"drum_{i}": rectangle(-0.3, 0.5 * i, 0.6, 0.5) for i in range(drums)}
    supports = [("foot", -0.9, -0.4), ("foot", 0.9, -0.4), ("foot", 0.0, -0.1)]
    top = [("crest", f"drum_{drums - 1}", 0.0, 0.5 * drums)]
    return model(blocks, supports=supports, points=top, **control)


def wall(bricks: int, courses: int, **control) -> list:
    groups = model({}, points=[("crest", "brick_1", 0.4, 0.25)], **control)
    groups[-1:-1] = [
        ("fixed_point", {"x": x, "y": y, "block": "base_1"})
        for x, y in ((0.0, -0.25), (float(bricks), -0.25), (bricks / 2, -0.4))
    ]
    place = [name for name, _ in groups].index("measured_point")
    groups[place:place] = [
        ("layers", {"name": "base", "left": -0.5, "bottom": -0.5, "width": bricks + 1.0,
                    "thickness": 0.5}),
        ("wall", {"name": "brick", "brick_length": 1.0, "brick_height": 0.5, "bricks": bricks,
                  "courses": courses}),
    ]
    return groups


def arch(voussoirs: int = 27, radius: float = 10.0, thickness: float = 1.3, **control) -> list:
    """A half circle on two fixed abutments."""
    blocks = {"left": rectangle(-14.0, -2.0, 8.0, 2.0), "right": rectangle(6.0, -2.0, 8.0, 2.0)}
    angles = [math.pi * i / voussoirs for i in range(voussoirs + 1)]
    inner, outer = radius - thickness / 2, radius + thickness / 2
    for i, (a, b) in enumerate(zip(angles, angles[1:], strict=False)):
        ring = [(inner, a), (outer, a), (outer, b), (inner, b)]
        blocks[f"v{i}"] = [
            c for r, t in ring for c in (r * math.cos(t), r * math.sin(t) if 0 < t < 3.14 else 0.0)
        ]
    supports = [
        (block, s * x, y)
        for block, s in (("left", -1), ("right", 1))
        for x, y in ((7.0, -1.9), (13.0, -1.9), (10.0, -0.5))
    ]
    return model(blocks, supports=supports, points=[("crest", "v13", 0.0, radius)], **control)


def slope(dip: float = 35.0, friction: float = 38.0, rows: int = 4, **control) -> list:
    """Slabs of 4 m x 2 m in `rows` layers on a plane that dips, in running bond."""
    t = math.radians(dip)
    along, up = np.array([math.cos(t), math.sin(t)]), np.array([-math.sin(t), math.cos(t)])

    def slab(a, b, h0, h1):
        return [float(c) for p, h in ((a, h0), (b, h0), (b, h1), (a, h1)) for c in p * along + h * up]

    blocks = {"ground": slab(-10.0, 40.0, -5.0, 0.0)}
    for row in range(rows):
        for i in range(5):
            a = 4.0 * i + 2.0 * (row % 2)
            blocks[f"b{row}_{i}"] = slab(a, a + 4.0, 2.0 * row, 2.0 * row + 2.0)
    supports = [("ground", *(a * along + h * up)) for a, h in ((-9.0, -4.0), (39.0, -4.0), (0, -1))]
    supports = [(block, float(x), float(y)) for block, x, y in supports]
    x, y = blocks[f"b{rows - 1}_4"][4:6]
    return model(blocks, friction, supports, [("crest", f"b{rows - 1}_4", x, y)], **control)


def unbalanced(run) -> float:
    """The share of the weight that the summary of a run gives."""
    words = run.summary.split("largest unbalanced force ")[1]
    return float(words.split(" N/m, ")[1].split(" ")[0])


@pytest.mark.parametrize(
    "groups",
    [column(), wall(5, 10), wall(25, 40, steps=2), arch(), slope()],
    ids=["column", "wall of 50", "wall of 1000", "arch", "slope"],
)
def test_a_model_at_rest_stays_there(groups, write_input):
    with sitedda.Simulation(write_input(groups)) as run:
        assert unbalanced(run) <= 1e-6
        assert run.energies["kinetic"] == 0.0
        assert not run.rates.any()
        assert run.time == 0.0 and run.counts["steps"] == 0
        assert run.energies["initial"] > 0.0  # what is stored at rest
        before = run.coordinates.copy()
        while not run.advance(10):
            pass
        assert np.abs(run.coordinates - before)[:, :2].max() <= 1e-9
        assert abs(run.energies["friction"]) <= 1e-6 * run.energies["initial"]


@pytest.mark.parametrize("step", [0.25e-3, 0.5e-3, 1e-3, 2e-3])
def test_no_step_moves_the_slope_at_rest(step, write_input):
    run = sitedda.run(write_input(slope()), time_step=step, steps=round(0.2 / step))
    moved = np.abs(run.history.displacement)
    assert float(moved.max()) <= 2e-3
    assert float(moved.max()) <= 1e-8  # what rounding leaves
    assert float(moved[0].max()) == 0.0


def test_rest_is_statics(write_input):
    """A column shortens by the weights above each level, over E A, k_n and the supports."""
    with sitedda.Simulation(write_input(column(4))) as run:
        stress = run.stresses[:, 1]
        weight = STONE["density"] * GRAVITY * 0.5
        expected = [-(4 - i - 0.5) * weight for i in range(4)]
        assert stress[1:] == pytest.approx(expected, rel=1e-3)


def test_loads_of_time_zero_act_and_motions_do_not(write_input):
    groups = tower(2, 10, {"name": "bedding", "friction_angle": 35.0}, gravity=[0.0, -GRAVITY])
    groups = changed(groups, "control", settle=True)
    load = {"x": 7.5, "y": 1.5, "time": [0.0, 1.0], "force_y": [-1.0e6, -1.0e6]}
    with sitedda.Simulation(write_input(groups)) as bare:
        first = bare.stresses.copy()
    with sitedda.Simulation(write_input([*groups, ("load", load)])) as loaded:
        assert loaded.energies["kinetic"] == 0.0
        change = loaded.stresses - first
        assert change.min() == pytest.approx(-1.0e6 / 15.0, rel=0.6)


def test_what_does_not_come_to_rest_is_named(write_input, native):
    file = write_input(slope(friction=20.0))
    with pytest.raises(sitedda.ConvergenceError, match=r"does not settle.*block .*unbalanced force"):
        sitedda.Simulation(file)
    done = native("run", file)
    assert done.returncode == 3
    assert "not at rest after" in done.stderr


def test_sudden_gravity_is_said(write_input, native, tmp_path):
    file = write_input(changed(column(2), "control", settle=False))
    done = native("run", file, folder=tmp_path)
    assert "gravity came on suddenly" in done.stdout
    with sitedda.Simulation(file) as run:
        assert "gravity came on suddenly" in run.summary
    with sitedda.Simulation(file, settle=True) as run:
        assert "gravity came on suddenly" not in run.summary


def test_senseless_settling_is_refused(write_input):
    with pytest.raises(sitedda.InputError, match="'original' of &contact has no static stage"):
        sitedda.Simulation(write_input(column(2)), contact_rules="original")
    moving = changed(column(2), "material", initial_velocity=[1.0, 0.0, 0.0])
    with pytest.raises(sitedda.InputError, match="material 'stone' has an initial_velocity"):
        sitedda.Simulation(write_input(moving))


def test_check_starts_from_the_same_rest(write_input):
    report = str(sitedda.check(write_input(column(3))))
    assert "at rest after 0 static steps" in report
    report = str(sitedda.check(write_input(changed(column(3), "control", settle=False))))
    assert "at rest after" in report and "after 0 static" not in report


def test_native_and_python_settle_to_the_same_bits(write_input, native, tmp_path):
    file = write_input(slope(steps=30))
    assert native("run", file, folder=tmp_path).returncode == 0
    mine = sitedda.run(file, output=tmp_path / "python.nc")
    assert mine.complete
    with (
        xr.open_dataset(tmp_path / "stages.nc") as one,
        xr.open_dataset(tmp_path / "python.nc") as two,
    ):
        xr.testing.assert_identical(one.drop_attrs(), two.drop_attrs())


def test_a_settled_run_resumes_to_the_same_bits(write_input, tmp_path):
    file = write_input(slope(steps=30))
    whole = sitedda.run(file, output=tmp_path / "whole.nc")
    assert whole.complete
    with sitedda.Simulation(file, tmp_path / "cut.nc") as run:
        run.advance(11)
    assert sitedda.resume(file, tmp_path / "cut.nc").complete
    with (
        xr.open_dataset(tmp_path / "whole.nc") as one,
        xr.open_dataset(tmp_path / "cut.nc") as two,
    ):
        xr.testing.assert_identical(one.drop_attrs(), two.drop_attrs())


def test_a_flying_block_cannot_settle(write_input):
    groups = changed(flying_block(), "control", settle=True, gravity=[0.0, -GRAVITY])
    groups = changed(groups, "material", initial_velocity=None)
    with pytest.raises(sitedda.ConvergenceError, match="not at rest after"):
        sitedda.Simulation(write_input(groups))
