# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshed blocks: selection, names, cell sizes, and rejected input."""

import numpy as np
import pytest

from sitedda import InputError
from sitedda.building import build_blocks, summary
from sitedda.cutting import Region, Tunnel, cut
from sitedda.cutting.rings import Rings
from sitedda.meshing.meshed import Piece, mesh_blocks
from sitedda.meshing.settings import Mesh, is_listed

ROCK = {"density": 2500.0, "young_modulus": 5e9, "poisson_ratio": 0.25}
MATERIALS = {"rock": ROCK, "soft": ROCK | {"young_modulus": 5e7}}


def box(left, bottom, width, height, **values):
    corners = [(0, 0), (width, 0), (width, height), (0, height)]
    return Piece(values | {"vertices": np.array(corners, float) + (left, bottom)})


def meshed(parts, *meshes):
    labels = [(mesh, f"mesh {i}") for i, mesh in enumerate(meshes, 1)]
    return mesh_blocks(parts, labels, MATERIALS)


BEAMS = [box(0, 0, 4, 1, name="beam_1"), box(0, 1, 4, 1, name="beam_2"), box(9, 0, 1, 1)]


def test_each_block_becomes_a_body_with_its_name():
    cells, meshed_blocks, messages = meshed(BEAMS, Mesh(blocks="beam_*", size=0.5))
    assert meshed_blocks == [0, 1] and not messages
    assert {cell["body"] for cell in cells} == {"beam_1", "beam_2"}
    assert len(cells) == 32 and not any("name" in cell for cell in cells)


def test_several_blocks_become_one_body_with_boundaries_between_materials():
    parts = [
        box(0, 0, 4, 1, name="low", material="rock", joint="a"),
        box(0, 1, 4, 1, name="high", material="soft", joint="b"),
    ]
    cells, *_ = meshed(parts, Mesh(blocks="low, high", body="ground", size=0.5))
    assert {cell["body"] for cell in cells} == {"ground"}
    for cell in cells:
        upper = cell["vertices"].mean(axis=0)[1] > 1
        assert (cell["material"], cell["joint"]) == (("soft", "b") if upper else ("rock", "a"))


def test_edge_joints_remain_on_the_outline():
    part = box(0, 0, 2, 1, name="one", joint="a", edge_joints=("", "b"))
    cells, *_ = meshed([part], Mesh(blocks="one", size=1.0))
    assert [cell.get("edge_joints") for cell in cells] == [None, ("a", "b", "a", "a")]


def test_a_frequency_gives_twelve_cells_per_wavelength_of_each_material():
    parts = [
        box(0, 0, 40, 10, name="low", material="rock"),
        box(0, 10, 40, 10, name="high", material="soft"),
    ]
    cells, *_ = meshed(parts, Mesh(blocks="low, high", body="ground", frequency=40.0))
    for name, rock in MATERIALS.items():
        shear = rock["young_modulus"] / 2 / (1 + rock["poisson_ratio"])
        size = np.sqrt(shear / rock["density"]) / 40.0 / 12
        rings = Rings.of([cell["vertices"] for cell in cells if cell["material"] == name])
        middle = abs(rings.centroids()[:, 1] - 10) > min(size, 5)
        assert np.sqrt(rings.areas()[middle]).max() < 1.25 * size
    velocities = {"density": 2000.0, "shear_velocity": 600.0, "pressure_velocity": 1200.0}
    assert Mesh(blocks="x", frequency=5.0).size_of("x", velocities) == pytest.approx(10.0)


