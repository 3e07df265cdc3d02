# SPDX-License-Identifier: GPL-3.0-or-later
"""Changes of variables by name: the right variable changes, and the rest of the text does not."""

import re

import numpy as np
import pytest
from model_text import changed, namelist, tower

import sitedda
from sitedda.changes import Typed, changed_input
from sitedda.input_text import find_groups

TEXT = """! head: / & ' "
&control time_step = 1e-3 ! s; a comment with / and 'quote
  steps = 40,
  gravity = 0.0,
     -9.81   ! down
/
&material name='clay' ! soft
  density=1900. young_modulus = 1e7 /
&MATERIAL
 Name = "it's / sand", Density = 2000.0
/
&joint friction_angle=30/
&motion name = 'quake', values(1) = 0.0, values(2) = 1.0, 0.5/
&load x=1, y=2, force_x = 0, 1, 0 /
&load x=3, y=2, force_x = 0, 1, 0 /
"""


NATIVE = [
    ["time_step=5e-4", "gravity=0,-5", "settle=True"],
    ["joint[cross].friction_angle=33", "joint.cross.cohesion=7e3", "duration=0.01"],
    ["joint[2].cohesion=8", "joint[*].tensile_strength=10", "output.block_interval=5"],
    ["material.density=1900", "contact.normal_stiffness=1e10", "title='It''s /&! new'"],
    ["title=It's new", "output.history_interval=2", "joint[cross].name='cross'"],
]
COMMENTED = """! a & b / 'c'
&control time_step = 1e-3, ! s / x & y
  steps = 10, gravity = 0, -9.81  ! comment
/
&run title = 'old' / ! and new
&joint name = 'bed''s', friction_angle=30 /
&joint name='cross', friction_angle = 20., cohesion = 1 ! c = 3
/
&material name='rock', density=2000, young_modulus=1e9, poisson_ratio=.2 /
&layers width = 2, thickness = 1, joint = 'cross', count = 3 /
&fixed_point x = 0.5, y = 0.1 / &fixed_point x = 1.5, y = 0.1 /
&measured_point name = 'top', x = 1, y = 3 /
&output file = 'o.nc' /
"""


@pytest.mark.parametrize("changes", NATIVE, ids=" ".join)
def test_both_programs_make_the_same_text_and_resume_runs_of_the_other(
    changes, write_input, binary, main, tmp_path, same_bits
):
    file = write_input(COMMENTED)
    options = [text for change in changes for text in ("--set", change)]
    for one, other in ((binary, main), (main, binary)):
        one.ok("run", file, *options, "-q", "-o", f"{one.name}.nc", folder=tmp_path)
        process = other("resume", file, *options, "-q", "-o", f"{one.name}.nc", folder=tmp_path)
        assert process.returncode == 0 and "is complete" in process.stdout, process.stderr
    same_bits(tmp_path / "sitedda.nc", tmp_path / "sitedda-native.nc")
    assert binary("check", file, *options).stdout != binary("check", file).stdout


def test_a_checkpoint_of_one_program_is_accepted_by_the_other(write_input, binary, tmp_path):
    file, options = write_input(COMMENTED), ["--set", "time_step=5e-4", "--set", "title=It's new"]
    changes = {name: Typed(value) for name, value in (text.split("=", 1) for text in options[1::2])}
    with sitedda.Simulation(file, tmp_path / "o.nc", changes=changes) as run:
        run.advance(3)
    process = binary("resume", file, *options, "-q", folder=tmp_path)
    assert (process.returncode, "resumed at step 3" in process.stdout) == (0, True), process.stderr


