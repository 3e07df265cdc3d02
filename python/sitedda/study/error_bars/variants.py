# SPDX-License-Identifier: GPL-3.0-or-later
"""Variants of a run: smaller time steps, larger penalty stiffness, displaced blocks (twins)."""

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np

from ...engine.damping import damping_of
from ...engine.simulation import Simulation
from ...input.input_text import input_values

RUN, TWIN, ENSEMBLE = "dt", "twin", "twin "  # names of variants; a number follows ENSEMBLE
STEPS = (1, 2, 4)  # divisors of Δt
PERTURBATION = 1e-9  # displacement of the block of a twin, as a fraction of its size
_ORDERS = {"midpoint": 2}  # orders of time integrations; other integrations have order 1


class Variants:
    """The axis of a study over variants of a run.

    `variants`: changes of the input in each variant, by its name.
    """

    def __init__(self, variants: Mapping[str, dict]):
        self._changes = list(variants.values())
        self.dims = {"variant": len(variants)}
        self.coordinates = {"variant": (("variant",), list(variants), {})}

    def changes(self, index: tuple[int, ...]) -> dict:
        """Return the changes of a variant."""
        return dict(self._changes[index[0]])


@dataclass(frozen=True)
class Facts:
    """Properties of a model that determine its variants."""

    groups: Mapping  # groups of the input
    order: int  # order of the time integration
    penalty: float  # penalty stiffness k_n, N/m; 0 if all joints have a measured stiffness
    # Numbers (from 1) of the blocks that no stage removes, from the highest block down
    remaining: Sequence[int] = (1,)

    @property
    def is_dynamic(self) -> bool:
        """Return whether any stage is dynamic."""
        return any(_is_dynamic_stage(stage) for stage in self.groups.get("stage", [{}]))

    @property
    def is_bonded(self) -> bool:
        """Return whether all joints have a tensile strength, so that a run may be linear."""
        return all(any(joint.get(f"{name}tensile_strength", 0.0) > 0.0 for name in ("", "peak_"))
                   for joint in self.groups.get("joint", []))  # fmt: skip

    @property
    def is_damped(self) -> bool:
        """Return whether a material or joint has damping."""
        joints = self.groups.get("joint", [])
        materials = self.groups.get("material", [])
        return any(map(damping_of, materials)) or any(j.get("damping", 0.0) > 0.0 for j in joints)


def facts_of(model, changes: Mapping) -> Facts:
    """Read a model and return the properties that determine its variants.

    `changes`: changes of the input.
    """
    with Simulation(model, changes=changes) as simulation:
        groups = input_values({"input_values": simulation.input_values})
        stiffness = simulation.normal_stiffness
        height = simulation.coordinates[:, 1]
        names = simulation.block_names
    control = next(iter(groups.get("control", [])), {})
    schemes = [control, *(s for s in groups.get("stage", []) if _is_dynamic_stage(s))]
    default = control.get("integration", "dda")
    order = min(_ORDERS.get(s.get("integration", default), 1) for s in schemes)
    # The stiffness of these joints is measured, so it is not a penalty stiffness.
    rigid = ["normal_stiffness_per_area" in joint or joint.get("law") == "barton_bandis"
           for joint in groups.get("joint", [])]  # fmt: skip
    penalty = 0.0 if rigid and all(rigid) else stiffness
    patterns = [p.strip() for s in groups.get("stage", []) for p in s.get("remove", "").split(",")]
    removed = [any(fnmatchcase(name, pattern) for pattern in patterns if pattern) for name in names]
    present = tuple(int(b) + 1 for b in np.argsort(-height, kind="stable") if not removed[b])
    return Facts(groups, order, penalty, present)


def _is_dynamic_stage(stage: Mapping) -> bool:
    return stage.get("kind", "dynamic") == "dynamic"


def finer(facts: Facts, divisor: int) -> dict:
    """Return the changes that divide all time steps by a whole number.

    `divisor`: the divisor.
    """
    groups = {"control": next(iter(facts.groups.get("control", [])), {})}
    stages = enumerate(facts.groups.get("stage", []), 1)
    groups |= {f"stage[{i}]": stage for i, stage in stages if _is_dynamic_stage(stage)}
    changes: dict = {}
    for path, group in groups.items() if divisor > 1 else ():
        if "time_step" in group:
            changes[f"{path}.time_step"] = group["time_step"] / divisor
        if "steps" in group:
            changes[f"{path}.steps"] = group["steps"] * divisor
    return changes


def twin(block: int, signs: tuple[int, int] = (1, 1)) -> dict:
    """Return the changes that displace a block slightly at the start of dynamics.

    `block`: number of the block, from 1; `signs`: signs of the displacement along x and y.
    """
    shift = tuple(PERTURBATION * sign for sign in signs)
    return {"control.displaced_block": str(block), "control.displaced_by": shift}


def ensemble(facts: Facts, count: int) -> dict[str, dict]:
    """Return the changes of each twin of an ensemble: reproducible random blocks and signs."""
    signs = ((1, 1), (1, -1), (-1, 1), (-1, -1))
    twins = {}
    for number in range(1, count + 1):
        generator = random.Random(number)
        block = generator.choice(facts.remaining)
        twins[f"{ENSEMBLE}{number}"] = twin(block, generator.choice(signs))
    return twins


def stiffer(facts: Facts) -> dict:
    """Return the change that multiplies the penalty stiffness by four."""
    return {"contact.normal_stiffness": 4.0 * facts.penalty}
