# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies divided into cells: areas, convexity, faces, sizes, invariance, bounds."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from sitedda import InputError
from sitedda.cutting.rings import Rings
from sitedda.meshing.body import Part, mesh_body

UTM = np.array([512_345.678, 4_649_776.224])
CELLS = ["quadrilateral", "voronoi"]


def circle(radius, sides=32, middle=(0.0, 0.0)):
    angle = 2 * np.pi * (np.arange(sides) + 0.5) / sides
    return radius * np.column_stack([np.cos(angle), np.sin(angle)]) + middle


def part(outline, size, holes=(), joint="rim"):
    outline = np.reshape(outline, (-1, 2)).astype(float)
    own = [(np.asarray(hole, float), ["hole"] * len(hole)) for hole in holes]
    return Part(outline, [joint] * len(outline), size, own)


def shape_of(parts):
    return shapely.union_all(
        [shapely.Polygon(part.outline, [hole for hole, _ in part.holes]) for part in parts]
    )


def sharpest_turn(polygons):
    """Sine of the sharpest turn to the right of any polygon."""
    worst = 0.0
    for corners in polygons:
        after, before = np.roll(corners, -1, 0) - corners, corners - np.roll(corners, 1, 0)
        cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        worst = min(worst, (cross / np.hypot(*after.T) / np.hypot(*before.T)).min())
    return worst


def common_lengths(polygons, tolerance):
    """Length of the edges of each cell, and length shared with edges of other cells."""
    rings = [shapely.LinearRing(corners) for corners in polygons]
    tree = shapely.STRtree(rings)
    one, other = tree.query(rings, predicate="dwithin", distance=tolerance)
    shared = np.zeros(len(rings))
    for i, k in zip(one, other, strict=True):
        if i != k:
            shared[i] += common(polygons[i], polygons[k], tolerance)
    return np.array([ring.length for ring in rings]), shared


def common(first, second, near):
    """Length of the common part of the edges of two convex polygons, by projection."""
    total = 0.0
    for a, b in zip(first, np.roll(first, -1, 0), strict=True):
        length = np.hypot(*(b - a))
        direction = (b - a) / length
        for c, d in zip(second, np.roll(second, -1, 0), strict=True):
            distances = [abs(direction[0] * (p - a)[1] - direction[1] * (p - a)[0]) for p in (c, d)]
            if max(distances) < near:
                low, high = sorted((direction @ (c - a), direction @ (d - a)))
                total += max(0.0, min(length, high) - max(0.0, low))
    return total


def check_cells(mesh, parts, area_tolerance=1e-12):
    """Check that cells are convex, fill the parts without overlap, and share faces or outlines."""
    domain = shape_of(parts)
    polygons = [shapely.Polygon(corners) for corners in mesh.polygons]
    assert sharpest_turn(mesh.polygons) > -1e-6
    for i, one in enumerate(parts):
        body = shape_of([one])
        cells = Rings.of([p for p, k in zip(mesh.polygons, mesh.parts, strict=True) if k == i])
        assert cells.areas().sum() == pytest.approx(body.area, rel=area_tolerance)
    tree = shapely.STRtree(polygons)
    first, second = tree.query(polygons, predicate="overlaps")
    tolerance = 1e-9 * np.sqrt(domain.area) + 16 * np.spacing(abs(parts[0].outline).max())
    # Without a grid, the intersection of two touching cells may be one of these cells.
    pairs = np.array(polygons)[first], np.array(polygons)[second]
    shared = shapely.intersection(*pairs, grid_size=tolerance)
    assert shapely.area(shared).max(initial=0.0) < tolerance * np.sqrt(domain.area)
    around, within = common_lengths(mesh.polygons, tolerance)
    boundary = domain.length
    assert around.sum() - within.sum() == pytest.approx(boundary, rel=1e-6)


def same(one, other, shift=0.0, within=0.0):
    return len(one.polygons) == len(other.polygons) and all(
        p.shape == q.shape and abs(p + shift - q).max() <= within
        for p, q in zip(one.polygons, other.polygons, strict=True))  # fmt: skip