@pytest.mark.parametrize("change", ["gravity=", "settle="])
def test_a_change_without_a_value_is_refused(change, write_input, binary, main):
    for program in (binary, main):
        process = program("check", write_input(COMMENTED), "--set", change)
        assert process.returncode == 1 and "a value is needed" in process.stderr


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("joint.friction_angle=3", "the input has 2 groups &joint (bed's, cross); name one"),
        ("joint[crss].cohesion=3", "no &joint named 'crss'; did you mean 'cross'?"),
        ("frction_angle=3", "no group has this variable; did you mean 'friction_angle'?"),
        ("jont.cohesion=1", "no group &jont; did you mean 'joint'?"),
        ("joint[1].cohesin=1", "no variable 'cohesin'; did you mean 'cohesion'?"),
        ("x=3", "several groups have this variable"),
        ("load.x=1", "the input has no group &load to change"),
        ("foo", "must have the form NAME=VALUE"),
        ("time_step=-1", "group &control (line 2): time_step = -1"),
        ("joint[2].cohesion=-1", "group &joint (line 7): cohesion = -1"),
    ],
)
def test_both_programs_refuse_changes_with_the_nearest_name(
    change, message, write_input, binary, main
):
    file = write_input(COMMENTED)
    for program in (binary, main) if "=" in change else (binary,):
        process = program("check", file, "--set", change)
        assert process.returncode == 1
        assert message in process.stderr and process.stderr.count("\n") == 1


def read(text: str) -> list[tuple[str, dict]]:
    """Return the groups with their values."""
    return [
        (group.name, {k: getattr(v, "tolist", lambda v=v: v)() for k, v in group.values.items()})
        for group in find_groups(text)
    ]


def test_an_ambiguous_name_of_joint_and_yielding_material_is_refused():
    """A group counts if it states its law, or if its default law permits the variable."""
    yielding_input = TEXT.replace("young_modulus = 1e7 /",
                                  "young_modulus = 1e7 law = 'mohr_coulomb' /")  # fmt: skip
    assert yielding_input != TEXT
    with pytest.raises(sitedda.InputError, match="material.friction_angle or joint.friction_angle"):
        changed_input(yielding_input, {"friction_angle": 35.0})


@pytest.mark.parametrize(
    ("path", "value", "index", "variable"),
    [
        ("time_step", 5e-4, 0, "time_step"),
        ("control.time_step", 5e-4, 0, "time_step"),
        ("control.dynamic_factor", 0.5, 0, "dynamic_factor"),
        ("gravity", (0.0, -1.5), 0, "gravity"),
        ("friction_angle", np.float64(35.0), 3, "friction_angle"),
        ("joint.cohesion", 1e6, 3, "cohesion"),
        ("joint[1].cohesion", 1e6, 3, "cohesion"),
        ("material.clay.density", 1.5, 1, "density"),
        ("material[clay].young_modulus", 2e9, 1, "young_modulus"),
        ("material[it's / sand].density", 1500, 2, "density"),
        ("material[2].name", "it's gravel", 2, "name"),
        ("motion.quake.values", np.array([0.0, 2.0]), 4, "values"),
        ("load[2].x", 4.5, 6, "x"),
        ("load.2.force_y", [1.0, 2.0], 6, "force_y"),
    ],
)
def test_one_variable_changes_and_nothing_else(path, value, index, variable):
    before, new = read(TEXT), changed_input(TEXT, {path: value})
    new_value = (np.asarray(value).tolist() if variable in ("gravity", "values",
                                                            "force_y") else value)  # fmt: skip
    expected = before[index][1] | {variable: new_value}
    assert read(new) == [*before[:index], (before[index][0], expected), *before[index + 1 :]]
    assert new.count("\n") == TEXT.count("\n")
    assert re.findall("!.*", new) == re.findall("!.*", TEXT)


def test_every_line_keeps_its_number():
    changes = {"gravity": (0.0, -1.0), "material.2.density": 1.0, "motion.values": [0.0] * 50}
    old_lines, new_lines = TEXT.splitlines(), changed_input(TEXT, changes).splitlines()
    equal_lines = [
        i for i, (one, other) in enumerate(zip(old_lines, new_lines, strict=True)) if one == other
    ]
    assert set(range(len(old_lines))) - set(equal_lines) == {3, 4, 9, 12}


def test_nested_mappings_select_groups_and_names():
    nested = changed_input(TEXT, {"material": {"clay": {"density": 1.0}}, "joint": {"cohesion": 2}})
    assert nested == changed_input(TEXT, {"material.clay.density": 1.0, "joint.cohesion": 2})


