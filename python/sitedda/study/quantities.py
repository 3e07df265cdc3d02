# SPDX-License-Identifier: GPL-3.0-or-later
"""Extract the results of a case from its output, as numbers and arrays."""

import re
import tempfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..base.core import FILES, engine_names
from ..base.errors import InputError, OutputError, SiteddaError
from ..base.reading import check_readable
from ..input.groups import nearest
from ..input.input_text import input_values
from ..output.variables import VARIABLES
from .arrays import Array
from .histories import histories
from .store import function_name

DEFAULT = ("verdict",)
REDUCTIONS: dict[str, Callable] = {
    "largest": lambda v: v[np.argmax(abs(v))],
    "max": np.max,
    "min": np.min,
    "range": np.ptp,
    "last": lambda v: v[-1],
}
_PATH = re.compile(r"(\w+)(?:\[([^\]]*)\])?(?:\.(\w+))?(?:\.(\w+))?")
_LABELS = {
    "axis": ("x", "y"),
    "component": ("xx", "yy", "xy"),
    "coordinate": ("x", "y", "rotation", "strain_x", "strain_y", "shear_strain"),
}
_ATTRIBUTES = "attributes"  # key of the results that the engine writes as attributes of the output
_MAXIMA = engine_names("maxima numbers")
_LARGEST = tuple(f"largest_{name}" for name in _MAXIMA)
_OF_JOINTS = [one for one in VARIABLES.values()
              if one.family == "measured_joints" and "time" in one.dimensions
              and not one.name.endswith(("_force_x", "_force_y"))]  # fmt: skip
_JOINTS = (*(one.number for one in _OF_JOINTS),
           *(f"largest_{one.number}" for one in _OF_JOINTS if one.unit == "m"))  # fmt: skip
_OF_POINTS = ("pgv_m_s", "pga_resolved_m_s2", "arias_resolved_m_s", "sa_resolved_m_s2")
_TOPICS = {
    _ATTRIBUTES: (*_LARGEST, *(f"residual_{name}" for name in _MAXIMA), "contacts_slipped",
               "contacts_opened", "bonds_broken", "energy_balance_j_m", "end_s", "pga_m_s2",
               "arias_m_s", "sa_m_s2", "sa_period_s", "pga_below_50_hz_m_s2",
               "resolved_frequency_hz", *_JOINTS, *_OF_POINTS,
               *(f"{name}_{axis}" for name in _OF_POINTS for axis in "xy")),
    "add_drift": ("residual_drift",),
    "add_fallen": ("blocks_fallen", "first_block_fallen_s"),
    "add_lost": ("blocks_lost", "first_block_lost_s"),
    "add_damping": ("amplification", "amplification_frequency_hz"),
}  # fmt: skip
NAMES = {name for names in _TOPICS.values() for name in names}
_AT_POINTS = {name for name in _TOPICS[_ATTRIBUTES]
              if name.startswith(("pga_", "pgv_", "arias_", "sa_", "resolved_"))}  # fmt: skip
_OF_PYTHON = ("residual_drift", "amplification")  # results that the engine does not write
_BLOCKS = ("frame_time", "vertex_block", "vertices", "block_coordinates", "frame_base")
_HISTORY = ("time", "acceleration", "velocity", "point_place", "time_step", "energy_balance")
_VARIABLES_OF = {"add_damping": _HISTORY}
_WRITTEN_AS = {"absolute_displacement": "displacement"}
_COMMON = ("verdict", "figures", "histories")  # quantities that all outputs contain
_NO_AMPLIFICATION = "amplification_ratio requires a group &amplification in the input"
_LARGE = 5e7  # size of the block coordinates (bytes) above which only required frames are read
_ZERO = ("contacts_slipped", "contacts_opened", "bonds_broken", "blocks_fallen", "blocks_lost")


@dataclass(frozen=True)
class Quantity:
    """A result that is extracted from each case."""

    label: str  # name in the table
    name: str  # name as in `measure`, or name of a function with the checksum of its source
    function: Callable | None = None  # function of a `sitedda.Run`


def quantities_of(results) -> list[Quantity]:
    """Convert the ``results`` of `study` to quantities.

    `results`: names as in `measure`, or functions of a Run; the keys of a mapping are names in the
    table.
    """
    if isinstance(results, str) or callable(results):
        results = [results]
    if isinstance(results, Mapping):
        pairs: Iterable = results.items()
    else:
        pairs = ((None, item) for item in results)
    return [_parse_quantity(label, item) for label, item in pairs]


