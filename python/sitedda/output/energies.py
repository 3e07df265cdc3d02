# SPDX-License-Identifier: GPL-3.0-or-later
"""Energies and losses of a run, and the residual of the energy audit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

# Terms that are shown as one curve, grouped by their role in `dda_energy`.
STORED = {"kinetic": ("kinetic",), "elastic": ("strain", "welded", "contact", "support", "law"),
          "work against gravity": ("gravity",)}  # fmt: skip
LOSSES = {
    "loss by slip": ("friction",),
    "loss by time integration": ("algorithmic", "kinetic_damping", "static"),
    "loss by damping": ("damping", "material_damping"),
    "loss by impacts, fracture, yield": ("impact", "fracture", "yield", "plastic"),
    "energy of removed blocks": ("removed",),
}
GAINED = (
    "initial", "input", "geometric", "changed", "zeroed", "dilation", "length", "breaking",
)  # fmt: skip
TERMS = (*(n for names in STORED.values() for n in names), *GAINED,
         *(n for names in LOSSES.values() for n in names), "balance")  # fmt: skip
_SMALL = 1e-3  # terms below this fraction of the supplied energy are shown together


@dataclass(frozen=True)
class Budget:
    """Energies over time, J/m, each of shape (samples,).

    Attributes
    ----------
    time : ndarray
        s
    given : ndarray
        Work done on the model and energy released, for example by gravity.
    parts : dict of ndarray
        Energies and losses by name, 0 or more: their sum is `given` plus `residual`.
    residual : ndarray
        Residual of the audit.
    """

    time: np.ndarray
    given: np.ndarray
    parts: dict[str, np.ndarray]
    residual: np.ndarray


def budget(history: xr.Dataset) -> Budget:
    """Return the energies of a run; negative terms count as supplied energy."""
    zero = np.zeros(history.sizes["time"])

    def sum_of(names) -> np.ndarray:
        terms = [history[f"energy_{n}"].values for n in names if f"energy_{n}" in history]
        return np.sum(terms, axis=0) if terms else zero

    parts, supplied = {}, zero.copy()
    for name, terms in (STORED | LOSSES).items():
        values = sum_of(terms)
        supplied += np.maximum(-values, 0.0)
        parts[name] = np.maximum(values, 0.0)
    remainder = zero.copy()
    for name in GAINED:
        values = sum_of([name])
        supplied += np.maximum(values, 0.0)
        remainder += np.maximum(-values, 0.0)
    threshold = _SMALL * float(supplied.max(initial=0.0))
    small_terms = [name for name, values in parts.items() if values.max(initial=0.0) <= threshold]
    remainder += np.sum([parts.pop(name) for name in small_terms], axis=0) if small_terms else 0.0
    if remainder.max(initial=0.0) > 0:
        parts["other terms"] = remainder
    return Budget(history["time"].values, supplied, parts, sum_of(["balance"]))
