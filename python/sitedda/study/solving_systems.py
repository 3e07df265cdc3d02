# SPDX-License-Identifier: GPL-3.0-or-later
"""Find values of several parameters at which as many results have target values.

Least squares within the ranges (trust region reflective: Branch, Coleman and Li 1999, SIAM Journal
on Scientific Computing 21, 1-23), with differences of second order; from the middle of the ranges,
then from points closer to their corners, until all results have their targets.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import islice, product

import numpy as np

from ..base.arguments import FINITE
from ..base.errors import InputError
from .trials import Trials, bracket_of

_STARTS = 9  # largest number of starting points
_STEP = 5e-3  # step of differences, over the range once to twice that
_SOLUTIONS = 40  # largest number of evaluations of a search, without differences
_DEPENDENT = 1e-4  # smallest ratio of singular values of the slopes that is not error


@dataclass(frozen=True)
class Roots:
    """The values of several parameters at which as many results have their target values.

    Attributes
    ----------
    parameters, results : tuple of str
    target, value, bar, reached : ndarray, shape (n,)
        Targets; values of the parameters, each taken to lie within its bar; the results there.
        Bars are the last step of the search and errors of the results over the slopes.
    slope : ndarray, shape (n, n)
        Change of each result (row) with each parameter.
    trials : tuple of (tuple, tuple)
        Values that were tried, and the results, in order.
    doubt : str
        Errors that the bars omit; empty if there are none.
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
        """Return the roots in one sentence, with warnings."""
        from ..base.numbers import with_bar

        values = zip(self.parameters, self.value, self.bar, strict=True)
        found = ", ".join(f"{name} = {with_bar(v, bar)}" for name, v, bar in values)
        wanted = zip(self.results, self.target, strict=True)
        words = ", ".join(f"{name} = {value:g}" for name, value in wanted)
        words = f"{found} for {words} ({len(self.trials)} runs)"
        return words + (f"; {self.doubt}" if self.doubt else "")


def solve_system(
    model, parameters, results, target, between, tolerance: float, task, accuracy: bool, changes
) -> Roots:
    """Solve for several parameters; the arguments are those of `solve_for`."""
    lengths = []
    for name, values in (("parameter", parameters), ("result", results), ("target", target),
                         ("between", between)):  # fmt: skip
        if isinstance(values, str) or not isinstance(values, Sequence | np.ndarray):
            raise InputError(f"{name} = {values!r}: give a list, with one value per parameter")
        lengths.append(len(values))
    if len(set(lengths)) > 1 or not lengths[0]:
        raise InputError("give as many parameters as results, targets and ranges, not {}, {}, {} "
                         "and {}".format(*lengths))  # fmt: skip
    for name, names in (("parameter", parameters), ("result", results)):
        if len(set(names)) < len(names):
            raise InputError(f"{name} = {list(names)}: a name is repeated")
    aims = np.array([FINITE.check("target", value) for value in target])
    ends = np.array([bracket_of(one) for one in between])
    trials = Trials(model, parameters, results, task, changes)
    if len(set(trials.names)) < len(trials.names):
        raise InputError(f"two results are named {trials.names[0]!r}: name the functions")
    search = _Search(trials, aims, ends, tolerance)
    value, reached, slope, last = search.run()
    errors, doubt = trials.errors_at(tuple(value.tolist()), accuracy)
    bar = last + abs(np.linalg.inv(slope)) @ errors
    return Roots(tuple(parameters), tuple(trials.names), aims, value, bar, reached, slope,
                 tuple(trials.done.items()), doubt)  # fmt: skip


class _Search:
    """The search of a root, in fractions of the ranges of the parameters, from 1 to 2."""

    def __init__(self, trials: Trials, aims: np.ndarray, ends: np.ndarray, tolerance: float):
        self.trials, self.aims, self.low, self.width = trials, aims, ends[:, 0], np.ptp(ends, 1)
        self.close = tolerance * abs(ends).max(1) / self.width

    def run(self) -> tuple:
        """Return values, results, slopes and last step of the parameters; or raise NoRootError."""
        size, first, nearest = len(self.aims), None, None
        starts = [np.full(size, 1.5), *map(np.array, product((1.2, 1.8), repeat=size))]
        for start in islice(starts, _STARTS):
            slopes = self._fit(start, 1.0, 1).jac
            first = slopes if first is None else first
            if not _are_independent(slopes):
                continue  # they may be independent from another starting point
            scale = np.linalg.norm(slopes, axis=1)
            found = self._fit(start, scale, _SOLUTIONS)
            slopes, gap = found.jac * scale[:, None], found.fun * scale
            step = abs(np.linalg.lstsq(slopes, gap, rcond=None)[0])
            if _are_independent(slopes) and np.all(step <= self.close):
                values = self._parameter_values(found.x)
                return values, gap + self.aims, slopes / self.width, step * self.width
            if nearest is None or found.cost < nearest.cost:
                nearest = found
        raise self._no_root_error(nearest.x) if nearest else self._dependence_error(first)

    def _fit(self, start: np.ndarray, scale, evaluations: int):
        """Return a least-squares fit to the targets, with gaps over a scale."""
        from scipy.optimize import least_squares

        return least_squares(
            lambda u: self._misfit(u) / scale, start, "3-point", (1.0, 2.0), diff_step=_STEP,
            ftol=None, gtol=None, xtol=1e-2 * self.close.min(), max_nfev=evaluations,
        )  # fmt: skip

    def _parameter_values(self, u: np.ndarray) -> np.ndarray:
        return self.low + (u - 1) * self.width

    def _misfit(self, u: np.ndarray) -> np.ndarray:
        return np.array(self.trials.results(tuple(self._parameter_values(u).tolist()))) - self.aims

    def _dependence_error(self, slopes: np.ndarray):
        sides = ((self.trials.parameters, "changes none of the results"),
                 (self.trials.names, "changes with none of them"))  # fmt: skip
        for axis, (names, words) in enumerate(sides):
            moves = slopes.any(axis)
            if not moves.all():
                return self.trials.failure("flat", f"{names[int(np.argmin(moves))]} {words}")
        names = " and ".join(self.trials.names)
        return self.trials.failure("dependent", f"{names} do not change independently with "
                                   f"{' and '.join(self.trials.parameters)}")  # fmt: skip

    def _no_root_error(self, u: np.ndarray):
        there = zip(self.trials.parameters, self._parameter_values(u), strict=True)
        where = ", ".join(f"{name} = {value:.6g}" for name, value in there)
        got = zip(self.trials.names, self._misfit(u) + self.aims, self.aims, strict=True)
        what = ", ".join(f"{name} = {value:.6g} (target {aim:g})" for name, value, aim in got)
        runs = len(self.trials.done)
        return self.trials.failure("outside", f"none found within the ranges ({runs} runs); "
                                   f"nearest is {where}, with {what}")  # fmt: skip


def _are_independent(slopes: np.ndarray) -> bool:
    """Return whether the results depend on all parameters independently."""
    for axis in (1, 0):
        size = np.linalg.norm(slopes, axis=axis, keepdims=True)
        if not size.all():
            return False
        slopes = slopes / size
    return np.linalg.cond(slopes) < 1 / _DEPENDENT
