# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve for n parameters such that n results have target values.

The method is least squares within the ranges (trust region reflective: Branch, Coleman and Li 1999,
SIAM Journal on Scientific Computing 21, 1-23), with central differences.  The search starts from
the middle of the ranges, then from points closer to their corners, until a solution is found.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import islice, product

import numpy as np

from ..base.arguments import FINITE
from ..base.errors import InputError
from .trials import Trials, bracket_of

_MOST_STARTS = 9  # largest number of starting points
_STEP = 5e-3  # relative step of the differences of the variables u, which are from 1 to 2
_SOLUTIONS = 40  # largest number of evaluations of a search, differences excluded
_DEPENDENT = 1e-4  # smallest ratio of singular values of the slopes of independent results


@dataclass(frozen=True)
class Roots:
    """The values of n parameters at which n results have their target values.

    Attributes
    ----------
    parameters, results : tuple of str
    target, value, bar, reached : ndarray, shape (n,)
        Target values; values of the parameters and their error bars; results at these values.
        The bars are the last step of the search, plus errors of the results over the slopes.
    slope : ndarray, shape (n, n)
        Derivative of each result (row) with respect to each parameter (column).
    trials : tuple of (tuple, tuple)
        Parameter values and results of all runs, in order.
    doubt : str
        Errors that the bars do not include; empty if there are none.
    """

    parameters: tuple[str, ...]
    results: tuple[str, ...]
    target: np.ndarray
    value: np.ndarray
    bar: np.ndarray
    reached: np.ndarray
    slope: np.ndarray
    trials: tuple = field(repr=False)
    doubt: str = ""

    def __str__(self) -> str:
        """Return a sentence with the values of the parameters and warnings."""
        from ..base.numbers import with_bar

        values = zip(self.parameters, self.value, self.bar, strict=True)
        solution = ", ".join(f"{name} = {with_bar(v, bar)}" for name, v, bar in values)
        pairs = zip(self.results, self.target, strict=True)
        targets = ", ".join(f"{name} = {value:g}" for name, value in pairs)
        text = f"{solution} for {targets} ({len(self.trials)} runs)"
        return text + (f"; {self.doubt}" if self.doubt else "")


def solve_system(
    model, parameters, results, target, between, tolerance, task, estimate_accuracy: bool, changes
) -> Roots:
    """Solve for several parameters; the arguments are those of `solve_for`."""
    lengths = []
    for name, values in (("parameter", parameters), ("result", results), ("target", target),
                         ("between", between)):  # fmt: skip
        if isinstance(values, str) or not isinstance(values, Sequence | np.ndarray):
            raise InputError(f"{name} = {values!r}: give a list, with one value per parameter")
        lengths.append(len(values))
    if len(set(lengths)) > 1 or not lengths[0]:
        raise InputError("parameter, result, target and between must have the same length, not {}, "
                         "{}, {} and {}".format(*lengths))  # fmt: skip
    for name, names in (("parameter", parameters), ("result", results)):
        if len(set(names)) < len(names):
            raise InputError(f"{name} = {list(names)}: a name is repeated")
    targets = np.array([FINITE.check("target", value) for value in target])
    limits = np.array([bracket_of(pair) for pair in between])
    trials = Trials(model, parameters, results, task, changes)
    if len(set(trials.names)) < len(trials.names):
        raise InputError(f"two results have the name {trials.names[0]!r}: rename the functions")
    search = _Search(trials, targets, limits, tolerance)
    value, results_at, slope, step = search.run()
    errors, warning = trials.errors_at(tuple(value.tolist()), estimate_accuracy)
    bar = step + abs(np.linalg.inv(slope)) @ errors
    return Roots(tuple(parameters), tuple(trials.names), targets, value, bar, results_at, slope,
                 tuple(trials.done.items()), warning)  # fmt: skip


