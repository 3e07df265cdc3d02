# SPDX-License-Identifier: GPL-3.0-or-later
"""The model as a Python object: the groups of the input without loss, checked, run, built."""

import inspect
import re
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from model_text import BONDED, flying_block, namelist, rectangle, tower

import sitedda
from sitedda import InputError, Model
from sitedda.building import built_text, find_groups, kinds
from sitedda.groups import is_made, read_values, variable_kinds
from sitedda.model import Group
from sitedda.schema import GROUPS


def test_each_group_that_becomes_blocks_has_a_class():
    group_names = {group.name for group in GROUPS.values() if group.built}
    assert group_names == {*kinds(), "polygons"}
    for name, kind in kinds().items():
        files = set(getattr(kind, "from_file", "") and ("file", "layer", "scale"))
        names = set(variable_kinds()[name])
        assert set(vars(kind.__base__)) & names | files == names
        assert "Attributes" in kind.__doc__ and not kind.__doc__.startswith("&")


def test_the_executable_names_the_command_that_builds_blocks(binary, root):
    for name, group in (("slope", "region"), ("arch", "arch"), ("colonnade", "colonnade")):
        file = root / "inputs" / f"{name}.nml"
        for command in ("run", "check", "resume"):
            process = binary(command, file)
            assert process.returncode == 1
            assert f"group &{group} (line " in process.stderr
            assert f"'sitedda build {file}'" in process.stderr
            assert process.stderr.count("\n") == 1


def small_slope(**control) -> Model:
    """Nine blocks on a fixed block."""
    model = Model("A small slope", time_step=1e-3, steps=40, gravity=(0, -9.81), **control)
    model.material("rock", 2600.0, 5e9, 0.25)
    model.joint("bedding", 38.0)
    model.joint("cross", friction_angle=30.0)
    model.block([-1, -1, 5, -1, 5, 0, -1, 0], "base")
    model.region("rock", [0, 0, 4, 0, 4, 3, 1, 3], joint="cross")
    model.joint_set("bedding", angle=30.0, spacing=1.0)
    model.joint_line([2.2, -1, 2, 4], joint="cross")
    model.fixed_point(-0.9, -0.9)
    model.fixed_point(4.9, -0.9)
    model.measured_point("crest", 1.0, 3.0)
    return model


# --- The schema ----------------------------------------------------------------------------------


@pytest.mark.parametrize("group", GROUPS.values(), ids=lambda group: group.name)
def test_the_example_of_a_group_is_valid(group):
    parsed = find_groups(group.example)[0]
    assert parsed.name == group.name and read_values(parsed, "example")


def test_a_group_of_the_schema_is_a_method_with_its_variables():
    for group in GROUPS.values():
        if group.repeats and group.name != "bolt":
            names = [*inspect.signature(getattr(Model, group.name)).parameters]
            assert names == ["self", *(v.name for v in group.variables), "others"]
        if group.name != "run":
            text = inspect.getdoc(getattr(Model, group.name))
            assert group.meaning in text and all(v.name in text for v in group.variables)
    assert inspect.getdoc(Model.run).startswith("Run the model")


# --- Reading and writing -------------------------------------------------------------------------


def inputs():
    return sorted((Path(__file__).parents[3] / "inputs").rglob("*.nml"))


@pytest.mark.parametrize("file", inputs(), ids=lambda file: file.stem)
def test_every_input_is_read_and_written_without_loss(file):
    model = Model.read(file)
    text = model.to_namelist()
    copied_model = Model.from_namelist(text, file)
    assert copied_model == model and copied_model.to_namelist() == text
    parsed = [group.name for group in find_groups(file.read_text())]
    assert sorted(parsed) == sorted(group.name for group in find_groups(text))


def test_a_model_that_was_read_runs_bit_identically(write_input, same_bits):
    file = write_input(tower())
    read = Model.read(file).run().history
    same_bits(sitedda.run(file).history, read, attributes=("title", "step_control"))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("vertices = 0,0, 1,0, 1,1", [[0, 0], [1, 0], [1, 1]]),
        ("vertices = 2*0.0 1 0 ! a comment\n 2*1.0d0", [[0, 0], [1, 0], [1, 1]]),
        ("VERTICES = 0. .0 +1.0E+0,0 10D-1 1,", [[0, 0], [1, 0], [1, 1]]),
    ],
)
def test_values_are_read_in_fortran_notation(text, value):
    model = Model.from_namelist(f"&block name = 'a ''b'' !/&' {text} /")
    assert model["block"][0].name == "a 'b' !/&"
    assert model["block"][0].vertices.tolist() == value


