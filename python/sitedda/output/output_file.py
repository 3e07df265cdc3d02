# SPDX-License-Identifier: GPL-3.0-or-later
"""The output of a run as a dataset, checked once when it is opened.

A file may be cut, changed, or another program's: what is read of it has the dimensions, kinds and
ranges that a run writes, or is one error that names the file and the variable.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..base.core import FILES
from ..base.errors import OutputError, lacks_memory
from ..base.reading import check_readable
from ..input.input_text import input_values
from .named_arrays import NamedArrays, read_netcdf

if TYPE_CHECKING:
    import xarray as xr

_MOST = 1e37  # of any number: single precision, and squares of larger ones, overflow
_ROUNDING = 1e-9  # of the length of an edge
_READ_AT_ONCE = 2**24  # bytes; larger variables are checked when they are read
_LENGTHS = {"axis": 2, "coordinate": 6, "component": 3, "coordinate4": 4}
_HELD = ("time", "frame", "vertex", "block")  # dimensions of which there is at least one


class _Kind(NamedTuple):
    """What a variable is: its dimensions; 'real', 'share', 'text' or what its numbers count."""

    dimensions: tuple[str, ...]
    what: str


def _kinds(text: str) -> dict[str, _Kind]:
    rows = (line.split() for line in text.strip().splitlines())
    return {name: _Kind(tuple(places), what) for name, what, *places in rows}


# Variables that come together: if one is there, all are.  Those of the first family always are.
# A number is 'real', a 'share' of an edge, an index below the length of a dimension, or 'number'
# from 0 upwards.
_FAMILIES = (
    _kinds("""
        time                  real    time
        time_step             real    time
        frame_time            real    frame
        vertices              real    frame vertex axis
        vertex_block          block   vertex
        block_coordinates     real    frame block coordinate
        block_rates           real    frame block coordinate
        block_stress          real    frame block component
        axis                  text    axis
        coordinate            text    coordinate
        component             text    component
        block                 text    block
        contact_frame         frame   contact
        contact_vertex        vertex  contact
        contact_edge          vertex  contact
        contact_state         number  contact
        contact_bonded        number  contact
        contact_gap           real    contact
        contact_normal_force  real    contact
        contact_shear_force   real    contact
        energy_kinetic        real    time
        energy_balance        real    time
    """),
    _kinds("""
        block_material        number  block
        edge_joint            number  vertex
    """),
    _kinds("""
        block_body            number  block
        edge_welded           number  vertex
    """),
    _kinds("""
        block_stress_error    real    frame block
    """),
    _kinds("""
        block_plastic_strain  real    frame block
    """),
    _kinds("""
        edge_damage           real    frame vertex
    """),
    _kinds("""
        stage                 number  time
        frame_stage           number  frame
    """),
    _kinds("""
        point                 text    point
        displacement          real    time point axis
        velocity              real    time point axis
        acceleration          real    time point axis
    """),
    _kinds("""
        bolt                  text    bolt
        bolt_force            real    time bolt
        bolt_shear_force      real    time bolt
        bolt_state            number  time bolt
        bolt_block            block   bolt axis
        bolt_place            real    bolt coordinate4
    """),
    _kinds("""
        bolt_through          bolt    through
        bolt_through_block    block   through
    """),
    _kinds("""
        boundary              text    boundary
        boundary_kind         text    boundary
        incoming_velocity     real    time boundary axis
        boundary_velocity     real    time boundary axis
    """),
    _kinds("""
        boundary_edge         vertex  boundary_edge
        boundary_edge_group   number  boundary_edge
        boundary_edge_from    share   boundary_edge
        boundary_edge_to      share   boundary_edge
    """),
)
_ALONE = _kinds("""
    block_removal         number  block
    block_density         real    block
    block_shear_modulus   real    block
    point_place           real    point axis
    joint                 text    joint
    iterations            real    time
    contact_joint         number  contact
    contact_stretch       real    contact
    contact_place         real    contact
