# SPDX-License-Identifier: GPL-3.0-or-later
"""A small substitute for `xarray.Dataset`: variables with names and dimensions.

It suffices for the verdict and the picture of a run.  Importing xarray and pandas, and indexing
the times, would take half the time of the steps of a run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property, partial
from types import EllipsisType

import numpy as np


class NamedArray:
    """Array with named dimensions, see `xarray.DataArray`; it is read on first use."""

    def __init__(
        self,
        dims: tuple[str, ...],
        read: Callable[[], np.ndarray],
        labels: Mapping[str, list[str]],
    ):
        self.dims, self._read, self._labels = dims, read, labels

    @cached_property
    def values(self) -> np.ndarray:
        """Return the values."""
        return np.asarray(self._read())

    def __getitem__(self, which: int | slice | EllipsisType) -> NamedArray:
        found = self.values[which]
        dims = self.dims[self.values.ndim - np.ndim(found) :]
        return NamedArray(dims, lambda: found, self._labels)

    def isel(self, **places: int) -> NamedArray:
        """Select values by the index along each given dimension that exists."""
        where = tuple(places.get(name, slice(None)) for name in self.dims)
        rest = tuple(name for name in self.dims if name not in places)
        return NamedArray(rest, lambda: self.values[where], self._labels)

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

    def __init__(
        self,
        variables: Mapping[str, NamedArray],
        sizes: Mapping[str, int],
        labels: Mapping[str, list[str]],
        attrs: Mapping,
    ):
        self.variables, self.sizes, self._labels, self.attrs = variables, sizes, labels, attrs

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

    def isel(self, **places: int) -> NamedArrays:
        """Select all variables by the index along each given dimension."""
        found = {name: one.isel(**places) for name, one in self.variables.items()}
        sizes = {name: size for name, size in self.sizes.items() if name not in places}
        return NamedArrays(found, sizes, self._labels, self.attrs)

    def sel(self, **labels: str) -> NamedArrays:
        """Select all variables by the label along each given dimension."""
        return self.isel(**_find_labels(self._labels, labels))


def _find_labels(labels: Mapping[str, list[str]], asked: Mapping[str, str]) -> dict[str, int]:
    """Return the indices of the requested labels; raise KeyError if one is missing."""
    for name, label in asked.items():
        if label not in labels[name]:
            raise KeyError(label)
    return {name: labels[name].index(label) for name, label in asked.items()}


def read_netcdf(file) -> NamedArrays:
    """Open a netCDF file; variables are read on first use, characters are converted to texts."""
    import netCDF4

    data = netCDF4.Dataset(file)
    data.set_auto_maskandscale(False)
    data.set_auto_chartostring(False)
    labels: dict[str, list[str]] = {}
    found = {}
    for name, one in data.variables.items():
        text = one.dtype == "S1" and one.ndim > 0
        dims = one.dimensions[:-1] if text else one.dimensions
        found[name] = NamedArray(dims, partial(_read_variable, one, text), labels)
        if text and dims == (name,):
            labels[name] = found[name].values.tolist()
    sizes = {name: len(one) for name, one in data.dimensions.items()}
    return NamedArrays(found, sizes, labels, {n: data.getncattr(n) for n in data.ncattrs()})


def _read_variable(variable, text: bool) -> np.ndarray:
    """Return the values of a variable of a netCDF file; the last dimension of a text is letters."""
    import netCDF4

    values = variable[...]
    return netCDF4.chartostring(values, encoding="utf-8") if text else values
