# SPDX-License-Identifier: GPL-3.0-or-later
"""Moduli of bonded square blocks that together behave as an elastic continuum."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SquareLattice:
    """Blocks and contacts of a lattice of squares of any size.

    Attributes
    ----------
    young_modulus : float
        Of the blocks, Pa.
    poisson_ratio : float
        Of the blocks.
    normal_stiffness : float
        Of &contact, N/m per metre of thickness.
    shear_ratio : float
        Of &contact.
    """

    young_modulus: float
    poisson_ratio: float
    normal_stiffness: float
    shear_ratio: float = 1.0


def square_lattice(
    young_modulus: float, poisson_ratio: float, ratio: float = 1.0, plane_strain: bool = True
) -> SquareLattice:
    """Blocks and contacts that give the moduli of a continuum to bonded squares.

    Two contacts on each side are springs in series with the blocks: they add 1/2k_n to the
    compliance along an axis and 1/k_s to that in shear, which stays isotropic for k_s = k_n.  Stiff
    contacts are no way out: blocks of constant strain that meet at all their corners can only move
    as u_x = f(x) + g(y), and all other motions take (k_n + k_s) h² (∂²u/∂x∂y)²/4 per area.

    Parameters
    ----------
    young_modulus, poisson_ratio : float
        Of the continuum, Pa and -.
    ratio : float
        k_n over its Young's modulus, above about 0.5; motions of wave number k and blocks of side h
        are too stiff by less than (1 + ν) ratio (kh)²/2.
    plane_strain : bool
        Else plane stress.

    Raises
    ------
    ValueError
        If the contacts alone are softer than the continuum.
    """
    stiffness = ratio * young_modulus
    part = 1.0 - poisson_ratio**2 if plane_strain else 1.0
    across = poisson_ratio * (1.0 + poisson_ratio if plane_strain else 1.0) / young_modulus
    along = part / young_modulus - 0.5 / stiffness if stiffness > 0.0 else 0.0
    if not along > across:
        raise ValueError(
            f"ratio = {ratio:g}: contacts of {ratio:g} times Young's modulus are softer than the "
            "continuum; take 1 or more"
        )
    share = across / along
    own = share / (1.0 + share) if plane_strain else share
    return SquareLattice((1.0 - own**2 if plane_strain else 1.0) / along, own, stiffness)
