# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw blocks to scale: a model before its run, or a frame of an output.

Only `matplotlib.figure.Figure` is used, so that the backend of the session does not change.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import FuncNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FixedLocator, MaxNLocator

from ..base.arguments import ANY_NUMBER
from ..base.errors import InputError
from ..base.numbers import counted, in_unit, number, shown
from ..output.scene import Scene
from ..report.layout import Head, Keys, folded, plain
from ..report.style import (
    BLUE,
    BOLT,
    EDGE,
    FAINT,
    FORCE,
    INK,
    JOINT_MAP,
    JOINTS,
    MAGNITUDE,
    PAPER,
    POINT,
    RESTING,
    RULE,
    SIGNED,
    STONES,
    WATER,
    dress,
    empty_figure,
)
from .boundary_marks import draw_boundaries
from .flow import draw_flow, key_of_flow
from .forces import (
    arrow_length,
    chain_key,
    draw_chains,
    draw_forces,
    draw_movement,
    force_scale,
    movement_scale,
    neighbour_forces,
    scale_arrow,
)
from .joint_map import draw_movements, joint_lines
from .point_names import PointNames
from .quantities import (
    ARROWS,
    COLORINGS,
    CONTACTS,
    MOVEMENTS,
    QUANTITIES,
    Limits,
    limits_of,
    movement_limits,
    quantity,
    rounding,
    select_frames,
)
from .stress_crosses import draw_crosses, key_of_crosses, largest_stress

__all__ = ["BlockPicture", "deformed", "draw", "neighbour_forces", "view_box"]

BROKEN = 4  # state of a bolt
_MOST_DRAWN_OUTLINES = 30000
_MOST_LABELS = 24  # largest number of measured points with names
_NAME = 2.0  # inches, largest width of a name beside a point or above a picture
_APART = 0.13  # smallest distance between ticks / length of a colour bar
_AROUND = 1.1  # inches above and below the axes for titles and labels


def draw(
    source,
    time: float | None = None,
    color: str | None = None,
    contacts: str | None = None,
    deformation: float = 1.0,
    axes: Axes | None = None,
    legend: bool = True,
    stage: str | None = None,
    arrows: str | None = None,
    since: str | None = None,
    absolute: bool = False,
) -> Axes:
    """Draw the blocks of a model or an output to scale.

    Parameters
    ----------
    source : path, Run, Simulation, xarray.Dataset or Scene
        A namelist input, an output, a Model, Simulation or Run.
    time : float, optional
        s; the nearest frame is drawn.  Default: the last frame.
    color : str, optional
        Quantity that colours the blocks: 'material', 'displacement', 'displacement_x',
        'displacement_y', 'velocity', 'rotation', 'compression', 'tension', 'stress_error' or
        'plastic_strain'; for compression and tension, cells of bodies have crosses of their
        principal stresses.  Default: material for a model, displacement for an output.
    contacts : {'force', 'chain', 'slip', 'opening'}, optional
        Contact forces between neighbours, as arrows that meet at the contact or as chains from
        centroid to centroid; or slip or opening of the joints since the start.
    deformation : float
        Factor on the displacements of the picture.
    axes : matplotlib.axes.Axes, optional
        Axes to draw in; by default the axes of a new figure.
    legend : bool
        Draw a legend outside the axes.
    stage : str, optional
        Use a frame of this stage; all static stages may have the same time.
    arrows : {'displacement', 'velocity'}, optional
        Quantity of the centroids that arrows show.
    since : str, optional
        Show displacements and rotations since the end of this stage.
    absolute : bool
        Show absolute displacements, not relative to the base of a shaken model.

    Returns
    -------
    matplotlib.axes.Axes
        ``axes.figure.savefig(file)`` writes the picture.

    Raises
    ------
    InputError
        If `color`, `contacts` or `arrows` is unknown, or `deformation` is not a number.
    InputError
        If the stage does not exist.
    """
    scene = Scene.of(source, absolute)
    picture = BlockPicture(scene, color, contacts, deformation, axes, legend, (), arrows, since)
    picture.show(scene.frame_at(time, stage))
    return picture.axes


