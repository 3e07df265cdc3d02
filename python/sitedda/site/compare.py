# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare linear, equivalent-linear and nonlinear analyses of a site."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .branches import Branches
from .column import Column
from .curves import SoilCurves
from .equivalent_linear import EquivalentLinear, equivalent_linear, small_strain_column
from .motion import Motion
from .nonlinear import NonlinearResponse, nonlinear
from .response import ColumnResponse, SiteResponse

_PERIODS = (0.1, 0.2, 0.5, 1.0)  # s, of the table


@dataclass(frozen=True)
class Analyses:
    """The results of three analyses of a site.

    Attributes
    ----------
    linear : ColumnResponse
    fitted : EquivalentLinear
    nonlinear : NonlinearResponse
    """

    linear: ColumnResponse
    fitted: EquivalentLinear
    nonlinear: NonlinearResponse

    @property
    def responses(self) -> dict[str, SiteResponse]:
        """Return the responses by the names of their analyses.

        The unbounded response of a linear column without damping on a rigid base is omitted.
        """
        found = {
            "linear": self.linear,
            "equivalent-linear": self.fitted.response,
            "nonlinear": self.nonlinear,
        }
        if self.unbounded:
            del found["linear"]
        return found

    @property
    def unbounded(self) -> str:
        """Return why the linear response is unbounded; '' if it is bounded."""
        column = self.linear.column
        if column.base != "rigid" or any(layer.damping_at([1.0])[0] for layer in column.layers):
            return ""
        return (
            "the linear column is omitted: without damping on a rigid base its resonance is "
            "infinite; give its soils a damping ratio at small strains"
        )

    def __str__(self) -> str:
        responses = self.responses
        lines = [f"{'':24s}" + "".join(f"{name:>19s}" for name in responses)]

        def row(name, values, unit):
            lines.append(f"{name:24s}" + "".join(f"{v:19.4g}" for v in values) + f" {unit}")

        parts = list(responses.values())
        row("surface PGA", [np.abs(r.acceleration()).max() for r in parts], "m/s²")
        for period in _PERIODS:
            row(f"surface Sa({period:g} s)", [r.spectrum([period])[0] for r in parts], "m/s²")
        profiles = [r.profile() for r in parts]
        row("largest shear strain", [100 * float(p.strain.max()) for p in profiles], "%")
        row("largest shear stress", [float(p.stress.max()) / 1e3 for p in profiles], "kPa")
        said = list(filter(None, [self.unbounded, self.fitted.doubt]))
        return "\n".join([self.nonlinear.words, *lines, *said, "", str(self.nonlinear)])

    def plot(self):
        """Draw spectra, profiles and loops side by side; return the figure."""
        from .picture import analyses_figure

        return analyses_figure(self)


def analyses(
    column: Column,
    curves: Sequence[SoilCurves | Branches | None],
    motion,
    time_step: float | None = None,
    *,
    kind: str = "outcrop",
    **options,
) -> Analyses:
    """Compute the linear, equivalent-linear and nonlinear response of a site.

    Parameters
    ----------
    column, curves, motion, time_step, kind
        As for :func:`nonlinear`; the linear column has the least damping ratios of the curves, and
        the equivalent-linear one the curves that given branches have.
    **options
        Of :func:`nonlinear`.

    Raises
    ------
    ValueError
        If an argument is out of range.
    ConvergenceError
        If an iteration or a step does not converge.
    """
    ground = motion if isinstance(motion, Motion) else Motion.of(motion, time_step)
    tables = [one.curves() if isinstance(one, Branches) else one for one in curves]
    fitted = equivalent_linear(column, tables, ground, kind=kind)
    found = nonlinear(column, curves, ground, kind=kind, **options)
    linear = ColumnResponse.of(small_strain_column(column, tables), ground, kind=kind)
    return Analyses(linear, fitted, found)