BAD_TEXT = {
    "unknown group": ("\n&blok x = 1 /", "&blok (line 2)", "did you mean 'block'?"),
    "unknown variable": ("&joint\n frction_angle = 3 /", "&joint (line 1)", "'friction_angle'"),
    "part": ("&block vertices(1,600) = 3 /", "&block", "there is no element (1,600)"),
    "left out": ("&block vertices = 1,,3 /", "&block", "is missing"),
    "no number": ("&joint cohesion = 'x' /", "&joint", "not a number"),
    "unit": ("&material density = 2700 kg\n/", "&material", "values have no units"),
    "no quotes": ("&joint name = x /", "&joint", "must be in quotes"),
    "two values": ("&joint cohesion = 1 2 /", "&joint", "has all its values"),
    "no variable": ("&joint 3 4 /", "&joint", "'3' cannot be read here"),
    "too many": ("&motion values = 999999999999*0.0 /", "&motion", "is not a possible number"),
    "nan": ("&joint cohesion = nan /", "&joint", "not a usable number"),
    "whole": ("&layers count = 1.5 /", "&layers", "whole number"),
    "once": ("&run /\n&run /", "&run (line 2)", "only once"),
    "same name": ("&joint name = 'a' /\n&joint name = 'a' /", "&joint (line 2)", "used twice"),
    "odd": ("&block vertices = 1, 2, 3 /", "&block", "pairs"),
    "both": ("&control steps = 1, duration = 1 /", "&control (line 1)", "either `duration`"),
}


@pytest.mark.parametrize("name", BAD_TEXT)
def test_bad_text_is_refused_with_its_line_number(name):
    text, location, message = BAD_TEXT[name]
    with pytest.raises(InputError) as error:
        Model.from_namelist(text, "some.nml")
    assert "some.nml, group " + location in str(error.value) and message in str(error.value)


# --- Attributes ----------------------------------------------------------------------------------


def test_unknown_attributes_are_refused():
    model = small_slope()
    refused = [
        (lambda: setattr(model, "loads", [1]), AttributeError, "loads"),
        (lambda: setattr(model, "time_step", 1e-3), AttributeError, "model.control.time_step"),
        (lambda: setattr(model.control, "time_stp", 1), AttributeError, "'time_step'"),
        (lambda: setattr(model["material"][0], "rho", 1), AttributeError, "'rho'"),
        (lambda: model.jont("x"), AttributeError, "'joint'"),
        (lambda: model.joint("x", friction=3), InputError, "'friction_angle'"),
        (lambda: model.joint("cross"), InputError, "used twice"),
        (lambda: model.joint("x", "y"), InputError, "friction_angle"),
        (lambda: model.joint("x", name="y"), TypeError, "multiple"),
        (lambda: model.joint("x", True), InputError, "friction_angle"),
        (lambda: model.control(steps=3, duration=1), InputError, "either `duration` or `steps`"),
        (lambda: model["jont"], InputError, "'joint'"),
        (lambda: model["joint.cros"], InputError, "did you mean 'cross'?"),
        (lambda: model.block(shapely.Point(0, 0).buffer(2) - shapely.Point(0, 0).buffer(1)),
         InputError, "holes"),
        (lambda: model.joint("x", float("nan")), InputError, "not a usable number"),
    ]  # fmt: skip
    before = model.to_namelist()
    for act, kind, message in refused:
        with pytest.raises(kind) as error:
            act()
        assert message in str(error.value)
    assert model.to_namelist() == before