class BlockPicture:
    """Picture of blocks on axes that shows one frame at a time; see `draw`.

    Parameters
    ----------
    scene : Scene
    color, contacts, deformation, axes, legend, arrows, since
        See `draw`.
    frames : sequence of int, optional
        Frames that will be shown; colour scale and view include all of them.
    title : str, optional
        Replaces the title of the model.

    Attributes
    ----------
    keys : Keys
        Keys beside the axes, once the first frame is drawn.
    """

    def __init__(
        self, scene, color=None, contacts=None, deformation=1.0, axes=None, legend=True, frames=(),
        arrows=None, since=None, title=None,
    ):  # fmt: skip
        self.scene, self.legend = scene, legend
        self.title = title or scene.title or "Untitled"
        self.deformation = ANY_NUMBER.check("deformation", deformation)
        self.color = color or ("material" if scene.before else "displacement")
        self.contacts, self.arrows = contacts, arrows
        for name, value, choices in (("color", self.color, COLORINGS),
                                   ("contacts", contacts, (None, *CONTACTS)),
                                   ("arrows", arrows, (None, *ARROWS))):  # fmt: skip
            if value not in choices:
                listing = ", ".join(filter(None, choices))
                raise InputError(f"{name} must be one of {listing}, not {value!r}")
        self.since = scene.frame_at(None, since) if since else 0
        self.rounding = rounding(scene)
        self.alone = axes is None
        self.axes = _make_figure(scene).subplots() if self.alone else axes
        self.frames = list(frames)
        self.blocks = self.head = None
        self.keys = Keys(self.axes)
        self.limits = self.movement = Limits(0.0, 0.0, 0.0)
        self.rests: list[str] = []  # notes on values that are rounding errors and are not drawn
        self.force = self.arrow = 0.0  # scale of forces, N/m; scale of arrows, m or m/s
        self.bars: list[tuple] = []
        self.lengths: list[tuple] = []  # length of an arrow, m, and label with its value
        self.lines: list = []
        self.stress = 0.0  # largest stress in cells of bodies, Pa; scale of stress crosses

    def show(self, frame: int) -> None:
        """Draw a frame in place of the present one."""
        scene = self.scene
        vertices = deformed(scene, frame, self.deformation)
        if self.blocks is None:
            self._draw_first_frame(frame, vertices)
        else:
            self.blocks.set_verts(_present_polygons(scene, frame, vertices))
            if self.blocks.get_array() is not None:
                values = quantity(scene, self.color, frame, self.since)
                self.blocks.set_array(values / self.size)
            for line in self.lines:
                line.remove()
        self.lines = _draw_body_outlines(self.axes, scene, frame, vertices)
        self.lines += self._draw_marks(frame, vertices) + _draw_bolts(self.axes, scene, frame)
        self.lines += draw_flow(self.axes, scene, frame)
        if self.stress > 0:
            self.lines += draw_crosses(self.axes, scene, frame, self.deformation, self.stress)
        self.head.show(self._text_with_notes(frame))

    def _draw_first_frame(self, frame: int, vertices) -> None:
        """Draw all that later frames retain: blocks, boundaries, view, title and keys."""
        scene, axes = self.scene, self.axes
        frames = select_frames(self.frames) or [frame]
        if scene.frames > 1 and (frame or self.frames) and scene.blocks <= _MOST_DRAWN_OUTLINES:
            look = {"facecolors": "none", "edgecolors": RULE, "linewidths": 0.5, "zorder": 1}
            axes.add_collection(PolyCollection(scene.polygons(0), **look))
        handles = self._add_blocks(frame, vertices, frames)
        if self.color == "material" and not self.contacts:
            handles += _draw_joints(axes, scene, frame, self.deformation)
        if self.color in ("compression", "tension") and (scene.body > 0).any():
            self.stress = largest_stress(scene, frames)
            handles += key_of_crosses(shown(self.stress, "Pa"))
        handles += self._prepare_marks(frames)
        if scene.before or self.color == "material":
            handles += draw_boundaries(axes, scene, frame) + _draw_supports(axes, scene)
        handles += _bolt_legend(scene, frame) + key_of_flow(scene, frame) + _draw_water(axes, scene)
        positions = [deformed(scene, f, self.deformation) for f in select_frames(self.frames)]
        if scene.before or self.color == "material":
            positions += [tail for tail, _, _ in load_arrows(scene)]
        _set_view(axes, scene, np.vstack([vertices, *positions]))
        self.head = Head(axes, self.title, [self._text_with_notes(number) for number in frames])
        if self.legend:
            self._stack_keys(handles)
        if self.alone:
            width, height = axes.figure.get_size_inches()
            axes.figure.set_size_inches(width, max(height, self.keys.height + _AROUND))
        dress(axes.figure)

    def _stack_keys(self, handles: list) -> None:
        """Place colour bars, arrow lengths and symbols below each other, beside the axes."""
        for artist, label, unit, span in self.bars:
            self.keys.bar(artist, f"{label} ({unit})", _scale_ticks(span))
        for length, text in self.lengths:
            self.keys.length(length, text)
        if handles:
            self.keys.legend(handles)

    def _add_blocks(self, frame: int, vertices, frames: list[int]) -> list:
        """Draw the blocks in their colours; return handles for the legend."""
        scene, edge = self.scene, _line_width(self.scene)
        look = {"edgecolors": EDGE, "linewidths": edge}
        if scene.welded.any():  # faces within bodies are thin; body outlines are drawn over them
            look = {"edgecolors": EDGE, "linewidths": 0.3 * edge}
        outlines = _present_polygons(scene, frame, vertices)
        polygons = self.blocks = PolyCollection(outlines, joinstyle="round", zorder=2, **look)
        self.axes.add_collection(polygons, autolim=False)
        if self.color == "material":
            polygons.set_facecolor([STONES[m % len(STONES)] for m in scene.material])
            return [
                Patch(fc=STONES[m % len(STONES)], ec=EDGE, lw=0.7, label=scene.material_names[m])
                for m in np.unique(scene.material)
            ]
        kind = QUANTITIES[self.color]
        self.limits = extremes = limits_of(scene, self.color, frames, self.since)
        if extremes.most <= self.rounding[kind.unit]:
            floor = shown(self.rounding[kind.unit], kind.unit, 2)
            self.rests.append(f"at rest: {kind.label.partition(',')[0]} below {floor}")
            self.limits = Limits(0.0, 0.0, 0.0)
            polygons.set_facecolor(RESTING)
            return []
        self.size, unit = in_unit(extremes.most, kind.unit)
        span = extremes.over(self.size)
        polygons.set_array(quantity(scene, self.color, frame, self.since) / self.size)
        polygons.set_cmap(SIGNED if kind.signed else MAGNITUDE)
        polygons.set_norm(_scale_norm(span))
        self.bars.append((polygons, kind.label, unit, span))
        return []

    def _prepare_marks(self, frames: list[int]) -> list:
        """Set the scales of contact forces, joints and arrows for frames; return legend handles."""
        scene, kind = self.scene, self.contacts
        handles = []
        if kind in ("force", "chain"):
            self.force = force_scale(scene, frames)
            if self.force <= self.rounding["N/m"]:
                self.force = 0.0
                self.rests.append("no contact forces")
            elif kind == "chain":
                handles = chain_key(self.force)
            else:
                length = arrow_length(scene)
                self.lengths.append(scale_arrow(length, self.force, "N/m", "contact force"))
        elif kind:
            self._prepare_movements(frames)
        if self.arrows:
            unit = QUANTITIES[self.arrows].unit
            self.arrow = movement_scale(scene, self.arrows, frames, self.since)
            if self.arrow <= self.rounding[unit]:
                self.arrow = 0.0
            else:
                length = 0.09 * scene.size
                self.lengths.append(scale_arrow(length, self.arrow, unit, self.arrows))
        return handles

    def _prepare_movements(self, frames: list[int]) -> None:
        """Set scale and colour bar of slip or opening, unless all values are rounding errors."""
        kind = MOVEMENTS[self.contacts]
        self.movement = movement_limits(self.scene, self.contacts, frames)
        if self.movement.most <= self.rounding["m"]:
            self.movement = Limits(0.0, 0.0, 0.0)
            self.rests.append(f"no {self.contacts} of joints")
            return
        size, unit = in_unit(self.movement.high, "m")
        span = self.movement.over(size)
        self.bars.append((ScalarMappable(_scale_norm(span), JOINT_MAP), kind.label, unit, span))

    def _draw_marks(self, frame: int, vertices) -> list:
        """Draw contact forces, joint movements and arrows of a frame; return the artists."""
        axes, scene, artists = self.axes, self.scene, []
        if self.contacts == "force":
            artists = draw_forces(axes, scene, frame, vertices, self.force)
        elif self.contacts == "chain":
            artists = draw_chains(axes, scene, frame, self.deformation, vertices, self.force)
        elif self.contacts:
            artists = draw_movements(axes, scene, self.contacts, frame, self.deformation,
                                   self.movement)  # fmt: skip
        if self.arrows:
            artists += draw_movement(axes, scene, self.arrows, frame, self.since, self.deformation,
                                   self.arrow)  # fmt: skip
        return artists

    def _text_with_notes(self, frame: int) -> str:
        """Return the text above a frame, with notes on rounding errors and the largest value."""
        lines = [_picture_text(self.scene, frame, self.deformation), *self.rests]
        if self.scene.origin and (self.arrows == "displacement" or "displacement" in self.color):
            lines.append(f"displacements {self.scene.origin}")
        if self.limits.most > self.limits.usual:
            kind, scene = QUANTITIES[self.color], self.scene
            values = np.nan_to_num(quantity(scene, self.color, frame, self.since))
            values[scene.removed(frame)] = 0.0
            block = int(np.argmax(abs(values)))
            if abs(values[block]) > self.limits.usual:
                name, area = _shorten_name(scene.names[block]), number(scene.areas()[block], 3)
                lines.append(f"largest: {name} ({area} m²) {shown(values[block], kind.unit)}")
        return "\n".join(lines)


