# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion and strain anywhere in a column, for a unit reference motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .layers import Waves, recursion

if TYPE_CHECKING:
    from .column import Column


def field(
    column: Column,
    waves: Waves,
    depths: ArrayLike,
    bottom: float,
    kind: str,
) -> tuple[NDArray[np.complex128], NDArray[np.complex128], NDArray[np.complex128]]:
    """Displacement, shear strain and shear stress for a unit reference displacement.

    Parameters
    ----------
    column : Column
    waves : Waves
    depths : array_like, shape (k,)
        m; at an interface the strain is that of the medium below, at a rigid base of the one above.
    bottom : float
        Depth of the reference motion, m.
    kind : {'outcrop', 'within'}
        What the reference motion is.

    Returns
    -------
    displacement : ndarray of complex128, shape (k, n)
        Dimensionless.
    strain : ndarray of complex128, shape (k, n)
        ∂u/∂z with z downwards, 1/m.
    stress : ndarray of complex128, shape (k, n)
        G* times the strain, Pa/m.

    Raises
    ------
    ValueError
        If a depth lies outside the column.
    """
    depths = np.asarray(depths, dtype=float)
    media, interfaces = column.cut_at([*depths, bottom])
    steps, reflections = recursion(waves, media, np.diff(interfaces))
    last = _nearest(interfaces, [bottom])[0]
    upgoing = _upgoing(steps, last)
    upgoing = upgoing / (2.0 if kind == "outcrop" else 1 + reflections[last])
    at = _nearest(interfaces, depths)
    displacement = upgoing[at] * (1 + reflections[at])
    strain = np.empty_like(displacement)
    stress = np.empty_like(displacement)
    for row, j in enumerate(at):
        medium, up, down = media[j], upgoing[j], upgoing[j] * reflections[j]
        if medium is None:  # a rigid base: the waves of the layer above, at its bottom
            medium = media[j - 1]
            modulus, density = waves.properties(medium)
            number = waves.omega / np.sqrt(modulus / density)
            turn = np.exp(-1j * number * (interfaces[j] - interfaces[j - 1]))
            up, down = upgoing[j - 1] / turn, upgoing[j - 1] * reflections[j - 1] * turn
        modulus, density = waves.properties(medium)
        strain[row] = 1j * waves.omega / np.sqrt(modulus / density) * (up - down)
        stress[row] = modulus * strain[row]
    return displacement, strain, stress


def _nearest(interfaces: NDArray[np.float64], depths: ArrayLike) -> NDArray[np.intp]:
    return np.array([np.argmin(np.abs(interfaces - depth)) for depth in depths], dtype=int)


def _upgoing(steps: NDArray[np.complex128], last: int) -> NDArray[np.complex128]:
    """Upgoing wave at the top of each medium, over that at interface `last`; shape (m + 1, n)."""
    upgoing = np.ones((len(steps) + 1, steps.shape[1]), dtype=complex)
    for j in range(last - 1, -1, -1):
        upgoing[j] = upgoing[j + 1] * steps[j]
    for j in range(last, len(steps)):
        upgoing[j + 1] = upgoing[j] / steps[j]
    return upgoing
