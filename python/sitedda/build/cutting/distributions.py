# SPDX-License-Identifier: GPL-3.0-or-later
"""Random lengths and angles of joints, reproducible from a seed in every version.

Raw 64-bit integers come from numpy's Philox generator, whose key is (seed, stream).  The formulas
of distributions are defined here, because the formulas of numpy may change.
"""

import numpy as np

from ...base.errors import InputError

DISTRIBUTIONS = ("constant", "uniform", "normal", "log-normal", "exponential")
_LEAST = 0.01  # shortest length over the mean length, for uniform and normal distributions

# Rational approximations of the inverse normal distribution, relative error below 1e-15:
# Wichura (1988), Algorithm AS 241, Applied Statistics 37, 477-484; highest power first.
_CENTRAL = (
    (
        2509.0809287301226727, 33430.575583588128105, 67265.770927008700853,
        45921.953931549871457, 13731.693765509461125, 1971.5909503065514427,
        133.14166789178437745, 3.3871328727963666080,
    ),
    (
        5226.4952788528545610, 28729.085735721942674, 39307.895800092710610,
        21213.794301586595867, 5394.1960214247511077, 687.18700749205790830,
        42.313330701600911252, 1.0,
    ),
)  # fmt: skip
_MIDDLE = (
    (
        7.74545014278341407640e-4, 0.0227238449892691845833, 0.241780725177450611770,
        1.27045825245236838258, 3.64784832476320460504, 5.76949722146069140550,
        4.63033784615654529590, 1.42343711074968357734,
    ),
    (
        1.05075007164441684324e-9, 5.47593808499534494600e-4, 0.0151986665636164571966,
        0.148103976427480074590, 0.689767334985100004550, 1.67638483018380384940,
        2.05319162663775882187, 1.0,
    ),
)  # fmt: skip
_TAIL = (
    (
        2.01033439929228813265e-7, 2.71155556874348757815e-5, 0.00124266094738807843860,
        0.0265321895265761230930, 0.296560571828504891230, 1.78482653991729133580,
        5.46378491116411436990, 6.65790464350110377720,
    ),
    (
        2.04426310338993978564e-15, 1.42151175831644588870e-7, 1.84631831751005468180e-5,
        7.86869131145613259100e-4, 0.0148753612908506148525, 0.136929880922735805310,
        0.599832206555887937690, 1.0,
    ),
)  # fmt: skip


def uniform(seed: int, stream: tuple[int, ...], count: int) -> np.ndarray:
    """Draw uniform numbers in the open interval (0, 1), shape (count,).

    Parameters
    ----------
    seed : int
        0 … 2⁶⁴ − 1.
    stream : up to three int
        Numbers that identify a stream of a seed: the first is part of the key, the others are words
        of the counter.  A longer draw from a stream begins with the numbers of a shorter draw.
    count : int
    """
    kind, *place = stream
    counter = np.array([0, *place, 0, 0, 0][:4], dtype=np.uint64)
    raw = np.random.Philox(key=np.array([seed, kind], np.uint64), counter=counter).random_raw(count)
    return ((raw >> np.uint64(12)).astype(float) + 0.5) * 2.0**-52


def normal_quantile(share) -> np.ndarray:
    """Return the quantile of the standard normal distribution for a probability in (0, 1)."""
    share = np.asarray(share, dtype=float)
    centred = share - 0.5
    inner = 0.180625 - centred**2
    root = np.sqrt(-np.log(np.minimum(share, 1 - share)))
    middle, tail = (
        _ratio_of_polynomials(_MIDDLE, root - 1.6),
        _ratio_of_polynomials(_TAIL, root - 5.0),
    )
    outer = np.sign(centred) * np.where(root <= 5.0, middle, tail)
    return np.where(inner >= 0, centred * _ratio_of_polynomials(_CENTRAL, inner), outer)


def _ratio_of_polynomials(polynomials, x):
    """Return the first polynomial divided by the second one at x."""
    return np.polyval(polynomials[0], x) / np.polyval(polynomials[1], x)


def draw(share, distribution: str, mean: float, deviation: float) -> np.ndarray:
    """Convert uniform numbers to numbers of a distribution.

    Parameters
    ----------
    share : array_like
        Uniform numbers in (0, 1).
    distribution : str
        One of `DISTRIBUTIONS`.
    mean : float
    deviation : float
        Standard deviation; for the uniform distribution, the greatest distance from the mean;
        without effect on constant and exponential distributions.
    """
    share = np.asarray(share, dtype=float)
    if distribution == "uniform":
        return mean + deviation * (2 * share - 1)
    if distribution == "normal":
        return mean + deviation * normal_quantile(share)
    if distribution == "log-normal":
        variance = np.log1p((deviation / mean) ** 2)
        return mean * np.exp(np.sqrt(variance) * normal_quantile(share) - 0.5 * variance)
    if distribution == "exponential":
        return -mean * np.log(share)
    return np.full(share.shape, float(mean))


def draw_lengths(share, distribution: str, mean: float, deviation: float) -> np.ndarray:
    """Convert uniform numbers to lengths; for uniform and normal, at least 1 % of the mean."""
    lengths = draw(share, distribution, mean, deviation)
    if distribution in ("uniform", "normal"):
        lengths = np.maximum(lengths, _LEAST * mean)
    return lengths


def check_distribution(name: str, distribution: str, mean: float, deviation: float) -> None:
    """Raise InputError for a deviation or mean that the distribution does not permit."""
    if distribution in ("constant", "exponential") and deviation:
        raise InputError(f"{name}_deviation: omit it for the distribution {distribution!r}")
    if distribution in ("log-normal", "exponential") and not mean > 0:
        raise InputError(f"{name} = {mean:g} must be positive for distribution {distribution!r}")