def _shorten_name(name: str) -> str:
    """Cut a name to the width `_NAME`, to leave space for other texts."""
    return folded(name, _NAME, 9.5, most_lines=1)


def _scale_norm(span: Limits) -> Normalize:
    """Return the matplotlib norm that maps values to positions on a colour scale, 0 … 1."""
    if span.usual == span.most:
        return Normalize(span.low, span.high)
    values, marks = span.nodes
    functions = (lambda v: np.interp(v, values, marks), lambda p: np.interp(p, marks, values))
    return FuncNorm(functions, span.low, span.high)


def _scale_ticks(span: Limits):
    """Return the tick locator of a colour scale: round values if linear, else ends of its parts."""
    if span.usual == span.most:
        return MaxNLocator(5, min_n_ticks=3)
    values, marks = span.nodes
    half = 0.5 * span.usual * np.sign([span.low, span.high])
    ends, inner = values[[0, -1]], [*values[1:-1], *half]
    ticks = [tick for tick in inner if abs(span.share(tick) - marks[[0, -1]]).min() >= _APART]
    return FixedLocator([*ends, *ticks])


def deformed(scene: Scene, frame: int, factor: float) -> np.ndarray:
    """Return positions of the vertices with scaled displacements, shape (vertices, 2), m."""
    positions = scene.vertices(frame)
    if factor == 1.0 or frame == 0:
        return positions
    return positions + (factor - 1.0) * (positions - scene.vertices(0) - scene.base[frame])


