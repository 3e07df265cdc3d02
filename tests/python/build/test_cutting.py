# SPDX-License-Identifier: GPL-3.0-or-later
"""Regions cut into blocks: counts, areas, invariance, bounds, dead ends, slivers, seeds."""

import time

import numpy as np
import pytest
import shapely
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.special import ndtri
from scipy.stats import kstest, norm

from sitedda import InputError
from sitedda.cutting import (
    Cutting,
    Excavation,
    Hole,
    JointLine,
    JointSet,
    Region,
    Surface,
    Tunnel,
    Voronoi,
    cut,
    slivers,
)
from sitedda.cutting.distributions import draw, normal_quantile, uniform
from sitedda.cutting.network import CORNER, Network, _find_crossings
from sitedda.cutting.rings import Rings

SQUARE = [0.0, 0, 10, 0, 10, 10, 0, 10]
HEXAGON = 8 * np.column_stack([np.cos(a := np.arange(6) * np.pi / 3 + 0.1), np.sin(a)])
KEEP = Cutting(slivers="keep")


def areas(blocks):
    return Rings.of(blocks.polygons).areas()


def full_lines(count, seed, reach=30.0):
    """Lines across the whole region at random angles and positions, shape (count, 2, 2)."""
    random = np.random.default_rng(seed)
    angle = random.uniform(0, np.pi, count)
    along = np.column_stack([np.cos(angle), np.sin(angle)])
    foot = random.uniform(-6, 6, (count, 2))
    return np.stack([foot - reach * along, foot + reach * along], axis=1)


def as_joints(lines):
    return [JointLine(points=line, joint=f"j{i % 3}") for i, line in enumerate(lines)]


def check_partition(blocks, area):
    """Blocks are simple, do not overlap, and fill the area."""
    polygons = [shapely.Polygon(corners) for corners in blocks.polygons]
    assert all(polygon.is_valid and polygon.exterior.is_ccw for polygon in polygons)
    assert areas(blocks).sum() == pytest.approx(area, rel=1e-12)
    tree = shapely.STRtree(polygons)
    one, other = tree.query(polygons, predicate="overlaps")
    common = shapely.intersection(np.array(polygons)[one], np.array(polygons)[other])
    assert (shapely.area(common) < 1e-9 * area).all()
    assert [len(names) for names in blocks.edge_joints] == [len(p) for p in blocks.polygons]


# --- Counts and areas ----------------------------------------------------------------------------


@pytest.mark.parametrize("outline", [SQUARE, HEXAGON], ids=["square", "hexagon"])
@pytest.mark.parametrize("count", [1, 7, 60, 150])
def test_full_lines_make_one_block_and_one_for_each_line_and_crossing(outline, count):
    lines = full_lines(count, seed=count)
    region = shapely.Polygon(np.reshape(outline, (-1, 2)))
    parts = [shapely.LineString(line).intersection(region) for line in lines]
    lines_inside = [part for part in parts if part.length > 0]
    crossings = sum(
        one.crosses(other) for i, one in enumerate(lines_inside) for other in lines_inside[:i]
    )
    blocks = cut([Region(outline=outline)], as_joints(lines), settings=KEEP)
    assert len(blocks) == 1 + len(lines_inside) + crossings
    check_partition(blocks, region.area)


@pytest.mark.parametrize(("first", "second"), [(0.0, 90.0), (35.0, -80.0), (10.0, 170.0)])
def test_inner_areas_of_two_sets(first, second):
    spacings = 0.7, 0.5
    sets = [JointSet(angle=a, spacing=s) for a, s in zip((first, second), spacings, strict=True)]
    blocks = cut([Region(outline=SQUARE)], sets, settings=KEEP)
    inner = [corners for corners in blocks.polygons
             if (abs(corners - 5) < 5 - 1e-6).all() and len(corners) == 4]  # fmt: skip
    expected = spacings[0] * spacings[1] / np.sin(np.radians(first - second))
    assert len(inner) > 50
    assert abs(Rings.of(inner).areas() / abs(expected) - 1).max() < 1e-9
    check_partition(blocks, 100.0)


CONCAVE = [0, 0, 10, 0, 10, 10, 6, 10, 5, 3, 4, 10, 0, 10]
MIXED = (
    JointSet(joint="a", angle=20, spacing=0.8, angle_distribution="normal", angle_deviation=6),
    JointSet(
        joint="b", dip=70, spacing=0.9, spacing_distribution="exponential", trace_length=3.0,
        trace_length_distribution="log-normal", trace_length_deviation=1.0, bridge=0.8, seed=5,
    ),
    Voronoi(joint="v", size=2.5, seed=1),
)  # fmt: skip


