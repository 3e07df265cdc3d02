# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs that differ from a run in one thing: its steps, its penalty stiffness."""

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase

import numpy as np

from ...engine.damping import damping_of
from ...engine.simulation import Simulation
from ...input.input_text import input_values

RUN, TWIN, ENSEMBLE = "dt", "twin", "twin "  # names; of an ensemble with a number behind
STEPS = (1, 2, 4)  # that Δt is divided by
TRIFLE = 1e-9  # of the size of a block, by which twins differ
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
        """Changes of a variant."""
        return dict(self._variants[place[0]].changes)


@dataclass(frozen=True)
class Facts:
    """Data for variants of a model.

    Attributes
    ----------
    groups : mapping
        The groups of the input.
    order : int
        Of the time integration.
    penalty : float
        k_n, N/m; 0 where no joint has a penalty: all have a stiffness of their own.
    there : sequence of int
        Numbers of the blocks that no stage removes, from 1, the highest first.
    """

    groups: Mapping
    order: int
    penalty: float
    there: Sequence[int] = (1,)

    @property
    def is_dynamic(self) -> bool:
        """Whether some stage is dynamic."""
        return any(_is_dynamic(one) for one in self.groups.get("stage", [{}]))

    @property
    def is_bonded(self) -> bool:
        """All joints bear tension, so a run may be linear."""
        return all(any(joint.get(f"{name}tensile_strength", 0.0) > 0.0 for name in ("", "peak_"))
                   for joint in self.groups.get("joint", []))  # fmt: skip

    @property
    def is_damped(self) -> bool:
        """Materials or joints damp; else the time integration alone does."""
        return any(map(damping_of, self.groups.get("material", []))) or any(
            joint.get("damping", 0.0) > 0.0 for joint in self.groups.get("joint", [])
        )


def facts_of(model, changes: Mapping) -> Facts:
    """Read a model and return the data for its variants.

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
        groups = input_values({"input_values": simulation.input_values})
        stiffness = simulation.normal_stiffness
        height = simulation.coordinates[:, 1]
        names = simulation.block_names
    control = next(iter(groups.get("control", [])), {})
    schemes = [control, *(s for s in groups.get("stage", []) if _is_dynamic(s))]
    default = control.get("integration", "dda")
    order = min(_ORDERS.get(s.get("integration", default), 1) for s in schemes)
    own = [_has_stiffness(joint) for joint in groups.get("joint", [])]
    penalty = 0.0 if own and all(own) else stiffness
    patterns = [p.strip() for s in groups.get("stage", []) for p in s.get("remove", "").split(",")]
    gone = [any(fnmatchcase(name, pattern) for pattern in patterns if pattern) for name in names]
    there = tuple(int(b) + 1 for b in np.argsort(-height, kind="stable") if not gone[b])
    return Facts(groups, order, penalty, there)


def _has_stiffness(joint: Mapping) -> bool:
    """Whether the stiffness is measured, so that it is no penalty."""
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
    return Variant(f"dt/{times}" if times > 1 else RUN, changes if times > 1 else {})


def _divided(where: str, group: Mapping, times: int) -> dict:
    changes: dict = {}
    if "time_step" in group:
        changes[f"{where}.time_step"] = group["time_step"] / times
    if "steps" in group:
        changes[f"{where}.steps"] = group["steps"] * times
    return changes


def twin(name: str, block: int, signs: tuple[int, int] = (1, 1)) -> Variant:
    """The run with one block displaced slightly when dynamics begin.

    Parameters
    ----------
    name : str
    block : int
        Its number, from 1.
    signs : (int, int)
        Of the displacement along x and y.
    """
    away = tuple(TRIFLE * sign for sign in signs)
    return Variant(name, {"control.displaced_block": str(block), "control.displaced_by": away})


def ensemble(facts: Facts, count: int) -> list[Variant]:
    """A number of twins with random blocks and signs of a fixed seed.

    Parameters
    ----------
    facts : Facts
    count : int
    """
    signs = ((1, 1), (1, -1), (-1, 1), (-1, -1))
    found = []
    for number in range(1, count + 1):
        dice = random.Random(number)
        block = dice.choice(facts.there)
        found.append(twin(f"{ENSEMBLE}{number}", block, dice.choice(signs)))
    return found


def stiffer(facts: Facts) -> Variant:
    """Four times the penalty stiffness.

    Parameters
    ----------
    facts : Facts
        With a penalty.
    """
    return Variant("4 k_n", {"contact.normal_stiffness": 4.0 * facts.penalty})