def _make_figure(scene: Scene) -> Figure:
    """Create a figure with the aspect ratio of the model."""
    low, high = scene.box
    width, height = np.maximum(high - low, 0.05 * scene.size)
    scale = min(7.0 / width, 5.6 / height)
    size = (max(3.6, width * scale) + 2.9, max(2.4, height * scale) + _AROUND)
    return empty_figure(size)


def _line_width(scene: Scene) -> float:
    """Return the line width of block edges, points; thinner for many blocks."""
    return 0.7 if scene.blocks < 600 else 0.35 if scene.blocks < 6000 else 0.15


def _draw_body_outlines(axes: Axes, scene: Scene, frame: int, vertices) -> list:
    """Draw outlines of bodies and damage of faces and joints in a frame; return the artists."""
    width, artists = _line_width(scene), []
    if scene.welded.any():
        visible = ~scene.welded & ~scene.removed(frame)[scene.owner]
        sides = np.stack([vertices[visible], vertices[scene.next_vertex[visible]]], axis=1)
        lines = LineCollection(sides, colors=EDGE, linewidths=width, capstyle="round", zorder=2.1)
        artists.append(axes.add_collection(lines, autolim=False))
    damage = np.where(scene.removed(frame)[scene.owner], 0.0, scene.edge_damage(frame))
    broken = damage > 0
    if broken.any():
        edges = np.stack([vertices[broken], vertices[scene.next_vertex[broken]]], axis=1)
        cracks = LineCollection(
            edges, colors=FORCE, linewidths=width * (0.5 + 1.5 * damage[broken]), zorder=2.2
        )
        artists.append(axes.add_collection(cracks, autolim=False))
    return artists


