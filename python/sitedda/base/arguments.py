# SPDX-License-Identifier: GPL-3.0-or-later
"""Check numeric arguments of functions and commands; messages name the argument and its value."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from .errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class Range:
    """The values that a number may have.

    `low`, `high`: bounds, which are finite.
    """

    low: float
    high: float
    above: bool = False  # exclude the lower bound
    whole: bool = False  # allow only whole numbers

    def check(self, name: str, value) -> float | int:
        """Return the value as a number; raise InputError if it is no number or out of range."""
        try:
            number = float(value)
        except (TypeError, ValueError, OverflowError):
            number = float("nan")
        in_range = self.low < number if self.above else self.low <= number
        if not in_range or not number <= self.high or (self.whole and number != int(number)):
            raise InputError(f"{name} = {value} must be {self}")
        return int(number) if self.whole else number

    def __str__(self) -> str:
        """Return the range in words, for messages."""
        kind = "a whole number" if self.whole else "a number"
        lowest = f"above {self.low:g}" if self.above else f"from {self.low:g}"
        return f"{kind} {lowest} to {self.high:g}"

    def __call__(self, text: str) -> float | int:
        """Convert the text of a command-line option to a number in the range, for `argparse`."""
        try:
            return self.check("it", text)
        except InputError:
            raise argparse.ArgumentTypeError(f"{text!r} is not {self}") from None


LARGEST = 1e9
ANY_NUMBER = Range(-LARGEST, LARGEST)
FINITE = Range(-1e30, 1e30)
POSITIVE = Range(0.0, LARGEST, above=True)
NOT_NEGATIVE = Range(0.0, LARGEST)
DOTS_PER_INCH = Range(1.0, 1200.0)
PICTURES_A_SECOND = Range(0.0, 1000.0, above=True)
SECONDS = Range(0.0, 1e6, above=True)
DAMPING_RATIO = Range(0.0, 1.0)
TOLERANCE = Range(1e-12, 1.0)  # relative tolerance of a search; numbers have 16 digits
WORKERS = Range(1, 4096, whole=True)
COUNT = Range(1, 2**31 - 1, whole=True)


def file_name(text: str) -> Path:
    """Return the file name given as an option; reject an empty name."""
    if not text:
        raise argparse.ArgumentTypeError("the file name is empty")
    return Path(text)


def picture_name(text: str) -> Path:
    """Return the picture name given as an option; reject an unknown file format."""
    name = file_name(text)
    formats = ("png", "pdf", "svg", "svgz", "jpg", "jpeg", "tif", "tiff", "webp", "eps", "ps")
    if name.suffix[1:].lower() not in formats:
        raise argparse.ArgumentTypeError(f"{text!r} must end in one of .{', .'.join(formats)}")
    return name


def positive(name: str, value: ArrayLike) -> NDArray:
    """Return values as floats; raise InputError unless all are finite and positive."""
    import numpy as np

    values = floats(name, value)
    valid = np.isfinite(values) & (values > 0)
    if not np.all(valid):
        raise InputError(f"{name} must be finite and positive, got {first_of(values, ~valid):g}")
    return values


def not_negative(name: str, value: ArrayLike) -> NDArray:
    """Return values as floats; raise InputError unless all are finite and not negative."""
    import numpy as np

    values = floats(name, value)
    fits = np.isfinite(values) & (values >= 0)
    if not np.all(fits):
        raise InputError(f"{name} must be finite and not negative, got {first_of(values, ~fits):g}")
    return values


def floats(name: str, value: ArrayLike) -> NDArray:
    """Return values as floats; raise InputError unless all are real numbers."""
    import numpy as np

    try:
        if np.iscomplexobj(value):
            raise TypeError
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{name} must contain real numbers, got {str(value)[:60]!r}") from None


def first_of(values: NDArray, mask: NDArray) -> float:
    """Return the first value for which `mask` is true, for a message."""
    import numpy as np

    return np.atleast_1d(values)[np.atleast_1d(mask)][0]
