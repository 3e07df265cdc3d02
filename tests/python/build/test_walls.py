# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls with openings: geometry of the stones, equilibrium and limit loads."""

import numpy as np
import pytest

import sitedda
from sitedda import InputError, Model

WIDTH, HEIGHT = 5.0, 3.0
DOOR = {"name": "door", "left": 0.8, "bottom": 0.0, "width": 1.0, "height": 2.1}
WINDOW = {"name": "window", "left": 3.0, "bottom": 1.0, "width": 0.8, "height": 1.0}


def wall(openings=(DOOR, WINDOW), **values) -> Model:
    """A wall on a floor."""
    model = Model("wall", time_step=1e-3, steps=1, gravity=(0, -9.81))
    model.contact(normal_stiffness=1e10)
    model.material("stone", density=2500.0, young_modulus=1e11, poisson_ratio=0.2)
    model.joint("dry", friction_angle=35.0)
    model.block([-1, -0.5, WIDTH + 1, -0.5, WIDTH + 1, 0, -1, 0], name="floor")
    for x, y in ((-0.9, -0.25), (WIDTH + 0.9, -0.25), (2, -0.4)):
        model.fixed_point(x, y, "floor")
    model.masonry_wall(**{"width": WIDTH, "height": HEIGHT, "courses": 10, "stone": 0.6} | values)
    for opening in openings:
        model.opening(**opening)
    return model


def area(polygon) -> float:
    x, y = np.asarray(polygon).T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def polygons(model) -> dict[str, np.ndarray]:
    return {block.name: block.vertices for block in model.build()["block"] if block.name != "floor"}


def under_chords(width, rise, voussoirs) -> float:
    """Area under the inner edges of the voussoirs, above the springing, m²."""
    radius = (0.25 * width**2 + rise**2) / (2 * rise)
    first = np.arctan2(radius - rise, 0.5 * width)
    angle = np.linspace(first, np.pi - first, voussoirs + 1)
    ends = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    return area(ends)


@pytest.mark.parametrize("bond", ["running", "header", "rubble"])
@pytest.mark.parametrize(
    ("head", "rise"), [("lintel", None), ("arch", 0.2), ("arch", 0.5), ("none", None)]
)
def test_stones_fill_the_wall_except_its_openings(bond, head, rise):
    door = DOOR | {"head": head, "depth": 0.25} | ({"rise": rise} if rise else {})
    height = HEIGHT if head != "none" else DOOR["height"]  # an opening without a head ends it
    openings = [door] if head == "none" else [door, WINDOW]
    stones = polygons(wall(openings, bond=bond, seed=3, height=height))
    empty = DOOR["width"] * (DOOR["height"] - (rise or 0.0))
    empty += under_chords(DOOR["width"], rise, 9) if rise else 0.0
    empty += WINDOW["width"] * WINDOW["height"] if head != "none" else 0.0
    assert sum(map(area, stones.values())) == pytest.approx(WIDTH * height - empty, rel=1e-9)
    assert min(map(area, stones.values())) > 0
    levels = np.unique(np.round([p[:, 1].min() for n, p in stones.items() if "wall" in n], 9))
    if head == "lintel":
        assert {1.0, 2.0, 2.1}.issubset(levels)
        assert np.ptp(stones["door_lintel"][:, 0]) == pytest.approx(1.0 + 0.6)
    if head == "arch":
        assert "door_9" in stones
        assert ("door_left" in stones) == (rise < 0.5)  # a half-circle springs level
    lengths = [np.ptp(p[:, 0]) for n, p in stones.items() if n.startswith("wall")]
    assert min(lengths) >= 0.3 * 0.6 * (0.5 if bond == "header" else 1.0) - 1e-9
    with sitedda.Simulation(wall(openings, bond=bond, seed=3, height=height)) as simulation:
        assert len(simulation.polygons) == len(stones) + 1  # none overlaps another


def test_head_joints_of_successive_rubble_courses_are_offset():
    stones = polygons(wall((), bond="rubble", seed=5, width=20.0, courses=12))
    courses: dict[float, list[float]] = {}
    for stone in stones.values():
        courses.setdefault(round(stone[:, 1].min(), 9), []).append(stone[:, 0].max())
    rows = [np.sort(courses[y])[:-1] for y in sorted(courses)]
    offsets = [abs(a[:, None] - b).min() for a, b in zip(rows, rows[1:], strict=False)]
    assert np.mean(np.array(offsets) >= 0.2 * 0.6 - 1e-9) > 0.6
    heights = np.diff(sorted(courses))
    assert heights.std() > 0.05 * heights.mean()
    other_stones = polygons(wall((), bond="rubble", seed=6, width=20.0, courses=12))
    assert not np.array_equal(stones["wall_1"], other_stones["wall_1"])


@pytest.mark.parametrize("seed", range(4))
def test_walls_stand_and_have_limit_loads(seed):
    rng = np.random.default_rng(seed)
    head = ("lintel", "arch")[seed % 2]
    door = DOOR | {"head": head, "width": rng.uniform(0.7, 1.1), "depth": 0.3}
    bond = ("running", "header", "rubble")[seed % 3]
    model = wall([door, WINDOW], bond=bond, seed=seed, stone=rng.uniform(0.5, 0.8))
    limits = sitedda.limit_analysis(model)
    assert 0.05 < limits.lower.factor <= limits.upper.factor * (1 + 1e-6) < 1.0
    model.control(steps=None)
    model.stage("rest", "static")
    assert "at rest" in model.run().summary


def test_walls_with_ties_run_in_both_programs(tmp_path, binary, same_bits):
    model = wall(ties=[2.5], tie_stiffness=1e7, tie_yield=1e5)
    model.write(tmp_path / "wall.nml")
    run = sitedda.run(tmp_path / "wall.nml", tmp_path / "a.nc")
    assert run.history.bolt.values.tolist() == ["wall_tie_1"]
    from sitedda.building import build_file

    built, _ = build_file(tmp_path / "wall.nml")
    binary.ok("run", built, "-o", tmp_path / "b.nc", "-q")
    same_bits(tmp_path / "a.nc", tmp_path / "b.nc")


@pytest.mark.parametrize(
    ("openings", "values", "message"),
    [
        ([DOOR | {"wall": "fence"}], {}, "'fence' is not the name of a &masonry_wall"),
        ([DOOR | {"left": 4.5}], {}, "'door': the opening with its head, x = 4.2 to 5.8 m"),
        ([DOOR | {"height": 3.0}], {}, "is not within the wall"),
        ([DOOR, DOOR | {"name": "gate", "left": 1.2}], {}, "'door' and 'gate'"),
        ([DOOR | {"head": "arch", "rise": 0.6}], {}, "above half of the width"),
        ([DOOR | {"head": "roof"}], {}, "head = 'roof'"),
        ((), {"bond": "english"}, "bond = 'english'"),
        ((), {"stone": -1.0}, "stone = -1"),
        ((), {"courses": 10**6}, "courses"),
        ((), {"ties": [1.0]}, "ties need tie_stiffness"),
        ((), {"ties": [9.0], "tie_stiffness": 1e7}, "9 m is not within a course"),
        ([{"left": 1.0}], {}, "opening 'opening': width is missing"),
    ],
)
def test_invalid_walls_are_refused(openings, values, message):
    with pytest.raises(InputError, match=message):
        wall(openings, **values).build()