def test_variables_are_attributes():
    model = small_slope()
    rock = model["material.rock"]
    assert rock.density == 2600.0 and rock.initial_stress is None
    rock.initial_stress = (-1e5, -2e5, 0)
    rock(density=2700)
    assert "density = 2700.0" in repr(rock) and rock.initial_stress.tolist() == [-1e5, -2e5, 0]
    rock.initial_stress = None
    assert "initial_stress" not in model.to_namelist()
    with pytest.raises(ValueError, match="read-only"):
        model["block"][0].vertices[0] = 7
    model.control.duration = 2.0
    assert model.control.steps is None and model.title == "A small slope"
    model.remove(model["joint_line"][0])
    assert model["joint_line"] == [] and "1 joint_set" in repr(model)
    assert {"joint_set", "control", "run"} <= set(dir(model))
    assert "density" in dir(rock)


def test_blocks_from_arrays_and_polygons_of_either_orientation():
    square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    model = Model(time_step=1e-3, steps=1)
    model.add_blocks([square, shapely.box(2, 0, 3, 1), (square + (4, 0))[::-1].ravel().tolist()])
    model.material("rock", 2600.0, 5e9, 0.25)
    model.joint("dry", 30.0)
    with sitedda.Simulation(model) as simulation:
        assert [len(polygon) for polygon in simulation.polygons] == [4, 4, 4]
        assert simulation.coordinates[:, 0].tolist() == [0.5, 2.5, 4.5]


def test_long_motions_and_relative_records_go_into_files(tmp_path, same_bits, root):
    model = Model("Long", time_step=1e-3, steps=30)
    model.material("rock", 2600.0, 5e9, 0.25)
    model.joint("dry", 30.0)
    model.layers("base", 0.0, 0.0, 5.0, 1.0)
    shake = np.sin(np.arange(6000) / 7)
    model.motion("shake", shake, 1e-3, "acceleration")
    model.folder = root / "inputs"
    model.motion("quake", file="records/LomaPrieta1989_USGS1002_APEEL2_133.smc")
    model.fixed_point(1.0, 0.5, motion_x="shake", motion_y="quake")
    model.fixed_point(4.0, 0.5, motion_x="shake", motion_y="quake")
    model.measured_point("top", 2.5, 1.0)
    with pytest.raises(InputError, match="6000 values"):
        model.to_namelist()
    file = model.write(tmp_path / "long.nml")
    assert np.array_equal(np.loadtxt(tmp_path / "long.shake.txt"), shake)
    names = ("title", "step_control")
    same_bits(model.run().history, sitedda.run(file).history, attributes=names)


# --- Building ------------------------------------------------------------------------------------


def test_build_turns_groups_into_blocks():
    model = small_slope()
    built = model.build()
    assert not any(is_made(group._name) for group in built.groups)
    blocks = built["block"]
    assert len(blocks) == 10 and blocks[0].name == "base" and blocks[1].name == "rock_1"
    joints = [block.edge_joints or {block.joint} for block in blocks[1:]]
    assert set().union(*joints) == {"bedding", "cross"}
    assert Model.from_namelist(built.to_namelist()) == built
    assert len(model["block"]) == 1  # the model itself is unchanged


def test_model_file_built_file_and_executable_are_bit_identical(tmp_path, same_bits, main, binary):
    model = small_slope()
    file = model.write(tmp_path / "slope.nml")
    process = main("build", file)
    assert process.returncode == 0 and "9 blocks with" in process.stdout
    built = tmp_path / "slope_blocks.nml"
    binary.ok("run", built, "-o", tmp_path / "native.nc", "--quiet")
    names = ("title", "step_control")
    first = sitedda.run(file).history
    same_bits(first, model.run().history, attributes=names)
    same_bits(first, model.build().run().history, attributes=names)
    same_bits(first, tmp_path / "native.nc", attributes=names)


def test_lines_keep_their_numbers(tmp_path):
    pier = "&pier\n width = 1.0 ! m\n height = 2.0 /\n&block"
    text = namelist(flying_block()).replace("&block", pier)
    text += "&pier name = 'p', centre = 9.0, width = 1.0, height = 1.0, courses = 2 / "
    text += "&joint name = 'x'\n"
    text += "   friction_angle = -3 /\n"
    line = text[: text.index("&joint name = 'x'")].count("\n") + 1
    file = tmp_path / "m.nml"
    file.write_text(text)
    with pytest.raises(InputError, match=rf"m.nml, group &joint \(line {line}\): friction_angle"):
        sitedda.Simulation(file)
    built, groups = built_text(text, file)
    assert len(groups.blocks) == 3 and "! &pier\n!  width = 1.0 ! m\n" in built
    assert built.splitlines()[line - 1].lstrip().startswith("&joint")


