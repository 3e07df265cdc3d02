# SPDX-License-Identifier: GPL-3.0-or-later
"""Add a stage to the input of a running simulation."""

from collections.abc import Mapping
from dataclasses import dataclass

from ..base.errors import InputError
from .changes import Typed, changed_input
from .groups import checked, group_text
from .input_text import find_groups

ADDED = ("remove", "release", "drop", "change_joints", "change_materials", "zero_displacements",
         "displacement", "duration", "steps", "time_step", "integration", "theta")  # fmt: skip
_ROUNDING = 1e-9  # relative tolerance of times, in Δt, as in the engine


@dataclass(frozen=True)
class PresentStage:
    """Progress of a stage.

    `steps`, `time`: steps taken and time elapsed (s) since the stage began.
    `planned`, `time_step`: planned number of steps and the time step Δt (s).
    """

    steps: int
    time: float
    planned: int
    time_step: float

    def last(self, adaptive: bool) -> int:
        """Return the number of steps Δt of the stage if another stage follows, as in the engine."""
        steps = max(self.steps, 1)
        if adaptive:
            steps = int(self.time / self.time_step + _ROUNDING) + 2
        return min(self.planned, steps)


def with_stage(
    text: str, present: PresentStage, file, name: str, kind: str, values: Mapping
) -> str:
    """Return the text of an input whose last stage ends now and is followed by another.

    `present`: the last stage of the text.
    `file`: file of the text.
    `name`, `kind`: name and kind of the new stage.
    `values`: other variables of the new stage, as values or as `Typed`.
    """
    for name_of_value in values:
        if name_of_value not in ADDED:
            allowed = ", ".join(ADDED)
            raise InputError(f"an added stage cannot have {name_of_value}; use only {allowed}")
    groups = find_groups(text, file, ("block",))
    control = next((group.values for group in groups if group.name == "control"), {})
    stages = [name_of_value for name_of_value in groups if name_of_value.name == "stage"]
    end = present.last(control.get("time_step_control") == "adaptive")
    remainder = present.planned - end
    if stages:
        final = f"stage[{len(stages)}]"
        text = changed_input(text, {f"{final}.duration": None, f"{final}.steps": end}, file=file)
    else:
        text = _with_stages_of_control(text, control, end, file)
    groups_text = [group_text("stage", {"name": name, "kind": kind})]
    timed = "duration" in values or "steps" in values
    if kind == "static" and remainder > 0:
        groups_text.append(group_text("stage", {"name": f"{name}, after", "steps": remainder}))
    elif kind != "static" and not timed:
        values = dict(values) | {"steps": max(remainder, 1)}
    text = f"{text.rstrip()}\n{''.join(groups_text)}"
    path = f"stage[{max(len(stages), 1 + bool(control.get('settle'))) + 1}]"
    typed_values = {f"{path}.{k}": v if isinstance(v, Typed) else checked("stage", k, v)
             for k, v in values.items()}  # fmt: skip
    return changed_input(text, typed_values, file=file)


def _with_stages_of_control(text: str, control: Mapping, end: int, file) -> str:
    """Return the text of an input without &stage, with its implicit stages as groups."""
    settles = bool(control.get("settle"))
    stages = group_text("stage", {"name": "rest", "kind": "static"}) if settles else ""
    values = {"name": "run", "steps": end, "zero_displacements": settles or None}
    unset = {f"control.{name}": None for name in ("settle", "duration", "steps") if name in control}
    text = changed_input(text, unset, file=file)
    return f"{text.rstrip()}\n{stages}{group_text('stage', values)}"