""")
_KNOWN = {name: kind for family in (*_FAMILIES, _ALONE) for name, kind in family.items()}
_ATTRIBUTES = ("title", "input_text", "input_values", "input_file", "stages", "step_control",
               "verdict", "accuracy", "complete")  # fmt: skip


def open_output(file) -> xr.Dataset:
    """An output file as a dataset; its frames are read when they are asked for.

    It has coordinates to select by:
    ``data.block_stress.sel(block="brick_7", component="yy").sel(frame=1.5, method="nearest")``.

    Raises
    ------
    InputError
        If there is no such file.
    OutputError
        If it is not an output of a run, or damaged; the message names the variable.
    """
    import xarray as xr

    check_readable(file)
    with _reading(_unreadable(file)):
        data = xr.open_dataset(file, engine="netcdf4", cache=False, decode_times=False)
    try:
        _check(data)
    except OutputError:
        data.close()
        raise
    return data


def read_output(file) -> NamedArrays:
    """All of an output, in memory, as far as words and pictures need it; errors as above."""
    check_readable(file)
    with _reading(_unreadable(file)):
        data = read_netcdf(file)
    _check(data)
    return data


def _unreadable(file) -> Callable[[str], OutputError]:
    return lambda why: OutputError(f"{file} cannot be read as an output: {why}")


def _check(data) -> None:
    """Structure, numbers and their order are those that a run writes."""
    _check_structure(data)
    for name in _KNOWN:
        if name in data.variables and data[name].nbytes <= _READ_AT_ONCE:
            read(data, name)
    _check_order(data)


def read(data: xr.Dataset, name: str, which=...) -> np.ndarray:
    """Values of a variable, or of some of its rows, that are what a run writes.

    Raises
    ------
    OutputError
        If the file does not hold them, or the bytes are no such numbers.
    """
    with _reading(lambda why: damaged(data, name, why)):
        values = data[name][which].values
    kind = _KNOWN.get(name)
    if kind is None or kind.what == "text" or values.size == 0:
        return values
    if not np.issubdtype(values.dtype, np.number):
        raise damaged(data, name, "it holds no numbers")
    if kind.what == "real":
        good = np.abs(values) <= _MOST
    elif kind.what == "share":
        good = np.abs(values - 0.5) <= 0.5 + _ROUNDING
    else:
        most = data.sizes.get(kind.what, np.iinfo(np.int32).max)
        good = (values >= 0) & (values < most)
    if not good.all():
        first = np.unravel_index(int(np.argmin(good)), good.shape)
        raise damaged(data, name, f"one value is {values[first]:g}")
    return values


def load(file) -> xr.Dataset:
    """All of an output, in memory."""

    def wrong(why: str) -> OutputError:
        return OutputError(f"{file} cannot be read: {why}")

    with open_output(file) as data, _reading(wrong):
        return data.load()


@contextmanager
def _reading(wrong: Callable[[str], OutputError]) -> Iterator[None]:
    """Whatever the libraries below raise for foreign bytes is one error; want of memory is not."""
    try:
        with FILES:
            yield
    except Exception as trouble:
        if lacks_memory(trouble):
            raise
        lines = str(trouble).strip().splitlines() or [type(trouble).__name__]
        raise wrong(lines[0]) from trouble


def _check_structure(data: xr.Dataset) -> None:
    """Variables that belong together are there, with their dimensions; texts are texts."""
    for place, family in enumerate(_FAMILIES):
        there = [name for name in family if name in data.variables]
        lacking = [name for name in family if name not in data.variables]
        if lacking and (there or place == 0):
            raise damaged(data, lacking[0], "it is not there")
    for name, kind in _KNOWN.items():
        if name not in data.variables:
            continue
        found = data[name]
        if found.dims != kind.dimensions:
            raise damaged(data, name, f"its dimensions are {', '.join(found.dims) or 'none'}")
        if (kind.what != "text") != np.issubdtype(found.dtype, np.number):
            raise damaged(data, name, f"its values are of type {found.dtype}")
    for name in data.variables:
        if str(name).startswith("energy_"):
            _check_numbers(data, name)
    for name, length in data.sizes.items():
        if length != _LENGTHS.get(name, length) or (name in _HELD and length == 0):
            raise OutputError(f"{_file(data)} is damaged: its dimension {name} is {length} long")
    for name in _ATTRIBUTES:
        if not isinstance(data.attrs.get(name, ""), str):
            raise OutputError(f"{_file(data)} is damaged: its attribute {name} is no text")
    try:
        input_values(data.attrs)
    except OutputError:
        raise OutputError(f"{_file(data)} is damaged: its attribute input_values") from None


def _check_numbers(data: xr.Dataset, name) -> None:
    """A history of one number a sample."""
    if data[name].dims != ("time",) or not np.issubdtype(data[name].dtype, np.number):
        raise damaged(data, name, f"its values are of type {data[name].dtype}")


def _check_order(data: xr.Dataset) -> None:
    """Vertices block by block, frames and contacts as time goes; stages that have names."""
    owner = read(data, "vertex_block")
    corners = np.bincount(owner, minlength=data.sizes["block"])
    if owner[0] or not np.isin(np.diff(owner), (0, 1)).all() or corners.min() < 3:
        raise damaged(data, "vertex_block", "its blocks are not in their order")
    for name in ("time", "frame_time", "contact_frame"):
        if np.any(np.diff(read(data, name)) < 0):
            raise damaged(data, name, "its values do not ascend")
    time, frames = read(data, "time"), read(data, "frame_time")
    if time[-1] == time[0] and frames[-1] > frames[0]:
        raise damaged(data, "time", "it does not go on, and the frames do")
    stages = str(data.attrs.get("stages", "")).count("\n") + 1
    for name in ("stage", "frame_stage"):
        if name in data.variables and (read(data, name) > stages).any():
            raise damaged(data, name, f"there are {stages} stages")
    groups = input_values(data.attrs)
    for name, group in (("block_material", "material"), ("edge_joint", "joint")):
        given = len(groups.get(group, []))
        if given and name in data.variables and (read(data, name) >= given).any():
            raise damaged(data, name, f"there are {given} groups &{group}")


def damaged(data: xr.Dataset, name: str, why: str) -> OutputError:
    """The error of a variable that is not what a run writes."""
    return OutputError(
        f"{_file(data)} is damaged, or not an output of a run: variable {name}: {why}"
    )


def _file(data: xr.Dataset) -> str:
    return data.encoding.get("source", "the dataset")