def _present_polygons(scene: Scene, frame: int, vertices) -> list[np.ndarray]:
    """Return the polygons of all blocks; polygons of removed blocks are NaN."""
    removed = scene.removed(frame)[scene.owner]
    return scene.split(np.where(removed[:, None], np.nan, vertices) if removed.any() else vertices)


def _draw_joints(axes: Axes, scene: Scene, frame: int, factor: float) -> list:
    """Draw the joints between blocks in the colours of their &joint; return legend handles."""
    faces = scene.interfaces
    if len(faces) == 0 or len(scene.joint_names) < 2:
        return []
    present = ~(scene.removed(frame)[faces.first] | scene.removed(frame)[faces.second])
    kinds = scene.interface_joints[present]
    lines = joint_lines(scene, frame, factor)[present]
    colors = [JOINTS[k % len(JOINTS)] for k in kinds]
    axes.add_collection(LineCollection(lines, colors=colors, linewidths=1.7, zorder=3))
    return [
        Line2D([], [], color=JOINTS[k % len(JOINTS)], lw=2, label=scene.joint_names[k])
        for k in np.unique(kinds)
    ]


def _draw_bolts(axes: Axes, scene: Scene, frame: int) -> list:
    """Draw bolts, wider for larger forces and dotted if broken; return the artists."""
    bolts = scene.bolts(frame)
    peak = max((abs(bolt["force"]) for bolt in bolts if np.isfinite(bolt["force"])), default=0.0)
    artists = []
    for bolt in bolts:
        ratio = abs(bolt["force"]) / peak if peak and np.isfinite(bolt["force"]) else 0.4
        style = ":" if bolt["state"] == BROKEN else "-"
        for color, margin, dash in ((PAPER, 1.6, "-"), (BOLT, 0.0, style)):
            look = {"color": color, "lw": 0.9 + 2.6 * ratio + margin, "ls": dash, "zorder": 6}
            look |= {"solid_capstyle": "round", "solid_joinstyle": "round"}
            artists += axes.plot(*bolt["places"].T, marker="o", ms=3.0, **look)
    return artists


def _bolt_legend(scene: Scene, frame: int) -> list:
    """Return the legend handle of the bolts, in a list; none without bolts."""
    bolts = scene.bolts(frame)
    if not bolts:
        return []
    forces = [abs(bolt["force"]) for bolt in bolts if np.isfinite(bolt["force"])]
    label = "bolt"
    if forces:
        label = f"bolt, largest force\n{shown(max(forces), 'N/m')}"
    return [Line2D([], [], color=BOLT, lw=2.2, marker="o", ms=3.0, label=label)]


def _draw_supports(axes: Axes, scene: Scene) -> list:
    """Draw supports, loads, measured points and slivers; return handles for the legend."""
    handles = []
    for is_moved, color, label in ((False, INK, "fixed point"), (True, BLUE, "moved point")):
        fixed = [(s["x"], s["y"]) for s in scene.supports() if s["moved"] == is_moved]
        if fixed:
            (line,) = axes.plot(
                *zip(*fixed, strict=True), "^", color=color, mec=PAPER, mew=0.8, ms=8.5, zorder=6
            )
            line.set_label(label)
            handles.append(line)
    handles += _draw_loads(axes, scene)
    points = scene.points()
    if points:
        x, y = [p["x"] for p in points], [p["y"] for p in points]
        (line,) = axes.plot(x, y, "o", color=POINT, mec=PAPER, mew=0.9, ms=7, zorder=7)
        line.set_label("measured point")
        handles.append(line)
        names = [plain(_shorten_name(point["name"])) for point in points[:_MOST_LABELS]]
        fixed = np.column_stack([x, y])
        PointNames(axes, names, fixed[:_MOST_LABELS], fixed)
    return handles + _draw_slivers(axes, scene)


