# SPDX-License-Identifier: GPL-3.0-or-later
"""An array result of a case, with its coordinates."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Array:
    """An array result of a case."""

    values: np.ndarray
    dims: tuple[str, ...]
    coordinates: dict[str, np.ndarray]  # coordinate of each dimension
    units: str = ""
