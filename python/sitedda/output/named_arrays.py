# SPDX-License-Identifier: GPL-3.0-or-later
"""A small substitute for `xarray.Dataset`: variables with names and dimensions.

It suffices for the verdict and the picture of a run.  Importing xarray and pandas, and indexing
the times, would take half the time of the steps of a run.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import EllipsisType
from typing import Any

import numpy as np


class NamedArray:
    """Array with named dimensions, see `xarray.DataArray`."""

    def __init__(self, dims: tuple[str, ...], values, labels: Mapping[str, list[str]]):
        self.dims = dims
        self.values = np.asarray(values)
        self._labels = labels

    @property
    def dtype(self) -> np.dtype:
        """Return the type of the values."""
        return self.values.dtype

    @property
    def nbytes(self) -> int:
        """Return the number of bytes of the values."""
        return self.values.nbytes

    def __getitem__(self, index: int | slice | EllipsisType) -> NamedArray:
        values = self.values[index]
        return NamedArray(self.dims[self.values.ndim - np.ndim(values) :], values, self._labels)

    def isel(self, **indices: int) -> NamedArray:
        """Select values by the index along each given dimension that exists."""
        key = tuple(indices.get(name, slice(None)) for name in self.dims)
        dims = tuple(name for name in self.dims if name not in indices)
        return NamedArray(dims, self.values[key], self._labels)

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
    """Variables with attributes in memory, see `xarray.Dataset`."""

    def __init__(self, variables: Mapping[str, tuple[tuple[str, ...], Any]], attrs, source: str):
        self._labels = {name: values.tolist() for name, (dims, values) in variables.items()
                        if dims == (name,) and values.dtype.kind == "U"}  # fmt: skip
        self.variables = {n: NamedArray(*pair, self._labels) for n, pair in variables.items()}
        self.attrs = attrs
        self.encoding = {"source": source}

    @property
    def sizes(self) -> dict[str, int]:
        """Return the length of each dimension."""
        return {name: length for array in self.variables.values()
                for name, length in zip(array.dims, array.values.shape, strict=True)}  # fmt: skip

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
        pairs = {name: (array.dims, array.values) for name, array in arrays.items()}
        return NamedArrays(pairs, self.attrs, self.encoding["source"])

    def sel(self, **labels: str) -> NamedArrays:
        """Select all variables by the label along each given dimension."""
        return self.isel(**_find_labels(self._labels, labels))


def _find_labels(labels: Mapping[str, list[str]], requested: Mapping[str, str]) -> dict[str, int]:
    """Return the indices of the requested labels; raise KeyError if one is missing."""
    for name, label in requested.items():
        if label not in labels[name]:
            raise KeyError(label)
    return {name: labels[name].index(label) for name, label in requested.items()}


def read_netcdf(file) -> NamedArrays:
    """Read a whole netCDF file; arrays of characters are converted to texts."""
    import netCDF4

    with netCDF4.Dataset(file) as data:
        data.set_auto_maskandscale(False)
        data.set_auto_chartostring(False)
        variables = {}
        for name, variable in data.variables.items():
            dims, values = variable.dimensions, variable[...]
            if variable.dtype == "S1" and dims:
                dims, values = dims[:-1], netCDF4.chartostring(values, encoding="utf-8")
            variables[name] = dims, np.asarray(values)
        return NamedArrays(variables, {n: data.getncattr(n) for n in data.ncattrs()}, str(file))
