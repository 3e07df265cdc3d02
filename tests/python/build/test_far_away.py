# SPDX-License-Identifier: GPL-3.0-or-later
"""Models at coordinates of a map: the same blocks and results as at the origin."""

import numpy as np
import pytest
from model_text import namelist

import sitedda
from sitedda.building import built_text
from sitedda.model import Model

EXACT = np.array([524288.0, 4194304.0])  # powers of two: multiples of 2⁻³⁰ m move without rounding
UTM = np.array([500000.0, 5200000.0])
NOISE = 1e-9  # rounding of map coordinates, m
AMPLIFIED = 10  # largest error over that caused by noise of vertices
STEPS = 200
HORIZON = 1e-3  # relative displacement due to noise at which the comparison ends

SLOPE = np.reshape([0, 0, 30, 0, 30, 4, 20, 4, 12, 14, 0, 14], (-1, 2)).astype(float)
SETS = {
    "sets": [{"angle": 35.0, "spacing": 2.0}, {"angle": -50.0, "spacing": 2.5}],
    "along the outline": [{"angle": 0.0, "spacing": 2.0}, {"angle": 90.0, "spacing": 2.0}],
    "random": [{"angle": 20.0, "spacing": 1.7, "spacing_distribution": "exponential", "seed": 3},
               {"angle": 80.0, "spacing": 2.2, "angle_distribution": "normal",
                "angle_deviation": 12.0, "trace_length": 5.0, "bridge": 0.5}],
}  # fmt: skip


def cut_by(sets):
    return lambda at: [
        ("region", {"name": "rock", "outline": (SLOPE + at).ravel()}),
        *(("joint_set", joint_set) for joint_set in sets),
    ]


GENERATORS = {
    **{name: cut_by(sets) for name, sets in SETS.items()},
    "voronoi": lambda at: [
        ("region", {"name": "rock", "outline": (SLOPE + at).ravel()}),
        ("voronoi", {"size": 2.0, "seed": 2}),
    ],
    "arch": lambda at: [("arch", {"centre": at, "span": 4.0, "rise": 1.3, "thickness": 0.5,
                                  "voussoirs": 9, "abutment": 0.7})],
    "pier": lambda at: [("pier", {"centre": at[0], "bottom": at[1], "width": 2.1, "height": 3.3,
                                  "top_width": 1.4, "courses": 5, "stones": 3})],
    "colonnade": lambda at: [("colonnade", {"left": at[0], "bottom": at[1], "columns": 3,
                                            "drums": 4, "spacing": 2.3, "width": 0.7,
                                            "top_width": 0.6, "height": 3.1, "capital_width": 0.9,
                                            "capital_height": 0.3, "beam_height": 0.4})],
    "retaining_wall": lambda at: [("retaining_wall", {"left": at[0], "bottom": at[1],
                                                      "base_width": 2.4, "top_width": 1.0,
                                                      "height": 5.0, "courses": 7, "stones": 3})],
    "lintel": lambda at: [("lintel", {"left": at[0], "bottom": at[1], "span": 1.3, "height": 0.3,
                                      "bearing": 0.2})],
}  # fmt: skip


def blocks_of(groups) -> list[np.ndarray]:
    """Vertices of the blocks that are built from groups."""
    groups = [("joint", {"name": "bed", "friction_angle": 30.0}), *groups]
    built = built_text(namelist(groups), "model.nml")[1]
    return [np.reshape(block["vertices"], (-1, 2)) for block in built.blocks]


@pytest.mark.parametrize("at", [EXACT, UTM, np.array([-3000.7, 1234.5])], ids=str)
@pytest.mark.parametrize("name", GENERATORS)
def test_every_generator_makes_the_same_blocks(name, at):
    near_blocks, far_blocks = (
        blocks_of(GENERATORS[name](np.zeros(2))),
        blocks_of(GENERATORS[name](at)),
    )
    assert [len(block) for block in near_blocks] == [len(block) for block in far_blocks]
    difference = max(abs(b - at - a).max() for a, b in zip(near_blocks, far_blocks, strict=True))
    assert difference <= 8 * np.spacing(abs(at).max())


def test_imported_polygons_are_the_same_blocks(tmp_path):
    square = np.array([[0.0, 0.0], [1.5, 0.0], [1.5, 1.0], [0.0, 1.0]])
    block_lists = []
    for at in (np.zeros(2), UTM):
        rows = [(i, *point) for i in range(2) for point in square + at + [2.0 * i, 0.0]]
        lines = [f"s{i}, {x:.17g}, {y:.17g}" for i, x, y in rows]
        (tmp_path / "map.csv").write_text("\n".join(["name, x, y", *lines, ""]))
        groups = [("joint", {"name": "bed"}), ("polygons", {"file": "map.csv"})]
        built = built_text(namelist(groups), tmp_path / "model.nml")[1]
        block_lists.append([np.reshape(block["vertices"], (-1, 2)) - at for block in built.blocks])
    assert len(block_lists[0]) == len(block_lists[1]) == 2
    assert np.allclose(block_lists[0], block_lists[1], rtol=0, atol=2e-9)


