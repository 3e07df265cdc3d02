# SPDX-License-Identifier: GPL-3.0-or-later
"""Hysteretic soil: parallel branches that slip or recover, fitted to curves of a soil."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.arguments import not_negative, positive
from ..base.core import api, checked
from ..base.errors import InputError
from .curves import STRAINS, SoilCurves, curves_of
from .layers import one_of

DAMPING_CURVES = ("target", "masing")


@dataclass(frozen=True)
class Branches:
    """Representation of a soil: branch j has the modulus g_j G and yields at γ_j.

    A fraction F_j of a branch slips, and the rest recovers its strain with the same stress cap, so
    that modulus *and* damping curve are fitted. A body with capped stress gives small strains a
    damping ratio independent of frequency; its effect vanishes as the soil yields
    (``docs/site.md``).
    """

    # γ_j, g_j, F_j; the sum of the g_j is 1 less the modulus fraction of the small-strain body
    strain: NDArray[np.float64]
    modulus: NDArray[np.float64]
    slipping: NDArray[np.float64]
    least_damping: float  # damping ratio at small strains
    # Strain from which that body slips, and its cap over G
    body_strain: float
    body_cap: float
    # Between strains of 0.001 and 1 %, as far as the curves go: largest relative error of the
    # modulus, and largest error of the damping ratio (0 by Masing's rules, where it follows
    # from the modulus)
    misfit: tuple[float, float]

    @classmethod
    def of(
        cls,
        curves: SoilCurves,
        branches: int = 40,
        damping_curve: str = "target",
        least_damping: float | None = None,
        reference_frequency: float = 1.0,
    ) -> "Branches":
        """Fit branches to the curves of a soil.

        Parameters
        ----------
        curves : SoilCurves
        branches : int
            2 … 200; the misfit decreases with their number.
        damping_curve : {'target', 'masing'}
            The damping ratio of the curves, or the one of Masing's rules from their moduli.
        least_damping : float, optional
            Damping ratio at small strains; default: the least of the curves, with Masing's rules 0.
        reference_frequency : float
            Hz; frequency at which the modulus is the given one.
        """
        one_of("damping_curve", damping_curve, DAMPING_CURVES)
        if not 2 <= int(branches) <= 200:
            raise InputError(f"branches must be in 2 … 200, got {branches!r}")
        if least_damping is None:
            least_damping = float(curves.damping[0]) if damping_curve == "target" else 0.0
        ratio = float(not_negative("least_damping", least_damping))
        reference = float(positive("reference_frequency", reference_frequency))
        soil = curves.strain, curves.reduction, curves.damping
        fitted, numbers = checked(api.soil_branches, *soil, damping_curve == "masing", ratio,
                                  reference, int(branches))  # fmt: skip
        strain, modulus_of, slipping = fitted.T
        body_strain, body_cap, modulus, damping = map(float, numbers)
        misfit = (modulus, damping)
        return cls(strain, modulus_of, slipping, ratio, body_strain, body_cap, misfit)

    @classmethod
    def of_material(cls, material: Mapping, shear_modulus: float) -> "Branches | None":
        """Return the branches of blocks of a group &material; None if it is linear."""
        if material.get("law") != "hysteretic":
            return None
        return cls.of(
            curves_of(material, shear_modulus), material.get("branches", 30),
            material.get("damping_curve", "target"), material.get("damping_ratio"),
            material.get("reference_frequency", 1.0),
        )  # fmt: skip

    def curves(self) -> SoilCurves:
        """Return the modulus reduction and damping curves of the branches."""
        strain = np.minimum(STRAINS, self.strain[-1])
        strain = strain[: np.searchsorted(STRAINS, self.strain[-1]) + 1]
        moduli = np.minimum(1.0, self.reduction_at(strain))
        return SoilCurves(strain, moduli, self.damping_at(strain), "branches")

    def reduction_at(self, strain: ArrayLike) -> NDArray[np.float64]:
        """Return G/G_max of the branches at shear strains above 0."""
        gamma = positive("strain", strain)[..., None]
        branches = np.sum(self.modulus * np.minimum(1.0, self.strain / gamma), -1)
        gamma = gamma[..., 0]
        return branches + (1 - self.modulus.sum()) * np.minimum(gamma, self.body_strain) / gamma

    def damping_at(self, strain: ArrayLike) -> NDArray[np.float64]:
        """Return the damping ratio of closed loops of the branches, with that of small strains."""
        gamma = positive("strain", strain)[..., None]
        slipped = self.slipping * self.modulus * self.strain * np.maximum(gamma - self.strain, 0.0)
        gamma, damping = gamma[..., 0], self.least_damping
        loss = 2 * np.sum(slipped, -1) + np.pi * damping * np.minimum(gamma, self.body_strain) ** 2
        if damping:
            loss = loss + 2 * self.body_cap * np.maximum(gamma - self.body_strain, 0.0)
        return loss / (np.pi * gamma**2 * self.reduction_at(strain))
