# SPDX-License-Identifier: GPL-3.0-or-later
"""Compute many motions in many columns by several analyses: medians and their scatter."""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.errors import InputError
from ..base.numbers import counted
from ..engine.records import read_record
from ..engine.signals import spectral_acceleration
from ..study.api import study
from ..study.records import Record, Records
from ..study.store import checksum
from ..study.table import counts
from .column import Column
from .equivalent_linear import DOUBTFUL_STRAIN, equivalent_linear, small_strain_column
from .motion import Motion
from .nonlinear import CONVERGED, NonlinearResponse, nonlinear
from .profile import Profile
from .randomization import Site
from .response import SiteResponse

if TYPE_CHECKING:
    import xarray as xr

ANALYSES = ("linear", "equivalent-linear", "nonlinear")
PERIODS = np.geomspace(0.05, 5.0, 20)  # s
_DIMS = ("profile", "motion")  # dimensions of the statistics


@dataclass(frozen=True)
class Suite:
    """The response of columns to motions.

    Attributes
    ----------
    table : xarray.Dataset
        Over ``profile``, ``motion``, ``level`` and ``analysis``: ``sa`` (surface, m/s²),
        ``amplification`` (its ratio to ``reference``, Sa of the motion) and ``converged`` (1 or 0)
        over ``period`` too; ``pga`` (surface, m/s²), ``strain`` (largest), ``status``, ``message``.
    """

    table: xr.Dataset

    @property
    def statistics(self) -> xr.Dataset:
        """Return statistics of successful cases over ``analysis``, ``level``, ``period``.

        ``median`` (exp of the mean logarithm) and ``sigma_ln`` of the amplification, ``sa_median``
        and ``sa_sigma_ln`` of Sa of the surface, the number ``count`` of cases, and the fraction
        ``converged`` of these.
        """
        import xarray as xr

        results = {"count": self.table.amplification.notnull().sum(_DIMS)}
        for prefix, quantity in (("", "amplification"), ("sa_", "sa")):
            logarithm = np.log(self.table[quantity])
            results[f"{prefix}median"] = np.exp(logarithm.mean(_DIMS))
            spread = logarithm.std(_DIMS, ddof=1) if results["count"].max() > 1 else np.nan
            results[f"{prefix}sigma_ln"] = spread + 0 * results[f"{prefix}median"]
        results["converged"] = self.table.converged.mean(_DIMS)
        results["sa_median"].attrs["units"] = "m/s^2"
        return xr.Dataset(results).transpose("analysis", "level", "period")

    def __str__(self) -> str:
        states = ", ".join(f"{n} {status}" for status, n in sorted(counts(self.table).items()))
        sizes = self.table.sizes
        lines = [
            f"{counted(sizes['profile'], 'profile', 'profiles')}, "
            f"{counted(sizes['motion'], 'motion', 'motions')}: {states}"
        ]
        for analysis, level, part in self.parts():
            lines += [f"{analysis}, {level}" if sizes["level"] > 1 else analysis]
            heads, *rows = self.rows_of(part)
            for row in (heads, *rows):
                lines.append("".join(f"{cell:>{max(11, len(name) + 2)}}"
                                     for cell, name in zip(row, heads, strict=True)))  # fmt: skip
        return "\n".join([*lines, *self.doubts])

    @property
    def doubts(self) -> list[str]:
        """Return warnings about the results, one sentence each."""
        texts = []
        messages = self.table.message.values[self.table.status.values != "complete"]
        if messages.size:
            texts.append(f"{counted(messages.size, 'case', 'cases')} failed and are excluded; "
                         f"first message: {messages[0]}")  # fmt: skip
        if "equivalent-linear" in self.table.analysis.values:
            strain = self.table.strain.sel(analysis="equivalent-linear").values
            doubtful, total = int((strain > DOUBTFUL_STRAIN).sum()), int(np.isfinite(strain).sum())
            if doubtful:
                texts.append(f"{doubtful} of {total} equivalent-linear cases have strains beyond "
                             f"{100 * DOUBTFUL_STRAIN:g} %, so they may not be accurate: "
                             "compare with nonlinear cases")  # fmt: skip
        for analysis, level, part in self.parts():
            periods = part.period.values[part.converged.values < 0.9]
            if periods.size:
                texts.append(f"{analysis}, {level}: more than a tenth of the cases do not converge "
                             "at periods of " + ", ".join(f"{p:.3g}" for p in periods)
                             + " s")  # fmt: skip
        return texts

    def parts(self):
        """Yield analysis, level in words, and statistics of each."""
        statistics, attributes = self.statistics, self.table.level.attrs
        unit = attributes.get("units", "").removeprefix("1")  # factors have none
        for analysis in self.table.analysis.values:
            for i, level in enumerate(self.table.level.values):
                label = f"{attributes.get('measure', 'scale')} {level:g} {unit}"
                part = statistics.sel(analysis=analysis).isel(level=i)
                yield str(analysis), label.strip(), part

    @staticmethod
    def rows_of(part: xr.Dataset) -> list[list[str]]:
        """Return heads and texts of the statistics of an analysis and a level, a row a period."""
        names = ("period", "median", "sigma_ln", "sa_median", "sa_sigma_ln", "count", "converged")
        values = zip(*(part[name].values for name in names), strict=True)
        return [
            ["period (s)", "median ratio", "σ_ln", "median Sa (m/s²)", "σ_ln of Sa", "N",
             "converged"],
            *([f"{period:.4g}", f"{median:.4g}", f"{sigma:.3f}", f"{sa:.4g}", f"{sa_sigma:.3f}",
               f"{count:d}", f"{100 * converged:.0f} %"]
              for period, median, sigma, sa, sa_sigma, count, converged in values),
        ]  # fmt: skip

    def to_netcdf(self, file) -> Path:
        """Write the table and its statistics to a netCDF file."""
        from ..base.files import written

        table = self.table.merge(self.statistics.rename(converged="converged_share"))
        with written(Path(file), "a netCDF file") as path:
            table.to_netcdf(path, engine="netcdf4")
        return Path(file)

    def to_csv(self, file) -> Path:
        """Write the statistics to a CSV file, a row for each analysis, level and period."""
        from ..base.files import write

        names = ["median", "sigma_ln", "count", "converged", "sa_median", "sa_sigma_ln"]
        rows = self.statistics.to_dataframe(["analysis", "level", "period"])[names]
        text = rows.astype(float).reset_index().rename(columns={"period": "period_s"}).to_csv(
            index=False, float_format="%.6g", na_rep="nan")  # fmt: skip
        return write(Path(file), text, "a table")

    def plot(self, level: int = 0):
        """Draw the cases, the median and ± σ of a level; return the figure."""
        from .suite_report import suite_figure

        return suite_figure(self, level)

    def write_page(self, file) -> Path:
        """Write an HTML page with figures, tables and warnings."""
        from .suite_report import write_suite_page

        return write_suite_page(self, file)


