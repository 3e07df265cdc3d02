# SPDX-License-Identifier: GPL-3.0-or-later
"""Probability of unknown stiffnesses given measured modes.

The unknowns are x = ln θ, with Gaussian priors.  With the relative error σⱼ of a frequency and the
discrepancy δ, a relative error of the model itself (Kennedy and O'Hagan 2001),

    ln p(x) = Σ ln N(xᵢ; mᵢ, sᵢ) + Σ ln N(ln fⱼ − ln fⱼ(x); 0, √(σⱼ² + δ²)) + shapes,       (1)

and a shape of n components and unit length adds n − 1 independent errors whose squares sum to
1 − MAC.  An unknown δ is one more unknown.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linear_sum_assignment, minimize

from ..base.errors import ConvergenceError, MissingLibrary
from .family import Family
from .measured import Observations

_STEP = 1e-3  # of a prior deviation, of differences of gradients
_STILL = 1e-10  # of the largest square that a shape can have at its points
_STARTS = 4  # from points of the prior, besides its median
_DRAWS = 2000  # of the integral of the evidence
_FREEDOM = 6  # degrees of freedom of its proposals, which reach farther than a Gaussian
_WALKERS, _STEPS, _LENGTHS = 32, 500, 50  # of the sampler; its autocorrelation times, at least
_MOST_STEPS = 20000


@dataclass(frozen=True)
class Posterior:
    """Eq. 1 on a reduced family.

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

    def solved(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """All ω² and modes of the family at rows of x; modes of the model that were measured."""
        theta = np.exp(x[:, : len(self.family.parts)])
        squares, y = np.linalg.eigh(self.family.fixed + np.tensordot(theta, self.family.parts, 1))
        squares = np.maximum(squares, 1e-300)
        chosen = np.tile(self.seen.number, (len(x), 1))
        if np.any(self.seen.number < 0):
            for one, s, shapes, d in zip(chosen, squares, y, self._delta(x), strict=True):
                self._match(one, s, shapes, d)
        return squares, y, chosen

    def _delta(self, x: np.ndarray) -> np.ndarray:
        return np.exp(x[:, -1]) if self.discrepancy is None else np.full(len(x), self.discrepancy)

    def _match(self, chosen, squares, y, delta) -> None:
        """Give each measured shape the mode that meets it and its frequency best."""
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
        """A mode at the points where the measured one has components."""
        return self.family.points[self.seen.rows[j]] @ y[:, mode]

    def _still(self, j: int) -> float:
        """Square of a shape at the points of a measured one that is round-off, 1/kg."""
        return _STILL * float(np.sum(self.family.points[self.seen.rows[j]] ** 2))

    def mac(self, y: np.ndarray, j: int, mode: int) -> float:
        """Modal assurance criterion: 1 if a mode is proportional to the measured shape."""
        shape = self.shape(y, j, mode)
        return float((self.seen.shapes[j] @ shape) ** 2 / (shape @ shape + self._still(j)))

    def log(self, x: np.ndarray) -> np.ndarray:
        """ln p of rows of x."""
        z = (x - self.mean) / self.deviation
        total = -0.5 * np.sum(z**2 + np.log(2 * np.pi * self.deviation**2), axis=1)
        squares, y, chosen = self.solved(x)
        delta, rows = self._delta(x), np.arange(len(x))
        for j, one in enumerate(self.seen.modes):
            off = np.log(2 * np.pi * one.frequency) - np.log(squares[rows, chosen[:, j]]) / 2
            total += _gauss(off**2, (one.deviation / one.frequency) ** 2 + delta**2)
            if self.seen.shapes[j].size:
                shapes = self.family.points[self.seen.rows[j]] @ y[rows, :, chosen[:, j]].T
                along = self.seen.shapes[j] @ shapes
                rest = 1 - along**2 / (np.sum(shapes**2, axis=0) + self._still(j))
                total += _gauss(rest, one.shape_deviation**2 + delta**2, shapes.shape[0] - 1)
        return total

    def minus_log(self, x: np.ndarray) -> tuple[float, np.ndarray]:
        """−ln p at one x, and its gradient."""
        family = self.family
        slope = -(x - self.mean) / self.deviation**2
        squares, y, chosen = (values[0] for values in self.solved(x[None]))
        delta = float(self._delta(x[None])[0])
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
                    along, length = seen @ shape, shape @ shape + self._still(j)
                    more = along * (seen @ turned) / length
                    slope[i] += (more - along**2 * (shape @ turned) / length**2) / variance
                spread.append((1 - self.mac(y, j, mode), variance, seen.size - 1))
            if self.discrepancy is None:
                slope[-1] += sum(delta**2 * (r / v**2 - n / v) for r, v, n in spread)
        return -float(self.log(x[None])[0]), -slope

    def best(self, seed: int, start=None) -> np.ndarray:
        """The x of the largest p, searched from the median and other points of the prior."""
        starts = [start]
        if start is None:
            around = np.random.default_rng(seed).standard_normal((_STARTS, self.mean.size))
            starts = [self.mean, *(self.mean + self.deviation * around)]
        found = [minimize(self._scaled, (x - self.mean) / self.deviation, jac=True, method="BFGS")
                 for x in starts]  # fmt: skip
        return self.mean + self.deviation * min(found, key=lambda one: one.fun).x

    def _scaled(self, z: np.ndarray) -> tuple[float, np.ndarray]:
        value, slope = self.minus_log(self.mean + self.deviation * z)
        return value, slope * self.deviation

    def covariance(self, x: np.ndarray) -> np.ndarray:
        """The inverse of the Hessian of −ln p at its minimum (Laplace)."""
        steps = _STEP * np.diag(self.deviation)
        rows = [(self.minus_log(x + h)[1] - self.minus_log(x - h)[1]) / (2 * h.sum())
                for h in steps]  # fmt: skip
        scaled = np.array(rows) * np.outer(self.deviation, self.deviation)
        values, axes = np.linalg.eigh((scaled + scaled.T) / 2)
        # Data seldom widen a prior: a flatter direction is a kink where modes cross.
        inverse = (axes / np.maximum(values, 0.25)) @ axes.T
        return inverse * np.outer(self.deviation, self.deviation)

    def evidence(self, x: np.ndarray, covariance: np.ndarray, seed: int) -> tuple:
        """ln of the integral of p, its standard error, and the fraction of draws that count.

        Importance sampling with draws of a multivariate t about the best x.
        """
        from scipy.stats import multivariate_t

        proposal = multivariate_t(x, covariance, df=_FREEDOM, seed=np.random.default_rng(seed))
        draws = np.atleast_1d(proposal.rvs(_DRAWS)).reshape(_DRAWS, x.size)
        logs = self.log(draws) - proposal.logpdf(draws)
        weights = np.exp(logs - logs.max())
        counting = weights.sum() ** 2 / np.sum(weights**2) / _DRAWS
        error = math.sqrt(max(1 / counting - 1, 0.0) / _DRAWS)
        return float(logs.max() + np.log(weights.mean())), error, float(counting)

    def sampled(self, x, covariance, count: int, seed: int) -> np.ndarray:
        """Samples of x by the affine-invariant ensemble of `emcee`, shape (count, unknowns).

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
        places = generator.multivariate_normal(x, covariance, max(_WALKERS, 4 * x.size))
        chain = emcee.EnsembleSampler(len(places), x.size, self.log, vectorize=True)
        chain.random_state = np.random.RandomState(seed).get_state()
        while chain.iteration < _MOST_STEPS:
            places = chain.run_mcmc(places, _STEPS)
            length = float(np.max(chain.get_autocorr_time(tol=0)))
            if chain.iteration > _LENGTHS * length:
                kept = chain.get_chain(discard=int(5 * length), flat=True)
                return kept[generator.choice(len(kept), count, replace=count > len(kept))]
        raise ConvergenceError(f"the sampler has an autocorrelation time of {length:.3g} steps: "
                               "narrow the priors, or drop unknowns")  # fmt: skip

    def on(self, family: Family) -> Posterior:
        """The same on another reduced family."""
        return replace(self, family=family)


def _gauss(square, variance, count: int = 1):
    """ln of the density of `count` Gaussian errors with a sum of squares."""
    return -0.5 * (square / variance + count * np.log(2 * np.pi * variance))
