# SPDX-License-Identifier: GPL-3.0-or-later
"""The drawing of a model that the server sends to the page before a run."""

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

_FILE_BLOCKS = 1_000  # number of blocks from which the engine reads them faster from a file
_ALIGNED = 8  # bytes; an array in the browser must start at a multiple of the size of its numbers


@dataclass(frozen=True)
class Drawing:
    """The drawing of a model.

    `notes`: notes on blocks that were removed or merged, and on probable mistakes of the input.
    """

    message: bytes  # message to the page in the format of `pack_message`
    notes: list[str]
    start: np.ndarray  # shape (blocks, 6); block coordinates, m and rad


def draw_model(text: str, file: Path, **header_values) -> Drawing:
    """Draw the model of an input.

    `file`: file of the input; `**header_values`: additional values for the head of the message.
    """
    with TemporaryDirectory(prefix="sitedda") as folder:
        write_blocks = partial(_blocks_text, Path(folder) / "blocks.nc")
        with Simulation(InputOfRun(file, text, write_blocks), drawn=True) as simulation:
            return draw_simulation(simulation, **header_values)


def _blocks_text(file: Path, blocks: Sequence[dict]) -> str:
    """Return the groups of the blocks; write `_FILE_BLOCKS` or more blocks to a file instead."""
    if len(blocks) >= _FILE_BLOCKS:
        with suppress(OutputError):  # a full disk
            return group_text("blocks", {"file": str(write_block_file(file, blocks))})
    return blocks_text(blocks)


def draw_simulation(simulation: Simulation, **header_values) -> Drawing:
    """Draw the present state of a simulation, with `header_values` in the header."""
    scene = Scene.of(simulation)
    notes = f"{simulation.notes}\n{simulation.block_notes()}".split("\n")
    notes = [note for note in notes if note.strip()]
    page = view(scene, color="material")
    streams = {name: base64.b64decode(data) for name, data in page.streams.items()}
    header = {"kind": "drawn", "meta": page.meta, "marks": marks(scene),
              "points": simulation.point_names, "notes": notes}  # fmt: skip
    return Drawing(pack_message(header | header_values, streams), notes, simulation.coordinates)


def pack_message(header: dict, streams: dict[str, bytes]) -> bytes:
    """Pack a message: length of the head (4 bytes), head as JSON, streams of bytes.

    The head contains the offset of each stream from the end of the head, and its length, in bytes.
    """
    ranges, offset = {}, 0
    for name, data in streams.items():
        ranges[name] = [offset, len(data)]
        offset += -(-len(data) // _ALIGNED) * _ALIGNED
    text = json.dumps(header | {"streams": ranges}, allow_nan=False).encode()
    text += b" " * (-(4 + len(text)) % _ALIGNED)
    chunks = [len(text).to_bytes(4, "little"), text]
    for data in streams.values():
        chunks += [data, b"\0" * (-len(data) % _ALIGNED)]
    return b"".join(chunks)


def marks(scene: Scene) -> dict:
    """Return supports, boundaries, loads, points, water and slivers; positions from the centre, m.

    The edges of boundaries have absolute positions.
    """
    low, high = scene.box
    x0, y0 = 0.5 * (low + high)

    def relative_to_centre(mark: dict) -> dict:
        return mark | {"x": mark["x"] - x0, "y": mark["y"] - y0}

    lines = [np.reshape(g["surface"], (-1, 2)) for g in scene.groups.get("water", [])
             if np.size(g.get("surface", ()))]  # fmt: skip
    return {
        "supports": [relative_to_centre(entry) for entry in scene.supports()],
        "boundaries": [
            {
                "kind": entry["kind"],
                "moved": entry["moved"],
                "edges": np.hstack([entry["start"], entry["end"]]).round(6).ravel().tolist(),
            }
            for entry in scene.boundaries(0)
        ],
        "loads": [
            relative_to_centre({name: float(v) for name, v in entry.items()})
            for entry in scene.loads()
        ],
        "points": [relative_to_centre(entry) for entry in scene.points()],
        "water": [(line - (x0, y0)).ravel().tolist() for line in lines],
        "slivers": scene.slivers().tolist(),
        "origin": [float(x0), float(y0)],
    }


def card(text: str, file: Path, limit: int = 4000) -> dict:
    """Return the outlines of blocks in thousandths of the size of the model, for a thumbnail.

    `text`, `file`: the input and its file; `limit`: largest number of blocks in the thumbnail; of
    more blocks, every second, third … is drawn.
    """
    with Simulation(InputOfRun(file, text), drawn=True) as simulation:
        polygons, materials = simulation.polygons, simulation.block_materials
        title = simulation.title
    points = np.concatenate(polygons)
    low, size = points.min(0), float(np.ptp(points, axis=0).max()) or 1.0
    step = -(-len(polygons) // limit)
    outlines = [
        [int(material), *np.rint(1000 * (polygon - low) / size).astype(int).ravel().tolist()]
        for polygon, material in zip(polygons[::step], materials[::step], strict=True)
    ]
    box = np.ceil(1000 * np.ptp(points, axis=0) / size).astype(int).tolist()
    return {"title": title, "box": box, "blocks": outlines}
