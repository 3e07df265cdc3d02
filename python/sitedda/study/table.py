# SPDX-License-Identifier: GPL-3.0-or-later
"""Collect the results of all cases of a study in one dataset."""

from __future__ import annotations

import json
import shutil
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ..base.errors import OutputError, library_required
from ..base.files import check_target, written
from .store import case_folder, read_arrays, read_manifest, read_result, refuse_links

BAR, DECIDED = "_bar", "_decided_s"  # suffixes of a result: error bar, end of its predictability
IN_MEMORY = 200e6  # size of the arrays (bytes) above which a table is always written to a file
_TEXTS = ("status", "message", "warning")


def collect(study, file=None, arrays: bool = True):
    """Return the table of a study with all existing results.

    Parameters
    ----------
    study : path
        Folder of the study.
    file : path, optional
        File of the table: zarr if the name ends with .zarr, otherwise netCDF.  Cases are written
        one by one, as chunks.
    arrays : bool
        Whether to include histories and other arrays.

    Returns
    -------
    xarray.Dataset
        Results over the dimensions of the parameters.  ``status`` is 'complete', 'failed' or
        'missing'; ``message`` is the error of a failed case; ``warning`` contains the warnings of
        the run; ``case`` is the key of the case.
    """
    import xarray as xr

    study = Path(study).absolute()
    manifest = read_manifest(study)
    results = _Results(study, manifest, arrays)
    if file is None and results.size > IN_MEMORY:
        file = study / "table.nc"
    if file is None:
        return results.dataset(arrays=True)
    file = Path(file).absolute()
    if file.suffix == ".zarr":
        _replace_zarr(results, file)
        return xr.open_zarr(file)
    with written(file, "a netCDF file") as temporary:
        _write_netcdf(results, temporary)
    return xr.open_dataset(file, cache=False)


def check_table(file) -> Path:
    """Return the path of a table; raise OutputError if it exists and is not a table."""
    file = Path(file)
    if file.suffix == ".zarr" and file.is_dir() and not file.is_symlink():
        if not (file / ".zgroup").is_file():
            raise OutputError(f"{file} is a folder that contains no table and is not replaced; "
                              "move it away, or choose another name")  # fmt: skip
        return file
    return check_target(file, "a netCDF file")


def _replace_zarr(results: _Results, file: Path) -> None:
    """Write a table in zarr to a temporary folder, which then replaces the folder `file`."""
    check_table(file)
    try:
        scratch = Path(tempfile.mkdtemp(prefix=".new-", dir=file.parent))
        try:
            _write_zarr_folder(results, scratch / file.name)
            check_table(file)
            if file.exists():
                file.replace(scratch / "old")
            (scratch / file.name).replace(file)
        finally:
            shutil.rmtree(scratch, ignore_errors=True)
    except OutputError:
        raise
    except OSError as error:
        reason = error.strerror or error
        raise OutputError(f"{file} cannot be written: {reason}") from error


