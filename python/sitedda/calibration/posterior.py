# SPDX-License-Identifier: GPL-3.0-or-later
"""The posterior probability of unknown stiffnesses given measured modes.

The unknowns are x = ln θ, with Gaussian priors.  With the relative error σⱼ of a frequency and the
discrepancy δ, a relative error of the model itself (Kennedy and O'Hagan 2001),

    ln p(x) = Σ ln N(xᵢ; mᵢ, sᵢ) + Σ ln N(ln fⱼ − ln fⱼ(x); 0, √(σⱼ² + δ²)) + shapes,       (1)

and a shape of n components and unit length adds n − 1 independent errors whose squares sum to
1 − MAC.  An unknown δ is one more unknown.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment, minimize
from scipy.special import logsumexp, softmax
from scipy.stats import multivariate_t

from ..base.errors import ConvergenceError, MissingLibrary
from .family import Family
from .measured import Observations

_STEP, _WIDTHS = 1e-2, 4  # first step of differences of gradients, prior deviations; iterations
_STILL = 1e-10  # fraction of the largest square of a shape at its points that counts as 0
_PRIOR, _STARTS = 200, 5  # draws of the prior, and starts of the search of peaks
_MOST, _LOWEST = 8, 7.0  # kept peaks: largest number, and largest difference to the highest in ln p
_FARTHEST = 8.0  # search range in standard deviations of the prior
_LARGEST = 200.0  # bound on x, so that the stiffnesses of extreme draws are finite
_DRAWS = 2000  # draws per round of the integral of the evidence
_WIDER = 3.0  # width of the wider proposal of a peak over the other one
_FREEDOM = 6  # degrees of freedom of the proposals, whose tails are wider than Gaussian
_ROUNDS, _LEAST = 6, 1e-12  # rounds that fit the proposals; least weight of a draw in a fit
_ENOUGH = 0.5  # effective fraction of draws at which the adaptation ends
_WALKERS, _STEPS, _LENGTHS = 32, 500, 50  # steps; least autocorrelation times
_MOST_STEPS = 20000


@dataclass(frozen=True)
class Posterior:
    """The posterior of eq. 1 on a reduced family.

    Attributes
    ----------
    family : Family
        Dense and small.
    seen : Observations
    mean, deviation : ndarray
        Priors of x; the last is that of ln δ, if `discrepancy` is None.
    discrepancy : float or None
        δ; None: unknown.
    """

    family: Family
    seen: Observations
    mean: np.ndarray
    deviation: np.ndarray
    discrepancy: float | None

    def solved(self, x: np.ndarray, shapes: bool = True) -> tuple:
        """Return all ω² and modes of the family at rows of x, and the measured modes.

        The modes can be omitted if no shape was measured.
        """
        theta = np.exp(np.clip(x[:, : len(self.family.parts)], -_LARGEST, _LARGEST))
        stiffness = self.family.fixed + np.tensordot(theta, self.family.parts, 1)
        if shapes or any(shape.size for shape in self.seen.shapes):
            squares, y = np.linalg.eigh(stiffness)
        else:
            squares, y = np.linalg.eigvalsh(stiffness), None
        squares = np.maximum(squares, 1e-30)
        chosen = np.tile(self.seen.number, (len(x), 1))
        if np.any(self.seen.number < 0):
            for one, s, shapes, d in zip(chosen, squares, y, self._discrepancy(x), strict=True):
                self._match_modes(one, s, shapes, d)
        return squares, y, chosen

    def _discrepancy(self, x: np.ndarray) -> np.ndarray:
        return np.exp(x[:, -1]) if self.discrepancy is None else np.full(len(x), self.discrepancy)

    def _match_modes(self, chosen, squares, y, delta) -> None:
        """Assign to each measured shape the mode that fits shape and frequency best."""
        free = np.flatnonzero(self.seen.number < 0)
        others = np.setdiff1d(np.arange(min(self.seen.count, len(squares))), self.seen.number)
        cost = np.empty((free.size, others.size))
        for row, j in zip(cost, free, strict=True):
            one = self.seen.modes[j]
            macs = np.array([self.mac(y, j, k) for k in others])
            off = np.log(2 * np.pi * one.frequency) - np.log(squares[others]) / 2
            row[:] = (1 - macs) / (one.shape_deviation**2 + delta**2)
            row += off**2 / ((one.deviation / one.frequency) ** 2 + delta**2)
        rows, columns = linear_sum_assignment(cost)
        chosen[free[rows]] = others[columns]

    def shape(self, y: np.ndarray, j: int, mode: int) -> np.ndarray:
        """Return a mode at the points where the measured shape has components."""
        return self.family.points[self.seen.rows[j]] @ y[:, mode]

    def _shape_round_off(self, j: int) -> float:
        """Return the squared shape at measured points below which it is round-off, 1/kg."""
        return _STILL * float(np.sum(self.family.points[self.seen.rows[j]] ** 2))

    def mac(self, y: np.ndarray, j: int, mode: int) -> float:
        """Return the modal assurance criterion: 1 if a mode is proportional to the measured one."""
        shape = self.shape(y, j, mode)
        return float(
            (self.seen.shapes[j] @ shape) ** 2 / (shape @ shape + self._shape_round_off(j))
        )

    def log(self, x: np.ndarray, solved=None) -> np.ndarray:
        """Return ln p of rows of x."""
        z = (x - self.mean) / self.deviation
        total = -0.5 * np.sum(z**2 + np.log(2 * np.pi * self.deviation**2), axis=1)
        squares, y, chosen = solved or self.solved(x, shapes=False)
        delta, rows = self._discrepancy(x), np.arange(len(x))
        for j, one in enumerate(self.seen.modes):
            off = np.log(2 * np.pi * one.frequency) - np.log(squares[rows, chosen[:, j]]) / 2
            total += _log_gaussian(off**2, (one.deviation / one.frequency) ** 2 + delta**2)
            if self.seen.shapes[j].size:
                shapes = self.family.points[self.seen.rows[j]] @ y[rows, :, chosen[:, j]].T
                along = self.seen.shapes[j] @ shapes
                rest = 1 - along**2 / (np.sum(shapes**2, axis=0) + self._shape_round_off(j))
                total += _log_gaussian(rest, one.shape_deviation**2 + delta**2, shapes.shape[0] - 1)
        return total

    def minus_log(self, x: np.ndarray) -> tuple[float, np.ndarray]:
        """Return −ln p at x, and its gradient."""
        family = self.family
        slope = -(x - self.mean) / self.deviation**2
        solved = self.solved(x[None])
        squares, y, chosen = (values[0] for values in solved)
        delta = float(self._discrepancy(x[None])[0])
        theta = np.exp(x[: len(family.parts)])
        moved = [t * (y.T @ part @ y) for t, part in zip(theta, family.parts, strict=True)]
        for j, one in enumerate(self.seen.modes):
            mode = chosen[j]
            off = np.log(2 * np.pi * one.frequency) - np.log(squares[mode]) / 2
            variance = (one.deviation / one.frequency) ** 2 + delta**2
            for i, change in enumerate(moved):
                slope[i] += off / variance * change[mode, mode] / (2 * squares[mode])
            spread = [(off**2, variance, 1)]
            if (seen := self.seen.shapes[j]).size:
                shape, variance = self.shape(y, j, mode), one.shape_deviation**2 + delta**2
                gaps = squares[mode] - squares
                gaps[mode] = np.inf
                for i, change in enumerate(moved):
                    turned = family.points[self.seen.rows[j]] @ (y @ (change[:, mode] / gaps))
                    along, length = seen @ shape, shape @ shape + self._shape_round_off(j)
                    more = along * (seen @ turned) / length
                    slope[i] += (more - along**2 * (shape @ turned) / length**2) / variance
                spread.append((1 - self.mac(y, j, mode), variance, seen.size - 1))
            if self.discrepancy is None:
                slope[-1] += sum(delta**2 * (r / v**2 - n / v) for r, v, n in spread)
        return -float(self.log(x[None], solved)[0]), -slope

    def peaks(self, seed: int) -> list[np.ndarray]:
        """Find local maxima of p from the most probable draws of the prior, the largest first.

        Several sets of stiffnesses may have the same frequencies.
        """
        draws = np.random.default_rng(seed).standard_normal((_PRIOR, self.mean.size))
        order = np.argsort(-self.log(self.mean + self.deviation * draws))
        starts = _select_apart([np.zeros(self.mean.size), *draws[order]], 1.0)[:_STARTS]
        found = sorted((self._maximise(z) for z in starts), key=lambda one: one.fun)
        near = [one.x for one in found if one.fun < found[0].fun + _LOWEST]
        return [self.mean + self.deviation * z for z in _select_apart(near, 0.05)]

    def best(self, start: np.ndarray) -> np.ndarray:
        """Return the local maximum of p that is reached from a start."""
        return self.mean + self.deviation * self._maximise((start - self.mean) / self.deviation).x

    def _maximise(self, z: np.ndarray):
        bounds = [(-_FARTHEST, _FARTHEST)] * z.size
        return minimize(self._objective_and_slope, z, jac=True, bounds=bounds)

    def _objective_and_slope(self, z: np.ndarray) -> tuple[float, np.ndarray]:
        value, slope = self.minus_log(self.mean + self.deviation * z)
        return value, slope * self.deviation

    def covariance(self, x: np.ndarray) -> np.ndarray:
        """Return the inverse of the Hessian of −ln p at its minimum (Laplace).

        Gradients are compared one standard deviation away along each principal axis, found by
        iteration: where modes cross, ln p has a kink, and its width there is no local curvature.
        """
        steps = _STEP * np.eye(x.size)
        for _ in range(_WIDTHS):
            ends = [x + sign * steps * self.deviation for sign in (1, -1)]
            high, low = (np.array([self.minus_log(one)[1] for one in end]) for end in ends)
            scaled = np.linalg.solve(steps, (high - low) / 2 * self.deviation)
            values, axes = np.linalg.eigh((scaled + scaled.T) / 2)
            # Data seldom widen a prior: a flatter direction is also a kink.
            steps = (axes / np.sqrt(np.maximum(values, 0.25))).T
        return steps.T @ steps * np.outer(self.deviation, self.deviation)

    def weighted(self, peaks: list[tuple], seed: int) -> tuple:
        """Return draws, weights, ln of the integral of p, its error, and effective fraction.

        Importance sampling draws from a mixture of multivariate t distributions: one about each
        peak, given by x and covariance, and a wider one that covers its surroundings.  If few
        draws have weight, p is not Gaussian, and the mixture is fitted to the weighted draws
        (population Monte Carlo: Cappé et al. 2008).

        Raises
        ------
        ConvergenceError
            If p is not finite, or far narrower along some unknowns than along others.
        """
        generator = np.random.default_rng(seed)
        parts = [(x, f**2 * covariance) for x, covariance in peaks for f in (1.0, _WIDER)]
        shares = np.tile([0.75, 0.25], len(peaks)) / len(peaks)
        best = (0.0,)
        trouble = ConvergenceError("the probability of the measured modes cannot be integrated: "
                                   "check their deviations, and narrow the ranges")  # fmt: skip
        for _ in range(_ROUNDS):
            try:
                mixture = [multivariate_t(x, shape, _FREEDOM) for x, shape in parts]
            except np.linalg.LinAlgError:
                raise trouble from None
            counts = generator.multinomial(_DRAWS, shares)
            draws = np.vstack([one.rvs(n, generator).reshape(n, self.mean.size)
                               for n, one in zip(counts, mixture, strict=True)])  # fmt: skip
            terms = np.log(shares) + np.column_stack([one.logpdf(draws) for one in mixture])
            density = logsumexp(terms, axis=1)
            logs = self.log(draws) - density
            if not np.all(np.isfinite(logs)):
                raise trouble
            weights = softmax(logs)
            counting = 1 / np.sum(weights**2) / _DRAWS
            if counting > best[0]:
                error = math.sqrt(max(1 / counting - 1, 0.0) / _DRAWS)
                integral = float(logsumexp(logs)) - math.log(_DRAWS)
                best = (float(counting), draws, weights, integral, error)
            if counting > _ENOUGH:
                break
            owned = weights[:, None] * np.exp(terms - density[:, None]) + _LEAST
            shares = owned.sum(0) / owned.sum()
            parts = [(w @ draws / w.sum(), np.atleast_2d(np.cov(draws.T, aweights=w)))
                     for w in owned.T]  # fmt: skip
        return *best[1:], best[0]

    def sampled(self, first: np.ndarray, count: int, seed: int) -> np.ndarray:
        """Sample x by the affine-invariant ensemble of `emcee`, shape (count, unknowns).

        Raises
        ------
        MissingLibrary
            Without emcee.
        ConvergenceError
            If the chain has less than 50 autocorrelation times after 20,000 steps.
        """
        try:
            import emcee
        except ImportError:
            raise MissingLibrary("sampler = 'ensemble' needs emcee: pip install emcee") from None
        generator = np.random.default_rng(seed)
        walkers = max(_WALKERS, 4 * self.mean.size)
        places = first[generator.choice(len(first), walkers, replace=len(first) < walkers)]
        chain = emcee.EnsembleSampler(walkers, self.mean.size, self.log, vectorize=True)
        chain.random_state = np.random.RandomState(seed).get_state()
        while chain.iteration < _MOST_STEPS:
            places = chain.run_mcmc(places, _STEPS)
            length = float(np.max(chain.get_autocorr_time(tol=0)))
            if chain.iteration > _LENGTHS * length:
                kept = chain.get_chain(discard=int(5 * length), flat=True)
                return kept[generator.choice(len(kept), count, replace=count > len(kept))]
        raise ConvergenceError(f"the sampler has an autocorrelation time of {length:.3g} steps: "
                               "narrow the priors, or drop unknowns")  # fmt: skip


def _select_apart(points: list[np.ndarray], distance: float) -> list[np.ndarray]:
    """Select points that are farther than a distance from all selected before."""
    kept: list[np.ndarray] = []
    for point in points:
        if len(kept) < _MOST and all(np.linalg.norm(point - one) > distance for one in kept):
            kept.append(point)
    return kept


def _log_gaussian(square, variance, count: int = 1):
    """Return ln of the density of `count` Gaussian errors with a sum of squares."""
    return -0.5 * (square / variance + count * np.log(2 * np.pi * variance))