SHAPES = {
    "beam": [part([0, 0, 10, 0, 10, 1, 0, 1], 0.25)],
    "voussoir": [part([0, 0, 1.1, 0.2, 1.5, 1.4, -0.1, 1.1], 0.2)],
    "triangle": [part([0, 0, 9, 1, 3, 7], 0.8)],
    "ridge": [part([-20, 0, 20, 0, 20, 5, 5, 5, 0, 10, -5, 5, -20, 5], 1.0)],
    "tunnel": [part([-10, -10, 10, -10, 10, 10, -10, 10], 1.2, [circle(2.5)])],
    "disc": [part(circle(5.0), 0.8)],
    "layers": [part([0, 0, 10, 0, 10, 3.2, 0, 4], 1.0), part([0, 4, 10, 3.2, 10, 7, 0, 7], 0.5)],
    "inclusion": [
        part([0, 0, 8, 0, 8, 8, 0, 8], 1.0, [circle(1.5, 20, (4, 4))[::-1]]),
        part(circle(1.5, 20, (4, 4)), 1.0),
    ],
    "L": [part([0, 0, 10, 0, 10, 4, 3.3, 4, 3.3, 9, 0, 9], 0.7)],
}


@pytest.mark.parametrize("cells", CELLS)
@pytest.mark.parametrize("name", SHAPES)
def test_cells_fill_the_body_and_are_convex(name, cells):
    parts = SHAPES[name]
    cut = mesh_body(parts, cells)
    check_cells(cut, parts)
    area = shape_of(parts).area
    expected = sum(shape_of([part]).area / part.size**2 for part in parts)
    assert 0.6 * expected < len(cut.polygons) < 2.0 * expected + 10
    assert not len(cut.short)
    mean = area / len(cut.polygons)
    assert Rings.of(cut.polygons).areas().min() > 0.02 * mean