def _draw_water(axes: Axes, scene: Scene) -> list:
    """Draw water tables and lines of water pressure; return handles for the legend."""
    handles = {}
    for group in scene.groups.get("water", []):
        for name, style, label in (("surface", "--", "water table"), ("along", "-", "water")):
            line = np.reshape(group.get(name, ()), (-1, 2))
            if len(line):
                axes.plot(*line.T, color=PAPER, lw=4.2, zorder=2.4)
                (handles[label],) = axes.plot(*line.T, style, color=WATER, lw=2.4, zorder=2.5,
                                              label=label)  # fmt: skip
    return list(handles.values())


def load_arrows(scene: Scene) -> list[tuple]:
    """Return tail and tip (m) of the arrow of each load, and the size of the load (N/m)."""
    loads = scene.loads()
    sizes = [float(np.hypot(load["fx"], load["fy"])) for load in loads]
    reach = 0.12 * scene.size / (max(sizes, default=0.0) or 1.0)
    tips = [np.array([load["x"], load["y"]], dtype=float) for load in loads]
    pushes = [reach * np.array([load["fx"], load["fy"]]) for load in loads]
    return [(t - p, t, size) for t, p, size in zip(tips, pushes, sizes, strict=True)]


def _draw_loads(axes: Axes, scene: Scene) -> list:
    """Draw loads as arrows; return their legend handle, in a list."""
    arrows = load_arrows(scene)
    if not arrows:
        return []
    look = {"arrowstyle": "-|>", "color": FORCE, "lw": 1.8, "mutation_scale": 13}
    for tail, tip, _ in arrows:
        axes.annotate("", tip, tail, arrowprops=look, zorder=7)
    label = f"load, largest {shown(max(size for _, _, size in arrows), 'N/m')}"
    return [Line2D([], [], color=FORCE, lw=1.8, marker=">", label=label)]


def _draw_slivers(axes: Axes, scene: Scene) -> list:
    """Draw circles around slivers; return their legend handle, in a list."""
    thin = scene.slivers()
    if len(thin) == 0:
        return []
    x, y = scene.coordinates(0)[thin, :2].T
    label = "sliver: " + _shorten_list([scene.names[b] for b in thin], 3)
    return axes.plot(x, y, "o", mfc="none", mec=POINT, mew=1.6, ms=13, zorder=8, label=label)


def view_box(scene: Scene, vertices=None) -> tuple[np.ndarray, np.ndarray]:
    """Return two corners of a picture, m: first frame, and vertices up to half its size away."""
    low, high = scene.box
    margin = 0.04 * scene.size
    if vertices is not None:
        reach = 0.5 * scene.size
        within = np.all((vertices > low - reach) & (vertices < high + reach), axis=1)
        if within.any():
            low = np.minimum(low, vertices[within].min(0))
            high = np.maximum(high, vertices[within].max(0))
    return low - margin, high + margin


def _set_view(axes: Axes, scene: Scene, vertices) -> None:
    """Set the ranges and labels of axes for given vertices, shape (k, 2), m."""
    low, high = view_box(scene, vertices)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", anchor="NW")
    axes.set_xlabel("x (m)", color=INK)
    axes.set_ylabel("y (m)", color=INK)
    axes.tick_params(color=FAINT, labelcolor=INK)


def _picture_text(scene: Scene, frame: int, deformation: float) -> str:
    """Return time, number of blocks, factor of displacements and lost blocks as text."""
    parts = [scene.size_words]
    if not scene.before:
        parts.insert(0, f"t = {scene.time[frame]:.4g} s")
    if deformation != 1.0:
        parts.append(f"displacements × {deformation:g}")
    removed = int(scene.removed(frame).sum())
    if removed:
        parts.append(f"{counted(removed, 'block', 'blocks')} removed")
    lost = scene.lost(frame)
    if len(lost):
        names = _shorten_list([scene.names[b] for b in lost], 3)
        parts.append(f"{counted(len(lost), 'block', 'blocks')} out of view: {names}")
    return ", ".join(parts)


def _shorten_list(names: list[str], count: int) -> str:
    """Return up to `count` names, and the number of the others, as text."""
    remainder = len(names) - count
    return ", ".join(names[:count]) + (f" and {remainder} more" if remainder > 0 else "")