def test_records_are_named_from_the_folder_of_the_built_file(tmp_path, root):
    (tmp_path / "out").mkdir()
    slope, target = root / "inputs" / "slope.nml", tmp_path / "out" / "b.nml"
    output, _ = sitedda.building.build_file(slope, target)
    with sitedda.Simulation(output) as simulation:
        assert len(simulation.block_names) > 90
    assert sitedda.building.built_text(output.read_text(), output)[0] == output.read_text()


BAD_GROUPS = [
    ("&joint_set angle = 3, spacing = 1 /", "&joint_set", "needs a &region"),
    ("&region outline = 0,0,1,0,1,1 /\n&joint_set angle = 3 /", "&joint_set (line 2)", "spacing"),
    ("&region outline = 0,0,1,1,1,0,0,1 /", "&region (line 1)", "crosses"),
    ("&region outline = 0,0,1,0,1,1, file = 'a.csv' /", "&region", "either `outline` or `file`"),
    ("&region file = 'gone.csv' /", "&region", "no such file"),
    ("&region layer = 'a' /", "&region", "requires `file`"),
    ("&polygons name = 'a' /", "&polygons", "`file` is missing"),
    ("&arch radius = 1 /", "&arch (line 1)", "thickness"),
    ("&pier width = 'a' /", "&pier", "not a number"),
    ("&cutting slivers = 'eat' /", "&cutting", "'eat'"),
    ("\n&pier width = 1, height = 1, joint = 'bedd' /", "(line 2)", "did you mean 'bedding'?"),
    ("&region outline = 0,0,1,0,1,1, material = 'x' /", "&region",
     "is not the name of a &material"),
    ("&region outline = 0,0,1,0,1,1 /\n&voronoi size = 1, region = 'x' /", "&voronoi (line 2)",
     "is not the name of a &region"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "location", "message"), BAD_GROUPS, ids=lambda one: one[:24])
def test_groups_that_cannot_be_built_report_their_position(
    text, location, message, write_input, main
):
    file = write_input(text + "\n" + namelist(flying_block()))
    process = main("build", file)
    assert process.returncode == 1 and not file.with_name("model_blocks.nml").exists()
    assert location in process.stderr and message in process.stderr


WORDS = ["0", "-1", "1e300", "nan", "1e-300", "999999999999", "'x'", "1e6", "(", "&", "/", "=", "é"]


@settings(max_examples=60, deadline=None)
@given(
    data=st.data(),
    file=st.sampled_from([f for f in inputs() if built_text(f.read_text(), f)[1].blocks]),
)
def test_damaged_groups_are_built_or_refused(data, file):
    """Values of the groups that are built are replaced at random."""
    text = file.read_text()
    for _ in range(data.draw(st.integers(1, 3))):
        values = [m for m in re.finditer(r"(?<![\w.])[-+]?\d[\d.eE+-]*", text)]
        index = data.draw(st.sampled_from(values))
        text = text[: index.start()] + data.draw(st.sampled_from(WORDS)) + text[index.end() :]
    for act in (lambda: built_text(text, file), lambda: Model.from_namelist(text, file).build()):
        try:
            act()
        except sitedda.SiteddaError as error:
            assert str(error)


def test_build_does_not_overwrite_its_input(write_input, main):
    file = write_input(flying_block())
    before = file.read_text()
    assert "is the input itself" in main("build", file, "-o", file).stderr
    assert file.read_text() == before


def test_check_and_run_name_slivers(write_input, main, tmp_path):
    thin = ("block", {"name": "thin", "vertices": [0.0, 5.0, 2.0, 5.0, 2.0, 5.0 + 1e-6]})
    slivers = [("block", {"vertices": rectangle(x, 8.0, 1.0, 1.0)}) for x in (0.0, 2.0)]
    file = write_input([*flying_block(), thin, *slivers])
    for command in ("check", "run"):
        process = main(command, file, *(["--no-plot"] if command == "run" else []), folder=tmp_path)
        assert "note: 1 block is a sliver: block 2 thin at" in process.stdout


