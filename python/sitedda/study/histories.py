# SPDX-License-Identifier: GPL-3.0-or-later
"""Histories of results: largest values and integrals of all steps up to each time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..base.core import engine_names
from .arrays import Array

if TYPE_CHECKING:
    from .quantities import Output

_GRAVITY = 9.80665  # m/s², of the Arias intensity
INTERVALS = 1000  # number of equal intervals of the duration, at whose ends results are evaluated


def histories(output: Output) -> dict[str, Array]:
    """Return results as functions of time, at `INTERVALS` + 1 equally spaced times of a run.

    Result: ``history_NAME``, such as ``history_pga_m_s2[top]``: largest values so far; peak
    acceleration, peak velocity and Arias intensity of measured points, each along the axis with the
    largest value; present kinetic energy.
    """
    time = output["time"]
    times = np.linspace(time[0], time[-1], INTERVALS + 1)
    rows = np.searchsorted(time, times + 1e-9 * (times[1] - times[0]), side="right") - 1
    results = {"energy_kinetic": output["energy_kinetic"][rows]}  # present values, not largest ones
    numbers = engine_names("maxima numbers")
    for name, so_far in zip(numbers, output["largest_so_far"][rows].T, strict=True):
        if np.isfinite(so_far).any():
            results[f"largest_{name}"] = so_far
    for i, point in enumerate(output.names("point") if output.has("velocity") else ()):
        if f"pga_m_s2[{point}]" not in output.attributes:
            continue
        velocity, acceleration = (abs(output[n][:, i]) for n in ("velocity", "acceleration"))
        squares = np.cumsum(acceleration[1:] ** 2 * np.diff(time)[:, None], axis=0)
        squares = np.append(0.0, squares[:, np.argmax(squares[-1])])
        for name, values in (("pga_m_s2", acceleration), ("pgv_m_s", velocity)):
            results[f"{name}[{point}]"] = np.maximum.accumulate(values.max(axis=1))[rows]
        results[f"arias_m_s[{point}]"] = np.pi / (2 * _GRAVITY) * squares[rows]
    return {f"history_{name}": Array(values, ("look",), {"look": times})
            for name, values in results.items()}  # fmt: skip