def test_an_origin_that_is_too_far_is_named_with_its_group(write_input):
    text = (
        "&joint name = 'bed' /\n&material density = 2600.0 /\n"
        "&region outline = 0.0, 0.0, 5.0, 0.0, 5.0, 5.0, 0.0, 5.0 /\n"
        "&joint_set angle = 10.0, spacing = 1.0 /\n"
        "&joint_set angle = 80.0, spacing = 1.0e-3, origin = 1e5, 0.0 /\n"
    )
    with pytest.raises(sitedda.InputError, match=r"&joint_set \(line 5\): origin is over"):
        built_text(text, write_input(text))


def shaken(at, unit: float = 1.0, noise: float = 0.0, seed: int = 0) -> sitedda.Run:
    """A running-bond wall with a loose stone on a shaken base, in a unit of length (m).

    The `noise` (m) moves its vertices.
    """
    rng = np.random.default_rng(seed)
    model = Model()
    model.control(time_step=1e-3, steps=STEPS, gravity=(1.0, -9.81))
    model.contact(normal_stiffness=2e9)
    model.material(name="stone", density=2500.0, young_modulus=1e10, poisson_ratio=0.25)
    model.joint(name="dry", friction_angle=35.0)
    pulse = 5.0 * np.sin(np.linspace(0, 4 * np.pi, 41))
    model.motion(name="pulse", values=pulse, time_step=0.005, quantity="acceleration")
    outlines = [(-0.5, -0.5, 5.0, 0.5)]
    for k in range(5):
        outlines += [(0.5 * (k % 2) + i, 0.5 * k, 1.0, 0.5) for i in range(3)]
    outlines.append((1.25, 2.53125, 0.5, 0.75))
    for number, (x, y, width, height) in enumerate(unit * np.array(outlines)):
        corners = np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height]])
        corners = corners + noise * rng.choice([-1.0, 1.0], corners.shape) + at
        model.block(name=f"b{number}", vertices=corners.ravel())
        middle = np.array([x + width / 2, y + height / 2]) + at
        model.measured_point(name=f"p{number}", x=middle[0], y=middle[1], block=f"b{number}")
    for x in (0.0, 4.0):
        model.fixed_point(x=unit * x + at[0], y=at[1] - 0.25, block="b0", motion_x="pulse")
    model.output(block_interval=20)
    return model.run()


def answer(run) -> dict[str, np.ndarray]:
    """Displacements of the points of all blocks, rates and stresses, by frame.

    The output rounds coordinates themselves like map coordinates.
    """
    moves = run.history.displacement.sel(time=run.history.frame_time.values).values
    return {"moves": moves, "rates": run.history.block_rates.values,
            "stress": run.history.block_stress.values}  # fmt: skip


def difference(one, other) -> dict[str, np.ndarray]:
    """Largest difference in each frame over the largest value of all frames."""
    return {name: abs(one[name] - other[name]).max(axis=(1, 2)) / abs(other[name]).max()
            for name in other}  # fmt: skip


def test_a_shaken_wall_far_away_moves_as_at_the_origin():
    here = answer(shaken(np.zeros(2)))
    exact = difference(answer(shaken(EXACT)), here)
    assert max(value.max() for value in exact.values()) <= 1e-8


def test_a_shaken_wall_at_coordinates_of_a_map_differs_by_their_rounding():
    unit = 1.1  # no power of two: every coordinate is rounded
    here = answer(shaken(np.zeros(2), unit))
    noisy = [difference(answer(shaken(np.zeros(2), unit, NOISE, i)), here) for i in range(3)]
    far = difference(answer(shaken(UTM, unit)), here)
    assert far["moves"].max() > 0
    grown = np.max([result["moves"] for result in noisy], axis=0)
    within = int(np.argmax(grown > HORIZON)) if (grown > HORIZON).any() else len(grown)
    print(f"horizon: frame {within} of {len(grown)}, where noise of {NOISE:g} m has become "
          f"{HORIZON:g} of the largest displacement; until then {grown[:within].max():.2g}, "
          f"at UTM coordinates {far['moves'][:within].max():.2g}")  # fmt: skip
    assert within > 5
    for name, values in far.items():
        noise = np.max([result[name] for result in noisy], axis=0)
        assert values[:within].max() <= AMPLIFIED * noise[:within].max()