def _parse_quantity(label: str | None, item) -> Quantity:
    """Convert a name or function to a quantity; raise InputError if the name is invalid."""
    if callable(item):
        return Quantity(label or item.__name__, function_name(item), item)
    if not isinstance(item, str) or not (match := _PATH.fullmatch(item)):
        raise InputError(f"{item!r} is not a quantity, such as largest_tilt_rad or "
                         "displacement[top].x.max")  # fmt: skip
    if match[4] and match[4] not in REDUCTIONS:
        raise InputError(f"{item}: there is no {match[4]!r}; use {', '.join(REDUCTIONS)}")
    return Quantity(label or item, item)


class Output:
    """An output of a run, whose variables are read on first access."""

    def __init__(self, file: Path):
        import netCDF4

        check_readable(file)
        self.file = file
        self._values: dict[str, np.ndarray] = {}
        with FILES:
            try:
                self._data = netCDF4.Dataset(file)
            except OSError as error:
                raise OutputError(f"{file} cannot be read as an output: {error}") from error
            self._data.set_auto_maskandscale(False)
            self._data.set_auto_chartostring(False)
            self.attributes = {name: self._data.getncattr(name) for name in self._data.ncattrs()}

    def __enter__(self) -> "Output":
        return self

    def __exit__(self, *_) -> None:
        with FILES:
            self._data.close()

    def has(self, name: str) -> bool:
        """Return whether a variable exists."""
        return name in self._data.variables

    def dims(self, name: str) -> tuple[str, ...]:
        """Return the dimensions of a variable."""
        if name not in self._data.variables:
            names = NAMES | set(self._data.variables)
            raise InputError(f"an output has no quantity {name!r}{nearest(name, names)}")
        return self._data[name].dimensions

    def units(self, name: str) -> str:
        """Return the unit of a variable."""
        with FILES:
            return str(getattr(self._data[name], "units", ""))

    def __getitem__(self, name: str) -> np.ndarray:
        """Return the values of a variable."""
        if name not in self._values:
            with FILES:
                self._values[name] = np.asarray(self._data[name][...])
        return self._values[name]

    def names(self, kind: str) -> list[str]:
        """Return the names of measured points or blocks."""
        rows = self[kind]
        return [b"".join(row).decode("utf-8", "replace").strip("\0 ") for row in rows]

    def dataset(self, names: Iterable[str]):
        """Return variables as an `xarray.Dataset` in which points are selected by name."""
        import xarray as xr

        if 8.0 * self._data["block_coordinates"].size > _LARGE:
            from ..output.scene import open_output

            return open_output(self.file)
        variables = {name: (self.dims(name), self[name]) for name in names if self.has(name)}
        data = xr.Dataset(variables, attrs=self.attributes)
        return data.assign_coords(point=("point", self.names("point")))


def measure(
    file: Path, quantities: Iterable[Quantity], notes: list[str] | None = None
) -> tuple[dict[str, float], dict[str, Array]]:
    """Extract quantities from an output; return numbers and arrays by their labels.

    Names of quantities are

    - ``verdict``: all numbers of `sitedda.Run.verdict`; or the name of one number, such as
      ``largest_tilt_rad`` or ``pga_m_s2[top]``; missing counts are 0;
    - ``figures``: the numbers in the table of the verdict, and all counts;
    - ``variable[point or block].component``, such as ``displacement[top].x``,
      ``block_stress[drum_3].yy``, ``energy_friction``: a history.  A suffix ``.max``, ``.min``,
      ``.range``, ``.last`` or ``.largest`` (absolute value) reduces it to a number.
      ``displacement`` is relative to the base, unlike ``absolute_displacement``;
    - ``spectrum[point].x``: acceleration response spectrum with 5 % damping;
    - ``histories``: results of the verdict as functions of time, see `sitedda.study.histories`;
    - ``amplification_ratio``: spectral ratio of the first &amplification of the input.

    `file`: output of a run; `notes`: list to which the warnings of the run are appended.

    Raises
    ------
    InputError
        If the output does not contain a quantity; the message lists existing ones.
    """
    numbers: dict[str, float] = {}
    arrays: dict[str, Array] = {}
    with Output(file) as output:
        for quantity in quantities:
            for label, value in _measure_quantity(output, quantity).items():
                if isinstance(value, Array):
                    arrays[label] = value
                else:
                    numbers[label] = float(value)
        if notes is not None:
            notes += str(output.attributes.get("doubts", "")).splitlines()
    return numbers, arrays


