# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare linear, equivalent-linear and nonlinear analyses of a site."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..engine.signals import arias_intensity, spectral_acceleration
from .branches import Branches
from .column import Column
from .curves import SoilCurves
from .equivalent_linear import EquivalentLinear, equivalent_linear, small_strain_column
from .motion import Motion
from .nonlinear import PERIODS, NonlinearResponse, nonlinear
from .response import ColumnResponse, SiteResponse


@dataclass(frozen=True)
class Analyses:
    """The results of three analyses of a site."""

    linear: ColumnResponse
    fitted: EquivalentLinear
    nonlinear: NonlinearResponse

    @property
    def responses(self) -> dict[str, SiteResponse]:
        """Return the responses by the names of their analyses.

        The unbounded response of a column without damping is omitted.
        """
        bounded = {name: r for name, r in self._columns.items() if not r.unbounded}
        return {**bounded, "nonlinear": self.nonlinear}

    @property
    def _columns(self) -> dict[str, ColumnResponse]:
        """Return the responses in the frequency domain, bounded or not."""
        return {"linear": self.linear, "equivalent-linear": self.fitted.response}

    @property
    def unbounded(self) -> str:
        """Return which responses are unbounded, and why; '' if none is."""
        reasons = {name: response.unbounded for name, response in self._columns.items()}
        return "\n".join(f"the {name} column is omitted: {reason}"
                         for name, reason in reasons.items() if reason)  # fmt: skip

    def __str__(self) -> str:
        strains, stresses = zip(*(r.largest for r in self.responses.values()), strict=True)
        series = {name: response.acceleration() for name, response in self.responses.items()}
        lines = tabulate_motions(series, self.linear.motion.time_step, [], [
            ("largest shear strain", [100 * strain for strain in strains], "%"),
            ("largest shear stress", [stress / 1e3 for stress in stresses], "kPa"),
        ])  # fmt: skip
        doubt = "" if self.fitted.response.unbounded else self.fitted.doubt
        warnings = list(filter(None, [self.unbounded, doubt]))
        return "\n".join([self.nonlinear.words, *lines, *warnings, "", str(self.nonlinear)])

    def plot(self):
        """Draw spectra, profiles and loops side by side; return the figure."""
        from .picture import analyses_figure

        return analyses_figure(self)


def tabulate_motions(series: Mapping, step: float, first_rows, last_rows) -> list[str]:
    """Return a table of surface accelerations by name: PGA, Arias intensity and Sa.

    Rows before and after these consist of name, values and unit.
    """
    width = max(12, *(len(name) + 2 for name in series))
    spectra = [spectral_acceleration(a, step, PERIODS) for a in series.values()]
    rows = [
        *first_rows,
        ("surface PGA", [np.abs(a).max() for a in series.values()], "m/s²"),
        ("surface Arias intensity", [arias_intensity(a, step) for a in series.values()], "m/s"),
        *((f"surface Sa at {period:g} s", values, "m/s²")
          for period, values in zip(PERIODS, np.transpose(spectra), strict=True)),
        *last_rows,
    ]  # fmt: skip
    heads = "".join(f"{name:>{width}s}" for name in series)
    return [f"{'':28s}{heads}"] + [
        f"{name:28s}{''.join(f'{value:{width}.4g}' for value in values)} {unit}".rstrip()
        for name, values, unit in rows
    ]


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
        As for :func:`nonlinear`; the linear column has the least damping ratios of the curves.  If
        branches are given, the equivalent-linear column has their curves.
    **options
        Options of :func:`nonlinear`.

    Raises
    ------
    ConvergenceError
        If an iteration or a step does not converge.
    """
    ground = Motion.of(motion, time_step)
    tables = [curve.curves() if isinstance(curve, Branches) else curve for curve in curves]
    fitted = equivalent_linear(column, tables, ground, kind=kind)
    stepped = nonlinear(column, curves, ground, kind=kind, **options)
    linear = small_strain_column(column, tables).response(ground, kind=kind)
    return Analyses(linear, fitted, stepped)
