# SPDX-License-Identifier: GPL-3.0-or-later
"""Pushover: a block against its closed form, walls between their limits, the command."""

import math

import numpy as np
import pytest
from test_walls import DOOR, WINDOW, wall

import sitedda
from sitedda import InputError, Model
from sitedda.stability import pushover

WIDTH, HEIGHT = 0.5, 2.0


def tower(friction=40.0) -> Model:
    """A block on a floor."""
    model = Model("tower", time_step=1e-3, steps=1, gravity=(0, -9.81))
    model.contact(normal_stiffness=1e10)
    model.material("stone", density=2500.0, young_modulus=1e11, poisson_ratio=0.2)
    model.joint("dry", friction_angle=friction)
    model.block([-3, -1, 3, -1, 3, 0, -3, 0], name="floor")
    model.block([0, 0, WIDTH, 0, WIDTH, HEIGHT, 0, HEIGHT], name="tower")
    for x, y in ((-2.5, -0.5), (2.5, -0.5), (0, -0.9)):
        model.fixed_point(x, y)
    model.measured_point("top", WIDTH / 2, HEIGHT, "tower")
    return model


@pytest.mark.parametrize("load", ["horizontal", "tilt", "mode"])
@pytest.mark.parametrize("sense", [1, -1])
def test_a_block_rocks_to_its_collapse(load, sense):
    """λ = tan(α − θ) about the corner, from b/h to nothing, over the way of the top."""
    found = pushover(tower(), "top", load=load, sense=sense, displacement=0.6, steps=60)
    assert found.peak == pytest.approx(WIDTH / HEIGHT, rel=2e-3)
    turn = np.linspace(0, 0.5, 5000)
    way = -WIDTH / 2 * (np.cos(turn) - 1) + HEIGHT * np.sin(turn)
    rocking = found.displacement > 1e-3
    angle = np.interp(found.displacement[rocking], way, turn)
    exact = np.tan(math.atan(WIDTH / HEIGHT) - angle)
    np.testing.assert_allclose(found.factor[rocking], exact, atol=1e-3)
    assert found.factor[-1] <= 0
    assert "collapse" in found.ending
    assert found.verdicts == ("stable", "topples")
    assert abs(found.friction[-1]) < 1e-4 * found.work[-1]


def test_a_block_slides_at_its_friction():
    friction = math.tan(math.radians(10.0))
    found = pushover(tower(10.0), "top", displacement=0.2, steps=40)
    assert found.peak == pytest.approx(friction, rel=2e-3)
    assert found.factor[-1] == pytest.approx(friction, rel=2e-3)
    assert found.verdicts == ("stable", "slides")
    assert found.friction[-1] == pytest.approx(found.work[-1], rel=0.02)
    assert "displacement asked for" in found.ending


@pytest.mark.parametrize("seed", [2, 3])
def test_walls_with_openings_fail_between_their_limits(seed):
    head, bond = ("lintel", "arch")[seed % 2], ("running", "header", "rubble")[seed % 3]
    model = wall([DOOR | {"head": head, "depth": 0.3}, WINDOW], bond=bond, seed=seed, stone=0.75)
    model.measured_point("top", 2.45, 2.95)
    limits = sitedda.limit_analysis(model)
    found = pushover(model, "top", displacement=0.02, steps=40)
    assert 0.98 * limits.lower.factor <= found.peak <= 1.02 * limits.upper.factor
    assert found.draw(limits).axes


def test_the_command_prints_draws_and_writes_the_curve(tmp_path, main):
    tower().write(tmp_path / "tower.nml")
    done = main.ok(
        "pushover",
        "tower.nml",
        "--point",
        "top",
        "--steps",
        "20",
        "--limits",
        "--displacement",
        "0.1",
        folder=tmp_path,
    )
    assert "peak: horizontal load over the weight 0.25" in done.stdout
    assert "limit analysis: 0.25 without dilation, 0.25 with" in done.stdout
    assert (tmp_path / "tower_pushover.png").exists()
    head, *rows = (tmp_path / "tower_pushover.csv").read_text().splitlines()
    assert head.startswith("displacement (m),largest (m),factor (1)")
    assert len(rows) > 20


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"point": "roof"}, "'roof' is not the name of a &measured_point; there are top"),
        ({"load": "wind"}, "load = 'wind'"),
        ({"sense": 0}, "sense = 0"),
        ({"displacement": -1.0}, "displacement"),
        ({"steps": 0}, "steps"),
        ({"changes": {"control.gravity": (0.0, 0.0)}}, "needs gravity"),
    ],
)
def test_arguments_that_cannot_be(values, words):
    with pytest.raises(InputError, match=words):
        pushover(tower(), **{"point": "top"} | values)


STUDY = """
model = "tower.nml"
parameters = {friction = {changes = "joint[dry].friction_angle", values = [8.0, 40.0]}}
pushover = {point = "top", displacement = 0.05, steps = 20, limits = true}
"""


def test_a_study_pushes_each_of_its_cases(tmp_path, main):
    """Slides at tan 8°, else rocks at width over height: the peaks, between their limits."""
    import xarray

    tower().write(tmp_path / "tower.nml")
    (tmp_path / "push.toml").write_text(STUDY)
    main.ok("study", str(tmp_path / "push.toml"), "--quiet")
    table = xarray.load_dataset(tmp_path / "push_study" / "table.nc")
    alone = pushover(tower(), "top", displacement=0.05, steps=20)
    assert table.peak_factor.values[1] == alone.peak
    assert table.peak_factor.values[0] == pytest.approx(math.tan(math.radians(8)), rel=0.02)
    assert (table.peak_factor <= table.limit_upper * 1.02).all()
    assert (table.peak_factor >= table.limit_lower * 0.98).all()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('point = "top", ', "", r"\[pushover\] point is missing"),
        ("limits = true", 'load = "up"', "load = 'up'"),
        ("steps = 20", "steps = 0", "steps"),
        ("model =", 'task = "safety"\nmodel =', "leave out task and results"),
        ("model =", "solve = {}\nmodel =", "are two tasks"),
        ("limits", "limit", "did you mean 'limits'"),
    ],
)
def test_bad_tables_of_a_pushover(tmp_path, old, new, words):
    from sitedda.study.settings import read_settings

    tower().write(tmp_path / "tower.nml")
    file = tmp_path / "push.toml"
    file.write_text(STUDY.replace(old, new, 1))
    with pytest.raises(InputError, match=words):
        read_settings(file)
