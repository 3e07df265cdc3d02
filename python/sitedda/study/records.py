# SPDX-License-Identifier: GPL-3.0-or-later
"""Suites of records that are scaled to levels of an intensity measure."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..base.errors import InputError
from ..engine.records import read_record
from ..engine.signals import arias_intensity, running_integral, spectral_acceleration
from .axes import checked_name, coordinate

_UNITS = {"scale": "1", "pga": "m/s^2", "pgv": "m/s", "sa": "m/s^2", "arias": "m/s"}
_PERIODS = np.geomspace(0.1, 2.0, 12)  # periods at which the spectra of records are compared, s


@dataclass(frozen=True)
class Record:
    """A ground acceleration in memory."""

    name: str
    acceleration: np.ndarray  # m/s²
    time_step: float  # s
    misfit: float = np.nan  # root mean square of Sa / target − 1 of a synthetic record

    @property
    def data(self) -> bytes:
        """Return the content of a text file with one sample per line."""
        return ("\n".join(map(repr, self.acceleration.tolist())) + "\n").encode()


@dataclass
class Records:
    """Records and levels of intensity: two dimensions of a study.

    Each record is multiplied by the ratio of the level to its intensity, so that all records of a
    level have the same intensity. For the Arias intensity, the factor is the root of this ratio.

    Parameters
    ----------
    records : sequence of path or Record
    levels : sequence of float
        Levels in the unit of the measure: factors, m/s² or m/s.
    measure : {'scale', 'pga', 'pgv', 'sa', 'arias'}
        Intensity measure, and name of its dimension. 'sa' is the pseudo-acceleration at `period`.
    motion : str
        Name of the &motion that uses the records; required if the input contains several.
    period, damping : float
        Period (s) and damping ratio of 'sa'.
    format, quantity, unit : str
        Variables of &motion, for files that do not state them.
    time_step : float
        Time step (s) of files that do not state it.
    """

    records: Sequence
    levels: Sequence[float]
    measure: str = "scale"
    motion: str = ""
    period: float | None = None
    damping: float = 0.05
    format: str = "auto"
    quantity: str = ""
    unit: str = ""
    time_step: float = 0.0
    dims: dict[str, int] = field(init=False)
    coordinates: dict[str, tuple] = field(init=False)
    factors: np.ndarray = field(init=False)

    def __post_init__(self):
        if self.measure not in _UNITS:
            raise InputError(f"measure = {self.measure!r}: use {', '.join(_UNITS)}")
        if self.measure == "sa" and not self.period:
            raise InputError("measure = 'sa' requires period, s")
        self.records, levels = list(self.records), np.asarray(self.levels, dtype=float)
        if not self.records or not levels.size or not np.all(np.isfinite(levels) & (levels > 0)):
            raise InputError("give at least one record, and levels above 0")
        checked_name(self.measure)
        motions = [self._read_motion(record) for record in self.records]
        pairs = zip(self.records, motions, strict=True)
        sizes = np.array([self._raw_measure(*pair) for pair in pairs])
        power = 0.5 if self.measure == "arias" else 1.0
        self.factors = (levels[None, :] / sizes[:, None]) ** power
        names = [_record_name(record) for record in self.records]
        names = [f"{n} ({i})" if names.count(n) > 1 else n for i, n in enumerate(names, 1)]
        self.dims = {"record": len(names), self.measure: levels.size}
        attributes: dict = {"units": _UNITS[self.measure]}
        if self.measure == "sa":
            attributes |= {"period": float(self.period), "damping": self.damping}
        self.coordinates = {
            "record": (("record",), coordinate(names), _ln_sa_scatter(motions)),
            self.measure: ((self.measure,), levels, attributes),
            "factor": (("record", self.measure), self.factors, {"units": "1"}),
        }

    def changes(self, index: tuple[int, ...]) -> dict:
        """Return the changes of &motion for a record and a level."""
        record = self.records[index[0]]
        group = f"motion[{self.motion}]" if self.motion else "motion"
        values: dict = {"values": None, "scale": float(self.factors[index])}
        if isinstance(record, Record):
            values |= {"file": record, "format": "text", "quantity": "acceleration", "unit": "m/s2",
                      "time_step": record.time_step}  # fmt: skip
        else:
            values |= {"file": os.path.abspath(record), "format": self.format}
            values |= {"quantity": self.quantity or None, "unit": self.unit or None}
            values["time_step"] = self.time_step or None
        return {f"{group}.{name}": value for name, value in values.items()}

    def _read_motion(self, record) -> tuple[np.ndarray, np.ndarray, float] | None:
        """Return acceleration (m/s²), velocity (m/s) and time step (s); None if not needed."""
        if isinstance(record, Record):
            velocity = running_integral(record.acceleration, record.time_step)
            return record.acceleration, velocity, record.time_step
        if self.measure == "scale":
            return None
        data = read_record(record, self.format, self.quantity, self.unit, self.time_step)
        return data.acceleration.values, data.velocity.values, float(data.time[1] - data.time[0])

    def _raw_measure(self, record, motion) -> float:
        """Return the intensity of an unscaled record."""
        if self.measure == "scale":
            return 1.0
        acceleration, velocity, step = motion
        value = intensity(self.measure, acceleration, velocity, step, self.period, self.damping)
        if not value > 0:
            raise InputError(f"{_record_name(record)} cannot be scaled: its {self.measure} is "
                             f"{value:g}")  # fmt: skip
        return value


def _ln_sa_scatter(motions: list) -> dict:
    """Return the scatter of ln Sa of records with a common mean, as an attribute of the table."""
    if len(motions) < 2 or None in motions or not all(motion[0].any() for motion in motions):
        return {}
    shapes = np.array([np.log(spectral_acceleration(acceleration, step, _PERIODS, 0.05))
                       for acceleration, _, step in motions])  # fmt: skip
    shapes -= shapes.mean(axis=1, keepdims=True)
    return {"spectral_scatter": float(shapes.std(axis=0, ddof=1).mean())}


def _record_name(record) -> str:
    return record.name if isinstance(record, Record) else Path(record).stem


def intensity(measure: str, acceleration, velocity, step: float, period=None, damping=0.05):
    """Return an intensity measure of a motion.

    Parameters
    ----------
    measure : {'pga', 'pgv', 'sa', 'arias'}
    acceleration, velocity : ndarray, shape (samples,)
        m/s² and m/s.
    step : float
        Time between samples, s.
    period, damping : float
        Period (s) and damping ratio of 'sa'.
    """
    if measure == "pga":
        return float(abs(acceleration).max())
    if measure == "pgv":
        return float(abs(velocity).max())
    if measure == "arias":
        return arias_intensity(acceleration, step)
    return float(spectral_acceleration(acceleration, step, [period], damping)[0])
