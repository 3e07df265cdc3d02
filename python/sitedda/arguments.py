# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of numbers that functions are given; the messages name the argument and its value."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["first_of", "not_negative", "positive"]


def positive(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """Values as an array of floats; ValueError unless all are finite and positive."""
    values = np.asarray(value, dtype=float)
    good = np.isfinite(values) & (values > 0)
    if not np.all(good):
        raise ValueError(f"{name} must be finite and positive, got {first_of(values, ~good):g}")
    return values


def not_negative(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """Values as an array of floats; ValueError unless all are finite and not negative."""
    values = np.asarray(value, dtype=float)
    good = np.isfinite(values) & (values >= 0)
    if not np.all(good):
        raise ValueError(f"{name} must be finite and not negative, got {first_of(values, ~good):g}")
    return values


def first_of(values: NDArray, chosen: NDArray) -> float:
    """The first of the chosen values, for a message."""
    return np.atleast_1d(values)[np.atleast_1d(chosen)][0]
