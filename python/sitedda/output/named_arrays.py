# SPDX-License-Identifier: GPL-3.0-or-later
"""A small substitute for `xarray.Dataset`: variables with names and dimensions.

It suffices for the verdict and the picture of a run.  Importing xarray and pandas, and indexing
the times, would take half the time of the steps of a run.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from functools import cached_property
from types import EllipsisType
from typing import Any

import numpy as np


class NamedArray:
    """Array with named dimensions, see `xarray.DataArray`.

    `source` is an array, or a variable of a file, which is read on first use within `guard()`.
    """

    def __init__(
        self, dims: tuple[str, ...], source: Any, labels: Mapping[str, list[str]], guard=nullcontext
    ):
        self.dims = dims
        self.dtype, self.shape = source.dtype, source.shape
        self._source, self._labels, self._guard = source, labels, guard

    @property
    def nbytes(self) -> int:
        """Return the number of bytes of the values."""
        return math.prod(self.shape) * self.dtype.itemsize

    @cached_property
    def values(self) -> np.ndarray:
        """Return the values."""
        with self._guard():
            return np.asarray(self._source[...])

    def __getitem__(self, index: int | slice | EllipsisType) -> NamedArray:
        values = np.asarray(self.values[index])
        return NamedArray(self.dims[self.values.ndim - np.ndim(values) :], values, self._labels)

    def isel(self, **indices: int) -> NamedArray:
        """Select values by the index along each given dimension that exists."""
        if not indices.keys() & set(self.dims):
            return self
        key = tuple(indices.get(name, slice(None)) for name in self.dims)
        dims = tuple(name for name in self.dims if name not in indices)
        return NamedArray(dims, np.asarray(self.values[key]), self._labels)

    def sel(self, **labels: str) -> NamedArray:
        """Select values by the label along each given dimension."""
        return self.isel(**_find_labels(self._labels, labels))

    def __array__(self, dtype=None, copy=None) -> np.ndarray:
        return np.array(self.values, dtype, copy=copy)

    def __float__(self) -> float:
        return float(self.values)

    def __int__(self) -> int:
        return int(self.values)


class NamedArrays:
    """Variables with attributes, see `xarray.Dataset`."""

    def __init__(self, variables: Mapping[str, NamedArray], labels, attrs, source: str):
        self.variables = variables
        self._labels = labels
        self.attrs = attrs
        self.encoding = {"source": source}

    @property
    def sizes(self) -> dict[str, int]:
        """Return the length of each dimension."""
        return {name: length for array in self.variables.values()
                for name, length in zip(array.dims, array.shape, strict=True)}  # fmt: skip

    @property
    def coords(self) -> list[str]:
        """Return the dimensions that have labels."""
        return list(self._labels)

    def __contains__(self, name: str) -> bool:
        return name in self.variables

    def __getitem__(self, name: str) -> NamedArray:
        return self.variables[name]

    def __getattr__(self, name: str) -> NamedArray:
        if name in self.__dict__.get("variables", ()):
            return self.variables[name]
        raise AttributeError(name)

    def isel(self, **indices: int) -> NamedArrays:
        """Select all variables by the index along each given dimension."""
        arrays = {name: array.isel(**indices) for name, array in self.variables.items()}
        labels = {name: values for name, values in self._labels.items() if name not in indices}
        return NamedArrays(arrays, labels, self.attrs, self.encoding["source"])

    def sel(self, **labels: str) -> NamedArrays:
        """Select all variables by the label along each given dimension."""
        return self.isel(**_find_labels(self._labels, labels))


def _find_labels(labels: Mapping[str, list[str]], requested: Mapping[str, str]) -> dict[str, int]:
    """Return the indices of the requested labels; raise KeyError if one is missing."""
    for name, label in requested.items():
        if label not in labels[name]:
            raise KeyError(label)
    return {name: labels[name].index(label) for name, label in requested.items()}


def read_netcdf(file, guard: Callable[[], AbstractContextManager] = nullcontext) -> NamedArrays:
    """Open a netCDF file; variables are read on first use, arrays of characters become texts.

    Reading is done within `guard()`.  The file is closed when the variables are garbage.
    """
    import netCDF4

    data = netCDF4.Dataset(file)
    data.set_auto_maskandscale(False)
    data.set_auto_chartostring(False)
    variables: dict[str, NamedArray] = {}
    labels: dict[str, list[str]] = {}
    for name, variable in data.variables.items():
        dims, source = variable.dimensions, variable
        if variable.dtype == "S1" and dims:
            dims, source = dims[:-1], netCDF4.chartostring(variable[...], encoding="utf-8")
            if dims == (name,):
                labels[name] = source.tolist()
        variables[name] = NamedArray(dims, source, labels, guard)
    return NamedArrays(variables, labels, {n: data.getncattr(n) for n in data.ncattrs()}, str(file))