def test_a_block_round_a_tunnel_is_meshed_round_it():
    square = [0.0, 0, 20, 0, 20, 20, 0, 20]
    tunnel = Tunnel(centre=(10, 10), width=6.0, joint="wall")
    ring = cut([Region(outline=square, joint="side")], (), holes=[tunnel], rings=True)
    assert len(ring) == 1 and len(ring.holes[0]) == 1
    hole = Rings.of([tunnel.outline]).areas()[0]
    part = Piece({"name": "rock_1", "vertices": ring.polygons[0], "joint": "side"}, "rock")
    part.holes = ring.holes[0]
    cells, meshed_blocks, _ = meshed([part], Mesh(regions="rock", size=2.0))
    assert meshed_blocks == [0]
    areas = Rings.of([cell["vertices"] for cell in cells]).areas()
    assert areas.sum() == pytest.approx(400 - hole, rel=1e-12)
    walls = sum(
        length
        for cell in cells if "edge_joints" in cell
        for joint, length in zip(
            cell["edge_joints"], Rings.of([cell["vertices"]]).edge_lengths(), strict=True
        )
        if joint == "wall"
    )  # fmt: skip
    assert walls == pytest.approx(Rings.of([tunnel.outline]).edge_lengths().sum(), rel=1e-9)


def test_a_ring_around_a_ring_surrounds_only_this_ring():
    square = np.array([[0, 0], [20, 0], [20, 20], [0, 20]], float)
    core = Region(name="core", outline=0.4 * square + 6)
    hole = Tunnel(centre=(10, 10), width=3.0, joint="wall")
    gap = Tunnel(name="gap", centre=(10, 10), width=10.0, shape="rectangle")
    rings = cut([core], (), holes=[hole], rings=True)
    assert [len(one) for one in rings.holes] == [1]
    assert {joint for _, joints in rings.holes[0] for joint in joints} == {"wall"}
    outer = cut([Region(outline=square)], (), holes=[gap], rings=True)
    assert abs(outer.holes[0][0][0] - 10).max() == 5.0
    with pytest.raises(InputError, match="mesh it"):
        cut([core], (), holes=[hole])


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        (Mesh(blocks="bean", size=1.0), "'bean' matches none of the blocks beam_1, beam_2"),
        (Mesh(regions="rock", size=1.0), "matches none of the regions: there are none"),
        (Mesh(blocks="*", size=1.0), "a block that lacks a name"),
        (Mesh(blocks="beam_1", size=1e-5), "choose a larger size"),
        (Mesh(blocks="beam_1", frequency=1e9), "choose a larger size"),
        (Mesh(blocks="beam_1", body="b" * 65, size=1.0), "at most 64 bytes"),
    ],
)
def test_meshes_that_cannot_be_made_are_refused_with_position(mesh, message):
    with pytest.raises(InputError, match=r"^mesh 1: ") as refused:
        meshed(BEAMS, mesh)
    assert message in str(refused.value)


@pytest.mark.parametrize("cells", ["quadrilateral", "voronoi"])
@pytest.mark.parametrize(
    "corners",
    [
        [(0, 0), (1, 0), (2, 0)],
        [(1, 1), (1, 1), (1, 1)],
        [(0, 0), (1, 1), (1, 0), (0, 1)],
        [(0, 0), (1, 0), (1, 1e-9), (0, 1e-9)],
    ],
    ids=["line", "point", "bow tie", "sheet"],
)
def test_an_outline_without_area_is_refused(corners, cells):
    flat = Piece({"name": "flat", "vertices": np.array(corners, float)})
    with pytest.raises(InputError, match="mesh 1: block 'flat' cannot be meshed: its outline"):
        meshed([flat], Mesh(blocks="flat", size=0.1, cells=cells))


def test_too_many_cells_of_all_bodies_are_refused_before_the_work():
    parts = [box(0, i, 400, 1, name=f"layer_{i}") for i in range(40)]
    with pytest.raises(InputError, match=r"give about 1.6e\+06 cells, more than 1000000"):
        meshed(parts, Mesh(blocks="*", size=0.1))