def test_changes_apply_to_groups_that_are_built():
    model = small_slope()
    with sitedda.Simulation(model) as one:
        count = len(one.block_names)
    with sitedda.Simulation(model, joint_set={"spacing": 0.5}) as other:
        assert len(other.block_names) > count + 4


def test_groups_accept_names_of_others_and_defaults():
    model = Model(time_step=1e-3, steps=1)
    model.region(outline=[0, 0, 4, 0, 4, 4, 0, 4])
    model.joint_line([0, 2, 4, 2], region="rock")
    assert [block.name for block in model.build()["block"]] == ["rock_1", "rock_2"]
    assert built_text("! &region\n&run /", "m.nml")[0] == "! &region\n&run /"


def test_edges_without_a_joint_have_the_first_of_the_model():
    model = Model(time_step=1e-3, steps=1)
    model.joint("first", 30.0)
    model.joint("second", 30.0)
    model.region(outline=[0, 0, 4, 0, 4, 4, 0, 4])
    model.joint_line([0, 2, 4, 2.5], "second")
    lower, upper = model.build()["block"]
    assert (lower.joint, upper.joint) == ("second", "second")
    assert lower.edge_joints == ("first", "first", "second", "first")
    assert upper.edge_joints == ("second", "first", "first", "first")


def test_groups_compare_by_value():
    one, other = Group("joint", {"cohesion": 1}), Group("joint", {"cohesion": 1.0})
    assert one == other and one != Group("joint") and Model("a") != Model("b")
    assert BONDED["cohesion"] == Group("joint", BONDED).as_dict()["cohesion"]


def test_whole_numbers_are_exact_or_refused():
    model = sitedda.Model()
    largest = 2**53 - 1
    model.voronoi(size=1.0, seed=largest)
    assert sitedda.Model.from_namelist(model.to_namelist())["voronoi"][0].seed == largest
    with pytest.raises(sitedda.InputError, match=f"seed: {2**53} is too large.*{largest}"):
        model.voronoi(size=1.0, seed=2**53)
    with pytest.raises(sitedda.InputError, match=r"&voronoi \(line 1\).*too large"):
        sitedda.Model.from_namelist(f"&voronoi size = 1, seed = {2**53 + 1} /")


def test_errors_of_a_model_cite_the_call_or_the_line_that_was_read(tmp_path):
    def model() -> sitedda.Model:
        return sitedda.Model.from_namelist(namelist(tower()), "tower.nml")

    def refusal(model) -> str:
        with pytest.raises(sitedda.InputError) as caught:
            sitedda.Simulation(model)
        assert "model.nml" not in str(caught.value)
        return str(caught.value)

    bad = model()
    bad.material(name="clay", density=-1.0, young_modulus=1e9, poisson_ratio=0.2)
    assert refusal(bad).startswith("Model.material(…), 'clay': density = -1 must be")
    bad = model()
    bad.load(1.0, 99.0, time=[0.0, 1.0], force_x=[1.0, 1.0])
    assert refusal(bad).startswith("Model.load(…), number 1: ")
    bad = model()
    bad["joint"][0].friction_angle = 95.0
    assert refusal(bad).startswith("tower.nml, group &joint (line ")
    assert refusal(sitedda.Model(time_step=-1.0, steps=3)).startswith("Model.control: time_step")
    assert refusal(sitedda.Model(time_step=1.0, steps=3)) == "Model: the group &material is missing"
    bad = model()
    bad.arch(span=-4.0, rise=1.0, thickness=0.5, voussoirs=15)
    assert refusal(bad).startswith("Model.arch(…), number 1: ")


def test_errors_of_a_change_cite_the_call():
    with sitedda.Simulation(sitedda.Model.from_namelist(namelist(tower()))) as run:
        for call, message in [
            (lambda: run.change(time_step=-1.0), "change(time_step = -1.0): &control: time_step"),
            (lambda: run.change(time_step="a"), "change(time_step = 'a'): &control: time_step"),
            (lambda: run.change({"joint.cohesion": -1.0}), "change(joint.cohesion = -1.0): &joint"),
            (lambda: run.add("load", x=1, y=99, time=[0, 1]), "add('load', …): &load: the point"),
        ]:
            with pytest.raises(sitedda.InputError) as caught:
                call()
            assert str(caught.value).startswith(f"Simulation.{message}")
            assert ".nml" not in str(caught.value)
