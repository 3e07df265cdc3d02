# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of blocks: a model before its run, or a frame of an output, to scale.

Only `matplotlib.figure.Figure` is used: the backend of the session stays as it is.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Normalize, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from ..base.arguments import ANY
from ..output.scene import Scene, principal_stresses
from .boundary_marks import draw_boundaries
from .stress_crosses import draw_crosses, key_of_crosses, largest_stress

COLORINGS = ("material", "displacement", "velocity", "rotation", "stress")
CONTACTS = ("force", "slip", "open")
INK, FAINT = "#22262b", "#8a9099"
STONES = ("#dccfb4", "#b4c4d4", "#d3b09a", "#bccbaa", "#c9bad6", "#e6d88f", "#a9adb3", "#9fcac2")
JOINTS = ("#4a4f57", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b58900")
SUPPORT, MOVED, LOAD, POINT = "#22262b", "#0072b2", "#c0392b", "#d81b60"
MAGNITUDE, SIGNED, JOINT_MAP, FORCE = "viridis", "PuOr", "inferno_r", "#c22316"
_LABELS = {
    "displacement": "displacement\nof the centroid",
    "velocity": "velocity\nof the centroid",
    "rotation": "rotation",
    "stress": "largest compression",
}
_UNITS = {
    "m": ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm")),
    "m/s": ((1.0, "m/s"), (1e-3, "mm/s"), (1e-6, "µm/s")),
    "Pa": ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa")),
    "N/m": ((1e9, "GN/m"), (1e6, "MN/m"), (1e3, "kN/m"), (1.0, "N/m")),
    "°": ((1.0, "°"),),
}
BOLT, BROKEN = "#7a1fa2", 4
_MOST_DRAWN_OUTLINES = 30000
_MOST_LABELS = 24  # of measured points
_LEAST_MOVEMENT = 0.01  # of the largest: below, a slip or opening is not drawn
_LEAST_FORCE = 0.005  # of the largest: below, a force is not drawn


def in_unit(largest: float, unit: str) -> tuple[float, str]:
    """The size and name of the unit in which a value reads well: mm for 0.004 m."""
    for size, name in _UNITS[unit]:
        if abs(largest) >= size:
            return size, name
    return (1.0, unit) if largest == 0 else _UNITS[unit][-1]


def quantity(scene: Scene, color: str, frame: int) -> tuple[np.ndarray, str]:
    """A quantity of the blocks, shape (blocks,), and its unit."""
    if color == "displacement":
        return np.linalg.norm(scene.displacement(frame), axis=1), "m"
    if color == "velocity":
        return np.linalg.norm(scene.rates(frame)[:, :2], axis=1), "m/s"
    if color == "rotation":
        turn = scene.coordinates(frame)[:, 2] - scene.coordinates(0)[:, 2]
        return np.degrees(turn), "°"
    if color == "stress":
        return -principal_stresses(scene.stress(frame))[1], "Pa"
    raise ValueError(f"color is one of {', '.join(COLORINGS)}, not {color!r}")


def draw(
    source,
    time: float | None = None,
    color: str | None = None,
    contacts: str | None = None,
    deformation: float = 1.0,
    axes: Axes | None = None,
    legend: bool = True,
    stage: str | None = None,
) -> Axes:
    """Draw the blocks of a model or an output to scale.

    Parameters
    ----------
    source : path, Run, Simulation, xarray.Dataset or Scene
        A namelist input, an output, or what stands for one.
    time : float, optional
        s; the nearest frame is drawn.  Default: the last one.
    color : {'material', 'displacement', 'velocity', 'rotation', 'stress'}, optional
        What the blocks are coloured by; by 'stress' cells of bodies have crosses of their principal
        stresses.  Default: material for a model, displacement for an output.
    contacts : {'force', 'slip', 'open'}, optional
        Resultant contact forces of neighbours, or slip or opening of the joints since the start.
    deformation : float
        Factor on the displacements of the picture.
    axes : matplotlib.axes.Axes, optional
        Where to draw; a figure of its own by default.
    legend : bool
        With what the colours and signs mean, outside the axes.
    stage : str, optional
        The frame is one of this stage: of several static ones all are at one time.

    Returns
    -------
    matplotlib.axes.Axes
        ``axes.figure.savefig(file)`` writes it.

    Raises
    ------
    ValueError
        If `color` or `contacts` is not one of the above, or `deformation` no number.
    InputError
        If there is no such stage.
    """
    scene = source if isinstance(source, Scene) else Scene.of(source)
    picture = BlockPicture(scene, color, contacts, deformation, axes, legend)
    picture.show(scene.frame_at(time, stage))
    if axes is None:  # labels of ticks, which the layout needs, are known after a first pass
        picture.axes.figure.draw_without_rendering()
    return picture.axes


class BlockPicture:
    """Blocks on axes, a frame at a time; see `draw`.

    Parameters
    ----------
    scene : Scene
    color, contacts, deformation, axes, legend
        See `draw`.
    frames : sequence of int, optional
        Frames that will be shown: colours and view are those of all of them.
    """

    def __init__(
        self, scene, color=None, contacts=None, deformation=1.0, axes=None, legend=True, frames=()
    ):
        self.scene, self.legend = scene, legend
        self.deformation = ANY.check("deformation", deformation)
        self.color = color or ("material" if scene.before else "displacement")
        self.contacts = contacts
        if self.color not in COLORINGS:
            raise ValueError(f"color is one of {', '.join(COLORINGS)}, not {color!r}")
        if contacts not in (None, *CONTACTS):
            raise ValueError(f"contacts is one of {', '.join(CONTACTS)}, not {contacts!r}")
        self.alone = axes is None
        self.axes = _figure(scene).subplots() if self.alone else axes
        self.frames = list(frames)
        self.blocks = self.note = None
        self.lines: list = []
        self.stress = 0.0  # the largest of the cells of bodies, Pa, where crosses are drawn

    def show(self, frame: int) -> None:
        """Draw a frame in place of the last one."""
        scene = self.scene
        vertices = deformed(scene, frame, self.deformation)
        if self.blocks is None:
            self._begin(frame, vertices)
        else:
            self.blocks.set_verts(_standing(scene, frame, vertices))
            if self.color != "material":
                self.blocks.set_array(quantity(scene, self.color, frame)[0] / self.size)
            for line in self.lines:
                line.remove()
        self.lines = _body_outlines(self.axes, scene, frame, vertices)
        self.lines += self._contacts(frame, vertices) + _bolts(self.axes, scene, frame)
        if self.stress > 0:
            self.lines += draw_crosses(self.axes, scene, frame, self.deformation, self.stress)
        self.note.set_text(plain(_words(scene, frame, self.deformation)))

    def _begin(self, frame: int, vertices) -> None:
        scene, axes = self.scene, self.axes
        if scene.frames > 1 and (frame > 0 or self.frames):
            _outlines(axes, scene)
        self.blocks, self.size, handles = _blocks(
            axes, scene, frame, vertices, self.frames or [frame], self.color
        )
        if self.color == "material" and not self.contacts:
            handles += _joints(axes, scene, frame, self.deformation)
        if self.color == "stress" and (scene.body > 0).any():
            self.stress = largest_stress(scene, _some_of(self.frames) or [frame])
            size, unit = in_unit(self.stress, "Pa")
            handles += key_of_crosses(f"{self.stress / size:.3g} {unit}")
        if self.contacts:
            self.scale = self._contact_scale(frame)
            handles += self._contact_key()
        if scene.before or self.color == "material":
            handles += draw_boundaries(axes, scene, frame) + _boundary(axes, scene)
        handles += _bolt_key(scene, frame)
        shown = [deformed(scene, f, self.deformation) for f in _some_of(self.frames)]
        if scene.before or self.color == "material":
            shown += [tail for tail, _, _ in load_arrows(scene)]
        _view(axes, scene, np.vstack([vertices, *shown]))
        self.note = head(axes, plain(scene.title or "Untitled"), "")
        if handles and self.legend:
            _legend(axes, handles, self.alone)

    def _contact_scale(self, frame: int) -> float:
        """The largest force, slip or opening of the frames that are shown."""
        scene, most = self.scene, 0.0
        for f in _some_of(self.frames) or [frame]:
            if self.contacts == "force":
                force = force_lines(scene, f, scene.vertices(f))[1]
                values = np.linalg.norm(force, axis=1)
            else:
                values = scene.joint_movement(f)[CONTACTS.index(self.contacts) - 1]
            most = max(most, float(values.max(initial=0.0)))
        return most

    def _contact_key(self) -> list:
        if self.contacts == "force":
            scale, unit = in_unit(self.scale, "N/m")
            label = f"contact force,\nlargest {self.scale / scale:.3g} {unit}"
            return [Line2D([], [], color=FORCE, lw=4, solid_capstyle="round", label=label)]
        size, unit = in_unit(self.scale, "m")
        mapped = ScalarMappable(Normalize(0.0, self.scale / size or 1.0), JOINT_MAP)
        name = "slip of the joints" if self.contacts == "slip" else "opening of the joints"
        color_bar(self.axes, mapped, f"{name} ({unit})")
        return []

    def _contacts(self, frame: int, vertices) -> list:
        if self.contacts == "force":
            return _forces(self.axes, self.scene, frame, vertices, self.scale)
        if self.contacts:
            movement = self.scene.joint_movement(frame)[CONTACTS.index(self.contacts) - 1]
            seen = movement > _LEAST_MOVEMENT * self.scale
            lines = LineCollection(
                _carried_lines(self.scene, frame, self.deformation)[seen],
                linewidths=2.6,
                capstyle="round",
                zorder=3,
                cmap=JOINT_MAP,
                norm=Normalize(0.0, self.scale or 1.0),
                array=movement[seen],
            )
            return [self.axes.add_collection(lines)]
        return []


def _some_of(frames: list[int], most: int = 40) -> list[int]:
    """Frames that stand for many, the first and the last among them."""
    frames = sorted(set(frames))
    if len(frames) <= most:
        return frames
    return [frames[i] for i in np.linspace(0, len(frames) - 1, most).round().astype(int)]


def _legend(axes: Axes, handles: list, alone: bool) -> None:
    """Beside the picture, never over it."""
    if alone:
        axes.figure.legend(handles=handles, loc="outside right center", frameon=False, fontsize=9)
    else:
        axes.legend(
            handles=handles,
            loc="upper left",
            bbox_to_anchor=(1.0, 1.0),
            frameon=False,
            fontsize=8.5,
        )


def deformed(scene: Scene, frame: int, factor: float) -> np.ndarray:
    """Places of the vertices with displacements times a factor, shape (vertices, 2), m."""
    now = scene.vertices(frame)
    if factor == 1.0 or frame == 0:
        return now
    start = scene.vertices(0)
    return start + factor * (now - start)


def _figure(scene: Scene) -> Figure:
    """A figure in the shape of the model."""
    low, high = scene.box
    width, height = np.maximum(high - low, 0.05 * scene.size)
    scale = min(7.0 / width, 5.6 / height)
    size = (max(4.2, width * scale) + 2.2, max(2.4, height * scale) + 1.1)
    return Figure(figsize=size, layout="constrained")


def _blocks(axes: Axes, scene: Scene, frame: int, vertices, frames: list[int], color: str):
    """Blocks in their colours, the size of the unit of the colour, and handles for the legend."""
    edge = _line_width(scene)
    shown = _standing(scene, frame, vertices)
    look = {"edgecolors": INK, "linewidths": edge}
    if scene.welded.any():  # the outlines of bodies are drawn above, faces within them faint
        look = {"edgecolors": FAINT, "linewidths": 0.4 * edge}
    drawn = PolyCollection(shown, joinstyle="round", zorder=2, **look)
    axes.add_collection(drawn, autolim=False)
    if color == "material":
        drawn.set_facecolor([STONES[m % len(STONES)] for m in scene.material])
        handles = [
            Patch(fc=STONES[m % len(STONES)], ec=INK, lw=0.7, label=plain(scene.material_names[m]))
            for m in np.unique(scene.material)
        ]
        return drawn, 1.0, handles
    values, unit = quantity(scene, color, frames[0])
    low, high = float(values.min()), float(values.max())
    for frame in _some_of(frames):
        others, _ = quantity(scene, color, frame)
        low, high = min(low, float(others.min())), max(high, float(others.max()))
    size, unit = in_unit(max(abs(low), abs(high)), unit)
    drawn.set_array(values / size)
    drawn.set_cmap(SIGNED if color == "rotation" else MAGNITUDE)
    drawn.set_norm(_norm(color, low / size, high / size))
    color_bar(axes, drawn, f"{_LABELS[color]} ({unit})")
    return drawn, size, []


def _line_width(scene: Scene) -> float:
    """Of the sides of blocks, points."""
    return 0.7 if scene.blocks < 600 else 0.35 if scene.blocks < 6000 else 0.15


def _body_outlines(axes: Axes, scene: Scene, frame: int, vertices) -> list:
    """Sides of blocks that lie in no body, where there are bodies."""
    if not scene.welded.any():
        return []
    shown = ~scene.welded & ~scene.removed(frame)[scene.owner]
    sides = np.stack([vertices[shown], vertices[scene.next_vertex[shown]]], axis=1)
    lines = LineCollection(
        sides, colors=INK, linewidths=_line_width(scene), capstyle="round", zorder=2.1
    )
    return [axes.add_collection(lines, autolim=False)]


def _standing(scene: Scene, frame: int, vertices) -> list[np.ndarray]:
    """The polygons of the blocks; those that stages have removed are not drawn."""
    gone = scene.removed(frame)[scene.owner]
    return scene.split(np.where(gone[:, None], np.nan, vertices) if gone.any() else vertices)


def _norm(color: str, low: float, high: float):
    if color == "rotation":
        most = max(abs(low), abs(high)) or 1.0
        return TwoSlopeNorm(0.0, -most, most)
    low = 0.0 if color != "stress" else min(low, 0.0)
    return Normalize(low, high if high > low else low + 1.0)


def color_bar(axes: Axes, drawn, label: str) -> None:
    """A slim colour bar beside the picture."""
    bar = axes.figure.colorbar(drawn, ax=axes, shrink=0.75, aspect=26, pad=0.02)
    bar.set_label(label, color=INK, labelpad=6)
    bar.outline.set_visible(False)
    bar.ax.tick_params(length=2.5, color=FAINT)
    bar.ax.yaxis.set_major_locator(MaxNLocator(6))


def _outlines(axes: Axes, scene: Scene) -> None:
    """The first frame, behind, as a fine line."""
    if scene.blocks <= _MOST_DRAWN_OUTLINES:
        look = {"facecolors": "none", "edgecolors": "#b9bec5", "linewidths": 0.5, "zorder": 1}
        axes.add_collection(PolyCollection(scene.polygons(0), **look))


def _joints(axes: Axes, scene: Scene, frame: int, factor: float) -> list:
    """Joints between blocks, by the joint with the lower friction angle, as contacts take it."""
    faces = scene.interfaces
    if len(faces) == 0 or len(scene.joint_names) < 2:
        return []
    stays = ~(scene.removed(frame)[faces.first] | scene.removed(frame)[faces.second])
    kinds = scene.interface_joints[stays]
    lines = _carried_lines(scene, frame, factor)[stays]
    colors = [JOINTS[k % len(JOINTS)] for k in kinds]
    axes.add_collection(LineCollection(lines, colors=colors, linewidths=1.7, zorder=3))
    return [
        Line2D([], [], color=JOINTS[k % len(JOINTS)], lw=2, label=plain(scene.joint_names[k]))
        for k in np.unique(kinds)
    ]


def _carried_lines(scene: Scene, frame: int, factor: float) -> np.ndarray:
    """Interfaces where they are now, shape (k, 2, 2): they stay with their first blocks."""
    faces, ends = scene.interfaces, []
    for places in (faces.start, faces.end):
        now = scene.carried(faces.first, places, frame)
        ends.append(places + factor * (now - places))
    return np.stack(ends, axis=1)


def force_lines(scene: Scene, frame: int, vertices) -> tuple[np.ndarray, np.ndarray]:
    """Resultants between neighbours: their places and vectors, (k, 2) each, m and N/m."""
    contacts = scene.contacts(frame)
    places, normal = scene.contact_points(frame, contacts)
    push, along = contacts["normal_force"], np.column_stack([-normal[:, 1], normal[:, 0]])
    force = push[:, None] * normal - contacts["shear_force"][:, None] * along
    a, b = scene.owner[contacts["vertex"]], scene.owner[contacts["edge"]]
    sign = np.where(a < b, 1.0, -1.0)
    pair = np.minimum(a, b) * scene.blocks + np.maximum(a, b)
    _, pair = np.unique(pair, return_inverse=True)
    k = pair.max(initial=-1) + 1
    weight = np.bincount(pair, push, k)
    total = np.column_stack([np.bincount(pair, sign * f, k) for f in force.T])
    where = scene.touching(vertices, contacts) if len(push) else np.zeros((0, 2))
    centre = np.column_stack([np.bincount(pair, push * x, k) for x in where.T])
    good = weight > 0
    return centre[good] / weight[good, None], total[good]


def _forces(axes: Axes, scene: Scene, frame: int, vertices, most: float) -> list:
    """Resultants as lines, longer and thicker with their size; the collections."""
    places, force = force_lines(scene, frame, vertices)
    if len(force) == 0 or most == 0:
        return []
    seen = np.linalg.norm(force, axis=1) > _LEAST_FORCE * most
    places, force = places[seen], force[seen]
    size = np.linalg.norm(force, axis=1) / most
    half = 0.5 * _force_length(scene) * force / most
    lines = np.stack([places - half, places + half], axis=1)
    width = np.clip(5.0 * size, 0.5, None)
    drawn = []
    for color, more in (("white", 1.35), (FORCE, 1.0)):
        look = {"colors": color, "linewidths": width * more, "capstyle": "round", "zorder": 4}
        drawn.append(axes.add_collection(LineCollection(lines, **look)))
    return drawn


def _bolts(axes: Axes, scene: Scene, frame: int) -> list:
    """Bolts as lines, thicker with their force; broken ones are dashed.  The artists."""
    bolts = scene.bolts(frame)
    most = max((abs(one["force"]) for one in bolts if np.isfinite(one["force"])), default=0.0)
    drawn = []
    for one in bolts:
        share = abs(one["force"]) / most if most and np.isfinite(one["force"]) else 0.4
        style = ":" if one["state"] == BROKEN else "-"
        for color, more, dash in (("white", 1.6, "-"), (BOLT, 0.0, style)):
            look = {"color": color, "lw": 0.9 + 2.6 * share + more, "ls": dash, "zorder": 6}
            look |= {"solid_capstyle": "round", "solid_joinstyle": "round"}
            drawn += axes.plot(*one["places"].T, marker="o", ms=3.0, **look)
    return drawn


def _bolt_key(scene: Scene, frame: int) -> list:
    """The handle of the legend."""
    bolts = scene.bolts(frame)
    if not bolts:
        return []
    forces = [abs(one["force"]) for one in bolts if np.isfinite(one["force"])]
    label = "bolt"
    if forces:
        scale, unit = in_unit(max(forces), "N/m")
        label = f"bolt, largest force\n{max(forces) / scale:.3g} {unit}"
    return [Line2D([], [], color=BOLT, lw=2.2, marker="o", ms=3.0, label=label)]


def _force_length(scene: Scene) -> float:
    """Length of the largest force in the picture, m: about a block."""
    return 1.1 * float(np.sqrt(np.median(scene.areas())))


def _boundary(axes: Axes, scene: Scene) -> list:
    """Supports, loads, measured points and slivers, with handles for the legend."""
    handles = []
    for moved, color, label in ((False, SUPPORT, "fixed point"), (True, MOVED, "moved point")):
        places = [(s["x"], s["y"]) for s in scene.supports() if s["moved"] == moved]
        if places:
            (line,) = axes.plot(
                *zip(*places, strict=True), "^", color=color, mec="white", mew=0.8, ms=8.5, zorder=6
            )
            line.set_label(label)
            handles.append(line)
    handles += _loads(axes, scene)
    points = scene.points()
    if points:
        x, y = [p["x"] for p in points], [p["y"] for p in points]
        (line,) = axes.plot(x, y, "o", color=POINT, mec="white", mew=0.9, ms=7, zorder=7)
        line.set_label("measured point")
        handles.append(line)
        for point in points[:_MOST_LABELS]:
            axes.annotate(
                plain(point["name"]),
                (point["x"], point["y"]),
                xytext=(6, 5),
                textcoords="offset points",
                fontsize=8.5,
                color=POINT,
                zorder=8,
                path_effects=[withStroke(linewidth=2.5, foreground="white")],
            )
    return handles + _slivers(axes, scene)


def load_arrows(scene: Scene) -> list[tuple]:
    """Tail and tip of the arrow of each load, m, and its size, N/m; the longest is 12 % of all."""
    loads = scene.loads()
    sizes = [float(np.hypot(load["fx"], load["fy"])) for load in loads]
    reach = 0.12 * scene.size / (max(sizes, default=0.0) or 1.0)
    tips = [np.array([load["x"], load["y"]], dtype=float) for load in loads]
    pushes = [reach * np.array([load["fx"], load["fy"]]) for load in loads]
    return [(t - p, t, size) for t, p, size in zip(tips, pushes, sizes, strict=True)]


def _loads(axes: Axes, scene: Scene) -> list:
    arrows = load_arrows(scene)
    if not arrows:
        return []
    look = {"arrowstyle": "-|>", "color": LOAD, "lw": 1.8, "mutation_scale": 13}
    for tail, tip, _ in arrows:
        axes.annotate("", tip, tail, arrowprops=look, zorder=7)
    size = max(size for _, _, size in arrows)
    scale, unit = in_unit(size, "N/m")
    label = f"load, largest {size / scale:.3g} {unit}"
    return [Line2D([], [], color=LOAD, lw=1.8, marker=">", label=label)]


def _slivers(axes: Axes, scene: Scene) -> list:
    thin = scene.slivers()
    if len(thin) == 0:
        return []
    x, y = scene.coordinates(0)[thin, :2].T
    label = "sliver: " + plain(_some([scene.names[b] for b in thin], 3))
    return axes.plot(x, y, "o", mfc="none", mec="#e6007e", mew=1.6, ms=13, zorder=8, label=label)


def view_box(scene: Scene, vertices=None) -> tuple[np.ndarray, np.ndarray]:
    """What a picture shows, m: the first frame and what stays within half its size around it."""
    low, high = scene.box
    margin = 0.04 * scene.size
    if vertices is not None:
        reach = 0.5 * scene.size
        near = np.all((vertices > low - reach) & (vertices < high + reach), axis=1)
        if near.any():
            low = np.minimum(low, vertices[near].min(0))
            high = np.maximum(high, vertices[near].max(0))
    return low - margin, high + margin


def _view(axes: Axes, scene: Scene, vertices) -> None:
    low, high = view_box(scene, vertices)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_xlabel("x (m)", color=INK)
    axes.set_ylabel("y (m)", color=INK)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(FAINT)
    axes.tick_params(color=FAINT, labelcolor=INK)


def _words(scene: Scene, frame: int, deformation: float) -> str:
    """What is seen: time, blocks, factor, and blocks that are out of view."""
    parts = [f"{scene.bodies:,} block" + "s" * (scene.bodies != 1)]
    if scene.bodies < scene.blocks:
        parts = [f"{parts[0]} of {scene.blocks:,} cells"]
    if not scene.before:
        parts.insert(0, f"t = {scene.time[frame]:.4g} s")
    if deformation != 1.0:
        parts.append(f"displacements × {deformation:g}")
    gone = int(scene.removed(frame).sum())
    if gone:
        parts.append(f"{gone} removed")
    lost = scene.lost(frame)
    if len(lost):
        parts.append(f"{len(lost)} out of view: {_some([scene.names[b] for b in lost], 3)}")
    return ", ".join(parts)


def head(axes: Axes, title: str, words: str):
    """A title with a fainter line under it, flush with the left side of the axes; that line."""
    axes.set_title(title, loc="left", fontsize=12, color=INK, fontweight="bold", pad=24)
    return axes.annotate(
        words,
        (0, 1),
        xytext=(0, 8),
        xycoords="axes fraction",
        textcoords="offset points",
        fontsize=9.5,
        color="#5b6169",
    )


def _some(names: list[str], most: int) -> str:
    more = len(names) - most
    return ", ".join(names[:most]) + (f" and {more} more" if more > 0 else "")


def plain(text: str) -> str:
    """A user's text as it is: matplotlib takes pairs of $ as formulas, a leading _ as hidden."""
    text = text.replace("$", r"\$")
    return f"\u200b{text}" if text.startswith("_") else text
