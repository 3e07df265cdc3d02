# SPDX-License-Identifier: GPL-3.0-or-later
"""Elastic spectra of building codes: functions of the period (s), Sa in m/s², 5 % damping."""

from collections.abc import Callable

import numpy as np

from ..base.arguments import POSITIVE
from ..base.errors import InputError

_GROUND = {  # EN 1998-1:2004, tables 3.2 and 3.3: S, T_B, T_C, T_D
    1: {"A": (1.0, 0.15, 0.4, 2.0), "B": (1.2, 0.15, 0.5, 2.0), "C": (1.15, 0.2, 0.6, 2.0),
        "D": (1.35, 0.2, 0.8, 2.0), "E": (1.4, 0.15, 0.5, 2.0)},
    2: {"A": (1.0, 0.05, 0.25, 1.2), "B": (1.35, 0.05, 0.25, 1.2), "C": (1.5, 0.1, 0.25, 1.2),
        "D": (1.8, 0.1, 0.3, 1.2), "E": (1.6, 0.05, 0.25, 1.2)},
}  # fmt: skip


def eurocode8(peak: float, ground: str = "A", kind: int = 1) -> Callable:
    """Return the elastic spectrum of EN 1998-1:2004, 3.2.2.2, with 5 % damping.

    Parameters
    ----------
    peak : float
        Ground acceleration a_g, m/s².
    ground : {'A', 'B', 'C', 'D', 'E'}
        Ground type.
    kind : {1, 2}
        Type of the spectrum.
    """
    if kind not in _GROUND or ground not in _GROUND[kind]:
        raise InputError(f"ground = {ground!r}, kind = {kind!r}: use ground A to E and kind 1 or 2")
    soil, b, c, d = _GROUND[kind][ground]
    peak = POSITIVE.check("peak", peak)

    def spectrum(period):
        t = np.asarray(period, dtype=float)
        shape = np.where(t < b, 1 + 1.5 * t / b, 2.5)
        shape = np.where(t > c, 2.5 * c / np.maximum(t, c), shape)
        shape = np.where(t > d, 2.5 * c * d / np.maximum(t, d) ** 2, shape)
        return peak * soil * shape

    return spectrum


def eurocode8_2024(
    plateau: float, one_second: float, factors: tuple[float, float] = (1.0, 1.0)
) -> Callable:
    """Return the elastic spectrum of EN 1998-1-1:2024, 5.2.2.2, with 5 % damping.

    Parameters
    ----------
    plateau, one_second : float
        S_α,RP and S_β,RP of site category A, m/s².
    factors : (float, float)
        Site amplification factors F_α and F_β, from the table of the code or a site analysis.
    """
    plateau = POSITIVE.check("plateau", plateau)
    one_second = POSITIVE.check("one_second", one_second)
    alpha, beta = (POSITIVE.check("factors", factor) for factor in factors)
    high, at_one = plateau * alpha, one_second * beta
    if not 0.05 * high <= at_one <= 2 * high:
        raise InputError(f"S_α = {high:g} and S_β = {at_one:g} m/s²: give S_β from 0.05 to 2 S_α")
    a, c, d = 0.02, at_one / high, max(2.0, 1.0 + one_second)
    b = min(max(c / 4, 0.05), 0.1)

    def spectrum(period):
        t = np.asarray(period, dtype=float)
        long = at_one * np.minimum(1.0, d / np.maximum(t, c)) / np.maximum(t, c)
        return np.where(t > max(b, c), long, np.interp(t, [a, b], [high / 2.5, high]))

    return spectrum


def asce7(short: float, one_second: float, long_period: float = 8.0) -> Callable:
    """Return the two-period design spectrum of ASCE/SEI 7-16, 11.4.6, with 5 % damping.

    Parameters
    ----------
    short, one_second : float
        S_DS and S_D1, m/s².
    long_period : float
        T_L, s.
    """
    if not 0 < one_second <= short * long_period or not short > 0:
        raise InputError(f"S_DS = {short:g} and S_D1 = {one_second:g} m/s²: give values above 0, "
                         "with S_D1/S_DS at most the long period T_L")  # fmt: skip
    end = one_second / short
    begin = 0.2 * end

    def spectrum(period):
        t = np.asarray(period, dtype=float)
        shape = np.where(t < begin, short * (0.4 + 0.6 * t / begin), short)
        shape = np.where(t > end, one_second / np.maximum(t, end), shape)
        long = one_second * long_period / np.maximum(t, long_period) ** 2
        return np.where(t > long_period, long, shape)

    return spectrum
