# SPDX-License-Identifier: GPL-3.0-or-later
"""Variables of an input changed by name, as keyword arguments and ``--set`` do."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from difflib import get_close_matches

from .errors import InputError
from .groups import is_made, single_groups, variables
from .namelist import Group, Namelist, Verbatim, value_text

_EXCLUSIVE = {"duration": "steps", "steps": "duration"}  # giving one takes the other out
_PATH = re.compile(r"\s*(\w+)\s*(?:\[(.*?)\])?\s*(?:\.\s*(.+?))?\s*", re.DOTALL)


# What may change while a model is stepped; all variables of loads but their names.
BETWEEN_STEPS = {
    "control": ("time_step", "gravity"),
    "joint": ("friction_angle", "cohesion", "tensile_strength"),
    "load": ("x", "y", "block", "time", "force_x", "force_y"),
    "motion": ("file", "format", "quantity", "unit", "time_step", "values", "scale", "taper",
               "drift_order", "channel", "after_end"),
    "fixed_point": ("direction", "motion_x", "motion_y"),
}  # fmt: skip


class Typed(str):
    """A value as it is typed on a command line: the kind of its variable says how it is meant."""


def changed_input(text: str, changes: Mapping, allowed: Mapping | None = None) -> str:
    """The namelist text with variables changed; every line keeps its number.

    Parameters
    ----------
    text : str
        Of the input.
    changes : mapping
        Values by the name of what they change, None for the default:

        - ``variable``, of &control or where only one kind of group has it: ``time_step``;
        - ``group.variable``, where the input has one group of that kind: ``motion.scale``;
        - ``group.name.variable`` or ``group[name].variable`` for a group among several, by its
          variable ``name`` or its number from 1: ``material.clay.density``, ``load[2].x``;
          ``group[*].variable`` for all of them;
        - ``group`` or ``group.name``, with a mapping of variables and values.
    allowed : mapping, optional
        The variables of each group that may be changed (all).

    Returns
    -------
    str

    Raises
    ------
    InputError
        If a name is unknown, or does not say which of several groups is meant.
    """
    namelist = Namelist.of(text)
    for path, value in flat_changes(changes):
        groups, variable = _target(namelist, path)
        if isinstance(value, Typed):
            value = _as_meant(path, value.strip(), variables()[groups[0].name][variable])
        if allowed is not None and variable not in allowed.get(groups[0].name, ()):
            known = "; ".join(f"&{kind}: {', '.join(names)}" for kind, names in allowed.items())
            raise InputError(f"{path} cannot change during a run; what can is of {known}")
        try:
            value_text(value if value is not None else "")
        except TypeError as trouble:
            raise InputError(f"{path}: {trouble}") from trouble
        for group in groups:
            if value is not None and variable in _EXCLUSIVE and group.name == "control":
                group.set(_EXCLUSIVE[variable], None)
            group.set(variable, value)
    return str(namelist)


def in_words(changes: Mapping) -> str:
    """Changes as one line, for the output."""
    return ", ".join(f"{path} = {value_text(value)}" for path, value in flat_changes(changes))


def _as_meant(path: str, text: str, kind: str) -> Verbatim:
    """A typed value in the words of a namelist, the same as the native executable makes of it."""
    if kind.startswith("text"):
        return Verbatim(text if text.startswith(("'", '"')) else value_text(text))
    if not text:
        raise InputError(f"{path}: a value is needed")
    if kind == "logical" and text.lower() in ("true", "false"):
        return Verbatim(f".{text.lower()}.")
    return Verbatim(text)


def flat_changes(changes: Mapping, before: str = "") -> Iterator[tuple[str, object]]:
    """Paths and values of mappings within mappings."""
    for name, value in changes.items():
        path = f"{before}.{name}" if before else str(name)
        if isinstance(value, Mapping):
            yield from flat_changes(value, path)
        else:
            yield path, value


def _target(namelist: Namelist, path: str) -> tuple[list[Group], str]:
    """The groups that a path means, and the variable of theirs."""
    match = _PATH.fullmatch(path)
    if not match:
        raise InputError(f"{path!r} does not name a variable, as time_step or joint[bed].cohesion")
    kind, which, rest = match[1].lower(), match[2], match[3]
    if which is None and rest is None:
        return _bare(namelist, kind)
    if which is None:
        which, dot, rest = rest.rpartition(".")
        which = which if dot else None
    if kind not in variables():
        raise InputError(f"{path}: there is no group &{kind}{_nearest(kind, variables())}")
    variable = (rest or "").lower()
    if variable not in variables()[kind]:
        known = variables()[kind]
        hint = _nearest(variable, known) or f"; it has {', '.join(known)}"
        raise InputError(f"{path}: group &{kind} has no variable {variable!r}{hint}")
    return _chosen(namelist, path, kind, which, variable), variable


def _bare(namelist: Namelist, variable: str) -> tuple[list[Group], str]:
    """The one group that a variable without a group can mean."""
    homes = [kind for kind, names in variables().items() if variable in names]
    if "control" in homes:
        homes = ["control"]
    if not homes:
        if variable in variables():
            known = f"{variable}.{next(iter(variables()[variable]))}"
            raise InputError(f"{variable!r} is a group: name a variable of it, such as {known}")
        names = sorted({name for names in variables().values() for name in names})
        raise InputError(f"no group has a variable {variable!r}{_nearest(variable, names)}")
    if any(not is_made(kind) for kind in homes):  # joints and masonry count where there are any
        homes = [kind for kind in homes if not is_made(kind) or namelist.named(kind)]
    if len(homes) > 1:
        paths = " or ".join(f"{kind}.{variable}" for kind in homes)
        raise InputError(f"{variable!r} is a variable of several groups: name one, as {paths}")
    return _chosen(namelist, variable, homes[0], None, variable), variable


def _chosen(namelist: Namelist, path: str, kind: str, which: str | None, variable: str):
    """The groups of a kind that are meant: the only one, one by name or number, or all (*)."""
    groups = namelist.named(kind)
    if which is None and kind in single_groups():
        return groups or [namelist.add(kind)]
    if not groups:
        raise InputError(f"{path}: the input has no group &{kind} to change")
    if which is None and len(groups) == 1 or which == "*":
        return groups
    names = [group.get("name") or str(i) for i, group in enumerate(groups, 1)]
    if which is None:
        shown = ", ".join(names[:8]) + (", …" if len(names) > 8 else "")
        raise InputError(
            f"{path}: the input has {len(groups)} groups &{kind} ({shown}); name one, as "
            f"{kind}[{names[0]}].{variable}, or all: {kind}[*].{variable}"
        )
    which = which.strip().strip("'\"")
    found = [group for group, name in zip(groups, names, strict=True) if name == which]
    if not found and which.isdecimal() and 1 <= int(which) <= len(groups):
        found = [groups[int(which) - 1]]
    if not found:
        hint = _nearest(which, names) or f"; there are {', '.join(names[:8])}"
        raise InputError(f"{path}: there is no &{kind} named {which!r}{hint}")
    return found


def _nearest(word: str, known) -> str:
    """A hint at the most similar of the known words, or nothing."""
    close = get_close_matches(word, known, 1)
    return f"; did you mean {close[0]!r}?" if close else ""
