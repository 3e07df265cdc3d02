# SPDX-License-Identifier: GPL-3.0-or-later
"""Data of the model for the page before any stage has started."""

import base64
import json
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from ..base.errors import OutputError
from ..drawing.view import view
from ..engine.simulation import Simulation
from ..input.block_file import write_block_file
from ..input.groups import group_text
from ..input.source import InputOfRun, blocks_text
from ..output.scene import Scene

_MANY = 1_000  # blocks
_ALIGNED = 8  # bytes: typed arrays of the browser are aligned to their size


@dataclass(frozen=True)
class Drawing:
    """The drawing of a model.

    Attributes
    ----------
    message : bytes
        For the page, see `packed`.
    notes : list of str
        Notes on blocks that were removed or merged, and on probable mistakes of the input.
    start : ndarray, shape (blocks, 6)
        Block coordinates, m and rad.
    """

    message: bytes
    notes: list[str]
    start: np.ndarray


def draw_model(text: str, file: Path, **more) -> Drawing:
    """Build the blocks of an input, read it by the engine and draw it.

    Parameters
    ----------
    text : str
    file : path
        File of the input.
    **more
        Additional values in the head of the message.

    Raises
    ------
    InputError
        If the input cannot be run; the message names group, line and value.
    """
    with TemporaryDirectory(prefix="sitedda") as folder:
        put = partial(_blocks_text, Path(folder) / "blocks.nc")
        with Simulation(InputOfRun(file, text, put), drawn=True) as simulation:
            return draw_simulation(simulation, **more)


def _blocks_text(file: Path, blocks: Sequence[dict]) -> str:
    """Return blocks as text; many are written to a file, which the engine reads faster."""
    if len(blocks) >= _MANY:
        with suppress(OutputError):  # a full disk
            return group_text("blocks", {"file": str(write_block_file(file, blocks))})
    return blocks_text(blocks)


def draw_simulation(simulation: Simulation, **more) -> Drawing:
    """Draw the present state of a simulation as the model."""
    scene = Scene.of(simulation)
    notes = f"{simulation.notes}\n{simulation.block_notes()}".split("\n")
    notes = [note for note in notes if note.strip()]
    page = view(scene, color="material")
    streams = {name: base64.b64decode(data) for name, data in page.streams.items()}
    head = {
        "kind": "drawn",
        "meta": page.meta,
        "marks": marks(scene),
        "points": simulation.point_names,
        "notes": notes,
    }
    return Drawing(packed(head | more, streams), notes, simulation.coordinates)


def packed(head: dict, streams: dict[str, bytes]) -> bytes:
    """Pack a message: length of its head (4 bytes), head as JSON, streams.

    The head contains the offset of each stream, from the end of the head, and its length.
    """
    places, at = {}, 0
    for name, data in streams.items():
        places[name] = [at, len(data)]
        at += -(-len(data) // _ALIGNED) * _ALIGNED
    text = json.dumps(head | {"streams": places}, allow_nan=False).encode()
    text += b" " * (-(4 + len(text)) % _ALIGNED)
    parts = [len(text).to_bytes(4, "little"), text]
    for data in streams.values():
        parts += [data, b"\0" * (-len(data) % _ALIGNED)]
    return b"".join(parts)


def marks(scene: Scene) -> dict:
    """Return supports, boundaries, loads, points, water and slivers relative to the origin."""
    low, high = scene.box
    x0, y0 = 0.5 * (low + high)

    def placed(one: dict) -> dict:
        return one | {"x": one["x"] - x0, "y": one["y"] - y0}

    lines = [np.reshape(g["surface"], (-1, 2)) for g in scene.groups.get("water", [])
             if np.size(g.get("surface", ()))]  # fmt: skip
    return {
        "supports": [placed(one) for one in scene.supports()],
        "boundaries": [
            {
                "kind": one["kind"],
                "moved": one["moved"],
                "edges": np.hstack([one["start"], one["end"]]).round(6).ravel().tolist(),
            }
            for one in scene.boundaries(0)
        ],  # fmt: skip
        "loads": [placed({name: float(v) for name, v in one.items()}) for one in scene.loads()],
        "points": [placed(one) for one in scene.points()],
        "water": [(line - (x0, y0)).ravel().tolist() for line in lines],
        "slivers": scene.slivers().tolist(),
        "origin": [float(x0), float(y0)],
    }


def card(text: str, file: Path, most: int = 4000) -> dict:
    """Return the outlines of the blocks of an input in whole numbers, for a small picture.

    Parameters
    ----------
    text, file
        The input, and where it is from.
    most : int
        Largest number of blocks; of more blocks, every second or third one is drawn.
    """
    with Simulation(InputOfRun(file, text), drawn=True) as simulation:
        polygons, materials = simulation.polygons, simulation.block_materials
        title = simulation.title
    places = np.concatenate(polygons)
    low, size = places.min(0), float(np.ptp(places, axis=0).max()) or 1.0
    step = -(-len(polygons) // most)
    outlines = [
        [int(material), *np.rint(1000 * (polygon - low) / size).astype(int).ravel().tolist()]
        for polygon, material in zip(polygons[::step], materials[::step], strict=True)
    ]
    box = np.ceil(1000 * np.ptp(places, axis=0) / size).astype(int).tolist()
    return {"title": title, "box": box, "blocks": outlines}