class _Results:
    """The results of all cases; numbers and texts are in memory, arrays are read from files."""

    def __init__(self, study: Path, manifest: dict, arrays: bool = True):
        self.study, self.manifest = study, manifest
        self.dims = {str(name): int(size) for name, size in manifest["dims"].items()}
        self.shape = tuple(self.dims.values())
        keys = manifest["cases"]
        if len(keys) != int(np.prod(self.shape, dtype=int)):
            raise OutputError(f"{study}: the manifest lists {len(keys)} cases for {self.dims}")
        refuse_links(study, study / "cases")
        self.keys = np.array(keys, dtype=object)
        self.texts = {name: np.full(len(keys), "", dtype=object) for name in _TEXTS}
        self.numbers: dict[str, np.ndarray] = {}
        self.seconds = np.full(len(keys), np.nan)
        self.arrays: dict[str, dict] = {}
        self.with_arrays: list[int] = []
        for number, key in enumerate(keys):
            self._read_case(number, key)
        if not arrays:
            self.arrays, self.with_arrays = {}, []
        self.coordinates = self._common_coordinates()

    def _read_case(self, number: int, key: str) -> None:
        """Read texts, numbers and shapes of arrays of a case."""
        folder = refuse_links(self.study, case_folder(self.study, key))
        result = read_result(folder)
        self.texts["status"][number] = result["status"] if result else "missing"
        if not result:
            return
        self.texts["message"][number] = str(result.get("message", ""))
        self.texts["warning"][number] = str(result.get("warning", ""))
        self.seconds[number] = result.get("seconds", np.nan)
        for name, value in result.get("numbers", {}).items():
            if name not in self.numbers:
                self.numbers[name] = np.full(len(self.keys), np.nan)
            self.numbers[name][number] = value
        for name, shape in result.get("shapes", {}).items():
            reference = self.arrays.setdefault(name, {**shape, "shape": list(shape["shape"])})
            if reference["dims"] != shape["dims"]:
                raise OutputError(f"{name} has dimensions {reference['dims']} in one case and "
                                  f"{shape['dims']} in case {number}")  # fmt: skip
            reference["shape"] = list(map(max, reference["shape"], shape["shape"]))
        if result.get("shapes"):
            self.with_arrays.append(number)

    @property
    def size(self) -> float:
        """Return the size of the arrays of all cases, bytes."""
        size_of_case = sum(np.prod(shape["shape"]) for shape in self.arrays.values())
        return 8.0 * float(size_of_case) * len(self.keys)

    def each_array(self) -> Iterator[tuple[int, dict[str, np.ndarray]]]:
        """Yield number and arrays of every case that has arrays."""
        for number in self.with_arrays:
            folder = case_folder(self.study, self.keys[number])
            arrays = read_arrays(folder)
            for name in self.arrays.keys() & arrays.keys():
                if not self._is_numeric_array(name, arrays):
                    raise OutputError(f"{folder / 'result.npy'} is damaged: {name}")
            yield number, arrays

    def _is_numeric_array(self, name: str, arrays: dict[str, np.ndarray]) -> bool:
        """Return whether an array of a case and its coordinates are numbers of equal shapes."""
        dims = [arrays.get(f"{name}|{dim}") for dim in self.arrays[name]["dims"]]
        if any(array is None or array.ndim != 1 or array.size == 0 for array in dims):
            return False
        if arrays[name].shape != tuple(map(len, dims)):
            return False
        return all(array.dtype.kind in "biuf" for array in (arrays[name], *dims))

    def _common_coordinates(self) -> dict[str, np.ndarray]:
        """Return the coordinate of each dimension of the arrays, such as time.

        If the coordinates of cases differ (adaptive steps), the dimension is added to `uneven`, and
        the coordinate has equal steps: the largest mean step, from the first start to the last end.
        """
        names = {d: n for n, shape in self.arrays.items() for d in shape["dims"]}
        coordinates: dict[str, np.ndarray] = {}
        ranges: dict[str, list] = {}
        self.uneven: set[str] = set()
        for _, arrays in self.each_array() if names else ():
            for dim, name in names.items():
                values = arrays.get(f"{name}|{dim}")
                if values is None:
                    continue
                reference = coordinates.setdefault(dim, values)
                overlap = min(len(reference), len(values))
                if not np.array_equal(values[:overlap], reference[:overlap]):
                    self.uneven.add(dim)
                if len(values) > len(reference):  # the case of `reference` ended earlier
                    coordinates[dim] = values
                step = (values[-1] - values[0]) / max(len(values) - 1, 1)
                ranges.setdefault(dim, []).append((values[0], values[-1], step))
        for dim in self.uneven:
            low, high, step = np.array(ranges[dim], dtype=float).T
            count = round((high.max() - low.min()) / (step.max() or 1.0)) + 1
            coordinates[dim] = np.linspace(low.min(), high.max(), count)
        return coordinates

    def layout(self, name: str) -> tuple[tuple[str, ...], tuple[int, ...], tuple[int, ...]]:
        """Return dimensions, shape and chunks of an array over all cases; each case is a chunk."""
        dims_of_result = tuple(self.arrays[name]["dims"])
        sizes = tuple(len(self.coordinates[d]) for d in dims_of_result)
        return ((*self.dims, *dims_of_result), (*self.shape, *sizes),
                (*(1 for _ in self.dims), *sizes))  # fmt: skip

    def at_common_coordinates(self, name: str, arrays: dict[str, np.ndarray]) -> np.ndarray:
        """Return an array of a case at the common coordinates; NaN outside of its own range."""
        values = arrays[name]
        for axis, dim in enumerate(self.arrays[name]["dims"]):
            target, own_values = self.coordinates[dim], arrays[f"{name}|{dim}"]
            if dim in self.uneven:

                def interpolated(v, x=own_values, points=target):
                    return np.interp(points, x, v, left=np.nan, right=np.nan)

                values = np.apply_along_axis(interpolated, axis, values)
            elif len(own_values) < len(target):
                padding = [(0, 0)] * values.ndim
                padding[axis] = (0, len(target) - len(own_values))
                values = np.pad(values, padding, constant_values=np.nan)
        return values

    def fill(self, targets: dict) -> None:
        """Write the arrays of all cases into the arrays of the table."""
        for number, arrays in self.each_array():
            index = np.unravel_index(number, self.shape)
            for name, target in targets.items():
                if name in arrays:
                    target[tuple(int(i) for i in index)] = self.at_common_coordinates(name, arrays)

    def case_variables(self) -> dict[str, tuple]:
        """Return the variables with one value per case: numbers, texts, key and seconds."""
        dims = tuple(self.dims)
        variables = {n: (dims, v.reshape(self.shape), {}) for n, v in self.numbers.items()}
        variables |= {n: (dims, v.reshape(self.shape), {}) for n, v in self.texts.items()}
        variables["case"] = (dims, self.keys.reshape(self.shape), {"long_name": "key of the case"})
        variables["seconds"] = (dims, self.seconds.reshape(self.shape),
                            {"units": "s", "long_name": "wall-clock time"})  # fmt: skip
        return variables

    def coordinate_variables(self) -> dict[str, tuple]:
        """Return the coordinates of parameters and of arrays."""
        variables = {
            name: (tuple(item["dims"]), coordinate_values(item["values"]), item.get("attrs", {}))
            for name, item in self.manifest["coordinates"].items()
        }
        units = {"time": "s", "frame": "s", "period": "s", "frequency": "Hz"}
        for dim, values in self.coordinates.items():
            attrs = {"units": units[dim]} if dim in units else {}
            if dim in self.uneven:
                attrs["comment"] = "histories of all cases are interpolated to equal steps"
            variables[dim] = ((dim,), values, attrs)
        return variables

    def dataset(self, arrays: bool):
        """Return the table in memory, with or without arrays."""
        import xarray as xr

        variables = self.case_variables()
        if arrays:
            targets = {name: np.full(self.layout(name)[1], np.nan) for name in self.arrays}
            self.fill(targets)
            for name, values in targets.items():
                units = {"units": self.arrays[name]["units"]}
                variables[name] = (self.layout(name)[0], values, units)
        names = ("model", "task", "program", "build")
        attributes = {name: str(self.manifest.get(name, "")) for name in names}
        attributes["fixed"] = json.dumps(self.manifest.get("fixed", {}))
        return xr.Dataset(variables, self.coordinate_variables(), attributes)


