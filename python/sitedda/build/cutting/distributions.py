# SPDX-License-Identifier: GPL-3.0-or-later
"""Random lengths and angles of joints, reproducible from a seed in every version up to rounding.

Raw 64-bit integers come from numpy's Philox generator, whose key is (seed, stream).  The formulas
of numpy's distributions may change and are not used.
"""

from statistics import NormalDist

import numpy as np

from ...base.errors import InputError

DISTRIBUTIONS = ("constant", "uniform", "normal", "log-normal", "exponential")
_LEAST = 0.01  # shortest length / mean length, for uniform and normal distributions


def uniform(seed: int, stream: tuple[int, ...], count: int) -> np.ndarray:
    """Draw uniform numbers in the open interval (0, 1), shape (count,).

    Parameters
    ----------
    seed : int
        0 … 2⁶⁴ − 1.
    stream : up to three int
        Numbers that identify a stream of a seed: the first is part of the key, the others are words
        of the counter.  A longer draw from a stream begins with the numbers of a shorter draw.
    """
    kind, *index = stream
    counter = np.array([0, *index, 0, 0, 0][:4], dtype=np.uint64)
    generator = np.random.Philox(key=np.array([seed, kind], np.uint64), counter=counter)
    integers = generator.random_raw(count)
    return ((integers >> np.uint64(12)).astype(float) + 0.5) * 2.0**-52


def normal_quantile(probability) -> np.ndarray:
    """Return the quantile of the standard normal distribution for a probability in (0, 1).

    The standard library computes it by algorithm AS 241 (Wichura 1988, Applied Statistics 37).
    """
    probability = np.asarray(probability, dtype=float)
    return np.reshape(list(map(NormalDist().inv_cdf, probability.ravel())), probability.shape)


def draw(probability, distribution: str, mean: float, deviation: float) -> np.ndarray:
    """Convert uniform numbers to numbers of a distribution.

    Parameters
    ----------
    probability : array_like
        Uniform numbers in (0, 1).
    distribution : str
        One of `DISTRIBUTIONS`.
    mean : float
    deviation : float
        Standard deviation; for the uniform distribution, the greatest distance from the mean;
        without effect on constant and exponential distributions.
    """
    probability = np.asarray(probability, dtype=float)
    if distribution == "uniform":
        return mean + deviation * (2 * probability - 1)
    if distribution == "normal":
        return mean + deviation * normal_quantile(probability)
    if distribution == "log-normal":
        variance = np.log1p((deviation / mean) ** 2)
        return mean * np.exp(np.sqrt(variance) * normal_quantile(probability) - 0.5 * variance)
    if distribution == "exponential":
        return -mean * np.log(probability)
    return np.full(probability.shape, float(mean))


def draw_lengths(probability, distribution: str, mean: float, deviation: float) -> np.ndarray:
    """Convert uniform numbers to lengths; for uniform and normal, at least 1 % of the mean."""
    lengths = draw(probability, distribution, mean, deviation)
    if distribution in ("uniform", "normal"):
        lengths = np.maximum(lengths, _LEAST * mean)
    return lengths


def check_distribution(name: str, distribution: str, mean: float, deviation: float) -> None:
    """Raise InputError for a deviation or mean that the distribution does not permit."""
    if distribution in ("constant", "exponential") and deviation:
        raise InputError(f"{name}_deviation: omit it for the distribution {distribution!r}")
    if distribution in ("log-normal", "exponential") and not mean > 0:
        raise InputError(f"{name} = {mean:g} must be positive for distribution {distribution!r}")
