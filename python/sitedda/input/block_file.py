# SPDX-License-Identifier: GPL-3.0-or-later
"""Write block files: the blocks of a large model in netCDF instead of text.

The format is netCDF classic, because the netCDF-4 library crashes on some damaged files.

``vertices`` (vertex, axis) contains the corners of all blocks, counter-clockwise; ``corners``
(block) the number of corners per block; ``name`` (block, letter) the names.  ``material`` (block),
``edge_joint`` (vertex; for the edge that begins there) and ``body`` (block; for cells) are indices
from 1 into ``material_name``, ``joint_name`` and ``body_name``; 0 is none.  Only ``vertices`` and
``corners`` are required.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from ..base.core import FILES
from ..base.errors import InputError
from ..base.files import written

LONGEST_NAME = 64  # longest name in bytes, as in the engine
LARGE = 10_000  # smallest number of blocks that are written to a separate file


def write_block_file(file, blocks: Sequence[dict], inputs: Sequence = ()) -> Path:
    """Write blocks to a file that ``&blocks file = …`` reads.

    `blocks`: variables of &block groups: vertices, and optionally name, material, joint,
    edge_joints, body.
    `inputs`: files from which the blocks are read, which must not be replaced.
    """
    import netCDF4

    file = Path(file)
    polygons = [np.reshape(block["vertices"], (-1, 2)) for block in blocks]
    corners = [len(polygon) for polygon in polygons]
    materials, material = _number_names(block.get("material", "") for block in blocks)
    joints, joint = _number_names(
        name
        for block, edges in zip(blocks, corners, strict=True)
        for name in _edge_joints(block, edges)
    )
    texts = {
        "name": [block.get("name", "") for block in blocks],
        "material_name": materials,
        "joint_name": joints,
    }
    vertices = np.concatenate(polygons) if polygons else np.empty((0, 2))
    numbers = {
        "vertices": (("vertex", "axis"), "f8", vertices),
        "corners": (("block",), "i4", corners),
        "material": (("block",), "i4", material),
        "edge_joint": (("vertex",), "i4", joint),
    }
    bodies, body = _number_names(block.get("body", "") for block in blocks)
    if bodies:
        texts["body_name"] = bodies
        numbers["body"] = (("block",), "i4", body)
    characters = {name: _names_to_characters(list_of) for name, list_of in texts.items()}
    with (
        written(file, "a netCDF file", inputs) as writing,
        FILES,
        netCDF4.Dataset(writing, "w", format="NETCDF3_64BIT_OFFSET") as data,
    ):
        data.title = "blocks of a sitedda model"
        for name, (dimensions, kind, values) in numbers.items():
            _write_variable(data, name, kind, dimensions, values)
        for name, letters in characters.items():
            rows = "block" if name == "name" else name
            _write_variable(data, name, "S1", (rows, f"letter_of_{name}"), letters)
        data["vertices"].units = "m"
    return file


def _write_variable(data, name: str, kind: str, dimensions, values) -> None:
    """Write a variable, and its missing dimensions, to a netCDF file."""
    if 0 in np.shape(values):  # netCDF treats a dimension of length 0 as unlimited
        return
    for dimension, size in zip(dimensions, np.shape(values), strict=True):
        if dimension not in data.dimensions:
            data.createDimension(dimension, size)
    data.createVariable(name, kind, dimensions, fill_value=False)
    data[name][:] = values


def _edge_joints(block: dict, edges: int) -> list[str]:
    """Return the joint name of each edge of a block; blank: the first joint of the input."""
    default_joint = block.get("joint", "")
    names = [name or default_joint for name in block.get("edge_joints", ())]
    return names + [default_joint] * (edges - len(names))


def _number_names(names: Iterable[str]) -> tuple[list[str], list[int]]:
    """Return the distinct names, and for each given name its number from 1 (blank: 0)."""
    number = {"": 0}
    numbers = [number.setdefault(name, len(number)) for name in names]
    return list(number)[1:], numbers


def _names_to_characters(names: Sequence[str]) -> np.ndarray:
    """Convert names to characters, shape (names, length of the longest)."""
    texts = [name.encode() for name in names]
    longest = max(map(len, texts), default=1) or 1
    if longest > LONGEST_NAME:
        name = names[int(np.argmax([len(text) for text in texts]))]
        raise InputError(f"the name {name!r} is longer than {LONGEST_NAME} bytes")
    return np.array(texts, dtype=f"S{longest}").view("S1").reshape(len(texts), longest)