@pytest.mark.parametrize("policy", ["keep", "merge"])
def test_areas_fill_a_concave_region_with_a_hole(policy):
    hole = Tunnel(centre=(2.0, 4.0), width=2.0, sides=16)
    blocks = cut([Region(outline=CONCAVE)], MIXED, holes=[hole], settings=Cutting(slivers=policy))
    region = shapely.Polygon(np.reshape(CONCAVE, (-1, 2)))
    check_partition(blocks, region.area - shapely.Polygon(hole.outline).area)
    assert len(blocks) > 150


def test_order_of_the_input_does_not_matter():
    joints = [*as_joints(full_lines(40, seed=3)), *MIXED]
    one = cut([Region(outline=SQUARE)], joints)
    other = cut([Region(outline=SQUARE[4:] + SQUARE[:4])], joints[::-1])
    assert one.names == other.names and one.edge_joints == other.edge_joints
    assert all(np.array_equal(p, q) for p, q in zip(one.polygons, other.polygons, strict=True))


def test_translation_and_rotation_change_rounding_alone():
    lines = full_lines(40, seed=9)
    region = np.reshape(SQUARE, (-1, 2)) - 5
    one = cut([Region(outline=region)], as_joints(lines), settings=KEEP)
    angle, shift = np.radians(77.0), np.array([3.0e5, -8.0e4])
    matrix = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    other = cut(
        [Region(outline=region @ matrix + shift)],
        as_joints(lines @ matrix + shift), settings=KEEP,
    )  # fmt: skip
    assert len(one) == len(other)
    centroids = Rings.of(one.polygons).centroids() @ matrix + shift
    tree = shapely.STRtree(shapely.points(Rings.of(other.polygons).centroids()))
    which, distance = tree.query_nearest(shapely.points(centroids), return_distance=True)
    assert sorted(which[1].tolist()) == list(range(len(one))) and distance.max() < 1e-8
    assert abs(areas(other)[which[1]] - areas(one)).max() < 1e-7


def test_twenty_thousand_blocks_in_three_seconds():
    spacing = np.sqrt(100 / 20_000)
    sets = [JointSet(angle=35, spacing=spacing), JointSet(angle=-55, spacing=spacing)]
    cut([Region(outline=SQUARE)], [JointSet(angle=35, spacing=1)])  # imports
    begun = time.process_time()
    blocks = cut([Region(outline=SQUARE)], sets, settings=KEEP)
    assert time.process_time() - begun < 3.0
    assert len(blocks) > 20_000
    assert areas(blocks).sum() == pytest.approx(100.0, rel=1e-12)


def test_poisson_lines_have_the_known_means():
    # Lines of density tau (length in an area) cut polygons of mean area pi / tau², perimeter
    # 2 pi / tau, with four sides; lines at random angles and distances from the middle.
    random, count, half = np.random.default_rng(4), 300, 10.0
    reach = half * np.sqrt(2)
    angle, offset = random.uniform(0, np.pi, count), random.uniform(-reach, reach, count)
    along = np.column_stack([np.cos(angle), np.sin(angle)])
    foot = offset[:, None] * np.column_stack([-np.sin(angle), np.cos(angle)])
    lines = np.stack([foot - 40 * along, foot + 40 * along], axis=1)
    region = half * np.array([-1.0, -1, 1, -1, 1, 1, -1, 1])
    blocks = cut([Region(outline=region)], as_joints(lines), settings=KEEP)
    square = shapely.Polygon(region.reshape(-1, 2))
    tau = sum(shapely.LineString(line).intersection(square).length for line in lines) / 400
    rings = Rings.of(blocks.polygons)
    inner = [i for i, p in enumerate(blocks.polygons) if (abs(p) < half - 1e-9).all()]
    assert rings.areas()[inner].mean() == pytest.approx(np.pi / tau**2, rel=0.15)
    sides = np.diff(rings.first)[inner]
    assert sides.mean() == pytest.approx(4.0, rel=0.02)


