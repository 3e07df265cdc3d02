# SPDX-License-Identifier: GPL-3.0-or-later
"""Mode shapes of a model as frames for pictures and the interactive view."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from ..base.arguments import Range
from ..engine.checking import Modes, modes
from ..engine.simulation import Simulation
from ..output.scene import Scene
from ..report.layout import Head, headline, plain
from ..report.style import dress, empty_figure
from .pictures import BlockPicture, view_box

_FRAMES = 24  # number of frames per period
REACH = 0.06  # largest displacement of a mode / size of the model
_COUNT = Range(1, 50, whole=True)
_WIDTH = 3.6  # width of the picture of a mode, inches


def mode_scene(source, count: int = 3, contacts: str = "auto") -> tuple[Scene, Modes]:
    """Return a scene with one period of each of the lowest modes, one stage per mode.

    `contacts`: see `sitedda.modes`.

    Frame 0 is the model at rest; the largest displacement of a mode is 6 % of the model size.
    """
    count = int(_COUNT.check("count", count))
    if isinstance(source, Simulation):
        model, result = Scene.of(source), modes(source, count, contacts)
    else:
        with Simulation(source) as simulation:
            model, result = Scene.of(simulation), modes(simulation, count, contacts)
    waves = np.cos(2 * np.pi * np.arange(1, _FRAMES + 1) / _FRAMES)
    displacements = [np.zeros((1, model.blocks, 6))]
    for shape in result.shapes:
        largest = np.linalg.norm(shape[:, :2], axis=1).max() or 1.0
        displacements.append(REACH * model.size / largest * waves[:, None, None] * shape)
    q = model.coordinates(0) + np.concatenate(displacements)
    return _make_scene(model, q, result), result


def _make_scene(model: Scene, q: np.ndarray, result: Modes) -> Scene:
    """Return a scene of a model with given block coordinates, shape (frames, blocks, 6)."""
    keep = [n for n in ("block", "block_material", "edge_joint", "block_body", "edge_welded",
                        "vertex_block") if n in model.data]  # fmt: skip
    frames = len(q)
    no_values = {f"contact_{n}": ("contact", np.zeros(0, dtype=int)) for n in
            ("frame", "vertex", "edge", "state", "bonded", "gap", "normal_force",
             "shear_force")}  # fmt: skip
    zeros = (("frame", "block", "component"), np.zeros((frames, model.blocks, 3)))
    data = xr.Dataset(
        {name: model.data[name] for name in keep}
        | {
            "vertices": (("frame", "vertex", "axis"), np.tile(model.vertices(0), (frames, 1, 1))),
            "block_coordinates": (("frame", "block", "coordinate"), q),
            "block_rates": (("frame", "block", "coordinate"), np.zeros_like(q)),
            "block_stress": zeros,
            "frame_time": ("frame", np.arange(frames) / _FRAMES),
            "frame_stage": ("frame", 1 + np.maximum(np.arange(frames) - 1, 0) // _FRAMES),
        }
        | no_values,
        attrs=model.data.attrs | {"stages": "\n".join(mode_words(result)), "loops": 1},
    )
    scene = Scene(data)
    vertices = [scene.carried(scene.owner, model.vertices(0), frame) for frame in range(frames)]
    data["vertices"] = ("frame", "vertex", "axis"), np.stack(vertices)
    scene = Scene(data)
    scene.title = f"Modes of {model.title or 'a model'}"
    return scene


def mode_words(result: Modes) -> list[str]:
    """Return number, frequency, damping and larger effective mass of each mode as text."""
    texts = []
    for i, (frequency, damping) in enumerate(zip(result.frequency, result.damping, strict=True)):
        axis = int(np.argmax(result.effective_mass[i]))
        percentage = 100 * result.effective_mass[i, axis]
        texts.append(f"mode {i + 1}: {frequency:.4g} Hz, damping {100 * damping:.2g} %, "
                     f"{percentage:.2g} % of the mass along {'xy'[axis]}")  # fmt: skip
    return texts


def draw_modes(
    source, count: int = 3, contacts: str = "auto", only: Sequence[int] | None = None, subtitle=None
) -> Figure:
    """Draw the lowest modes with exaggerated displacements; return the figure.

    `source`, `count`, `contacts`: see `mode_scene`; `only`: indices of the drawn modes, from 0
    (all); `words`: title and description of each mode, separated by a comma (`mode_words`).
    """
    scene, result = mode_scene(source, count, contacts)
    only = range(len(result.frequency)) if only is None else only
    subtitle = subtitle or [mode_words(result)[i] for i in only]
    low, high = view_box(scene)
    columns = min(len(subtitle), 3)
    rows = -(-len(subtitle) // columns)
    height = float(np.clip(_WIDTH * (high - low)[1] / (high - low)[0], 1.2, 6.0))
    figure = empty_figure((_WIDTH * columns + 0.6, (height + 1.2) * rows + 0.6))
    headline(figure, plain(scene.title))
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, i, line in zip(panels, only, subtitle, strict=False):
        picture = BlockPicture(scene, "displacement", axes=axes, legend=False)
        picture.show((i + 1) * _FRAMES)
        picture.head.note.remove()
        title, _, details = line.partition(", ")
        Head(axes, title, [details.replace(", ", "\n")])
    for axes in panels[len(subtitle) :]:
        axes.set_visible(False)
    return dress(figure)
