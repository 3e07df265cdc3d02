# SPDX-License-Identifier: GPL-3.0-or-later
"""The posterior probability of unknown stiffnesses given measured modes.

The unknowns θ have log-normal priors: z = (ln θ − m) / s is standard normal.  With the relative
error σⱼ of a frequency and the discrepancy δ, a relative error of the model itself (Kennedy and
O'Hagan 2001),

    ln p(z) = Σ ln N(zᵢ; 0, 1) + Σ ln N(ln fⱼ − ln fⱼ(z); 0, √(σⱼ² + δ²)) + shapes,         (1)

and a shape of n components and unit length adds n − 1 independent errors whose squares sum to
1 − MAC.  An unknown δ is one more unknown.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares, linear_sum_assignment
from scipy.special import logsumexp, softmax
from scipy.stats import multivariate_t

from ..base.errors import ConvergenceError, library_required
from .family import Family
from .measured import Observations

_STEP = 1e-6  # step of finite differences / prior deviation
_LEAST_SQUARE = 1e-30  # smallest ω², rad²/s²: soft joints under weight are unstable
_ROUND_OFF = 1e-10  # fraction of the largest square of a shape at its points that counts as 0
_PRIOR, _STARTS = 200, 5  # draws of the prior, and starts of the search of peaks
_MOST_PEAKS, _LOWEST = 8, 7.0  # of used peaks: number, difference to the highest in ln p
_RANGE = 8.0  # search range in standard deviations of the prior
_LARGEST = 200.0  # bound on ln θ, so that the stiffnesses of extreme draws are finite
_DRAWS = 3000  # samples per round of importance sampling of the evidence
_PRIOR_FRACTION = 0.3  # fraction of samples from the proposal with the width of the prior
_FREEDOM = 6  # degrees of freedom of Student's t of the proposals
_ROUNDS, _LEAST_WEIGHT = 6, 1e-12  # rounds that fit proposals; least weight of a sample in a fit
_SUFFICIENT = 0.5  # effective sample size / samples at which the adaptation ends
_WALKERS, _STEPS, _LENGTHS = 32, 500, 50  # walkers, steps, least number of autocorrelation times
_MOST_STEPS = 20000


@dataclass(frozen=True)
class Posterior:
    """The posterior of eq. 1 on a reduced family."""

    family: Family  # dense and small
    seen: Observations
    mean: np.ndarray  # of the priors of ln θ, and of that of ln δ if δ is unknown
    deviation: np.ndarray
    discrepancy: float | None  # δ; None: unknown

    def values(self, z: np.ndarray) -> np.ndarray:
        """Return the unknowns θ, and δ if it is unknown, at rows of z."""
        return np.exp(np.clip(self.mean + self.deviation * z, -_LARGEST, _LARGEST))

    def solve_modes(self, z: np.ndarray, shapes: bool = True) -> tuple:
        """Return all ω² and modes of the family at rows of z, and the measured modes.

        The modes can be omitted if no shape was measured.
        """
        theta = self.values(z)[:, : len(self.family.parts)]
        stiffness = self.family.fixed + np.tensordot(theta, self.family.parts, 1)
        if shapes or any(shape.size for shape in self.seen.shapes):
            squares, y = np.linalg.eigh(stiffness)
        else:
            squares, y = np.linalg.eigvalsh(stiffness), None
        squares = np.maximum(squares, _LEAST_SQUARE)
        numbers = np.tile(self.seen.number, (len(z), 1))
        if np.any(self.seen.number < 0):
            for row, s, shapes, d in zip(numbers, squares, y, self.discrepancies(z), strict=True):
                self._match_modes(row, s, shapes, d)
        return squares, y, numbers

    def discrepancies(self, z: np.ndarray) -> np.ndarray:
        """Return δ at rows of z."""
        discrepancy = self.values(z)[:, -1] if self.discrepancy is None else self.discrepancy
        return np.broadcast_to(discrepancy, len(z))

    def _match_modes(self, numbers, squares, y, delta) -> None:
        """Assign to each measured shape the mode that fits shape and frequency best."""
        unnumbered = np.flatnonzero(self.seen.number < 0)
        unassigned = np.setdiff1d(np.arange(min(self.seen.count, len(squares))), self.seen.number)
        cost = np.empty((unnumbered.size, unassigned.size))
        for row, j in zip(cost, unnumbered, strict=True):
            misfit = self.seen.log_omega[j] - np.log(squares[unassigned]) / 2
            row[:] = (1 - self.macs(y[:, unassigned],
                                    j)) / (self.seen.shape_error[j] ** 2 + delta**2)  # fmt: skip
            row += misfit**2 / (self.seen.error[j] ** 2 + delta**2)
        rows, columns = linear_sum_assignment(cost)
        numbers[unnumbered[rows]] = unassigned[columns]

    def _shapes_at_points(self, y: np.ndarray, j: int) -> tuple[np.ndarray, np.ndarray]:
        """Return modes (columns) at the points of a measured shape, and scalar products with it.

        The modes are scaled to unit length and positive scalar products. An added last component
        of the size of round-off prevents zero length.
        """
        points = self.family.points[self.seen.rows[j]]
        shapes = points @ y
        shapes *= np.copysign(1.0, self.seen.shapes[j] @ shapes)
        round_off = np.full((1, y.shape[1]), math.sqrt(_ROUND_OFF) * np.linalg.norm(points))
        shapes = np.vstack([shapes, round_off])
        shapes /= np.linalg.norm(shapes, axis=0)
        return shapes, self.seen.shapes[j] @ shapes[:-1]

    def macs(self, y: np.ndarray, j: int) -> np.ndarray:
        """Return the modal assurance criterion of modes: 1 if one is proportional to a shape."""
        return self._shapes_at_points(y, j)[1] ** 2

    def residuals(self, z: np.ndarray) -> np.ndarray:
        """Return errors / deviations at rows of z; their squares sum to −2 ln p + constant.

        δ also changes the norming factor of p, so each error has a second residual for its change.
        """
        return self._weigh_errors(z, *self.solve_modes(z, shapes=False))

    def _weigh_errors(self, z, squares, y, numbers) -> np.ndarray:
        """Return `residuals` from modes at rows of z."""
        delta, rows, rows_of_errors = self.discrepancies(z), np.arange(len(z)), [z.T]
        for j, shape in enumerate(self.seen.shapes):
            misfit = self.seen.log_omega[j] - np.log(squares[rows, numbers[:, j]]) / 2
            errors = [(misfit[None], self.seen.error[j], 1)]
            if shape.size:
                shapes, components = self._shapes_at_points(y[rows, :, numbers[:, j]].T, j)
                shapes[:-1] -= np.outer(shape, components)
                errors.append((shapes, self.seen.shape_error[j], shape.size - 1))
            for error, deviation, count in errors:
                rows_of_errors += [error / np.hypot(deviation, delta),
                          np.sqrt(count * np.log1p((delta / deviation) ** 2))[None]]  # fmt: skip
        return np.vstack(rows_of_errors).T

    def jacobian(self, z: np.ndarray) -> np.ndarray:
        """Return the derivatives of the residuals at z, shape (residuals, unknowns).

        The derivatives of the modes are exact (`Family.slopes`); the residuals as functions of the
        modes are differentiated by central differences.
        """
        squares, y, numbers = self.solve_modes(z[None])
        count = len(self.family.parts)
        scale = (self.deviation * self.values(z))[:count]
        slopes = np.zeros((z.size, *squares[0].shape)), np.zeros((z.size, *y[0].shape))
        for array, slope in zip(slopes, self.family.slopes(squares[0], y[0]), strict=True):
            array[:count] = (slope.T * scale).T
        low, high = (
            self._weigh_errors(z + h * np.eye(z.size),
                               np.maximum(squares + h * slopes[0], _LEAST_SQUARE),
                               y + h * slopes[1], np.tile(numbers, (z.size, 1)))
            for h in (-_STEP, _STEP)
        )  # fmt: skip
        return (high - low).T / (2 * _STEP)

    def log(self, z: np.ndarray) -> np.ndarray:
        """Return ln p of rows of z."""
        counts = [max(shape.size - 1, 0) for shape in self.seen.shapes]
        scales = np.concatenate([np.ones(self.mean.size), self.seen.error,
                                 np.repeat(self.seen.shape_error, counts)])  # fmt: skip
        constant = np.sum(np.log(math.sqrt(2 * np.pi) * scales))
        return -np.sum(self.residuals(z) ** 2, axis=1) / 2 - constant

    def starts(self, seed: int) -> list[np.ndarray]:
        """Return the most probable of random draws of the prior, from which to search peaks."""
        draws = np.random.default_rng(seed).standard_normal((_PRIOR, self.mean.size))
        draws = np.vstack([0 * self.mean, draws[np.argsort(-self.log(draws))]])
        return [draws[i] for i in _select_distant(draws, 1.0)[:_STARTS]]

    def peaks(self, starts: list[np.ndarray]) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return local maxima of p, the largest first, with covariances (Laplace).

        Several sets of stiffnesses may have the same frequencies.
        """
        fits = [least_squares(lambda z: self.residuals(z[None])[0], start, self.jacobian,
                              bounds=(-_RANGE, _RANGE)) for start in starts]  # fmt: skip
        fits.sort(key=lambda fit: fit.cost)
        distinct_fits = [fits[i] for i in _select_distant([fit.x for fit in fits], 0.05)]
        return [(fit.x, np.linalg.inv(fit.jac.T @ fit.jac)) for fit in distinct_fits
                if fit.cost <= fits[0].cost + _LOWEST]  # fmt: skip

    def draw_weighted(self, peaks: list[tuple], seed: int) -> tuple:
        """Return draws, weights, ln of the integral of p, its error, and effective fraction.

        Importance sampling draws from a mixture of multivariate t distributions: one about each
        peak, given by z and covariance, and one as wide as the prior, for regions without peaks
        where modes cross.  If few draws have weight, p is not Gaussian, and the mixture is fitted
        to the weighted draws (population Monte Carlo: Cappé et al. 2008).
        """
        generator = np.random.default_rng(seed)
        proposals = [*peaks, (0 * self.mean, np.eye(self.mean.size))]
        ratios = np.append(np.full(len(peaks), (1 - _PRIOR_FRACTION) / len(peaks)), _PRIOR_FRACTION)
        best_round = (0.0,)
        failure = ConvergenceError("the probability of the measured modes cannot be integrated: "
                                   "check their deviations, and narrow the ranges")  # fmt: skip
        for _ in range(_ROUNDS):
            try:
                mixture = [multivariate_t(z, shape, _FREEDOM) for z, shape in proposals]
            except np.linalg.LinAlgError:
                raise failure from None
            counts = generator.multinomial(_DRAWS, ratios)
            draws = np.vstack([term.rvs(n, generator).reshape(n, self.mean.size)
                               for n, term in zip(counts, mixture, strict=True)])  # fmt: skip
            terms = np.log(ratios) + np.column_stack([term.logpdf(draws) for term in mixture])
            density = logsumexp(terms, axis=1)
            logs = self.log(draws) - density
            if not np.all(np.isfinite(logs)):
                raise failure
            weights = softmax(logs)
            effective = 1 / np.sum(weights**2) / _DRAWS
            if effective > best_round[0]:
                error = math.sqrt(max(1 / effective - 1, 0.0) / _DRAWS)
                integral = float(logsumexp(logs)) - math.log(_DRAWS)
                best_round = (float(effective), draws, weights, integral, error)
            if effective > _SUFFICIENT:
                break
            responsibilities = weights[:, None] * np.exp(terms - density[:, None]) + _LEAST_WEIGHT
            ratios = responsibilities.sum(0) / responsibilities.sum()
            proposals = [(w @ draws / w.sum(), np.atleast_2d(np.cov(draws.T, aweights=w)))
                     for w in responsibilities.T]  # fmt: skip
        return *best_round[1:], best_round[0]

    def draw_samples(self, draws: np.ndarray, count: int, seed: int) -> np.ndarray:
        """Sample z by the affine-invariant ensemble of `emcee`, shape (count, unknowns)."""
        with library_required("sampler = 'ensemble' needs emcee: pip install emcee"):
            import emcee
        generator = np.random.default_rng(seed)
        walkers = max(_WALKERS, 4 * self.mean.size)
        walkers_at = draws[generator.choice(len(draws), walkers, replace=len(draws) < walkers)]
        chain = emcee.EnsembleSampler(walkers, self.mean.size, self.log, vectorize=True)
        chain.random_state = np.random.RandomState(seed).get_state()
        while chain.iteration < _MOST_STEPS:
            walkers_at = chain.run_mcmc(walkers_at, _STEPS)
            length = float(np.max(chain.get_autocorr_time(tol=0)))
            if chain.iteration > _LENGTHS * length:
                samples = chain.get_chain(discard=int(5 * length), flat=True)
                return samples[generator.choice(len(samples), count, replace=count > len(samples))]
        raise ConvergenceError(f"the sampler has an autocorrelation time of {length:.3g} steps: "
                               "narrow the priors, or drop unknowns")  # fmt: skip


def _select_distant(points, distance: float) -> list[int]:
    """Return indices of points that are farther than a distance from all selected before."""
    selected: list[int] = []
    for i, point in enumerate(points):
        is_distant = all(np.linalg.norm(point - points[k]) > distance for k in selected)
        if len(selected) < _MOST_PEAKS and is_distant:
            selected.append(i)
    return selected
