# SPDX-License-Identifier: GPL-3.0-or-later
# Made from fortran/input/schema.txt by fortran/input/make_schema.py.
"""The values of groups that become blocks, with their defaults."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from numpy.typing import ArrayLike as Numbers
from numpy.typing import ArrayLike as Points

from .values import Values


@dataclass(kw_only=True)
class RegionValues(Values):
    """&region: a polygon to be cut into blocks.

    Attributes
    ----------
    name : str
        its blocks are name_1, name_2 … from below; at most 56 bytes ('rock').
    outline : Points, m
        x, y, x, y … of its corners in either sense (required).
    material : str
        material of the blocks; the name of a &material (the first).
    joint : str
        joint of their sides; the name of a &joint (the first).
    """

    group: ClassVar[str] = "region"
    from_file: ClassVar[str] = "outline"
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("name", "name", 0, False, "at most 56 bytes"),
        ("outline", "points", 100000, True, "any"),
        ("material", "name", 0, False, "the name of a &material"),
        ("joint", "name", 0, False, "the name of a &joint"),
    )

    name: str | None = "rock"
    outline: Points | None = None
    material: str | None = ""
    joint: str | None = ""


@dataclass(kw_only=True)
class SurfaceValues(Values):
    """&surface: a line from left to right, below which another material may begin.

    Attributes
    ----------
    points : Points, m
        x, y, x, y … with growing x; level beyond the ends (required).
    material : str
        of the blocks below, down to the next surface; the name of a &material (as it was).
    joint : str
        of the cut; the name of a &joint (the first).
    """

    group: ClassVar[str] = "surface"
    from_file: ClassVar[str] = "points"
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("points", "points", 100000, True, "any"),
        ("material", "name", 0, False, "the name of a &material"),
        ("joint", "name", 0, False, "the name of a &joint"),
    )

    points: Points | None = None
    material: str | None = ""
    joint: str | None = ""


@dataclass(kw_only=True)
class JointLineValues(Values):
    """&joint_line: a single joint or a fault.

    Attributes
    ----------
    points : Points, m
        x, y, x, y … of its bends (required).
    joint : str
        of the cut; the name of a &joint (the first).
    region : str
        the only region that is cut; the name of a &region (all).
    """

    group: ClassVar[str] = "joint_line"
    from_file: ClassVar[str] = "points"
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("points", "points", 100000, True, "any"),
        ("joint", "name", 0, False, "the name of a &joint"),
        ("region", "name", 0, False, "the name of a &region"),
    )

    points: Points | None = None
    joint: str | None = ""
    region: str | None = ""


@dataclass(kw_only=True)
class JointSetValues(Values):
    """&joint_set: parallel joints, or joints that are so on average.

    Attributes
    ----------
    joint : str
        of the cut; the name of a &joint (the first).
    angle : float, degrees
        of the joints, from the x axis, counter-clockwise; -360 to 360 (this or dip).
    dip : float, degrees
        below the horizontal towards +x; -360 to 360 (this or angle).
    spacing : float, m
        between neighbours, at right angles to them; above 0 (required).
    trace_length : float, m
        of a joint; persistence is trace / (trace + bridge); at least 0 (0: without end).
    bridge : float, m
        rock between two traces on one line; at least 0 (0).
    angle_distribution : {'constant', 'uniform', 'normal', 'log-normal', 'exponential'}
        of angle ('constant').
    angle_deviation : float, degrees
        standard deviation; of 'uniform' the greatest distance from the mean; at least 0 (0).
    spacing_distribution : {'constant', 'uniform', 'normal', 'log-normal', 'exponential'}
        of spacing ('constant').
    spacing_deviation : float, m
        likewise; at least 0 (0).
    trace_length_distribution : {'constant', 'uniform', 'normal', 'log-normal', 'exponential'}
        of trace_length ('constant').
    trace_length_deviation : float, m
        likewise; at least 0 (0).
    bridge_distribution : {'constant', 'uniform', 'normal', 'log-normal', 'exponential'}
        of bridge ('constant').
    bridge_deviation : float, m
        likewise; at least 0 (0).
    origin : Numbers, m
        a point on a joint, where traces begin unless their lengths are random (lower left
        corner of what is cut).
    stagger : float
        share of a trace and a bridge by which each line is shifted beyond the one before; -1 to
        1 (0).
    seed : int
        of the random numbers; 0 to 9007199254740991 (0).
    region : str
        the only region that is cut; the name of a &region (all).
    """

    group: ClassVar[str] = "joint_set"
    from_file: ClassVar[str] = ""
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("joint", "name", 0, False, "the name of a &joint"),
        ("angle", "real", 0, False, "-360 to 360"),
        ("dip", "real", 0, False, "-360 to 360"),
        ("spacing", "real", 0, True, "above 0"),
        ("trace_length", "real", 0, False, "at least 0"),
        ("bridge", "real", 0, False, "at least 0"),
        (
            "angle_distribution",
            "word",
            0,
            False,
            "'constant', 'uniform', 'normal', 'log-normal', 'exponential'",
        ),
        ("angle_deviation", "real", 0, False, "at least 0"),
        (
            "spacing_distribution",
            "word",
            0,
            False,
            "'constant', 'uniform', 'normal', 'log-normal', 'exponential'",
        ),
        ("spacing_deviation", "real", 0, False, "at least 0"),
        (
            "trace_length_distribution",
            "word",
            0,
            False,
            "'constant', 'uniform', 'normal', 'log-normal', 'exponential'",
        ),
        ("trace_length_deviation", "real", 0, False, "at least 0"),
        (
            "bridge_distribution",
            "word",
            0,
            False,
            "'constant', 'uniform', 'normal', 'log-normal', 'exponential'",
        ),
        ("bridge_deviation", "real", 0, False, "at least 0"),
        ("origin", "real", 2, False, "any"),
        ("stagger", "real", 0, False, "-1 to 1"),
        ("seed", "integer", 0, False, "0 to 9007199254740991"),
        ("region", "name", 0, False, "the name of a &region"),
    )

    joint: str | None = ""
    angle: float | None = None
    dip: float | None = None
    spacing: float | None = None
    trace_length: float | None = 0.0
    bridge: float | None = 0.0
    angle_distribution: str | None = "constant"
    angle_deviation: float | None = 0.0
    spacing_distribution: str | None = "constant"
    spacing_deviation: float | None = 0.0
    trace_length_distribution: str | None = "constant"
    trace_length_deviation: float | None = 0.0
    bridge_distribution: str | None = "constant"
    bridge_deviation: float | None = 0.0
    origin: Numbers | None = None
    stagger: float | None = 0.0
    seed: int | None = 0
    region: str | None = ""


@dataclass(kw_only=True)
class VoronoiValues(Values):
    """&voronoi: random polygons.

    Attributes
    ----------
    size : float, m
        side of a square as large as a polygon is on average; above 0 (required).
    iterations : int
        how often each seed point is moved to the middle of its polygon: 0 wild, 50 even; 0 to
        50 (3).
    seed : int
        of the random numbers; 0 to 9007199254740991 (0).
    joint : str
        of the cut; the name of a &joint (the first).
    region : str
        the only region that is cut; the name of a &region (all).
    """

    group: ClassVar[str] = "voronoi"
    from_file: ClassVar[str] = ""
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("size", "real", 0, True, "above 0"),
        ("iterations", "integer", 0, False, "0 to 50"),
        ("seed", "integer", 0, False, "0 to 9007199254740991"),
        ("joint", "name", 0, False, "the name of a &joint"),
        ("region", "name", 0, False, "the name of a &region"),
    )

    size: float | None = None
    iterations: int | None = 3
    seed: int | None = 0
    joint: str | None = ""
    region: str | None = ""


@dataclass(kw_only=True)
class HoleValues(Values):
    """&hole: a polygon that is left empty.

    Attributes
    ----------
    name : str
        its name ('hole').
    outline : Points, m
        x, y, x, y … of its corners (required).
    joint : str
        of its outline; the name of a &joint (the first).
    """

    group: ClassVar[str] = "hole"
    from_file: ClassVar[str] = "outline"
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("name", "name", 0, False, "any"),
        ("outline", "points", 100000, True, "any"),
        ("joint", "name", 0, False, "the name of a &joint"),
    )

    name: str | None = "hole"
    outline: Points | None = None
    joint: str | None = ""


@dataclass(kw_only=True)
class TunnelValues(Values):
    """&tunnel: a hole of a usual shape.

    Attributes
    ----------
    name : str
        its name ('tunnel').
    centre : Numbers, m
        middle of its width and height (0, 0).
    width : float, m
        its width; above 0 (required).
    height : float, m
        its height; above 0 (width).
    shape : {'circle', 'horseshoe', 'rectangle'}
        circle: an ellipse where width and height differ ('circle').
    sides : int
        of the polygon that stands for a whole ellipse; 8 to 512 (32).
    joint : str
        of its outline; the name of a &joint (the first).
    """

    group: ClassVar[str] = "tunnel"
    from_file: ClassVar[str] = ""
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("name", "name", 0, False, "any"),
        ("centre", "real", 2, False, "any"),
        ("width", "real", 0, True, "above 0"),
        ("height", "real", 0, False, "above 0"),
        ("shape", "word", 0, False, "'circle', 'horseshoe', 'rectangle'"),
        ("sides", "integer", 0, False, "8 to 512"),
        ("joint", "name", 0, False, "the name of a &joint"),
    )

    name: str | None = "tunnel"
    centre: Numbers | None = (0.0, 0.0)
    width: float | None = None
    height: float | None = None
    shape: str | None = "circle"
    sides: int | None = 32
    joint: str | None = ""


@dataclass(kw_only=True)
class ExcavationValues(Values):
    """&excavation: a polygon that cuts blocks which a later stage can remove.

    Attributes
    ----------
    name : str
        its blocks are name_1, name_2 …; at most 56 bytes ('excavation').
    outline : Points, m
        x, y, x, y … of its corners (required).
    joint : str
        of its outline; the name of a &joint (the first).
    """

    group: ClassVar[str] = "excavation"
    from_file: ClassVar[str] = "outline"
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("name", "name", 0, False, "at most 56 bytes"),
        ("outline", "points", 100000, True, "any"),
        ("joint", "name", 0, False, "the name of a &joint"),
    )

    name: str | None = "excavation"
    outline: Points | None = None
    joint: str | None = ""


@dataclass(kw_only=True)
class CuttingValues(Values):
    """&cutting: how joints become blocks, and what is done with slivers.

    Attributes
    ----------
    slivers : {'merge', 'refuse', 'keep'}
        merge: each with the neighbour of its longest common edge ('merge').
    least_area : float, m²
        smaller blocks are slivers; at least 0 (10⁻³ of the mean area).
    least_edge : float, m
        corners closer than this become one when slivers are merged; shorter edges make a sliver
        when they are refused; at least 0 (10⁻³ of the root of the mean area).
    least_angle : float, degrees
        blocks with a sharper corner are slivers; at least 0 (0).
    tolerance : float, m
        what is closer than this is the same point; at least 0 (10⁻⁹ of the size of the
        regions).
    most_blocks : int
        more are refused before the work; 1 to 10000000 (1000000).
    """

    group: ClassVar[str] = "cutting"
    from_file: ClassVar[str] = ""
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("slivers", "word", 0, False, "'merge', 'refuse', 'keep'"),
        ("least_area", "real", 0, False, "at least 0"),
        ("least_edge", "real", 0, False, "at least 0"),
        ("least_angle", "real", 0, False, "at least 0"),
        ("tolerance", "real", 0, False, "at least 0"),
        ("most_blocks", "integer", 0, False, "1 to 10000000"),
    )

    slivers: str | None = "merge"
    least_area: float | None = None
    least_edge: float | None = None
    least_angle: float | None = 0.0
    tolerance: float | None = None
    most_blocks: int | None = 1000000


@dataclass(kw_only=True)
class MeshValues(Values):
    """&mesh: blocks that become bodies of welded cells, which bend.

    Attributes
    ----------
    blocks : str
        blocks that become bodies: &block groups, cut ones, masonry; names: 'one, two, all_*'
        (this or regions).
    regions : str
        regions whose blocks become bodies; joints stay joints; names: 'one, two, all_*' (this
        or blocks).
    body : str
        the one body that all these blocks become, welded where they meet (none: each block is a
        body of its own name).
    size : float, m
        side of a square as large as a cell; above 0 (this or frequency).
    frequency : float, Hz
        highest frequency that matters: cells of a twelfth of the length of S waves in their
        material; above 0 (this or size).
    cells : {'quadrilateral', 'voronoi'}
        squares, and what outlines leave of them; or even polygons ('quadrilateral').
    fine_at : Points, m
        x, y, x, y …: points near which cells have fine_size (none).
    fine_along : Points, m
        x, y, x, y …: polyline near which they have it, as a tunnel's outline (none).
    fine_size : float, m
        size of cells there; it grows by a quarter of the distance; above 0 (none).
    seed : int
        of the polygons; 0 to 9007199254740991 (0).
    """

    group: ClassVar[str] = "mesh"
    from_file: ClassVar[str] = ""
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("blocks", "text", 0, False, "names: 'one, two, all_*'"),
        ("regions", "text", 0, False, "names: 'one, two, all_*'"),
        ("body", "name", 0, False, "any"),
        ("size", "real", 0, False, "above 0"),
        ("frequency", "real", 0, False, "above 0"),
        ("cells", "word", 0, False, "'quadrilateral', 'voronoi'"),
        ("fine_at", "points", 256, False, "any"),
        ("fine_along", "points", 100000, False, "any"),
        ("fine_size", "real", 0, False, "above 0"),
        ("seed", "integer", 0, False, "0 to 9007199254740991"),
    )

    blocks: str | None = ""
    regions: str | None = ""
    body: str | None = ""
    size: float | None = None
    frequency: float | None = None
    cells: str | None = "quadrilateral"
    fine_at: Points | None = None
    fine_along: Points | None = None
    fine_size: float | None = None
    seed: int | None = 0


@dataclass(kw_only=True)
class MasonryWallValues(Values):
    """&masonry_wall: a wall of courses, seen from the front, with openings, arches and ties.

    Attributes
    ----------
    name : str
        the blocks are name_1, name_2 … course by course from below; at most 56 bytes ('wall').
    left : float, m
        x of its left side (0).
    bottom : float, m
        y of its foot (0).
    width : float, m
        of the wall; above 0 (required).
    height : float, m
        of the wall; above 0 (required).
    courses : int
        about so many: courses are fitted to sills and heads of openings; at least 1 (1).
    stone : float, m
        length of a stone; above 0 (required).
    bond : {'running', 'header', 'rubble'}
        running: stones shifted by half of their length; header: half stones, shifted by a
        quarter of one; rubble: random heights and lengths, without upright joints close above
        each other ('running').
    variation : float
        of rubble: largest change of heights and lengths over their mean; 0 to 0.5 (0.3).
    seed : int
        of the random numbers; 0 to 9007199254740991 (0).
    ties : Numbers, m
        levels y of tie rods between the ends of the wall (none).
    tie_stiffness : float, N/m
        force over elongation of a tie rod, per metre of thickness; above 0 (none).
    tie_yield : float, N/m
        force at which a tie rod yields; above 0 (none).
    material : str
        material of the blocks; the name of a &material (the first).
    joint : str
        joint of their sides; the name of a &joint (the first).
    """

    group: ClassVar[str] = "masonry_wall"
    from_file: ClassVar[str] = ""
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("name", "name", 0, False, "at most 56 bytes"),
        ("left", "real", 0, False, "any"),
        ("bottom", "real", 0, False, "any"),
        ("width", "real", 0, True, "above 0"),
        ("height", "real", 0, True, "above 0"),
        ("courses", "integer", 0, False, "at least 1"),
        ("stone", "real", 0, True, "above 0"),
        ("bond", "word", 0, False, "'running', 'header', 'rubble'"),
        ("variation", "real", 0, False, "0 to 0.5"),
        ("seed", "integer", 0, False, "0 to 9007199254740991"),
        ("ties", "real", 64, False, "any"),
        ("tie_stiffness", "real", 0, False, "above 0"),
        ("tie_yield", "real", 0, False, "above 0"),
        ("material", "name", 0, False, "the name of a &material"),
        ("joint", "name", 0, False, "the name of a &joint"),
    )

    name: str | None = "wall"
    left: float | None = 0.0
    bottom: float | None = 0.0
    width: float | None = None
    height: float | None = None
    courses: int | None = 1
    stone: float | None = None
    bond: str | None = "running"
    variation: float | None = 0.3
    seed: int | None = 0
    ties: Numbers | None = None
    tie_stiffness: float | None = None
    tie_yield: float | None = None
    material: str | None = ""
    joint: str | None = ""


@dataclass(kw_only=True)
class OpeningValues(Values):
    """&opening: a door, window or niche in a masonry wall.

    Attributes
    ----------
    name : str
        its lintel is name_lintel, its voussoirs name_1, name_2 … from the right; at most 56
        bytes ('opening').
    wall : str
        wall that it is in; the name of a &masonry_wall ('wall').
    left : float, m
        x of its left side (0).
    bottom : float, m
        y of its foot (0).
    width : float, m
        of the opening; above 0 (required).
    height : float, m
        of the opening, to the crown of an arch; above 0 (required).
    head : {'lintel', 'arch', 'none'}
        what is over it ('lintel').
    depth : float, m
        height of the lintel, or thickness of the arch at its crown; its back is level; above 0
        (a course).
    bearing : float, m
        length of the head on each side that rests on the wall; above 0 (half a stone).
    rise : float, m
        of the arch, at most half of the width; above 0 (a quarter of the width).
    voussoirs : int
        of the arch; 2 to 1000 (9).
    material : str
        material of the blocks; the name of a &material (the first).
    joint : str
        joint of their sides; the name of a &joint (the first).
    """

    group: ClassVar[str] = "opening"
    from_file: ClassVar[str] = ""
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("name", "name", 0, False, "at most 56 bytes"),
        ("wall", "name", 0, False, "the name of a &masonry_wall"),
        ("left", "real", 0, False, "any"),
        ("bottom", "real", 0, False, "any"),
        ("width", "real", 0, True, "above 0"),
        ("height", "real", 0, True, "above 0"),
        ("head", "word", 0, False, "'lintel', 'arch', 'none'"),
        ("depth", "real", 0, False, "above 0"),
        ("bearing", "real", 0, False, "above 0"),
        ("rise", "real", 0, False, "above 0"),
        ("voussoirs", "integer", 0, False, "2 to 1000"),
        ("material", "name", 0, False, "the name of a &material"),
        ("joint", "name", 0, False, "the name of a &joint"),
    )

    name: str | None = "opening"
    wall: str | None = "wall"
    left: float | None = 0.0
    bottom: float | None = 0.0
    width: float | None = None
    height: float | None = None
    head: str | None = "lintel"
    depth: float | None = None
    bearing: float | None = None
    rise: float | None = None
    voussoirs: int | None = 9
    material: str | None = ""
    joint: str | None = ""


@dataclass(kw_only=True)
class ProfileValues(Values):
    """&profile: level ground in layers, from a CSV file of velocities over depth.

    Attributes
    ----------
    file : str
        CSV file with depth or thickness, velocities, density, damping and curves, see
        docs/site.md; a readable file (required).
    name : str
        blocks are name_1, name_2 … from below, on name_base; materials name_1 … from the
        surface; at most 56 bytes ('soil').
    left : float, m
        x of its left side (0).
    top : float, m
        y of its surface (0).
    width : float, m
        of the ground; above 0 (the thickest block's).
    columns : int
        columns of blocks across the width; at least 1 (1).
    highest_frequency : float, Hz
        highest frequency that matters: blocks are at most a twelfth of the length of S waves
        thick; above 0 (15).
    base : {'compliant', 'fixed', 'none'}
        what is below: the half-space of the file; a rigid base ('compliant' with a half-space,
        else 'fixed').
    sides : {'tied', 'free_field', 'roller', 'none'}
        what is beside: itself again; level ground; rollers along y ('tied').
    motion_x : str
        motion of the base along x; the name of a &motion (none).
    motion_y : str
        motion of the base along y; the name of a &motion (none).
    points : bool
        measured points surface, base, and depth_D at each boundary of layers (.true.).
    """

    group: ClassVar[str] = "profile"
    from_file: ClassVar[str] = ""
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("file", "text", 0, True, "a readable file"),
        ("name", "name", 0, False, "at most 56 bytes"),
        ("left", "real", 0, False, "any"),
        ("top", "real", 0, False, "any"),
        ("width", "real", 0, False, "above 0"),
        ("columns", "integer", 0, False, "at least 1"),
        ("highest_frequency", "real", 0, False, "above 0"),
        ("base", "word", 0, False, "'compliant', 'fixed', 'none'"),
        ("sides", "word", 0, False, "'tied', 'free_field', 'roller', 'none'"),
        ("motion_x", "name", 0, False, "the name of a &motion"),
        ("motion_y", "name", 0, False, "the name of a &motion"),
        ("points", "logical", 0, False, ""),
    )

    file: str | None = ""
    name: str | None = "soil"
    left: float | None = 0.0
    top: float | None = 0.0
    width: float | None = None
    columns: int | None = 1
    highest_frequency: float | None = 15.0
    base: str | None = None
    sides: str | None = "tied"
    motion_x: str | None = ""
    motion_y: str | None = ""
    points: bool | None = True


@dataclass(kw_only=True)
class GroundValues(Values):
    """&ground: meshed ground beside and below jointed rock, with its boundaries.

    Attributes
    ----------
    name : str
        the body is name, or name_1 and name_2 on both sides of a core that reaches the bottom;
        at most 50 bytes ('ground').
    left : float, m
        x of its left side (required).
    right : float, m
        x of its right side (required).
    bottom : float, m
        y of its lower side (required).
    surface : Points, m
        x, y, x, y … with growing x: its upper side, level beyond the ends (the core's upper
        side).
    core : Points, m
        x, y, x, y … of the corners of a region that it surrounds: what joint sets cut, tied to
        the ground for ever (none).
    core_name : str
        name of that &region; at most 56 bytes ('core').
    core_material : str
        of the core; the name of a &material (material).
    material : str
        of the ground; the name of a &material (the first).
    size : float, m
        side of a square as large as a cell; above 0 (this or frequency).
    frequency : float, Hz
        highest frequency that matters: cells of a twelfth of the length of S waves; above 0
        (this or size).
    fine_size : float, m
        of the cells beside the core; it grows by a quarter of the distance; above 0 (size).
    base : {'compliant', 'fixed', 'roller', 'none'}
        what is below: a half-space of the same ground; a rigid base ('compliant').
    sides : {'free_field', 'tied', 'viscous', 'roller', 'none'}
        what is beside: level ground; itself again; dashpots; rollers along y ('free_field').
    motion_x : str
        motion of the base along x; the name of a &motion (none).
    motion_y : str
        motion of the base along y; the name of a &motion (none).
    """

    group: ClassVar[str] = "ground"
    from_file: ClassVar[str] = ""
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("name", "name", 0, False, "at most 50 bytes"),
        ("left", "real", 0, True, "any"),
        ("right", "real", 0, True, "any"),
        ("bottom", "real", 0, True, "any"),
        ("surface", "points", 256, False, "any"),
        ("core", "points", 256, False, "any"),
        ("core_name", "name", 0, False, "at most 56 bytes"),
        ("core_material", "name", 0, False, "the name of a &material"),
        ("material", "name", 0, False, "the name of a &material"),
        ("size", "real", 0, False, "above 0"),
        ("frequency", "real", 0, False, "above 0"),
        ("fine_size", "real", 0, False, "above 0"),
        ("base", "word", 0, False, "'compliant', 'fixed', 'roller', 'none'"),
        ("sides", "word", 0, False, "'free_field', 'tied', 'viscous', 'roller', 'none'"),
        ("motion_x", "name", 0, False, "the name of a &motion"),
        ("motion_y", "name", 0, False, "the name of a &motion"),
    )

    name: str | None = "ground"
    left: float | None = None
    right: float | None = None
    bottom: float | None = None
    surface: Points | None = None
    core: Points | None = None
    core_name: str | None = "core"
    core_material: str | None = ""
    material: str | None = ""
    size: float | None = None
    frequency: float | None = None
    fine_size: float | None = None
    base: str | None = "compliant"
    sides: str | None = "free_field"
    motion_x: str | None = ""
    motion_y: str | None = ""


@dataclass(kw_only=True)
class ArchValues(Values):
    """&arch: an arch of voussoirs, cut at right angles to its centre line.

    Attributes
    ----------
    name : str
        the blocks are name_1, name_2 …; at most 40 bytes ('voussoir').
    centre : Numbers, m
        middle between the springings of the centre line (0, 0).
    radius : float, m
        of the centre line of a half-circle; above 0 (this or span and rise).
    span : float, m
        of the centre line; above 0 (this or radius).
    rise : float, m
        half the span: a half-circle; less: a segmental arch; more: a pointed one; above 0 (this
        or radius).
    thickness : float, m
        of the arch; above 0 (required).
    voussoirs : int
        their number, even for a pointed arch; 2 to 100000 (required).
    abutment : float, m
        size of a block behind each springing, name_left and name_right; at least 0 (0: none).
    material : str
        material of the blocks; the name of a &material (the first).
    joint : str
        joint of their sides; the name of a &joint (the first).
    """

    group: ClassVar[str] = "arch"
    from_file: ClassVar[str] = ""
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("name", "name", 0, False, "at most 40 bytes"),
        ("centre", "real", 2, False, "any"),
        ("radius", "real", 0, False, "above 0"),
        ("span", "real", 0, False, "above 0"),
        ("rise", "real", 0, False, "above 0"),
        ("thickness", "real", 0, True, "above 0"),
        ("voussoirs", "integer", 0, True, "2 to 100000"),
        ("abutment", "real", 0, False, "at least 0"),
        ("material", "name", 0, False, "the name of a &material"),
        ("joint", "name", 0, False, "the name of a &joint"),
    )

    name: str | None = "voussoir"
    centre: Numbers | None = (0.0, 0.0)
    radius: float | None = None
    span: float | None = None
    rise: float | None = None
    thickness: float | None = None
    voussoirs: int | None = None
    abutment: float | None = 0.0
    material: str | None = ""
    joint: str | None = ""


@dataclass(kw_only=True)
class PierValues(Values):
    """&pier: a pier of courses in running bond.

    Attributes
    ----------
    name : str
        the blocks are name_1, name_2 …; at most 40 bytes ('pier').
    centre : float, m
        x of its axis (0).
    bottom : float, m
        y of its foot (0).
    width : float, m
        at its foot; above 0 (required).
    top_width : float, m
        at its top; above 0 (width).
    height : float, m
        its height; above 0 (required).
    courses : int
        their number; 1 to 100000 (1).
    stones : int
        in a full course; 1 to 100000 (1).
    material : str
        material of the blocks; the name of a &material (the first).
    joint : str
        joint of their sides; the name of a &joint (the first).
    """

    group: ClassVar[str] = "pier"
    from_file: ClassVar[str] = ""
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("name", "name", 0, False, "at most 40 bytes"),
        ("centre", "real", 0, False, "any"),
        ("bottom", "real", 0, False, "any"),
        ("width", "real", 0, True, "above 0"),
        ("top_width", "real", 0, False, "above 0"),
        ("height", "real", 0, True, "above 0"),
        ("courses", "integer", 0, False, "1 to 100000"),
        ("stones", "integer", 0, False, "1 to 100000"),
        ("material", "name", 0, False, "the name of a &material"),
        ("joint", "name", 0, False, "the name of a &joint"),
    )

    name: str | None = "pier"
    centre: float | None = 0.0
    bottom: float | None = 0.0
    width: float | None = None
    top_width: float | None = None
    height: float | None = None
    courses: int | None = 1
    stones: int | None = 1
    material: str | None = ""
    joint: str | None = ""


@dataclass(kw_only=True)
class LintelValues(Values):
    """&lintel: a beam over an opening.

    Attributes
    ----------
    name : str
        of the block; at most 40 bytes ('lintel').
    left : float, m
        x of the left side of the opening (0).
    bottom : float, m
        y of the underside (0).
    span : float, m
        of the opening; above 0 (required).
    height : float, m
        of the beam; above 0 (required).
    bearing : float, m
        length on each side that rests on the walls; above 0 (required).
    material : str
        material of the blocks; the name of a &material (the first).
    joint : str
        joint of their sides; the name of a &joint (the first).
    """

    group: ClassVar[str] = "lintel"
    from_file: ClassVar[str] = ""
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("name", "name", 0, False, "at most 40 bytes"),
        ("left", "real", 0, False, "any"),
        ("bottom", "real", 0, False, "any"),
        ("span", "real", 0, True, "above 0"),
        ("height", "real", 0, True, "above 0"),
        ("bearing", "real", 0, True, "above 0"),
        ("material", "name", 0, False, "the name of a &material"),
        ("joint", "name", 0, False, "the name of a &joint"),
    )

    name: str | None = "lintel"
    left: float | None = 0.0
    bottom: float | None = 0.0
    span: float | None = None
    height: float | None = None
    bearing: float | None = None
    material: str | None = ""
    joint: str | None = ""


@dataclass(kw_only=True)
class ColonnadeValues(Values):
    """&colonnade: columns of drums, with capitals and beams if wanted.

    Attributes
    ----------
    name : str
        drums are name1_1 … from below, then name1_capital; beams name_beam_1 …; at most 40
        bytes ('column').
    left : float, m
        x of the axis of the first column (0).
    bottom : float, m
        y of its foot (0).
    columns : int
        their number; 1 to 100000 (2).
    drums : int
        of a column; 1 to 100000 (1).
    spacing : float, m
        between axes; above 0 (required).
    width : float, m
        of a shaft at its foot; above 0 (required).
    top_width : float, m
        of a shaft at its top; above 0 (width).
    height : float, m
        of a shaft; above 0 (required).
    capital_width : float, m
        of a capital; at least 0 (0: none).
    capital_height : float, m
        of a capital; at least 0 (0: none).
    beam_height : float, m
        of the beams from axis to axis; at least 0 (0: none).
    material : str
        material of the blocks; the name of a &material (the first).
    joint : str
        joint of their sides; the name of a &joint (the first).
    """

    group: ClassVar[str] = "colonnade"
    from_file: ClassVar[str] = ""
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("name", "name", 0, False, "at most 40 bytes"),
        ("left", "real", 0, False, "any"),
        ("bottom", "real", 0, False, "any"),
        ("columns", "integer", 0, False, "1 to 100000"),
        ("drums", "integer", 0, False, "1 to 100000"),
        ("spacing", "real", 0, True, "above 0"),
        ("width", "real", 0, True, "above 0"),
        ("top_width", "real", 0, False, "above 0"),
        ("height", "real", 0, True, "above 0"),
        ("capital_width", "real", 0, False, "at least 0"),
        ("capital_height", "real", 0, False, "at least 0"),
        ("beam_height", "real", 0, False, "at least 0"),
        ("material", "name", 0, False, "the name of a &material"),
        ("joint", "name", 0, False, "the name of a &joint"),
    )

    name: str | None = "column"
    left: float | None = 0.0
    bottom: float | None = 0.0
    columns: int | None = 2
    drums: int | None = 1
    spacing: float | None = None
    width: float | None = None
    top_width: float | None = None
    height: float | None = None
    capital_width: float | None = 0.0
    capital_height: float | None = 0.0
    beam_height: float | None = 0.0
    material: str | None = ""
    joint: str | None = ""


@dataclass(kw_only=True)
class RetainingWallValues(Values):
    """&retaining_wall: a wall of courses in running bond with an upright back and a battered face.

    Attributes
    ----------
    name : str
        the blocks are name_1, name_2 …; at most 40 bytes ('wall').
    left : float, m
        x of its left side (0).
    bottom : float, m
        y of its foot (0).
    base_width : float, m
        at its foot; above 0 (required).
    top_width : float, m
        at its top; above 0 (required).
    height : float, m
        its height; above 0 (required).
    face : {'left', 'right'}
        the battered side ('left').
    courses : int
        their number; 1 to 100000 (1).
    stones : int
        in a full course; 1 to 100000 (1).
    material : str
        material of the blocks; the name of a &material (the first).
    joint : str
        joint of their sides; the name of a &joint (the first).
    """

    group: ClassVar[str] = "retaining_wall"
    from_file: ClassVar[str] = ""
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("name", "name", 0, False, "at most 40 bytes"),
        ("left", "real", 0, False, "any"),
        ("bottom", "real", 0, False, "any"),
        ("base_width", "real", 0, True, "above 0"),
        ("top_width", "real", 0, True, "above 0"),
        ("height", "real", 0, True, "above 0"),
        ("face", "word", 0, False, "'left', 'right'"),
        ("courses", "integer", 0, False, "1 to 100000"),
        ("stones", "integer", 0, False, "1 to 100000"),
        ("material", "name", 0, False, "the name of a &material"),
        ("joint", "name", 0, False, "the name of a &joint"),
    )

    name: str | None = "wall"
    left: float | None = 0.0
    bottom: float | None = 0.0
    base_width: float | None = None
    top_width: float | None = None
    height: float | None = None
    face: str | None = "left"
    courses: int | None = 1
    stones: int | None = 1
    material: str | None = ""
    joint: str | None = ""


@dataclass(kw_only=True)
class MultiLeafWallValues(Values):
    """&multi_leaf_wall: two leaves of stones with a core between them, in section.

    Attributes
    ----------
    name : str
        stones are name_left_1, name_core_1, name_right_1, name_tie_1 …; at most 40 bytes
        ('wall').
    left : float, m
        x of its left side (0).
    bottom : float, m
        y of its foot (0).
    height : float, m
        its height; above 0 (required).
    leaf : float, m
        thickness of each leaf; above 0 (required).
    core : float, m
        thickness of the core; above 0 (required).
    courses : int
        of the leaves; 1 to 100000 (1).
    core_courses : int
        of the core in each course of the leaves; 1 to 100000 (1).
    core_stones : int
        in each of these, in running bond; 1 to 100000 (1).
    ties : int
        every so many courses a stone goes through the whole wall; 0 to 100000 (0: none).
    material : str
        material of the blocks; the name of a &material (the first).
    joint : str
        joint of their sides; the name of a &joint (the first).
    core_material : str
        of the core; the name of a &material (material).
    core_joint : str
        of the core; the name of a &joint (joint).
    """

    group: ClassVar[str] = "multi_leaf_wall"
    from_file: ClassVar[str] = ""
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("name", "name", 0, False, "at most 40 bytes"),
        ("left", "real", 0, False, "any"),
        ("bottom", "real", 0, False, "any"),
        ("height", "real", 0, True, "above 0"),
        ("leaf", "real", 0, True, "above 0"),
        ("core", "real", 0, True, "above 0"),
        ("courses", "integer", 0, False, "1 to 100000"),
        ("core_courses", "integer", 0, False, "1 to 100000"),
        ("core_stones", "integer", 0, False, "1 to 100000"),
        ("ties", "integer", 0, False, "0 to 100000"),
        ("material", "name", 0, False, "the name of a &material"),
        ("joint", "name", 0, False, "the name of a &joint"),
        ("core_material", "name", 0, False, "the name of a &material"),
        ("core_joint", "name", 0, False, "the name of a &joint"),
    )

    name: str | None = "wall"
    left: float | None = 0.0
    bottom: float | None = 0.0
    height: float | None = None
    leaf: float | None = None
    core: float | None = None
    courses: int | None = 1
    core_courses: int | None = 1
    core_stones: int | None = 1
    ties: int | None = 0
    material: str | None = ""
    joint: str | None = ""
    core_material: str | None = ""
    core_joint: str | None = ""


@dataclass(kw_only=True)
class PolygonsValues(Values):
    """&polygons: closed polygons of a file become blocks as they are.

    Attributes
    ----------
    file : str
        DXF, GeoJSON, WKT or CSV; a readable file (required).
    layer : str
        the only layer that is taken; a layer of the file (all).
    scale : float
        metres in a unit of the file; above 0 (1).
    name : str
        the blocks are name_1, name_2 …; at most 56 bytes (from the file).
    material : str
        material of the blocks; the name of a &material (the first).
    joint : str
        joint of their sides; the name of a &joint (the first).
    """

    group: ClassVar[str] = "polygons"
    from_file: ClassVar[str] = ""
    variables: ClassVar[tuple[tuple[str, str, int, bool, str], ...]] = (
        ("file", "text", 0, True, "a readable file"),
        ("layer", "text", 0, False, "a layer of the file"),
        ("scale", "real", 0, False, "above 0"),
        ("name", "name", 0, False, "at most 56 bytes"),
        ("material", "name", 0, False, "the name of a &material"),
        ("joint", "name", 0, False, "the name of a &joint"),
    )

    file: str | None = ""
    layer: str | None = ""
    scale: float | None = 1.0
    name: str | None = ""
    material: str | None = ""
    joint: str | None = ""