# --- Bounds --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        ([JointSet(angle=0, spacing=3e-3), JointSet(angle=90, spacing=3e-3)], "form about 1.1e+07"),
        ([JointSet(angle=0, spacing=1e-6)], "segments"),
        ([JointSet(angle=0, spacing=0.01, trace_length=0.01)], "segments"),
        ([Voronoi(size=1e-3)], "segments"),
        ([JointSet(angle=0, spacing=1e-3, origin=(1e5, 0))], "origin is over"),
    ],
    ids=["crossings", "lines", "traces", "polygons", "far origin"],
)
def test_too_many_blocks_are_refused_before_the_work(joints, message):
    begun = time.process_time()
    with pytest.raises(InputError) as error:
        cut([Region(outline=SQUARE)], joints)
    assert message in str(error.value)
    assert time.process_time() - begun < 1.0


def test_most_blocks_is_a_limit():
    sets = [JointSet(angle=0, spacing=1.0), JointSet(angle=90, spacing=1.0)]
    assert len(cut([Region(outline=SQUARE)], sets, settings=Cutting(most_blocks=100))) == 100
    for limit, message in ((99, "form 100 blocks"), (50, "form about")):
        with pytest.raises(InputError, match=message):
            cut([Region(outline=SQUARE)], sets, settings=Cutting(most_blocks=limit))


