# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples of random parameters: Latin hypercube, Sobol', and designs for sensitivity analysis."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ..base.arguments import FINITE
from ..base.errors import InputError
from ..base.reading import read_numbers
from .axes import Points

_LARGEST = 2**26  # largest size of a file of samples, bytes


def uniform(low: float, high: float):
    """Return the uniform distribution between two values (`scipy.stats`)."""
    from scipy import stats

    if not low < high:
        raise InputError(f"a uniform distribution requires low < high, not {low:g} and {high:g}")
    return stats.uniform(low, high - low)


def normal(mean: float, deviation: float):
    """Return a normal distribution (`scipy.stats`)."""
    from scipy import stats

    if not deviation > 0:
        raise InputError(f"a normal distribution requires deviation > 0, not {deviation:g}")
    return stats.norm(mean, deviation)


def lognormal(median: float, deviation: float):
    """Return a lognormal distribution; `deviation` is the standard deviation of the logarithm."""
    from scipy import stats

    if not (deviation > 0 and median > 0):
        raise InputError("a lognormal distribution requires median > 0 and deviation > 0, not "
                         f"{median:g} and {deviation:g}")  # fmt: skip
    return stats.lognorm(deviation, scale=median)


_KINDS: dict[str, Callable] = {"uniform": uniform, "normal": normal, "lognormal": lognormal}


def distribution(values: Mapping):
    """Return the distribution of a table ``{distribution = "uniform", low = 1, high = 2}``."""
    values = dict(values)
    kind = values.pop("distribution", None)
    if not isinstance(kind, str) or kind not in _KINDS:
        raise InputError(f"distribution = {kind!r}: use {', '.join(_KINDS)}")
    try:
        return _KINDS[kind](**{name: FINITE.check(name, number) for name, number in values.items()})
    except TypeError as error:
        raise InputError(f"distribution {kind!r}: {error}") from None


def latin_hypercube(count: int, distributions: Mapping, seed: int = 0, name="sample") -> Points:
    """Return a Latin hypercube sample (`scipy.stats.qmc`).

    Parameters
    ----------
    count : int
        Number of cases.
    distributions : mapping
        Distribution of each variable: frozen distributions of `scipy.stats`, or `uniform`,
        `normal`, `lognormal` of this package.
    name : str
        Name of the dimension.
    """
    from scipy.stats import qmc

    rng = _random_generator(seed)
    unit = qmc.LatinHypercube(len(distributions), seed=rng).random(_check_count(count))
    return Points(name, _values_at_points(distributions, unit))


def sobol(count: int, distributions: Mapping, seed: int = 0, name="sample") -> Points:
    """Return a scrambled Sobol' sample (`scipy.stats.qmc`); see `latin_hypercube`.

    Raises
    ------
    InputError
        If `count` is not a power of two, which the balance of the sequence requires.
    """
    points = _sobol_points(count, len(distributions), seed)
    return Points(name, _values_at_points(distributions, points))


def saltelli(count: int, distributions: Mapping, seed: int = 0, name="sample") -> Points:
    """Return the design for `sobol_indices`: count × (parameters + 2) cases.

    The design contains samples A and B, then, for each parameter, A with the column of the
    parameter from B (Saltelli et al. 2010, Comput. Phys. Commun. 181, 259).

    Parameters
    ----------
    count : int
        Number of cases in each sample, a power of two.
    distributions, seed, name
        See `latin_hypercube`.
    """
    width = len(distributions)
    unit = _sobol_points(count, 2 * width, seed)
    a, b = unit[:, :width], unit[:, width:]
    mixed_points = [np.where(np.arange(width) == i, b, a) for i in range(width)]
    return Points(name, _values_at_points(distributions, np.concatenate([a, b, *mixed_points])))


def one_at_a_time(ranges: Mapping, name: str = "variation") -> Points:
    """Return the design for `tornado`: base values, then each parameter at low and high.

    Parameters
    ----------
    ranges : mapping of (low, base, high)
        Values of each variable.
    name : str
        Name of the dimension.
    """
    for path, values in ranges.items():
        if not isinstance(values, Sequence) or len(values) != 3:
            raise InputError(f"parameter {path!r}: give low, base and high, not {values!r}")
    base = {path: base_value for path, (_, base_value, _) in ranges.items()}
    rows = [base] + [base | {path: v} for path, (low, _, high) in ranges.items()
                     for v in (low, high)]  # fmt: skip
    return Points(name, {path: [row[path] for row in rows] for path in ranges})


def read_points(file, count: int | None = None, name: str = "sample") -> Points:
    """Read samples from a CSV file, such as those of a calibration.

    Parameters
    ----------
    file : path
        Its heading lists the changed variables; lines that begin with # are comments.
    count : int, optional
        Number of rows to read; default: all.
    name : str
        Name of the dimension.

    Raises
    ------
    InputError
        If the file has fewer rows, or a value is not a number.
    """
    names, rows = read_numbers(file, _LARGEST)
    if len(rows) < (count or 1):
        raise InputError(f"{file} has {len(rows)} rows of values; {count or 1} are required")
    columns = zip(*(values for _, values in rows[:count]), strict=True)
    return Points(name, {heading: [FINITE.check(f"{file}: {heading}", value) for value in column]
                         for heading, column in zip(names, columns, strict=True)})  # fmt: skip


def _sobol_points(count: int, width: int, seed: int) -> np.ndarray:
    """Return a scrambled Sobol' sample in the unit cube, shape (count, width)."""
    from scipy.stats import qmc

    count = _check_count(count)
    if count & (count - 1):
        power = 1 << (count.bit_length() - 1)
        raise InputError(f"count = {count}: a Sobol' sample requires a power of two, such as "
                         f"{power} or {2 * power}")  # fmt: skip
    return qmc.Sobol(width, seed=_random_generator(seed)).random(count)


def _check_count(count: int) -> int:
    """Return a number of cases as an integer; raise InputError if it is not positive."""
    if int(count) != count or count < 1:
        raise InputError(f"count = {count} must be a whole number above 0")
    return int(count)


def _random_generator(seed: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(seed))


def _values_at_points(distributions: Mapping, unit: np.ndarray) -> dict[str, list[float]]:
    """Transform points of the unit cube to values of the distributions, by variable."""
    if not distributions:
        raise InputError("a sample requires at least one parameter")
    result = {}
    for (path, item), column in zip(distributions.items(), unit.T, strict=True):
        item = distribution(item) if isinstance(item, Mapping) else item
        if not hasattr(item, "ppf"):
            raise InputError(f"parameter {path!r}: {item!r} is not a distribution")
        result[path] = item.ppf(column).tolist()
    return result
