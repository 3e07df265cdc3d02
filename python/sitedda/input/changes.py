# SPDX-License-Identifier: GPL-3.0-or-later
"""Change variables of an input by name, for keyword arguments and ``--set``."""

import argparse
from collections.abc import Callable, Iterator, Mapping

from ..base.errors import InputError, located
from .groups import value_text
from .input_text import ParsedGroup, find_groups, with_changes

# Variables that may change during a run; all variables of loads except their names.
BETWEEN_STEPS = {
    "control": ("time_step", "gravity"),
    "joint": ("friction_angle", "cohesion", "tensile_strength", "fracture_energy",
              "shear_fracture_energy"),
    "load": ("x", "y", "block", "time", "force_x", "force_y"),
    "motion": ("file", "format", "quantity", "unit", "time_step", "values", "scale", "taper",
               "drift_order", "channel", "after_end"),
    "fixed_point": ("direction", "motion_x", "motion_y"),
}  # fmt: skip


class Typed(str):
    """A value typed on a command line; the kind of its variable determines how it is read."""


def merged(changes: Mapping | None, variables: Mapping) -> dict:
    """Return changes and keyword arguments together; raise InputError if `changes` has no names."""
    if changes is not None and not isinstance(changes, Mapping):
        raise InputError(
            f"changes = {changes!r} must be a mapping, as {{'material.clay.density': 1900.0}}"
        )
    return dict(changes or {}) | dict(variables)


def changed_input(text: str, changes: Mapping, allowed: Mapping | None = None, file="input") -> str:
    """Return the text of an input with changed variables; line numbers do not change.

    `text`: the input.
    `changes`: values by the path of a variable; None restores the default.  A path is one of:

    - ``variable``, if &control or only one kind of group has it: ``time_step``
    - ``group.variable``, if the input has one group of that kind: ``motion.scale``
    - ``group.name.variable`` or ``group[name].variable`` for a group among several, by its variable
      ``name`` or its number from 1: ``material.clay.density``, ``load[2].x``
    - ``group[*].variable`` for all groups of a kind
    - ``group`` or ``group.name``, with a mapping of variables and values

    `allowed`: the variables of each group that may be changed (all).
    `file`: file of the text, for messages.
    """
    texts = [(path, _change_text(path, value)) for path, value in flat_changes(changes)]
    text, variables = with_changes(text, texts, file)
    for (path, _), variable in zip(texts, variables, strict=True):
        if allowed is not None and variable.name not in allowed.get(variable.group, ()):
            hint = "; ".join(f"&{kind}: {', '.join(names)}" for kind, names in allowed.items())
            raise InputError(f"{path} cannot change during a run; these can: {hint}")
    return text


def _change_text(path: str, value) -> str | None:
    """Return a new value as text; None, if the default is restored."""
    with located(path, TypeError):
        return value if value is None or isinstance(value, Typed) else value_text(value)


def changes_text(changes: Mapping) -> str:
    """Format changes as one line, for the output."""
    return ", ".join(f"{path} = {value_text(value)}" for path, value in flat_changes(changes))


def flat_changes(changes: Mapping, prefix: str = "") -> Iterator[tuple[str, object]]:
    """Flatten nested mappings into pairs of paths and values."""
    for name, value in changes.items():
        path = f"{prefix}.{name}" if prefix else str(name)
        if isinstance(value, Mapping):
            yield from flat_changes(value, path)
        else:
            yield path, value


def with_files(text: str, name_of: Callable[[ParsedGroup], str], file="input") -> str:
    """Return a text in which groups refer to other files.

    `name_of`: returns the new file name of a group, or an empty text if it does not change.
    `file`: file of the text, for messages.
    """
    parts, start = [], 0
    for item in find_groups(text, file, ("block",)):
        if name := name_of(item):
            group = changed_input(text[item.start : item.end], {f"{item.name}.file": name})
            parts += [text[start : item.start], group]
            start = item.end
    return "".join(parts) + text[start:]


def add_changes(parser: argparse.ArgumentParser) -> None:
    """Add the option --set; ``dict(options.set)`` then maps variables to values."""
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        type=_parse_assignment,
        help="change a variable of the input: time_step=5e-4, output.file=fine.nc, "
        "material.clay.density=1900, joint[bed].friction_angle=30, joint[*].cohesion=0",
    )


def _parse_assignment(text: str):
    """Return name and value of NAME=VALUE."""
    name, equals, value = text.partition("=")
    if not equals:
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE")
    return name.strip(), Typed(value)
