# SPDX-License-Identifier: GPL-3.0-or-later
"""Read the output of a run as a dataset and check it.

A file may be truncated, altered or from another program.  Its variables must have the dimensions,
types and ranges that a run writes; otherwise one error names the file and the variable.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..base.core import FILES
from ..base.errors import OutputError, lacks_memory
from ..base.reading import check_readable
from ..input.input_text import input_values
from .named_arrays import NamedArrays, read_netcdf
from .variables import FAMILIES, LENGTHS, VARIABLES

if TYPE_CHECKING:
    import xarray as xr

_LARGEST = 1e37  # largest number: larger ones overflow in single precision or when squared
_ROUNDING = 1e-9  # tolerance of fractions of edge lengths
_READ_AT_ONCE = 2**24  # bytes; larger variables are checked when they are read
_NOT_EMPTY = ("time", "frame", "vertex", "block")  # dimensions that must not be empty
_ATTRIBUTES = ("title", "input_text", "input_values", "input_file", "stages", "step_control",
               "verdict", "accuracy", "complete")  # fmt: skip


def open_output(file) -> xr.Dataset:
    """Open an output file as a dataset; its frames are read on access.

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
    with _errors_as_damage(_unreadable_error(file)):
        data = xr.open_dataset(file, engine="netcdf4", cache=False, decode_times=False)
    try:
        _check_run(data)
    except OutputError:
        data.close()
        raise
    return data


def read_output(file, written: bool = False) -> NamedArrays:
    """Open an output for verdict and pictures; variables are read on first use.

    `written`: this process has written the file, so only its structure is checked.  Errors are as
    in `open_output`.
    """
    check_readable(file)
    guard = partial(_errors_as_damage, _unreadable_error(file))
    with guard():
        data = read_netcdf(file, guard)
    (_check_structure if written else _check_run)(data)
    return data


def _unreadable_error(file) -> Callable[[str], OutputError]:
    """Return a function that makes the error for an unreadable file from a reason."""
    return lambda reason: OutputError(f"{file} cannot be read as an output: {reason}")


def _check_run(data) -> None:
    """Check that structure, numbers and their order are those of a run."""
    _check_structure(data)
    for name in VARIABLES:
        if name in data.variables and data[name].nbytes <= _READ_AT_ONCE:
            read(data, name)
    _check_order(data)


def read(data: xr.Dataset, name: str, rows=...) -> np.ndarray:
    """Read and check the values of a variable, or of some of its rows.

    Raises
    ------
    OutputError
        If the values are missing, of the wrong kind, or out of range.
    """
    with _errors_as_damage(lambda reason: damaged(data, name, reason)):
        values = data[name][rows].values
    entry = VARIABLES.get(name)
    if entry is None or entry.kind == "text" or values.size == 0:
        return values
    if not np.issubdtype(values.dtype, np.number):
        raise damaged(data, name, "it does not contain numbers")
    kind = entry.kind.removesuffix(" or none")
    if kind == "real":
        valid = np.abs(values) <= _LARGEST
        if kind != entry.kind:
            valid |= np.isnan(values)
    elif kind == "fraction":
        valid = np.abs(values - 0.5) <= 0.5 + _ROUNDING
    else:
        limit = data.sizes.get(kind, np.iinfo(np.int32).max)
        valid = (values >= (0 if kind == entry.kind else -1)) & (values < limit)
    if not valid.all():
        index = np.unravel_index(int(np.argmin(valid)), valid.shape)
        raise damaged(data, name, f"the value {values[index]:g} is out of range")
    return values


def load(file) -> xr.Dataset:
    """Read a whole output into memory."""
    with open_output(file) as data, _errors_as_damage(_unreadable_error(file)):
        return data.load()


@contextmanager
def _errors_as_damage(make_error: Callable[[str], OutputError]) -> Iterator[None]:
    """Raise the given OutputError for any exception except one caused by lack of memory."""
    try:
        with FILES:
            yield
    except Exception as error:
        if lacks_memory(error):
            raise
        lines = str(error).strip().splitlines() or [type(error).__name__]
        raise make_error(lines[0]) from error


def _check_structure(data: xr.Dataset) -> None:
    """Check that required variables exist, and the dimensions and types of all variables."""
    families = {entry.family for name, entry in VARIABLES.items() if name in data.variables}
    for name, entry in VARIABLES.items():
        if name not in data.variables:
            if entry.needed and (entry.family in families or FAMILIES[entry.family]):
                raise damaged(data, name, "it is missing")
            continue
        variable = data[name]
        if variable.dims != entry.dimensions:
            raise damaged(data, name, f"its dimensions are {', '.join(variable.dims) or 'none'}")
        if (entry.kind != "text") != np.issubdtype(variable.dtype, np.number):
            raise damaged(data, name, f"its values are of type {variable.dtype}")
    for name, length in data.sizes.items():
        if length != LENGTHS.get(name, length) or (name in _NOT_EMPTY and length == 0):
            raise OutputError(
                f"{_file_name(data)} is damaged: its dimension {name} has length {length}"
            )
    if "input_values" not in data.attrs:
        raise OutputError(f"{_file_name(data)} is of an earlier version, without the attribute "
                          "input_values: run its input again")  # fmt: skip
    for name in _ATTRIBUTES:
        if not isinstance(data.attrs.get(name, ""), str):
            raise OutputError(f"{_file_name(data)} is damaged: its attribute {name} is not text")
    try:
        input_values(data.attrs)
    except OutputError:
        fault = "is damaged: its attribute input_values is invalid"
        raise OutputError(f"{_file_name(data)} {fault}") from None


def _check_order(data: xr.Dataset) -> None:
    """Check the order of vertices, frames and contacts, and the names of stages."""
    owner = read(data, "vertex_block")
    corners = np.bincount(owner, minlength=data.sizes["block"])
    if owner[0] or not np.isin(np.diff(owner), (0, 1)).all() or corners.min() < 3:
        raise damaged(data, "vertex_block", "its blocks are not consecutive polygons")
    for name in ("time", "frame_time", "contact_frame"):
        if np.any(np.diff(read(data, name)) < 0):
            raise damaged(data, name, "its values decrease")
    time, frames = read(data, "time"), read(data, "frame_time")
    if time[-1] == time[0] and frames[-1] > frames[0]:
        raise damaged(data, "time", "its values do not increase")
    stages = str(data.attrs.get("stages", "")).count("\n") + 1
    for name in ("stage", "frame_stage"):
        if name in data.variables and (read(data, name) > stages).any():
            raise damaged(data, name, f"a value exceeds {stages}, the number of stages")
    groups = input_values(data.attrs)
    for name, group in (("block_material", "material"), ("edge_joint", "joint")):
        count = len(groups.get(group, []))
        if count and name in data.variables and (read(data, name) >= count).any():
            raise damaged(data, name, f"a value exceeds {count}, the number of groups &{group}")


def damaged(data: xr.Dataset, name: str, reason: str) -> OutputError:
    """Return the error for an invalid variable."""
    return OutputError(
        f"{_file_name(data)} is damaged, or not an output of a run: variable {name}: {reason}"
    )


def _file_name(data: xr.Dataset) -> str:
    """Return the file name of a dataset, for messages."""
    return data.encoding.get("source", "the dataset")
