# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion and strain at any depth of a column, for a unit reference motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .layers import Waves, recursion

if TYPE_CHECKING:
    from .column import Column


def displacements(
    column: Column, waves: Waves, depths: ArrayLike, bottom: float, kind: str
) -> NDArray[np.complex128]:
    """Return displacements for a unit reference displacement.

    Parameters
    ----------
    column : Column
    waves : Waves
    depths : array_like, shape (k,)
        m.
    bottom : float
        Depth of the reference motion, m.
    kind : {'outcrop', 'within'}
        Kind of reference motion.

    Returns
    -------
    ndarray of complex128, shape (k, n)
        Dimensionless.

    Raises
    ------
    ValueError
        If a depth lies outside the column.
    """
    _, interfaces, upgoing, reflections = _waves_at(column, waves, depths, bottom, kind)
    found = [upgoing[j] * (1 + reflections[j]) for j in _nearest_interface(interfaces, depths)]
    return np.array(found)


def strains(
    column: Column, waves: Waves, depths: ArrayLike, bottom: float, kind: str
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Return shear strains ∂u/∂z, z downwards (1/m), and stresses (Pa/m), shape (k, n).

    At an interface, strains belong to the medium below, at a rigid base to the one above.
    """
    media, interfaces, upgoing, reflections = _waves_at(column, waves, depths, bottom, kind)
    at = _nearest_interface(interfaces, depths)
    strain = np.empty((len(at), upgoing.shape[1]), dtype=complex)
    stress = np.empty_like(strain)
    for row, j in enumerate(at):
        medium, up, down = media[j], upgoing[j], upgoing[j] * reflections[j]
        if medium is None:  # at a rigid base, use the waves at the bottom of the layer above
            medium = media[j - 1]
            modulus, density = waves.properties(medium)
            number = waves.omega / np.sqrt(modulus / density)
            turn = np.exp(-1j * number * (interfaces[j] - interfaces[j - 1]))
            up, down = upgoing[j - 1] / turn, upgoing[j - 1] * reflections[j - 1] * turn
        modulus, density = waves.properties(medium)
        strain[row] = 1j * waves.omega / np.sqrt(modulus / density) * (up - down)
        stress[row] = modulus * strain[row]
    return strain, stress


def _waves_at(column: Column, waves: Waves, depths: ArrayLike, bottom: float, kind: str):
    """Return media, their tops (m), upgoing waves, and downgoing over upgoing waves."""
    media, interfaces = column.cut_at([*np.asarray(depths, dtype=float), bottom])
    steps, reflections = recursion(waves, media, np.diff(interfaces))
    last = _nearest_interface(interfaces, [bottom])[0]
    upgoing = _upgoing_waves(steps, last)
    upgoing /= 2.0 if kind == "outcrop" else 1 + reflections[last]
    return media, interfaces, upgoing, reflections


def _nearest_interface(interfaces: NDArray[np.float64], depths: ArrayLike) -> NDArray[np.intp]:
    return np.array([np.argmin(np.abs(interfaces - depth)) for depth in depths], dtype=int)


def _upgoing_waves(steps: NDArray[np.complex128], last: int) -> NDArray[np.complex128]:
    """Return the upgoing wave at the top of each medium over that at interface `last`."""
    upgoing = np.empty((len(steps) + 1, steps.shape[1]), dtype=complex)
    upgoing[last] = 1.0
    for j in range(last - 1, -1, -1):
        upgoing[j] = upgoing[j + 1] * steps[j]
    for j in range(last, len(steps)):
        upgoing[j + 1] = upgoing[j] / steps[j]
    return upgoing