@st.composite
def bodies(draw):
    """Draw a simple polygon, round or toothed, with or without a hole, and a cell size."""
    count = draw(st.integers(3, 12))
    random = np.random.default_rng(draw(st.integers(0, 2**31)))
    angle = 2 * np.pi * (np.arange(count) + random.uniform(0.1, 0.9, count)) / count
    reach = random.uniform(draw(st.sampled_from([0.4, 0.8, 1.0])), 1.0, count)
    outline = 10 * reach[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    polygon = shapely.Polygon(outline)
    room = shapely.Point(0, 0).distance(polygon.exterior) if polygon.contains_properly(
        shapely.Point(0, 0)
    ) else 0.0  # fmt: skip
    holes = []
    if room > 1.0 and draw(st.booleans()):
        holes = [circle(0.6 * room, draw(st.integers(4, 40)))]
    return part(outline, draw(st.floats(0.5, 3.0)), holes)


@settings(max_examples=60, deadline=None)
@given(bodies(), st.sampled_from(CELLS))
def test_any_body_is_filled_with_convex_cells(one, cells):
    cut = mesh_body([one], cells)
    check_cells(cut, [one])
    length = Rings.of(cut.polygons).edge_lengths()
    smallest = min([one.size, *(0.5 * np.ptp(hole, axis=0).min() for hole, _ in one.holes)])
    assert (length < 0.05 * smallest).sum() <= len(cut.short)


@pytest.mark.parametrize("cells", CELLS)
@pytest.mark.parametrize("name", SHAPES)
def test_cells_do_not_depend_on_where_an_outline_begins(name, cells):
    parts = SHAPES[name]
    shifted_parts = [
        Part(
            np.roll(part.outline, 2, axis=0), part.joints, part.size,
            [(np.roll(hole, 3, axis=0)[::-1], joints) for hole, joints in part.holes],
        )
        for part in parts
    ]  # fmt: skip
    assert same(mesh_body(parts, cells), mesh_body(shifted_parts, cells))


@pytest.mark.parametrize("cells", CELLS)
@pytest.mark.parametrize("name", SHAPES)
def test_cells_far_away_are_the_same(name, cells):
    parts = SHAPES[name]
    far_parts = [
        Part(part.outline + UTM, part.joints, part.size, [(h + UTM, j) for h, j in part.holes])
        for part in parts]  # fmt: skip
    far = mesh_body(far_parts, cells)
    assert same(mesh_body(parts, cells), far, UTM, 1e-6)
    check_cells(far, far_parts, area_tolerance=1e-9)


def test_a_rotated_rectangle_is_divided_into_rectangles():
    rotation = np.array([[0.8, 0.6], [-0.6, 0.8]])
    for matrix in (np.eye(2), rotation):
        box = np.reshape([0.0, 0, 3, 0, 3, 1, 0, 1], (-1, 2)) @ matrix
        cut = mesh_body([part(box, 0.26)])
        assert len(cut.polygons) == 12 * 4
        assert Rings.of(cut.polygons).areas() == pytest.approx(1 / 16, rel=1e-12)


@pytest.mark.parametrize("cells", CELLS)
@pytest.mark.parametrize(
    "fine", [shapely.Point(2, 2), shapely.LineString([(0, 0), (10, 10)])], ids=["point", "line"]
)
def test_cells_grow_with_the_distance_from_small_cells(cells, fine):
    one = part([0, 0, 20, 0, 20, 20, 0, 20], 2.0)
    cut = mesh_body([one], cells, [fine], 0.25)
    check_cells(cut, [one])
    rings = Rings.of(cut.polygons)
    size = np.sqrt(rings.areas())
    distance = shapely.distance(shapely.points(rings.centroids()), fine)
    expected = np.minimum(2.0, 0.25 + 0.25 * distance)
    assert (size < 1.9 * expected + 0.1).all()
    assert (size > 0.3 * expected).mean() > 0.95
    assert size[distance < 0.5].mean() < 0.45 and size[distance > 9].mean() > 1.4


def test_boundaries_of_materials_are_edges_of_cells():
    parts = SHAPES["layers"]
    cut = mesh_body(parts)
    shapes = [shape_of([part]) for part in parts]
    for corners, own in zip(cut.polygons, cut.parts, strict=True):
        cell = shapely.Polygon(corners)
        assert cell.intersection(shapes[own]).area == pytest.approx(cell.area, rel=1e-9)


def test_edge_joints_stay_on_the_outline():
    box = np.reshape([0.0, 0, 4, 0, 4, 2, 0, 2], (-1, 2))
    cut = mesh_body([Part(box, ["low", "right", "up", "left"], 0.5)])
    total = dict.fromkeys(["", "low", "right", "up", "left"], 0.0)
    for corners, joints in zip(cut.polygons, cut.joints, strict=True):
        for length, joint in zip(Rings.of([corners]).edge_lengths(), joints, strict=True):
            total[joint] += length
    inner = 2 * (7 * 2.0 + 3 * 4.0)  # seven vertical and three horizontal lines, both sides
    assert total == pytest.approx({"low": 4, "right": 2, "up": 4, "left": 2, "": inner})


@pytest.mark.parametrize("cells", CELLS)
@pytest.mark.parametrize("at", [0.9, 1.3, 2.0])
def test_a_joint_that_ends_on_a_side_ends_at_a_corner_of_cells(cells, at):
    outline = np.reshape([0.0, 0, at, 0, 4, 0, 4, 2, 1.5, 2, 0, 2], (-1, 2))
    parts = [Part(outline, ["low", "tie", "rim", "rim", "tie", "rim"], 0.5)]
    cut = mesh_body(parts, cells)
    check_cells(cut, parts)
    assert not Rings.of(cut.polygons).straight(1e-9).any()


def test_corners_of_the_outline_are_bit_identical():
    rim = SHAPES["ridge"][0].outline + UTM
    cut = mesh_body([part(rim, 1.0)])
    corners = {tuple(corner) for polygon in cut.polygons for corner in polygon.tolist()}
    assert {tuple(corner) for corner in rim.tolist()} <= corners


def test_unconnected_parts_are_refused():
    parts = [part([0, 0, 1, 0, 1, 1, 0, 1], 0.5), part([3, 0, 4, 0, 4, 1, 3, 1], 0.5)]
    with pytest.raises(InputError, match="has 2 parts"):
        mesh_body(parts)


LARGE, SLIVER = [0, 0, 1e3, 0, 1e3, 1e3, 0, 1e3], [0, 0, 1e6, 0, 1e6, 4e-6]


@pytest.mark.parametrize("cells", CELLS)
@pytest.mark.parametrize(("outline", "size"), [(LARGE, 1e-3), (LARGE, 1e-300), (SLIVER, 0.1)])
def test_too_many_cells_are_refused_before_the_work(cells, outline, size):
    with pytest.raises(InputError, match="more than 1000000; choose"):
        mesh_body([part(outline, size)], cells)


@pytest.mark.parametrize("cells", CELLS)
@pytest.mark.parametrize("fine", [1e-9, 1e-300, 5e-324])
def test_cells_too_small_for_their_coordinates_are_refused(cells, fine):
    with pytest.raises(InputError, match="choose"):
        mesh_body([part([0, 0, 4, 0, 4, 3, 0, 3], 1.0)], cells, [shapely.Point(1, 1)], fine)


@pytest.mark.parametrize("cells", CELLS)
def test_ten_thousand_cells(cells):
    cut = mesh_body([part([0, 0, 100, 0, 103, 77, 100, 100, 0, 100], 1.0)], cells)
    assert len(cut.polygons) > 9_500