def _measure_quantity(output: Output, quantity: Quantity) -> dict:
    """Return the numbers and arrays of one quantity by their labels."""
    if quantity.function:
        return split_value(quantity.label, quantity.function(_ended_run(output.file)))
    name, label, component, reduction = _PATH.fullmatch(quantity.name).groups()
    if name == "verdict":
        return _verdict_numbers(output, list(_TOPICS))
    if name == "figures":  # the engine lists the numbers that exceed rounding errors
        rows = str(output.attributes.get("figures", "")).splitlines()
        keys = {key for row in rows for key in row.split("\t")[1:3]} | {*_ZERO, *_OF_PYTHON}
        return {n: v for n, v in _verdict_numbers(output, list(_TOPICS)).items() if n in keys}
    for topic, names in _TOPICS.items():
        if name in names:
            return {quantity.label: _verdict_number(output, topic, name, label)}
    if name == "histories":
        return histories(output)
    if name == "spectrum":
        return {quantity.label: _compute_spectrum(output, quantity.name, label, component)}
    if name == "amplification_ratio":
        from ..output.response import amplifications

        peaks = amplifications(output.dataset([*_BLOCKS, *_HISTORY]))
        if not peaks:
            raise InputError(_NO_AMPLIFICATION)
        frequency = {"frequency": peaks[0].frequency}
        return {quantity.label: Array(peaks[0].ratio, ("frequency",), frequency, "1")}
    return {quantity.label: _read_history(output, quantity.name, name, label, component, reduction)}


def _ended_run(file: Path):
    """Return the run of an output, for functions of the user."""
    from ..drawing.ended_run import EndedRun
    from ..output.output_file import load

    history = load(file)
    return EndedRun(history, True, file, str(history.attrs.get("step_control", "")))


def _verdict_numbers(output: Output, topics: Iterable[str]) -> dict[str, float]:
    """Return the numbers of parts (keys of `_TOPICS`) of the verdict by name."""
    if "amplification" not in input_values(output.attributes):
        topics = [topic for topic in topics if topic != "add_damping"]
    numbers = {name: 0.0 for topic in topics for name in _TOPICS[topic] if name in _ZERO}
    if _ATTRIBUTES in topics:
        attributes = output.attributes.items()
        numbers |= {n: v for n, v in attributes if n.partition("[")[0] in _TOPICS[_ATTRIBUTES]}
    computed = [topic for topic in topics if topic != _ATTRIBUTES]
    return numbers | _compute_verdict(output, computed) if computed else numbers


def _compute_verdict(output: Output, topics: Iterable[str]) -> dict[str, float]:
    """Return the values of those parts of the verdict that the engine does not write."""
    from ..output import verdict as words
    from ..output.scene import Scene

    names = [*_BLOCKS, *(name for topic in topics for name in _VARIABLES_OF.get(topic, ()))]
    data = output.dataset(dict.fromkeys(names))
    scene, result = Scene.of(data), words.Verdict()
    for topic in topics:
        getattr(words, topic)(result, data if _VARIABLES_OF.get(topic) is _HISTORY else scene)
    return result.values


def _verdict_number(output: Output, topic: str, name: str, label: str | None) -> float:
    """Return a number of the verdict; `label` is the name of its point or joint, if any."""
    values = _verdict_numbers(output, [topic])
    key = name if label is None else f"{name}[{label}]"
    if key in values:
        return values[key]
    if name.startswith("first_"):
        return np.nan
    listing = ", ".join(n for n in values if n.startswith(name))
    hint = f"; similar results are {listing}" if listing else ""
    raise InputError(f"the run has no result {key}{hint}")


def _compute_spectrum(output: Output, name: str, point: str | None, axis: str | None) -> Array:
    """Return the acceleration response spectrum of a point with 5 % damping, m/s²."""
    from ..output.verdict import PERIODS, acceleration_spectrum

    series = _read_history(output, name, "acceleration", point, axis or "x", None)
    assert isinstance(series, Array)  # not reduced
    time = series.coordinates["time"]
    step = float(time[-1] - time[0]) / (len(time) - 1)
    values = acceleration_spectrum(series.values, step)
    return Array(values, ("period",), {"period": PERIODS}, "m/s^2")