@pytest.mark.parametrize("fineness, cells", [("size = 0.7", "3.1e"), ("frequency = 65", "2.9e")])
def test_far_too_many_cells_are_refused_before_regions_are_cut(
    main, write_input, monkeypatch, fineness, cells
):
    """A region of 5 km, whose 1,800 joints take half a minute to cut."""
    monkeypatch.setattr("sitedda.build.building._cut_regions", lambda *_: pytest.fail("cut"))
    file = write_input(
        "&control time_step = 1e-3, steps = 6 /\n&joint name = 'j', friction_angle = 35.0 /\n"
        "&material name = 'rock', density = 2500.0, young_modulus = 2e9, poisson_ratio = 0.25 /\n"
        "&region name = 'r', outline = 0, 0, 5000, 0, 5000, 3000, 0, 3000 /\n"
        "&joint_set joint = 'j', angle = 20.0, spacing = 1.5 /\n"
        f"&mesh regions = 'r', {fineness} /"
    )
    process = main("check", file)
    assert process.returncode == 1 and f"would give about {cells}+0" in process.stderr


def test_a_block_is_meshed_once():
    first_mesh, second_mesh = Mesh(blocks="beam_1", size=1.0), Mesh(blocks="beam_*", size=1.0)
    with pytest.raises(InputError, match="mesh 2: 'beam_1' is already meshed by mesh 1"):
        meshed(BEAMS, first_mesh, second_mesh)


SQUARE = [0.0, 0, 20, 0, 20, 20, 0, 20]
INPUT = [
    ("material", {"name": "rock", **ROCK}, "line 1"),
    ("joint", {"name": "side"}, "line 2"),
    ("region", {"outline": SQUARE}, "line 3"),
    ("tunnel", {"centre": (10, 10), "width": 6.0}, "line 4"),
    ("block", {"name": "cap", "vertices": [0, 20, 9, 20, 9, 22, 0, 22]}, "line 5"),
    ("block", {"name": "rigid", "vertices": [10, 20, 12, 20, 12, 22, 10, 22]}, "line 6"),
]


def test_groups_of_an_input_become_cells():
    meshes = [
        ("mesh", {"regions": "rock", "size": 2.0}, "line 7"),
        ("mesh", {"blocks": "cap", "size": 1.0}, "line 8"),
    ]
    built = build_blocks([*INPUT, *meshes], ".")
    assert built.meshed == [4]
    assert {block.get("body") for block in built.blocks} == {"rock_1", "cap"}
    assert "18 cells of cap" in summary(built)
    alone = build_blocks([*INPUT, ("joint_line", {"points": [0, 10, 20, 10]}, "line 7")], ".")
    assert not alone.meshed and not any("body" in block for block in alone.blocks)


def test_a_ring_that_is_not_meshed_is_refused():
    with pytest.raises(InputError, match="line 3: a block is a ring .* or mesh it"):
        build_blocks(INPUT, ".")
    with pytest.raises(InputError, match="block 'rock_1' is a ring .* or mesh it"):
        build_blocks([*INPUT, ("mesh", {"blocks": "cap", "size": 1.0}, "line 7")], ".")


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"size": 1.0}, "give blocks or regions"),
        ({"blocks": "a", "regions": "b", "size": 1.0}, "either blocks or regions"),
        ({"blocks": "a"}, "give size or frequency"),
        ({"blocks": "a", "size": 1.0, "frequency": 1.0}, "either size or frequency"),
        ({"blocks": "a", "size": -1.0}, "size = -1 must be a positive number"),
        ({"blocks": "a", "size": float("nan")}, "size = nan must be"),
        ({"blocks": "a", "size": 1.0, "cells": "hexagon"}, "must be 'quadrilateral' or 'voronoi'"),
        ({"blocks": "a", "size": 1.0, "fine_size": 0.1}, "fine_size needs fine_at or fine_along"),
        ({"blocks": "a", "size": 1.0, "fine_at": [0, 0]}, "fine_at needs fine_size"),
        ({"blocks": "a", "size": 1.0, "fine_along": [0, 0], "fine_size": 0.1}, "at least 2"),
        ({"blocks": "a", "size": 1.0, "seed": -1}, "seed = -1"),
    ],
)
def test_contradictory_settings_are_refused(values, message):
    with pytest.raises(InputError, match=message):
        Mesh(**values)


def test_names_match_patterns_of_a_list():
    assert is_listed("roof_3", "beam, roof_*") and is_listed("beam", " beam ,x")
    assert not is_listed("roof", "roof_*") and not is_listed("beam_1", "beam")