def test_a_star_selects_all_groups_of_a_kind():
    loads = [v for name, v in read(changed_input(TEXT, {"load[*].x": 9})) if name == "load"]
    assert [group["x"] for group in loads] == [9, 9]


def test_none_removes_a_variable_and_steps_replace_the_duration():
    control = read(changed_input(TEXT, {"steps": None, "gravity": None}))[0][1]
    assert set(control) == {"time_step"}
    assert set(read(changed_input(TEXT, {"duration": 1.0}))[0][1]) == {
        "time_step",
        "gravity",
        "duration",
    }


def test_a_group_that_may_be_missing_is_added():
    new = changed_input(TEXT, {"normal_stiffness": 1e9, "output.file": "a.nc", "title": "T"})
    assert new.startswith(TEXT)
    assert read(new)[7:] == [
        ("contact", {"normal_stiffness": 1e9}),
        ("output", {"file": "a.nc"}),
        ("run", {"title": "T"}),
    ]


@pytest.mark.parametrize(
    ("path", "message"),
    [
        (
            "material.density",
            ["2 groups &material", "clay, it's / sand", "material[clay].density", "[*]"],
        ),
        ("load.x", ["2 groups &load (1, 2)", "load[1].x"]),
        ("material.cly.density", ["no &material named 'cly'", "did you mean 'clay'?"]),
        ("load[3].x", ["no &load named '3'", "there are 1, 2"]),
        ("material.clay.densty", ["&material has no variable 'densty'", "mean 'density'?"]),
        ("time_stp", ["time_stp: no group has this variable", "did you mean 'time_step'?"]),
        ("motoin.scale", ["no group &motoin", "did you mean 'motion'?"]),
        ("output", ["output: this is a group", "output.file"]),
        ("file", ["several groups", "motion.file", "output.file", " or "]),
        ("wall.bricks", ["no group &wall"]),
        ("a b", ["a b: no group has this variable"]),
    ],
)
def test_an_unknown_or_ambiguous_name_is_refused(path, message):
    with pytest.raises(sitedda.InputError) as error_info:
        changed_input(TEXT, {path: 1})
    for part in message:
        assert part in str(error_info.value)


def test_a_value_that_a_namelist_cannot_contain_is_refused():
    with pytest.raises(sitedda.InputError, match="steps: a namelist cannot contain"):
        changed_input(TEXT, {"steps": object()})


def test_errors_of_a_damaged_text_are_those_of_the_engine(write_input):
    file = write_input("&control time_step = 1e-3\n&material density = 1 /\n")
    with pytest.raises(sitedda.InputError, match="no closing slash"):
        sitedda.run(file, time_step=1e-4)


def test_a_named_material_changes_without_others(write_input):
    clay = {"name": "clay", "density": 1800.0, "young_modulus": 1e9, "poisson_ratio": 0.3}
    groups = [*changed(tower(steps=1), "layers", 1, material="clay"), ("material", clay)]
    file = write_input(groups)
    history = sitedda.run(file, changes={"material.clay.density": 1900.0}).history
    assert set(history.block_density.values[1:]) == {1900.0}
    assert history.block_density.values[0] == 2643.0
    with pytest.raises(sitedda.InputError, match=r"2 groups &material \(rock, clay\)"):
        sitedda.run(file, material={"density": 999.0})


def test_errors_after_changes_name_the_line_of_the_file(write_input):
    text = "! a comment\n" * 7 + namelist(tower())
    line = 1 + text[: text.index("&material")].count("\n")
    with pytest.raises(sitedda.InputError, match=rf"&material \(line {line}\)"):
        sitedda.run(write_input(text), changes={"time_step": 5e-4, "material.density": -1.0})


def test_a_null_value_counts_as_missing():
    text = "&material name = 'rock', density = , young_modulus = 1e9, poisson_ratio = /\n"
    assert find_groups(text)[0].values == {"name": "rock", "young_modulus": 1e9}
