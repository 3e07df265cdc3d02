# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs that differ from a run in one thing: its steps, its penalty stiffness."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..input_text import small_groups
from ..simulation import Simulation

_ORDERS = {"midpoint": 2}  # of time integration; of all others 1


@dataclass(frozen=True)
class Variant:
    """One of them.

    Attributes
    ----------
    name : str
        In the table of the runs.
    changes : dict
        Of the input, by name.
    """

    name: str
    changes: dict = field(default_factory=dict)


class Variants:
    """The axis of a study along which the variants lie.

    Parameters
    ----------
    variants : sequence of Variant
    """

    def __init__(self, variants):
        self._variants = list(variants)
        names = [one.name for one in self._variants]
        self.dims = {"variant": len(names)}
        self.coordinates = {"variant": (("variant",), names, {})}

    def changes(self, place: tuple[int, ...]) -> dict:
        """What is changed at a place."""
        return dict(self._variants[place[0]].changes)


@dataclass(frozen=True)
class Facts:
    """What variants are made from.

    Attributes
    ----------
    groups : mapping
        The groups of the input.
    order : int
        Of the time integration.
    penalty : float
        k_n, N/m; 0 where no joint has a penalty: all have a stiffness of their own.
    """

    groups: Mapping
    order: int
    penalty: float


def facts_of(model, changes: Mapping) -> Facts:
    """Read a model, and say what its variants need to know.

    Parameters
    ----------
    model : path or Model
    changes : mapping
        Of the input.

    Raises
    ------
    InputError
        If the input cannot be run.
    """
    with Simulation(model, changes=changes) as simulation:
        groups = small_groups(simulation.input_text)
        stiffness = simulation.normal_stiffness
    control = next(iter(groups.get("control", [])), {})
    schemes = [control, *(s for s in groups.get("stage", []) if _is_dynamic(s))]
    default = control.get("integration", "dda")
    order = min(_ORDERS.get(s.get("integration", default), 1) for s in schemes)
    own = [_has_stiffness(joint) for joint in groups.get("joint", [])]
    return Facts(groups, order, 0.0 if own and all(own) else stiffness)


def _has_stiffness(joint: Mapping) -> bool:
    """A measured stiffness is physics, no penalty."""
    return "normal_stiffness_per_area" in joint or joint.get("law") == "barton_bandis"


def _is_dynamic(stage: Mapping) -> bool:
    return stage.get("kind", "dynamic") == "dynamic"


def finer(facts: Facts, times: int) -> Variant:
    """All time steps divided by a whole number.

    Parameters
    ----------
    facts : Facts
    times : int
    """
    changes = _divided("control", next(iter(facts.groups.get("control", [])), {}), times)
    for i, stage in enumerate(facts.groups.get("stage", []), 1):
        if _is_dynamic(stage):
            changes |= _divided(f"stage[{i}]", stage, times)
    return Variant(f"dt/{times}" if times > 1 else "dt", changes if times > 1 else {})


def _divided(where: str, group: Mapping, times: int) -> dict:
    changes: dict = {}
    if "time_step" in group:
        changes[f"{where}.time_step"] = group["time_step"] / times
    if "steps" in group:
        changes[f"{where}.steps"] = group["steps"] * times
    return changes


def stiffer(facts: Facts) -> Variant:
    """Four times the penalty stiffness.

    Parameters
    ----------
    facts : Facts
        With a penalty.
    """
    return Variant("4 k_n", {"contact.normal_stiffness": 4.0 * facts.penalty})