def suite(
    profiles: Profile | Sequence[Site],
    motions: Sequence | Mapping,
    analyses: Sequence[str] = ANALYSES,
    *,
    periods: ArrayLike = PERIODS,
    levels: Sequence[float] = (1.0,),
    measure: str = "scale",
    period: float | None = None,
    kind: str = "outcrop",
    folder=None,
    workers: int | None = None,
    retry: bool = False,
    progress: bool = False,
    **options,
) -> Suite:
    """Compute the response of columns to motions by several analyses, on all processors.

    Parameters
    ----------
    profiles : Profile, or sequence of (Column, curves)
        Such as those of :func:`randomized`; curves as for :func:`nonlinear`.
    motions : sequence of path or xarray.Dataset, or mapping of these by name
    analyses : sequence of {'linear', 'equivalent-linear', 'nonlinear'}
    periods : array_like, shape (n,)
        s.
    levels : sequence of float
        Levels to which each motion is scaled.
    measure : {'scale', 'pga', 'pgv', 'sa', 'arias'}
        Kind of level: a factor, or a measure of the motion, in m and s.
    period : float, optional
        Period of the measure 'sa', s.
    kind : {'outcrop', 'within'}
        Kind of motions.
    folder : path, optional
        Folder of the cases; existing ones are not computed again.
    workers : int, optional
        Processes.
    retry : bool
        Repeat failed cases.
    progress : bool
        Show a progress bar.
    **options
        Options of :func:`nonlinear`.

    Raises
    ------
    InterruptedRun
        If the suite was stopped; a call with the same folder continues.
    """
    import xarray as xr

    sites = _check_sites(profiles)
    records = _read_motions(motions, levels, measure, period)
    names = list(analyses)
    if not names or not set(names) <= set(ANALYSES):
        raise InputError(f"analyses = {names}: use {', '.join(ANALYSES)}")
    grid = np.asarray(periods, dtype=float)
    if grid.ndim != 1 or not grid.size or not np.all(np.isfinite(grid) & (grid > 0)):
        raise InputError("periods must be a row of numbers above 0, s")
    cases = Cases(sites, records, grid, kind, options)
    rows, columns = records.factors.shape
    axes = {"profile": range(len(sites)), "motion": range(rows), "level": range(columns),
            "analysis": names}  # fmt: skip
    table = study(cases, axes, folder=folder, workers=workers, retry=retry, progress=progress)
    if not {"sa", "strain"} <= set(table.data_vars):
        raise InputError(f"no case succeeds; first message: {table.message.values.ravel()[0]}")
    _, values, attributes = records.coordinates[measure]
    level = ("level", values, {"measure": measure} | attributes)
    table = table.assign_coords(motion=records.coordinates["record"][1], level=level)
    reference = np.array([spectral_acceleration(record.acceleration, record.time_step, grid)
                          for record in records.records])  # fmt: skip
    table["reference"] = xr.DataArray(
        reference[:, None] * records.factors[..., None], dims=("motion", "level", "period"),
        attrs={"units": "m/s^2"},
    )  # fmt: skip
    table["amplification"] = table.sa / table.reference
    return Suite(table)