BAD = {
    "zero spacing": (lambda: JointSet(angle=0, spacing=0), "spacing = 0"),
    "no angle": (lambda: JointSet(spacing=1), "give angle or dip"),
    "nan angle": (lambda: JointSet(angle=np.nan, spacing=1), "angle = nan"),
    "bridge alone": (lambda: JointSet(angle=0, spacing=1, bridge=1), "bridge needs"),
    "distribution": (
        lambda: JointSet(angle=0, spacing=1, spacing_distribution="gauss"), "= 'gauss' must be",
    ),
    "deviation": (lambda: JointSet(angle=0, spacing=1, angle_deviation=3), "angle_deviation: omit"),
    "negative seed": (lambda: Voronoi(size=1, seed=-1), "seed"),
    "crossing outline": (lambda: Region(outline=[0, 0, 1, 1, 1, 0, 0, 1]), "crosses or touches"),
    "two points": (lambda: Region(outline=[0, 0, 1, 1]), "at least 3"),
    "odd": (lambda: Region(outline=[0, 0, 1, 1, 1]), "pairs"),
    "nan": (lambda: Region(outline=[0, 0, 1, np.nan, 1, 1]), "point 2"),
    "surface back": (lambda: Surface(points=[0, 0, 2, 1, 1, 1]), "point 3"),
    "no region": (lambda: cut([]), "nothing to cut"),
    "hole outside": (
        lambda: cut([Region(outline=SQUARE)], holes=[Hole(outline=np.add(SQUARE, 20))]),
        "outside all regions"),
    "all hole": (
        lambda: cut([Region(outline=SQUARE)], holes=[Hole(outline=SQUARE)]), "cover the regions",
    ),
    "unknown region": (
        lambda: cut([Region(outline=SQUARE)], [JointSet(angle=0, spacing=1, region="x")]),
        "region = 'x'"),
    "overlap": (lambda: cut([Region(name="a", outline=SQUARE), Region(name="b", outline=SQUARE)]),
                "'a' and 'b' overlap by 100"),
    "ring": (lambda: cut([Region(outline=SQUARE)], holes=[Hole(outline=[4, 4, 6, 4, 6, 6, 4, 6])]),
             "is a ring around the hole"),
    "many corners": (
        lambda: cut([Region(outline=[(np.cos(a), np.sin(a)) for a in np.arange(600) / 96])]),
        "600 corners"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_refused_in_words(name):
    make, message = BAD[name]
    with pytest.raises(InputError) as error:
        make()
    assert message in str(error.value)


# --- Dead ends, snapping, loops ------------------------------------------------------------------


def test_dead_ends_are_removed():
    through = JointLine(points=[0, 5, 10, 5])
    ends = [JointLine(points=[5, 5, 5, 8]), JointLine(points=[2, 2, 3, 3, 3, 4])]
    blocks = cut([Region(outline=SQUARE)], [through, *ends], settings=KEEP)
    assert sorted(areas(blocks)) == [50, 50] and blocks.dead_ends == 3
    assert [len(corners) for corners in blocks.polygons] == [4, 4]


@pytest.mark.parametrize("miss", [1e-13, -1e-13, 3e-9, -3e-9])
def test_joints_that_miss_an_outline_by_rounding_reach_it(miss):
    joint = JointLine(points=[miss, 5 + 2 * miss, 10 - miss, 5])
    blocks = cut([Region(outline=SQUARE)], [joint], settings=KEEP)
    assert len(blocks) == 2
    assert areas(blocks).sum() == pytest.approx(100, rel=1e-12)
    assert len(cut([Region(outline=SQUARE)], [JointLine(points=[1e-6, 5, 10, 5])])) == 1


def test_loops_inside_one_block_are_omitted_and_reported():
    loop = JointLine(points=[4, 4, 6, 4, 5, 6, 4, 4])
    touching = JointLine(points=[0, 3, 2, 2, 2, 4, 0, 3])  # touches the outline at one point
    blocks = cut([Region(outline=SQUARE)], [loop, touching], settings=KEEP)
    assert len(blocks) == 1 and blocks.loops == 2
    assert "2 loops of joints" in blocks.messages[0]


def test_coincident_segments_become_one_edge():
    joints = [
        JointLine(points=[0, 5, 10, 5], joint="fault"),
        JointSet(joint="set", angle=0, spacing=2.5),
        JointLine(points=[2, 5, 7, 5], joint="fault"),
    ]
    blocks = cut([Region(outline=SQUARE, joint="free")], joints, settings=KEEP)
    assert len(blocks) == 4
    bottom, middle, top = ["set", "free"], ["fault", "free"], ["set", "free"]
    expected = [bottom + top, bottom + middle, middle + top, bottom + top]
    assert blocks.edge_joints == expected
    assert blocks.joints == ["set", "fault", "fault", "set"]


def test_each_edge_has_the_joint_that_cut_it():
    sets = [JointSet(joint="a", angle=30, spacing=1.1), JointSet(joint="b", angle=-50, spacing=0.9)]
    blocks = cut([Region(outline=SQUARE, joint="free")], sets)
    angles = {"a": 30.0, "b": 130.0}
    for corners, names in zip(blocks.polygons, blocks.edge_joints, strict=True):
        along = np.roll(corners, -1, axis=0) - corners
        inclination = np.degrees(np.arctan2(along[:, 1], along[:, 0])) % 180
        for name, angle in zip(names, inclination, strict=True):
            if name in angles:
                assert angle == pytest.approx(angles[name], abs=1e-6)
            else:
                assert min(angle % 90, 90 - angle % 90) < 1e-6


coordinate = st.integers(0, 6) | st.sampled_from([1e-9, 1e-6, 1e-3, 3 + 1e-8, 5.999])
point = st.tuples(coordinate, coordinate)


@settings(max_examples=50, deadline=None)
@given(
    lines=st.lists(st.tuples(point, point), min_size=1, max_size=25),
    outline=st.sampled_from([[0, 0, 6, 0, 6, 6, 0, 6], [0, 0, 6, 0, 6, 6, 3, 2, 0, 6]]),
    policy=st.sampled_from([{"slivers": "keep"}, {}, {"least_edge": 0.05}, {"least_angle": 20.0}]),
)
@example(  # a crossing close to two outlines
    lines=[((0, 1), (4, 0)), ((0, 6), (1, 3)), ((0, 5.999), (3, 0))],
    outline=[0, 0, 6, 0, 6, 6, 3, 2, 0, 6],
    policy={},
)
def test_any_lines_cut_a_region_into_simple_blocks(lines, outline, policy):
    joints = [JointLine(points=np.array(line, dtype=float)) for line in lines]
    blocks = cut([Region(outline=outline)], joints, settings=Cutting(**policy))
    polygons = [shapely.Polygon(corners) for corners in blocks.polygons]
    assert all(polygon.is_valid for polygon in polygons)
    area = shapely.Polygon(np.reshape(outline, (-1, 2))).area
    assert areas(blocks).sum() == pytest.approx(area, rel=1e-11)


# --- Slivers -------------------------------------------------------------------------------------

WEDGE = [JointLine(points=[0, 5, 10, 5]), JointLine(points=[0, 4.9999, 10, 4.998], joint="near")]


def test_slivers_are_merged_with_the_neighbour_of_the_longest_common_edge():
    # The triangle in the corner has its longest side with the large block.
    joints = [JointLine(points=[0, 0.1, 0.2, 0]), JointLine(points=[0, 5, 10, 5])]
    region = [Region(outline=SQUARE)]
    unmerged = cut(region, joints, settings=KEEP)
    assert (
        len(unmerged) == 3
        and len(unmerged.slivers) == 1
        and "area 0.01 m²" in str(unmerged.slivers[0])
    )
    merged = cut(region, joints)
    assert len(merged) == 2 and merged.merged == 1 and not merged.slivers
    assert "1 sliver was merged" in merged.messages[-1]
    assert areas(merged).sum() == 100
    with pytest.raises(InputError, match=r"1 block is a sliver: block 1 rock_1 at \(0.0"):
        cut(region, joints, settings=Cutting(slivers="refuse"))


def test_a_sliver_is_not_merged_across_a_material():
    surfaces = [Surface(points=[0, 5], material="clay")]
    joints = [JointLine(points=[0, 5.01, 10, 5.01])]
    region = Region(outline=SQUARE, material="sand")
    blocks = cut([region], joints, surfaces, settings=Cutting(least_area=0.5, least_edge=0))
    assert sorted(blocks.materials) == ["clay", "sand"]
    assert areas(blocks)[blocks.materials.index("clay")] == pytest.approx(50)


def test_thin_blocks_vanish_with_least_edge_and_sharp_ones_with_least_angle():
    region = [Region(outline=SQUARE)]
    assert len(cut(region, WEDGE, settings=KEEP)) == 3
    flat = cut(region, WEDGE, settings=Cutting(least_edge=0.01))
    assert len(flat) == 2 and "merged with others" in flat.messages[0]
    sharp = cut(region, [JointLine(points=[0, 0, 10, 1])], settings=Cutting(least_angle=8))
    assert len(sharp) == 1
    check_partition(flat, 100.0)


@settings(max_examples=12, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    least_edge=st.sampled_from([0.1, 0.3]),
    shape=st.sampled_from(["circle", "horseshoe", "rectangle"]),
    place=st.tuples(st.floats(2, 8), st.floats(2, 8)),
)
@example(seed=1115, least_edge=0.3, shape="circle", place=(2, 2))
@example(seed=8980, least_edge=0.1, shape="horseshoe", place=(5.591186665513415, 5.634437216308598))
def test_outlines_keep_their_shape_when_corners_are_merged(seed, least_edge, shape, place):
    hole = Tunnel(centre=place, width=1.5, height=2.5, shape=shape, sides=16)  # of short sides
    joints = [
        JointSet(angle=20, spacing=0.9, spacing_distribution="exponential", seed=seed),
        JointSet(angle=80, spacing=1.2, angle_distribution="normal", angle_deviation=12, seed=seed),
        Voronoi(size=2.0, seed=seed),
    ]
    policy = Cutting(least_edge=least_edge, least_area=0.2, least_angle=12)
    blocks = cut([Region(outline=CONCAVE)], joints, holes=[hole], settings=policy)
    outline = shapely.Polygon(np.reshape(CONCAVE, (-1, 2)))
    check_partition(blocks, outline.difference(shapely.Polygon(hole.outline)).area)


def pairs_of_edges(ends):
    """A network of pairs of edges from their ends, shape (pairs, 4, 2)."""
    edges = np.arange(2 * ends.shape[0] * 2).reshape(-1, 2)
    nodes = ends.reshape(-1, 2)
    kinds, labels = np.full(len(nodes), CORNER), np.zeros(len(edges), dtype=int)
    return Network(nodes, kinds, edges, labels, labels == 0)


def random_lines(count, seed):
    """A position, a direction and the normal direction of each line, shape (count, 2)."""
    random = np.random.default_rng(seed)
    angle = random.uniform(0, 2 * np.pi, count)
    along = np.column_stack([np.cos(angle), np.sin(angle)])
    return random, random.uniform(-10, 10, (count, 2)), along, along[:, ::-1] * [-1, 1]


def crossings_found(ends):
    """Number of pairs of edges that are found to cross, each pair by itself."""
    network = pairs_of_edges(ends)
    one = 2 * np.arange(len(ends))
    return len(_find_crossings(network, one, one + 1, np.ones(len(one), dtype=bool))[0])


def test_edges_of_one_side_do_not_cross_by_rounding():
    random, foot, along, _ = random_lines(200_000, 1)
    fraction = np.sort(random.uniform(-5, 5, (len(foot), 4)), axis=1)
    assert crossings_found(foot[:, None] + fraction[:, :, None] * along[:, None]) == 0


@pytest.mark.parametrize("angle", [1e-9, 1e-6, 1e-3, 1.0])
def test_edges_that_cross_at_a_small_angle_are_found(angle):
    random, foot, along, across = random_lines(2_000, 2)
    reach = random.uniform(2, 5, (len(foot), 4, 1)) * [[-1], [1], [-1], [1]]
    rotated = np.cos(angle) * along + np.sin(angle) * across
    arms = np.stack([along, along, rotated, rotated], axis=1)
    assert crossings_found(foot[:, None] + reach * arms) == len(foot)


def test_slivers_of_imported_polygons_are_named():
    squares = [np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) + (i, 0) for i in range(5)]
    thin = [
        np.array([(0, 2), (1, 2), (1, 2 + 1e-5)]),
        np.array([(0, 3), (1, 3), (1, 4), (1 - 1e-6, 4)]),
    ]
    sliver_list = slivers(squares + thin, names=[f"b{i}" for i in range(7)])
    assert [sliver.index for sliver in sliver_list] == [5, 6]
    assert "block 6 b5" in str(sliver_list[0]) and "area 5e-06 m²" in sliver_list[0].reason
    assert (
        "corner of 0.000573°" in sliver_list[0].reason
        and "edge of 1e-06 m" in sliver_list[1].reason
    )
    assert slivers(squares) == [] and slivers([]) == []


# --- Regions, surfaces, holes --------------------------------------------------------------------


def test_surfaces_give_materials_from_the_top_down():
    surfaces = [
        Surface(points=[0, 8, 5, 9, 10, 8], material="clay", joint="top"),
        Surface(points=[3, 4], material="sand"),
    ]
    blocks = cut([Region(outline=SQUARE, material="soil")], surfaces=surfaces, settings=KEEP)
    assert blocks.materials == ["sand", "clay", "soil"]
    assert areas(blocks).tolist() == pytest.approx([40, 45, 15])
    assert blocks.edge_joints[1].count("top") == 2
    with pytest.raises(InputError, match="surface 2 lies above surface 1: .* top down"):
        cut([Region(outline=SQUARE, material="soil")], surfaces=surfaces[::-1], settings=KEEP)
    outcrop = Surface(points=[0, 0, 10, 10], material="clay")  # the surfaces cross
    cut([Region(outline=SQUARE, material="soil")], surfaces=[outcrop, surfaces[1]], settings=KEEP)


def test_regions_side_by_side_share_corners():
    left, right = [0, 0, 5, 0, 5, 10, 0, 10], [5, 0, 10, 0, 10, 10, 5, 10]
    regions = [Region(name="left", outline=left), Region(name="right", outline=right)]
    joints = [JointSet(angle=10, spacing=2, region="left"), JointLine(points=[0, 5, 10, 5])]
    blocks = cut(regions, joints, settings=KEEP)
    assert blocks.regions.count("right") == 2 and blocks.regions.count("left") > 6
    assert [name.rsplit("_")[0] for name in blocks.names] == blocks.regions
    check_partition(blocks, 100.0)


def test_a_hole_stays_empty_and_an_excavation_keeps_its_blocks():
    joint = JointLine(points=[0, 5, 10, 5])
    outline = [4, 4, 6, 4, 6, 6, 4, 6]
    empty = cut([Region(outline=SQUARE)], [joint], holes=[Hole(outline=outline, joint="wall")])
    assert len(empty) == 2 and areas(empty).sum() == pytest.approx(96, rel=1e-12)
    assert all(names.count("wall") == 3 for names in empty.edge_joints)
    pit = Excavation(name="pit", outline=outline)
    full = cut([Region(outline=SQUARE)], [joint], excavations=[pit])
    assert sorted(full.names) == ["pit_1", "pit_2", "rock_1", "rock_2"]


@pytest.mark.parametrize("shape", ["circle", "horseshoe", "rectangle"])
def test_tunnels_have_the_given_width_and_height(shape):
    tunnel = Tunnel(centre=(1, 2), width=4, height=5, shape=shape, sides=64)
    low, high = tunnel.outline.min(axis=0), tunnel.outline.max(axis=0)
    assert high - low == pytest.approx([4, 5], rel=2e-3) and high + low == pytest.approx([2, 4])
    area = {"circle": np.pi * 5, "horseshoe": 12 + np.pi * 2, "rectangle": 20}[shape]
    assert shapely.Polygon(tunnel.outline).area == pytest.approx(area, rel=2e-3)


def test_random_polygons_have_the_given_size_and_become_even():
    spread = []
    for iterations in (0, 10):
        blocks = cut(
            [Region(outline=np.multiply(SQUARE, 3))],
            [Voronoi(size=1.0, iterations=iterations, seed=2)], settings=KEEP,
        )  # fmt: skip
        inner = areas(blocks)[areas(blocks) > 0.05]
        assert np.mean(inner) == pytest.approx(1.0, rel=0.15)
        spread.append(inner.std())
        check_partition(blocks, 900.0)
    assert spread[1] < 0.5 * spread[0]


# --- Random numbers ------------------------------------------------------------------------------


def philox(key, counter, count):
    """Philox 4×64 of ten rounds in whole numbers (Salmon et al. 2011)."""
    mask, values = 2**64 - 1, []
    for block in range(1, count // 4 + 2):
        (k0, k1), c = key, [counter[0] + block, *counter[1:]]
        for _ in range(10):
            one, two = 0xD2E7470EE14C6C93 * c[0], 0xCA5A826395121157 * c[2]
            c = [(two >> 64) ^ c[1] ^ k0, two & mask, (one >> 64) ^ c[3] ^ k1, one & mask]
            k0, k1 = (k0 + 0x9E3779B97F4A7C15) & mask, (k1 + 0xBB67AE8584CAA73B) & mask
        values += c
    return values[:count]


def test_uniform_numbers_come_from_philox():
    raw = philox((12345, 5), (0, 1, 7, 0), 9)
    assert uniform(12345, (5, 1, 7), 9).tolist() == [((r >> 12) + 0.5) / 2**52 for r in raw]
    assert uniform(12345, (5, 1, 7), 4).tolist() == uniform(12345, (5, 1, 7), 9)[:4].tolist()


def test_the_inverse_normal_distribution():
    tail = np.geomspace(1e-300, 0.5, 500)
    fraction = np.concatenate([tail, 1 - np.geomspace(1e-15, 0.5, 500)])
    expected = ndtri(fraction)
    assert abs(normal_quantile(fraction) - expected).max() < 1e-14 * abs(expected).max()


@pytest.mark.parametrize(
    ("distribution", "cdf"),
    [
        ("uniform", lambda x: (x - 1) / 2),
        ("normal", lambda x: norm.cdf(x, 2, 1)),
        (
            "log-normal",
            lambda x: norm.cdf((np.log(x / 2) + 0.5 * np.log(1.25)) / np.sqrt(np.log(1.25))),
        ),
        ("exponential", lambda x: 1 - np.exp(-x / 2)),
    ],
)
def test_distributions(distribution, cdf):
    samples = draw(uniform(1, (0,), 20_000), distribution, 2.0, 1.0)
    assert samples.mean() == pytest.approx(2.0, abs=0.03)
    assert kstest(samples, cdf).pvalue > 0.01


def test_a_larger_region_contains_the_joints_of_a_smaller_one():
    joints = JointSet(
        angle=25, spacing=0.5, spacing_distribution="normal", spacing_deviation=0.1, seed=11,
        trace_length=2, trace_length_distribution="exponential", bridge=0.5,
        angle_distribution="uniform", angle_deviation=5, bridge_distribution="exponential",
    )  # fmt: skip
    small = {tuple(map(float, s.ravel())) for s in joints.segments(np.zeros(2), 5.0)}
    large = {tuple(map(float, s.ravel())) for s in joints.segments(np.array([2.0, 1]), 12.0)}
    assert len(small) > 50 and small <= large
    other = {tuple(map(float, s.ravel())) for s in JointSet(
        angle=25, spacing=0.5, spacing_distribution="normal", spacing_deviation=0.1, seed=12,
    ).segments(np.zeros(2), 5.0)}  # fmt: skip
    assert not small & other


def test_persistence_is_trace_over_trace_and_bridge():
    joints = JointSet(angle=15, spacing=0.2, trace_length=3.0, bridge=1.0, stagger=0.5)
    segments = joints.segments(np.zeros(2), 20.0)
    disc = shapely.Point(0, 0).buffer(15, 64)
    length = shapely.length(shapely.intersection(shapely.linestrings(segments), disc)).sum()
    assert length / disc.area == pytest.approx(0.75 / 0.2, rel=0.01)
