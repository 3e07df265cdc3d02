# SPDX-License-Identifier: GPL-3.0-or-later
"""Stiffness as a linear function of unknown stiffnesses, its modes and their derivatives.

    K(θ) = K₀ + Σ θᵢ Kᵢ,    K x = ω² M x,    xᵀ M x = 1                               (1)
    ∂ω²/∂θᵢ = xᵀ Kᵢ x,    ∂x/∂θᵢ = Σ xₘ (xₘᵀ Kᵢ x) / (ω² − ωₘ²)                       (2)

Modes X that share a frequency are not unique: the derivatives of their ω² along θᵢ are the
eigenvalues of Xᵀ Kᵢ X.  All matrices here are those of y in x = W y with Wᵀ M W = 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy import linalg, sparse

from ..base.errors import InputError
from ..engine.checking import matrices
from ..input.changes import merged

_DENSE = 900  # largest number of coordinates for which LAPACK computes all modes
_NO_STIFFNESS = 1e-12  # ω² below this fraction of the largest entry: rigid motions and mechanisms
_EQUAL = 1e-8  # relative difference of ω² that counts as round-off
_STEP = 1e-4  # relative change of an unknown, small so that few contacts change
_LINEAR = 1e-3  # largest relative curvature of K: settled contacts move by micrometres
_FREE = 12  # motions without stiffness for which the first search suffices


@dataclass(frozen=True)
class Family:
    """A stiffness matrix that depends linearly on unknowns, in coordinates of unit mass."""

    fixed: np.ndarray  # K₀, shape (n, n), 1/s²
    parts: list  # Kᵢ, 1/s² for one unit of the unknown
    points: np.ndarray  # displacements x and y of the measured points in turn, (2 points, n)

    def stiffness(self, theta):
        """Return K at unknowns of shape (unknowns,)."""
        return sum((t * term for t, term in zip(theta, self.parts, strict=True)), self.fixed)

    def modes(self, theta, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the lowest ω² (rad²/s²) that have stiffness, ascending, and modes y as columns."""
        stiffness, rigid = self.stiffness(theta), _FREE
        limit = _NO_STIFFNESS * abs(stiffness).max()
        while True:
            squares, y = self._lowest(stiffness, count + rigid)
            start = int(np.searchsorted(squares, limit))
            if start <= rigid or squares.size < count + rigid:
                return squares[start : start + count], y[:, start : start + count]
            rigid = 2 * start

    @staticmethod
    def _lowest(stiffness, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the lowest eigenvalues of a matrix, ascending, and eigenvectors as columns."""
        if isinstance(stiffness, np.ndarray):
            highest = min(count, len(stiffness)) - 1
            squares, y = linalg.eigh(stiffness, subset_by_index=(0, highest))
        else:
            from scipy.sparse.linalg import eigsh

            shift = 1e-9 * stiffness.diagonal().mean()  # K itself may be singular
            squares, y = eigsh(stiffness.tocsc(), min(count, stiffness.shape[0] - 1), sigma=-shift)
            order = np.argsort(squares)
            squares, y = squares[order], y[:, order]
        return squares, y

    def slopes(self, squares: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return derivatives of ω², shape (unknowns, modes), and of modes y by eq. 2.

        At a repeated ω², its derivatives are one-sided, for increasing unknowns, in ascending
        order.  The sum of eq. 2 is over the given modes and omits those of equal ω².
        """
        differences = squares - squares[:, None]
        is_equal = abs(differences) <= _EQUAL * squares
        inverse = np.divide(1.0, differences, out=np.zeros_like(differences), where=~is_equal)
        groups = np.split(np.arange(squares.size), np.flatnonzero(~is_equal.diagonal(1)) + 1)
        derivatives, mode_slopes = [], []
        for term in self.parts:
            products = y.T @ (term @ y)
            derivatives.append(products.diagonal().copy())
            for group in groups:
                if group.size > 1:
                    derivatives[-1][group] = np.linalg.eigvalsh(products[np.ix_(group, group)])
            mode_slopes.append(y @ (products * inverse))
        return np.array(derivatives), np.array(mode_slopes)

    def reduced(self, y: np.ndarray) -> Family:
        """Return the dense family projected on vectors, shape (n, any)."""
        u, sizes, _ = np.linalg.svd(y, full_matrices=False)
        basis = u[:, sizes > 1e-5 * sizes[0]]
        fixed, *reduced_terms = (basis.T @ (k @ basis) for k in (self.fixed, *self.parts))
        return Family((fixed + fixed.T) / 2, [(k + k.T) / 2 for k in reduced_terms],
                      self.points @ basis)  # fmt: skip


def family_of(model, unknowns: Mapping, contacts="auto", changes=None) -> Family:
    """Return the family of a model about values of unknowns.

    K is linear in each unknown, so that K(θᵢ + h θᵢ) − K(θ) = h θᵢ Kᵢ exactly.  A small h leaves
    the contacts that gravity closes.

    `unknowns`: values by the name of what they change, such as
    ``joint[bed].shear_stiffness_per_area``; `contacts`: see `sitedda.modes`; `changes`: further
    changes of the input.

    Raises
    ------
    InputError
        If an unknown changes no stiffness, changes masses, or K is not linear in it.
    """
    values = merged(changes, unknowns)
    base, mass, points, _ = matrices(model, contacts, values)
    steps = []
    for name, value in unknowns.items():
        stiffness, mass_b, *_ = matrices(model, contacts, values | {name: (1 + _STEP) * value})
        step = stiffness - base
        if abs(mass_b - mass).max() > _LINEAR * _STEP * abs(mass).max():
            raise InputError(f"{name} changes masses: only stiffnesses can be calibrated")
        if abs(step).max() <= _NO_STIFFNESS * abs(base).max():
            raise InputError(f"{name} changes no stiffness of the model")
        steps.append(step)
    # Steps of other sizes also show whether the first steps changed contacts.
    mixed_values = {n: v * (1 + (i + 2) * _STEP) for i, (n, v) in enumerate(unknowns.items())}
    stiffness, *_ = matrices(model, contacts, values | mixed_values)
    linear = base + sum((i + 2) * step for i, step in enumerate(steps))
    if abs(stiffness - linear).max() > _LINEAR * _STEP * max(abs(step).max() for step in steps):
        raise InputError(
            f"the stiffness matrix is not linear in {', '.join(unknowns)}: choose independent "
            "stiffnesses instead of ratios; if gravity opens contacts, set contacts = 'closed'"
        )
    w = _unit_mass(mass)
    theta = list(unknowns.values())
    terms = [w.T @ (step / (_STEP * t)) @ w for step, t in zip(steps, theta, strict=True)]
    fixed = w.T @ base @ w - sum(t * term for t, term in zip(theta, terms, strict=True))
    if fixed.shape[0] <= _DENSE:
        fixed, terms = fixed.toarray(), [term.toarray() for term in terms]
    return Family(fixed, terms, (points @ w).toarray())


def _unit_mass(mass: sparse.csr_array) -> sparse.csr_array:
    """Return W with Wᵀ M W = 1, without coordinates of removed blocks."""
    mass = mass.copy()
    mass.eliminate_zeros()
    blocks = sparse.bsr_array(mass, blocksize=(6, 6))
    inverse = np.linalg.inv(np.linalg.cholesky(blocks.data)).transpose(0, 2, 1)
    columns = np.arange(len(inverse))
    shape = (mass.shape[0], 6 * len(inverse))
    return sparse.csr_array(sparse.bsr_array((inverse, columns, blocks.indptr), shape=shape))