@dataclass(frozen=True)
class Cases:
    """The results of each profile, motion, level and analysis."""

    sites: list[Site]
    records: Records
    periods: NDArray[np.float64]  # s
    kind: str
    options: dict  # of `nonlinear`

    def __str__(self) -> str:
        """Return a unique name of the set of cases."""
        return f"Cases_{checksum(pickle.dumps(self))}"

    def __call__(self, profile: int, motion: int, level: int, analysis: str) -> dict:
        """Compute Sa of the surface over periods, convergence flags, PGA and largest strain."""
        import xarray as xr

        column, curves = self.sites[profile]
        record, factor = self.records.records[motion], float(self.records.factors[motion, level])
        ground = Motion.of(factor * record.acceleration, record.time_step)
        response = self._compute_response(analysis, column, curves, ground)
        spectrum, surface = response.spectrum(self.periods), response.acceleration()
        converged = np.ones(self.periods.size)
        if isinstance(response, NonlinearResponse):
            coarse = response.coarse_spectrum(self.periods)
            agrees = np.abs(coarse - spectrum) <= CONVERGED * spectrum
            converged = np.where(np.isnan(coarse), np.nan, agrees)
        coordinates = {"period": self.periods}
        return {
            "sa": xr.DataArray(spectrum, coordinates, ("period",), attrs={"units": "m/s^2"}),
            "converged": xr.DataArray(converged, coordinates, ("period",)),
            "pga": float(np.abs(surface).max()),
            "strain": response.largest[0],
        }

    def _compute_response(self, analysis, column, curves, ground) -> SiteResponse:
        """Return the response of a column by an analysis."""
        if analysis == "linear":
            return small_strain_column(column, curves).response(ground, kind=self.kind)
        if analysis == "equivalent-linear":
            return equivalent_linear(column, curves, ground, kind=self.kind).response
        return nonlinear(column, curves, ground, kind=self.kind, **self.options)


def _check_sites(profiles) -> list[Site]:
    if isinstance(profiles, Profile):
        return [(profiles.column(), profiles.curves())]
    sites = list(profiles)
    if not sites:
        raise InputError("profiles: give at least one")
    for number, site in enumerate(sites):
        if not (isinstance(site, tuple) and len(site) == 2 and isinstance(site[0], Column)):
            raise InputError(f"profile {number}: give a pair of a Column and the curves of its "
                             "layers, or make every entry a Profile")  # fmt: skip
        if len(site[1]) != len(site[0].layers):
            raise InputError(f"profile {number}: {len(site[0].layers)} layers need one curve each, "
                             f"not {len(site[1])}")  # fmt: skip
    return sites


def _read_motions(motions, levels, measure: str, period) -> Records:
    """Return motions, their names, and their factors at the levels."""
    if isinstance(motions, Mapping):
        named = [(str(name), motion) for name, motion in motions.items()]
    else:
        named = [(_motion_name(motion, i), motion) for i, motion in enumerate(motions, 1)]
    records = []
    for name, motion in named:
        ground = Motion.of(motion if hasattr(motion, "acceleration") else read_record(motion))
        records.append(Record(name, ground.acceleration, ground.time_step))
    return Records(records, np.ravel(levels), measure, period=period)


def _motion_name(motion, number: int) -> str:
    if hasattr(motion, "attrs"):
        return Path(motion.attrs.get("file", f"motion {number}")).stem
    return f"motion {number}" if isinstance(motion, Motion) else Path(motion).stem
