# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays that hold the parts of many things one behind the other."""

from itertools import pairwise

import numpy as np


def parts_of(values: np.ndarray, first: np.ndarray) -> list[np.ndarray]:
    """Views of the rows of each part; `numpy.split` takes more than twice as long.

    Parameters
    ----------
    values : ndarray, shape (rows, ...)
    first : ndarray of int, shape (parts + 1,)
        The first row of each part, and the number of rows.
    """
    return [values[begin:end] for begin, end in pairwise(first.tolist())]
