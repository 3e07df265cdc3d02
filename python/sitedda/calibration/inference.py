# SPDX-License-Identifier: GPL-3.0-or-later
"""Estimate unknown stiffnesses of a model and their errors from measured modes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from scipy.special import softmax

from ..base.arguments import COUNT, NOT_NEGATIVE, positive
from ..base.errors import InputError
from ..base.numbers import number
from ..engine.checking import Modes, matrices, modes
from ..input.changes import merged
from .family import family_of
from .measured import BAND, Observations, measured_modes, shapes_of
from .posterior import Posterior

SAMPLERS = ("laplace", "ensemble")
_DISCREPANCY = (0.02, 1.0)  # prior of an unknown discrepancy: median, deviation of its logarithm
_EXACT = 1e-5  # relative error of frequencies by the reduction at which its basis is complete
_LINEAR_TOLERANCE = 1e-3  # relative difference of frequencies of family and model
_TRIALS = 12  # largest number of values at which the contacts that gravity closes are found
_REFERENCE = {"control.settle": False}  # change after which all touching contacts are closed
_ROUNDS = 6  # largest number of bases
# Limits of warnings: misfit / deviation, range / prior range, correlation, effective fraction.
_LARGE_MISFIT, _WIDE, _CORRELATED, _FEW = 2.0, 0.8, 0.9, 0.2
SILENT = ("small vibrations do not determine friction, cohesion, tensile strength and joint "
          "opening: their uncertainty is unchanged")  # fmt: skip


@dataclass(frozen=True)
class Calibration:
    """Unknown stiffnesses with their uncertainty given measured modes.

    Attributes
    ----------
    unknowns : DataFrame
        By name: ``best`` (most probable), ``median``, ``low`` and ``high`` (middle 90 %),
        ``prior_low`` and ``prior_high`` (of the prior), and ``deviation`` of the logarithm.
    measured : DataFrame
        See `sitedda.calibration.measured_modes`.
    fit : DataFrame
        By measured mode: ``number`` of the model's mode, from 1; ``frequency`` of the best model,
        and ``low`` and ``high`` (middle 90 % of the samples), Hz; ``misfit``, ln(measured f /
        best f) divided by the deviation due to error and discrepancy; ``mac``, the modal assurance
        criterion of the shape (NaN if no shape was measured).
    modes : Modes
        Modes of the best model.
    samples : DataFrame
        Samples of the posterior, with a column for each unknown.
    discrepancy : float
        Relative error of the model's own frequencies: given, or its median if it was unknown.
    evidence, evidence_error : float
        ln of the probability of the measured modes under this model and its priors, and its
        standard error.
    reduction_error : float
        Largest relative error of frequencies by the reduced basis, up to 2 σ from the peaks.
    doubts : tuple of str
        Warnings on modes that do not fit, and on unknowns that the modes do not determine.
    """

    unknowns: pd.DataFrame
    measured: pd.DataFrame
    fit: pd.DataFrame
    modes: Modes
    samples: pd.DataFrame
    discrepancy: float
    evidence: float
    evidence_error: float
    reduction_error: float
    doubts: tuple[str, ...] = ()

    def __str__(self) -> str:
        """Return the unknowns, the modes and the warnings, one line each."""
        lines = [
            f"{name} = {row['median']} ({row.low} to {row.high}; prior {row.prior_low} to "
            f"{row.prior_high})" for name, row in self.unknowns.map(number).iterrows()
        ]  # fmt: skip
        lines += self.mode_words()
        lines.append(f"ln evidence = {self.evidence:.2f} ± {self.evidence_error:.2f}, with a "
                     f"model discrepancy of {100 * self.discrepancy:.2g} %")  # fmt: skip
        return "\n".join([*lines, *(f"note: {warning}" for warning in self.doubts)])

    def mode_words(self) -> list[str]:
        """Compare each measured mode with that of the model, one line each."""
        lines = []
        pairs = zip(self.measured.itertuples(), self.fit.itertuples(), strict=True)
        for row, fit in pairs:
            text = (f"mode {fit.number}: {number(row.frequency)} ± {row.deviation:.2g} Hz "
                     f"measured, {number(fit.frequency)} Hz computed")  # fmt: skip
            if np.isfinite(fit.mac):
                text += f", MAC {fit.mac:.2f}"
            if np.isfinite(row.damping):
                computed = self.modes.damping[fit.number - 1]
                text += f", damping {100 * row.damping:.2g} % (computed {100 * computed:.2g} %)"
            lines.append(text)
        return lines

    def to_csv(self) -> str:
        """Return the samples as CSV, one column per unknown, for ``[sample] file`` of a study."""
        return "# written by sitedda\n" + self.samples.to_csv(index=False, float_format="%.10g")

    def points(self, name: str = "sample"):
        """Return the samples as an axis of `sitedda.study` (`sitedda.study.Points`)."""
        from ..study import Points

        return Points(name, {column: self.samples[column].to_numpy() for column in self.samples})


def calibrate(
    model,
    measured,
    unknowns: Mapping,
    *,
    discrepancy: float | None = 0.02,
    sampler: str = "laplace",
    samples: int = 1000,
    seed: int = 0,
    contacts: str = "auto",
    changes: Mapping | None = None,
    **variables,
) -> Calibration:
    """Find unknown stiffnesses of a model from measured modes.

    Parameters
    ----------
    model : path or Model
    measured : path, DataFrame or mapping of sequences
        See `sitedda.calibration.measured_modes`.  The first is the model's first mode and so on,
        unless a number or a shape says otherwise.
    unknowns : mapping of (float, float)
        The range of each unknown that contains 90 % of its log-normal prior.
        Names are those of changes: ``{"contact.normal_stiffness": (5e7, 1e9)}``.  The stiffness
        must be linear in them.
    discrepancy : float or None
        Relative error of the model's frequencies; None: an unknown, about 2 %.
    sampler : 'laplace' or 'ensemble'
        Importance sampling from t distributions about the peaks of the posterior; or `emcee`.
    samples : int
        Number of samples.
    seed : int
        Seed of the samples.
    contacts, changes, **variables
        See `sitedda.modes`.

    Returns
    -------
    Calibration

    Raises
    ------
    InputError
        If an unknown changes no stiffness, a range is empty, or the model has no such point.
    ConvergenceError
        If the sampler does not converge.
    """
    if sampler not in SAMPLERS:
        raise InputError(f"sampler = {sampler!r}: use one of {', '.join(SAMPLERS)}")
    samples = int(COUNT.check("samples", samples))
    prior = _check_priors(unknowns)
    data = measured_modes(measured)
    changes = merged(changes, variables)
    mean, deviation = np.log(prior).mean(1), np.ptp(np.log(prior), axis=1) / (2 * BAND)
    centre = dict(zip(unknowns, np.exp(mean).tolist(), strict=True))
    *_, points = matrices(model, contacts, changes | centre)
    observations = Observations(data, points)
    if discrepancy is None:
        mean = np.append(mean, np.log(_DISCREPANCY[0]))
        deviation = np.append(deviation, _DISCREPANCY[1])
    else:
        NOT_NEGATIVE.check("discrepancy", discrepancy)
    count = len(prior)
    terms = observations, mean, deviation, discrepancy
    fit = _fit_contacts(model, tuple(unknowns), terms, seed, contacts, changes)
    posterior, peaks, error, best, contact_warnings = fit
    peak = peaks[0][0]
    draws, weights, evidence, sigma, effective_fraction = posterior.draw_weighted(peaks, seed)
    chosen = draws[np.random.default_rng(seed).choice(len(draws), samples, p=weights)]
    if sampler == "ensemble":
        draws = chosen = posterior.draw_samples(chosen, samples, seed)
        weights = None
    values = pd.DataFrame(posterior.values(chosen)[:, :count], columns=list(unknowns))
    low, median, high = np.quantile(posterior.values(draws)[:, :count], (0.05, 0.5, 0.95), axis=0,
                                    method="inverted_cdf", weights=weights)  # fmt: skip
    table = pd.DataFrame(
        {"best": posterior.values(peak)[:count], "median": median, "low": low, "high": high,
         "prior_low": prior[:, 0], "prior_high": prior[:, 1],
         "deviation": np.log(values).std(ddof=0)}, list(unknowns),
    )  # fmt: skip
    level = float(np.median(posterior.discrepancies(chosen)))
    fit = _compare_modes(posterior, peak, chosen, level)
    result = Calibration(table, data, fit, best, values, level, evidence, sigma, error)
    warnings = _find_warnings(result, peak, deviation)
    if effective_fraction < _FEW and sampler == "laplace":
        warnings.append("the posterior is not Gaussian, and ranges may be too narrow: use the "
                      "sampler 'ensemble', or fewer unknowns")  # fmt: skip
    return replace(result, doubts=(*contact_warnings, *warnings, SILENT))


def _compare_modes(posterior: Posterior, peak, chosen, level: float) -> pd.DataFrame:
    """Compare measured modes with those of the best model and of the samples."""
    squares, y, numbers = posterior.solve_modes(np.vstack([peak, chosen]), shapes=False)
    frequencies = np.sqrt(np.take_along_axis(squares, numbers, 1)) / (2 * np.pi)
    low, high = np.percentile(frequencies[1:], (5, 95), axis=0)
    observed = posterior.seen
    misfit = np.log(observed.table.frequency / frequencies[0]) / np.hypot(observed.error, level)
    macs = [posterior.macs(y[0], j)[numbers[0, j]] if shape.size else np.nan
            for j, shape in enumerate(observed.shapes)]  # fmt: skip
    return pd.DataFrame({"number": numbers[0] + 1, "frequency": frequencies[0], "low": low,
                         "high": high, "misfit": misfit, "mac": macs})  # fmt: skip


def _fit_contacts(model, unknowns, terms, seed, contacts, changes) -> tuple:
    """Move the centre of the family until its contacts are those that close in its best model.

    Steps are at most one prior deviation; a step is halved where the family is not linear. If it
    is not linear at the centre of the priors, all touching contacts are assumed closed.

    Result: as of `_find_peaks`, modes of the best model, and a warning if the frequencies of the
    family and of the best model differ.
    """
    _, mean, deviation, _ = terms
    z, step, assumption = 0 * mean, 0 * mean, ""
    for trial in range(_TRIALS):
        centre = np.exp(mean + (z + step) * deviation)
        values = dict(zip(unknowns, centre.tolist(), strict=False))
        try:
            family = family_of(model, values, contacts, changes)
        except InputError:  # for example, any change opens or closes a contact without force
            if contacts != "auto":
                raise
            if trial:
                step /= 2
                continue
            family = family_of(model, values, "closed", changes | _REFERENCE)
            assumption = ": all touching contacts are assumed closed"
        z = z + step
        posterior, peaks, error = _find_peaks(Posterior(family, *terms), seed)
        peak = peaks[0][0]
        best_values = dict(zip(unknowns, posterior.values(peak).tolist(), strict=False))
        squares, _, (numbers,) = posterior.solve_modes(peak[None])
        frequency = np.sqrt(squares[0, numbers]) / (2 * np.pi)
        result = modes(model, int(numbers.max()) + 1, contacts, changes | best_values)
        change = float(abs(result.frequency[numbers] / frequency - 1).max())
        if change < _LINEAR_TOLERANCE and not assumption:
            return posterior, peaks, error, result, ()
        if assumption:
            break
        step = np.clip(peak - z, -1, 1)
    warning = (f"gravity closes contacts that depend on the unknowns{assumption}. This changes "
            f"frequencies of the best model by up to {100 * change:.2g} %")  # fmt: skip
    return posterior, peaks, error, result, (warning,)


def odds(calibrations: Mapping[str, Calibration]) -> dict[str, float]:
    """Return the probabilities of hypotheses on the same modes, with equal priors.

    Parameters
    ----------
    calibrations : mapping of Calibration
        By the name of the hypothesis; each with its own model or unknowns.
    """
    weights = softmax([calibration.evidence for calibration in calibrations.values()])
    return dict(zip(calibrations, weights.tolist(), strict=True))


def _find_peaks(posterior: Posterior, seed: int) -> tuple[Posterior, list[tuple], float]:
    """Return the posterior in a basis of modes, its peaks with covariances, and the basis error.

    The basis grows by exact modes at the peaks and two standard deviations away, until the
    frequencies there are exact.
    """
    family, count, size = posterior.family, posterior.seen.count, posterior.mean.size

    def solve(z, axes):
        steps = z + np.vstack([0 * z, axes, -axes])
        theta = posterior.values(steps)[:, : len(family.parts)]
        return [(step, *family.modes(t, count + 2)) for step, t in zip(steps, theta, strict=True)]

    initial, peaks = solve(np.zeros(size), BAND * np.eye(size)), []
    posterior.seen.check_count(min(len(squares) for _, squares, _ in initial))
    vectors = [y for *_, y in initial]
    for _ in range(_ROUNDS):
        posterior = replace(posterior, family=family.reduced(np.hstack(vectors)))
        peaks, error = posterior.peaks([z for z, _ in peaks] or posterior.starts(seed)), 0.0
        for z, covariance in peaks:
            for point, squares, y in solve(z, 2 * np.linalg.cholesky(covariance).T):
                reduced = posterior.solve_modes(point[None])[0][0, :count]
                error = max(error, float(np.max(abs(reduced / squares[:count] - 1))) / 2)
                vectors.append(y)
        if error < _EXACT:
            break
    return posterior, peaks, error


def _check_priors(unknowns: Mapping) -> np.ndarray:
    """Return the ranges of the unknowns, shape (unknowns, 2)."""
    if not unknowns or not isinstance(unknowns, Mapping):
        raise InputError("name at least one unknown, such as contact.normal_stiffness, and its "
                         "range")  # fmt: skip
    for name, values in unknowns.items():
        try:
            low, high = positive(name, values)
        except (TypeError, ValueError):
            low = high = 0.0
        if not low < high:
            raise InputError(f"{name}: give a range of two numbers, 0 < low < high, not {values}")
    return np.array(list(unknowns.values()), dtype=float)


def _find_warnings(result: Calibration, peak, deviation) -> list[str]:
    """Return warnings on modes that do not fit and unknowns that are not determined."""
    texts = [
        f"mode {fit.number} cannot be fitted: its measured {number(mode.frequency)} Hz is "
        f"{abs(fit.misfit):.1f} standard deviations from {number(fit.frequency)} Hz of the model"
        for mode, fit in zip(result.measured.itertuples(), result.fit.itertuples(), strict=True)
        if abs(fit.misfit) > _LARGE_MISFIT
    ]
    correlation = np.log(result.samples).corr()
    for i, (name, row) in enumerate(result.unknowns.iterrows()):
        if row.deviation > _WIDE * deviation[i]:
            texts.append(f"the modes do not determine {name}: its range equals its prior range")
        if abs(peak[i]) > _LARGE_MISFIT:
            texts.append(f"the modes are fitted best with {name} outside its prior range")
        texts += [f"only a combination of {name} and {second} is determined (correlation "
                  f"{value:.2f})" for second, value in correlation[name].iloc[:i].items()
                  if abs(value) > _CORRELATED]  # fmt: skip
    if any(shapes_of(result.measured).count(axis=1) == 1):
        texts.append("shapes of one component are not compared, because they fit any mode")
    if result.reduction_error > 100 * _EXACT:
        error = f"{result.reduction_error:.1e}"
        texts.append(f"the reduced model has an error of {error}: narrow the ranges")
    return texts
