# SPDX-License-Identifier: GPL-3.0-or-later
"""The schema of the input agrees with the reader of the engine and with its use in Python."""

import re

import pytest
from model_text import namelist, tower

import sitedda
from sitedda.changes import changed_input
from sitedda.engine import engine_names
from sitedda.input_text import groups_by_name
from sitedda.schema import GROUPS

NOTHING = "there is no variable"
VARIABLES = [v for group in GROUPS.values() if not group.built for v in group.variables]
SINGLE = {name for name, group in GROUPS.items() if not group.repeats}
GROUPS_READ = [name for name, group in GROUPS.items() if not group.built]


def value_of(variable):
    """Return a valid value of a variable by its kind."""
    value = {"real": 1.0, "points": 1.0, "integer": 1, "logical": True}.get(variable.kind, "x")
    return [value] if variable.size else value


def needed(variable):
    """Return the variables that a group must have for a variable to be permitted."""
    switch, _, values = variable.when.partition(" = ")
    return {switch: values.split("'")[1]} if switch else {}


def test_every_variable_of_the_schema_is_read(root):
    """Its value is used by a reader, or by a type of the model that extends the values."""
    files = (root / "fortran").rglob("*.f90")
    names = set(re.findall(r"%(\w+)", "".join(file.read_text() for file in files)))
    published = [(v.group, v.name) for v in VARIABLES]
    assert len(published) == len(set(published))
    assert {name for _, name in published} <= names


def test_each_variable_has_meaning_default_and_values():
    assert SINGLE == {"run", "control", "contact", "output", "stop", "cutting"}
    for variable in VARIABLES:
        assert variable.default and variable.meaning, variable
        assert variable.values or variable.kind == "logical", variable


@pytest.mark.parametrize("variable", VARIABLES, ids=lambda v: f"{v.group}-{v.name}")
def test_every_variable_is_known_to_the_reader(variable, write_input):
    groups = [*tower(), (variable.group, {variable.name: value_of(variable)})]
    if variable.group in SINGLE:
        groups = [g for g in tower() if g[0] != variable.group] + groups[-1:]
    try:
        sitedda.Simulation(write_input(groups)).close()
    except sitedda.InputError as refusal:
        assert NOTHING not in str(refusal), refusal


@pytest.mark.parametrize("variable", VARIABLES, ids=lambda v: f"{v.group}-{v.name}")
def test_every_variable_is_changed_in_its_group(variable):
    """`penetration_tolerance` and `contact_rules` were once changed in &control."""
    path = f"{variable.group}[*].{variable.name}"
    groups = [(name, needed(variable)) for name in (*GROUPS_READ, variable.group)]
    groups = [(name, values if name == variable.group else {}) for name, values in groups]
    after = changed_input(namelist(groups), {path: value_of(variable)})
    changed_groups = groups_by_name(after)[variable.group]
    assert all(group.get(variable.name) == value_of(variable) for group in changed_groups)


@pytest.mark.parametrize("variable", VARIABLES, ids=lambda v: f"{v.group}-{v.name}")
def test_a_name_without_group_is_accepted_if_unambiguous(variable):
    text = namelist([("run", {}), (variable.group, needed(variable))])
    same_names = [v for v in VARIABLES if v.name == variable.name]
    homes = {v.group for v in same_names if not v.when or v.group == variable.group}
    if len(homes) > 1 and "control" not in homes:
        with pytest.raises(sitedda.InputError, match="several groups have this variable"):
            changed_input(text, {variable.name: value_of(variable)})
        return
    group_name = "control" if "control" in homes else homes.pop()
    after = groups_by_name(changed_input(text, {variable.name: value_of(variable)}))[group_name]
    assert after[0][variable.name] == value_of(variable)


CLAUSES = [
    (v, *clause.rpartition(": ")[::2], excludes)
    for v in VARIABLES
    for cell, excludes in ((v.needs, False), (v.excludes, True))
    for clause in filter(None, cell.split("; "))
]


@pytest.mark.parametrize(
    ("variable", "condition", "items", "excludes"),
    CLAUSES,
    ids=lambda v: getattr(v, "name", str(v)),
)
def test_what_the_schema_needs_and_excludes_is_refused(
    variable, condition, items, excludes, write_input
):
    group_variables = {v.name: v for v in VARIABLES if v.group == variable.group}
    names = re.split(", | or ", re.sub(" = '[^']*'", "", items))
    assigned = needed(variable) | {
        variable.name: condition.split("'")[1] if condition else value_of(variable)
    }
    excluded_names = [names[0]] if excludes else []
    for group_variable in group_variables.values():  # variables that its law or kind requires
        switch, _, values = group_variable.when.partition(" = ")
        if (
            group_variable.default.startswith("required by its ")
            and f"'{assigned.get(switch)}'" in values
        ):
            excluded_names.append(group_variable.name)
    if excludes and ":" not in variable.needs:
        excluded_names += filter(None, re.split(", | or ", variable.needs))
    alternatives = GROUPS[variable.group].needs.split(" or ")
    if not {*alternatives} & {*assigned, *excluded_names, ""}:
        excluded_names.append(
            next(
                group_variable
                for group_variable in reversed(alternatives)
                if group_variable not in names
            )
        )
    assigned = {name: value_of(group_variables[name])
                for name in excluded_names if excludes or name not in names} | assigned  # fmt: skip
    groups = [g for g in tower() if g[0] not in SINGLE or g[0] != variable.group]
    with pytest.raises(sitedda.InputError, match=rf"\b({'|'.join(names)})\b"):
        sitedda.Simulation(write_input([*groups, (variable.group, assigned)]))


@pytest.mark.parametrize(
    ("text", "phrases"),
    [
        ("&control time_stop = 1 /", ["'time_stop'", "is 'time_step' meant?"]),
        ("&control friction_angle = 3 /", ["'friction_angle'", "it belongs to &material, &joint"]),
        ("&control qqqqqq = 3 /", ["'qqqqqq'", "known are time_step, steps"]),
        ("&controll steps = 3 /", ["&controll", "is &control meant?"]),
        ("&qqqqqq steps = 3 /", ["&qqqqqq", "known are &run, &control"]),
    ],
)
def test_an_unknown_name_gets_the_nearest_known_one(text, phrases, write_input):
    with pytest.raises(sitedda.InputError) as error_info:
        sitedda.Simulation(write_input(text))
    for phrase in phrases:
        assert phrase in str(error_info.value)


def test_names_of_energies_counts_and_phases_agree(write_input):
    with sitedda.Simulation(write_input(tower(steps=2))) as run:
        run.phase_times()
        run.advance(2)
        assert tuple(run.energies) == engine_names("energies")
        assert tuple(run.counts) == engine_names("counts")
        assert tuple(run.phase_times()) == engine_names("phases")
        assert run.counts["steps"] == 2
    assert engine_names("nothing of the kind") == ()