def coordinate_values(values: list) -> np.ndarray:
    """Return the values of a coordinate as an array; texts have the type object."""
    array = np.asarray(values)
    return array.astype(object) if array.dtype.kind in "US" else array


def _write_netcdf(results: _Results, file: Path) -> None:
    """Write a table in netCDF, case by case."""
    import netCDF4

    results.dataset(arrays=False).to_netcdf(file, engine="netcdf4")
    with netCDF4.Dataset(file, "a") as data:
        targets = {}
        for name in results.arrays:
            dims, shape, chunks = results.layout(name)
            targets[name] = data.createVariable(
                name, "f8", dims, chunksizes=chunks, zlib=True, complevel=1, shuffle=True,
                fill_value=np.nan,
            )  # fmt: skip
            targets[name].units = results.arrays[name]["units"]
        results.fill(targets)


def _write_zarr_folder(results: _Results, file: Path) -> None:
    """Write a table in zarr, case by case."""
    with library_required("a .zarr table requires zarr: pip install zarr"):
        import zarr
    frame = results.dataset(arrays=False)
    for name in frame.variables:
        if frame[name].dtype == object:
            frame[name] = frame[name].astype(str)
    frame.to_zarr(file, mode="w", consolidated=False, zarr_format=2)
    group = zarr.open_group(file, mode="a")
    targets = {}
    for name in results.arrays:
        dims, shape, chunks = results.layout(name)
        targets[name] = group.create_array(
            name, shape=shape, chunks=chunks, dtype="f8", fill_value=np.nan,
            attributes={"_ARRAY_DIMENSIONS": list(dims), "units": results.arrays[name]["units"]},
        )  # fmt: skip
    results.fill(targets)
    zarr.consolidate_metadata(file)


def counts(table) -> Counter:
    """Return the numbers of complete, failed and missing cases."""
    return Counter(np.asarray(table["status"].values).ravel().tolist())