def _read_history(output, path, name, label, component, reduction) -> Array | float:
    """Return a variable of a point or block as a function of time, or reduced to a number."""
    index, reduction = _locate_history(output, path, name, label, component, reduction)
    variable = _WRITTEN_AS.get(name, name)
    values, dim = output[variable][index], output.dims(variable)[0]
    if name == "displacement" and output.has("base_displacement"):
        values = values - output["base_displacement"][:, index[-1]]
    if reduction:
        return float(REDUCTIONS[reduction](values))
    time = output["time" if dim == "time" else "frame_time"]
    return Array(values, (dim,), {dim: time}, output.units(variable))


def _locate_history(output, path, name, label, component, reduction) -> tuple[tuple, str | None]:
    """Return the index of a history in the array of its variable, and the name of its reduction."""
    dims = output.dims(_WRITTEN_AS.get(name, name))
    index: list = [slice(None)]
    if component in REDUCTIONS and reduction is None and len(dims) < 3:
        component, reduction = None, component
    if dims[:1] not in (("time",), ("frame",)):
        raise InputError(f"{path}: {name} does not vary in time")
    if len(dims) > 1:
        index.append(_find_index(path, f"a {dims[1]}", label, output.names(dims[1])))
    if len(dims) > 2:
        index.append(_find_index(path, f"a {dims[2]}", component, _LABELS.get(dims[2], ())))
    return tuple(index), reduction


def check_names(source, quantities: Iterable[Quantity]) -> None:
    """Check before a run that its output will contain quantities; see `measure`.

    `source`: the input; `quantities`: quantities; functions are not checked.
    """
    from ..engine.simulation import Simulation

    names = [item.name for item in quantities if not item.function and item.name not in _COMMON]
    if not names:
        return
    with tempfile.TemporaryDirectory(prefix="sitedda-study-") as folder:
        try:
            with Simulation(source, Path(folder) / "out.nc"):
                pass
        except SiteddaError as error:
            raise NotBegun(str(error)) from error
        with Output(Path(folder) / "out.nc.partial") as output:
            for name in names:
                _check_name(output, name)


class NotBegun(SiteddaError):
    """A run cannot start, so the names of its results are unknown."""


def _check_name(output: Output, path: str) -> None:
    """Check that an output contains a quantity; raise InputError otherwise."""
    name, label, component, reduction = _PATH.fullmatch(path).groups()
    kind = "measured_joint" if name in _JOINTS else "point" if name in _AT_POINTS else ""
    if kind:
        names = output.names(kind) if output.has(kind) else []
        _find_index(path, f"a {kind}", label, [item or str(i) for i, item in enumerate(names, 1)])
    elif name == "amplification_ratio":
        if "amplification" not in input_values(output.attributes):
            raise InputError(_NO_AMPLIFICATION)
    elif name == "spectrum":
        _locate_history(output, path, "acceleration", label, component or "x", None)
    elif name not in NAMES:
        _locate_history(output, path, name, label, component, reduction)


def _find_index(path: str, kind: str, name: str | None, names) -> int:
    """Return the index of a name, such as that of a point; raise InputError if it is missing."""
    if name in names:
        return list(names).index(name)
    listing = ", ".join(list(names)[:8]) + (" …" if len(names) > 8 else "")
    if name is None:
        raise InputError(f"{path}: name the {kind.partition(' ')[2]}, one of {listing}")
    raise InputError(f"{path}: there is no {kind.partition(' ')[2]} {name!r}; there are {listing}")


def split_value(label: str, value) -> dict:
    """Convert the value of a function (number, array, DataArray, mapping) to numbers and arrays."""
    if isinstance(value, Mapping):
        parts = [split_value(str(name), item) for name, item in value.items()]
        return {key: item for part in parts for key, item in part.items()}
    if hasattr(value, "dims") and hasattr(value, "coords"):
        coordinates = {d: np.asarray(value[d].values) for d in value.dims}
        units = str(value.attrs.get("units", ""))
        array = Array(np.asarray(value.values), tuple(map(str, value.dims)), coordinates, units)
        return {label: array if array.dims else float(array.values)}
    try:
        values = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{label}: a function must return numbers or arrays of them, not "
                         f"{type(value).__name__}") from None  # fmt: skip
    if values.ndim == 0:
        return {label: float(values)}
    dims = tuple(f"{label}_{i}" for i in range(values.ndim))
    return {label: Array(values, dims, {d: np.arange(n) for d, n in zip(dims, values.shape,
                                                                        strict=True)})}  # fmt: skip