class _Search:
    """The search of a root, in variables u from 1 (lower end of a range) to 2 (upper end)."""

    def __init__(self, trials: Trials, targets: np.ndarray, limits: np.ndarray, tolerance: float):
        self.trials, self.aims, self.low, self.width = (trials, targets, limits[:, 0],
                                                        np.ptp(limits, 1))  # fmt: skip
        self.close = tolerance * abs(limits).max(1) / self.width

    def run(self) -> tuple:
        """Return parameters, results, slopes and last step; raise NoRootError if none is found."""
        size, first_slopes, nearest = len(self.aims), None, None
        start_points = [np.full(size, 1.5), *map(np.array, product((1.2, 1.8), repeat=size))]
        for start in islice(start_points, _MOST_STARTS):
            slopes = self._fit_parameters(start, 1.0, 1).jac
            first_slopes = slopes if first_slopes is None else first_slopes
            if not _are_independent(slopes):
                continue  # the results may be independent at another starting point
            scale = np.linalg.norm(slopes, axis=1)
            solution = self._fit_parameters(start, scale, _SOLUTIONS)
            slopes, gap = solution.jac * scale[:, None], solution.fun * scale
            step = abs(np.linalg.lstsq(slopes, gap, rcond=None)[0])
            if _are_independent(slopes) and np.all(step <= self.close):
                values = self._parameter_values(solution.x)
                return values, gap + self.aims, slopes / self.width, step * self.width
            if nearest is None or solution.cost < nearest.cost:
                nearest = solution
        raise self._no_root_error(nearest.x) if nearest else self._dependence_error(first_slopes)

    def _fit_parameters(self, start: np.ndarray, scale, evaluations: int):
        """Return the least-squares fit of misfits / `scale`, from a starting point."""
        from scipy.optimize import least_squares

        return least_squares(
            lambda u: self._misfit(u) / scale, start, "3-point", (1.0, 2.0), diff_step=_STEP,
            ftol=None, gtol=None, xtol=1e-2 * self.close.min(), max_nfev=evaluations,
        )  # fmt: skip

    def _parameter_values(self, u: np.ndarray) -> np.ndarray:
        return self.low + (u - 1) * self.width

    def _misfit(self, u: np.ndarray) -> np.ndarray:
        """Return the differences of the results from their targets, shape (n,)."""
        return np.array(self.trials.results(tuple(self._parameter_values(u).tolist()))) - self.aims

    def _dependence_error(self, slopes: np.ndarray):
        """Return the error for results that do not depend independently on the parameters."""
        causes = ((self.trials.parameters, "changes none of the results"),
                 (self.trials.names, "depends on none of the parameters"))  # fmt: skip
        for axis, (names, text) in enumerate(causes):
            has_effect = slopes.any(axis)
            if not has_effect.all():
                return self.trials.failure("flat", f"{names[int(np.argmin(has_effect))]} {text}")
        names = " and ".join(self.trials.names)
        return self.trials.failure("dependent", f"{names} do not change independently with "
                                   f"{' and '.join(self.trials.parameters)}")  # fmt: skip

    def _no_root_error(self, u: np.ndarray):
        """Return the error that no solution was found; u are the best parameters."""
        values = zip(self.trials.parameters, self._parameter_values(u), strict=True)
        point = ", ".join(f"{name} = {value:.6g}" for name, value in values)
        results = zip(self.trials.names, self._misfit(u) + self.aims, self.aims, strict=True)
        listing = ", ".join(f"{name} = {value:.6g} (target {target:g})"
                            for name, value, target in results)  # fmt: skip
        count = len(self.trials.done)
        return self.trials.failure("outside", f"none found within the ranges ({count} runs); "
                                   f"the closest is {point}, with {listing}")  # fmt: skip


def _are_independent(slopes: np.ndarray) -> bool:
    """Return whether the matrix of slopes (results, parameters) is well-conditioned."""
    for axis in (1, 0):
        size = np.linalg.norm(slopes, axis=axis, keepdims=True)
        if not size.all():
            return False
        slopes = slopes / size
    return np.linalg.cond(slopes) < 1 / _DEPENDENT
