# SPDX-License-Identifier: GPL-3.0-or-later
"""Suites of records, each scaled to the same levels of an intensity measure."""

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
_PERIODS = np.geomspace(0.1, 2.0, 12)  # s, at which spectra of records are compared


@dataclass(frozen=True)
class Record:
    """A ground acceleration that is not yet in a file.

    Attributes
    ----------
    name : str
    acceleration : ndarray, shape (samples,)
        m/s².
    time_step : float
        s.
    misfit : float
        Of a synthetic one: root of the mean square of Sa over its target, less 1.
    """

    name: str
    acceleration: np.ndarray
    time_step: float
    misfit: float = np.nan

    @property
    def data(self) -> bytes:
        """Return the samples as a text file, one per line."""
        return ("\n".join(map(repr, self.acceleration.tolist())) + "\n").encode()


@dataclass
class Records:
    """Records and levels of intensity: two dimensions of a study.

    The factor of a record is the level over the measure of the record, so that all records of a
    level have the same intensity. For the Arias intensity, the factor is the root of this ratio.

    Parameters
    ----------
    records : sequence of path or Record
    levels : sequence of float
        In the unit of the measure: factors, m/s², m/s.
    measure : {'scale', 'pga', 'pgv', 'sa', 'arias'}
        Also the name of the dimension. 'sa' is the spectral pseudo-acceleration at `period`.
    motion : str
        Name of the &motion that the records are for, where the input has several.
    period, damping : float
        s and damping ratio, of 'sa'.
    format, quantity, unit : str
        Of files that do not state it, as in &motion.
    time_step : float
        s, of files that do not state it.
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
            raise InputError("measure 'sa' needs the period, s")
        self.records, levels = list(self.records), np.asarray(self.levels, dtype=float)
        if not self.records or not levels.size or not np.all(np.isfinite(levels) & (levels > 0)):
            raise InputError("give at least one record, and levels above 0")
        checked_name(self.measure)
        motions = [self._read_motion(one) for one in self.records]
        own = np.array(
            [self._raw_measure(*both) for both in zip(self.records, motions, strict=True)]
        )
        power = 0.5 if self.measure == "arias" else 1.0
        self.factors = (levels[None, :] / own[:, None]) ** power
        names = [_record_name(one) for one in self.records]
        names = [f"{n} ({i})" if names.count(n) > 1 else n for i, n in enumerate(names, 1)]
        self.dims = {"record": len(names), self.measure: levels.size}
        about: dict = {"units": _UNITS[self.measure]}
        if self.measure == "sa":
            about |= {"period": float(self.period), "damping": self.damping}
        self.coordinates = {
            "record": (("record",), coordinate(names), _ln_sa_scatter(motions)),
            self.measure: ((self.measure,), levels, about),
            "factor": (("record", self.measure), self.factors, {"units": "1"}),
        }

    def changes(self, place: tuple[int, ...]) -> dict:
        """Return file and factor of the motion."""
        record = self.records[place[0]]
        group = f"motion[{self.motion}]" if self.motion else "motion"
        found: dict = {"values": None, "scale": float(self.factors[place])}
        if isinstance(record, Record):
            found |= {"file": record, "format": "text", "quantity": "acceleration", "unit": "m/s2",
                      "time_step": record.time_step}  # fmt: skip
        else:
            found |= {"file": os.path.abspath(record), "format": self.format}
            found |= {"quantity": self.quantity or None, "unit": self.unit or None}
            found["time_step"] = self.time_step or None
        return {f"{group}.{name}": value for name, value in found.items()}

    def _read_motion(self, record) -> tuple[np.ndarray, np.ndarray, float] | None:
        """Return acceleration, velocity and step; None for a file that need not be read."""
        if isinstance(record, Record):
            velocity = running_integral(record.acceleration, record.time_step)
            return record.acceleration, velocity, record.time_step
        if self.measure == "scale":
            return None
        read = read_record(record, self.format, self.quantity, self.unit, self.time_step)
        return read.acceleration.values, read.velocity.values, float(read.time[1] - read.time[0])

    def _raw_measure(self, record, motion) -> float:
        """Return the measure of an unscaled record."""
        if self.measure == "scale":
            return 1.0
        acceleration, velocity, step = motion
        found = intensity(self.measure, acceleration, velocity, step, self.period, self.damping)
        if not found > 0:
            raise InputError(f"{_record_name(record)}: its {self.measure} is {found:g}; it cannot "
                             "be scaled")  # fmt: skip
        return found


def _ln_sa_scatter(motions: list) -> dict:
    """Return, as an attribute, the scatter of ln Sa of records scaled to a common mean."""
    if len(motions) < 2 or None in motions:
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
        s between samples.
    period, damping : float
        Of 'sa', s and damping ratio.
    """
    if measure == "pga":
        return float(abs(acceleration).max())
    if measure == "pgv":
        return float(abs(velocity).max())
    if measure == "arias":
        return arias_intensity(acceleration, step)
    return float(spectral_acceleration(acceleration, step, [period], damping)[0])
