# SPDX-License-Identifier: GPL-3.0-or-later
"""Pipes, devices and damaged outputs instead of the files that a command reads."""

import json
import os
import sys
from contextlib import nullcontext
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from model_text import changed, tower

import sitedda
from sitedda.base.core import FILES
from sitedda.input_text import input_values
from sitedda.output.output_file import read_output
from sitedda.reading import check_readable, read_bounded

INPUTS = Path(__file__).parents[3] / "inputs"
sys.path.insert(0, str(Path(__file__).parents[2] / "robustness"))


@pytest.fixture
def pipe(tmp_path) -> Path:
    """Return a pipe without a writer: a reader would wait for ever."""
    file = tmp_path / "pipe"
    os.mkfifo(file)
    return file


def said(process) -> list[str]:
    assert process.returncode in (1, 5)
    return process.stderr.strip().splitlines()


@pytest.mark.parametrize("file", ["pipe", "/dev/zero", "/dev/stdin", "."])
@pytest.mark.parametrize("command", ["run", "check"])
def test_an_input_is_a_regular_file(program, pipe, command, file):
    (line,) = said(program(command, file, folder=pipe.parent))
    assert "cannot be read, because it is not a regular file" in line


@pytest.mark.parametrize(
    "command",
    [["draw"], ["view"], ["movie"], ["report"], ["surface"], ["site"], ["build"], ["safety"],
     ["record"], ["export", "--vtk", "out"], ["study", "run"], ["study", "collect"]],
    ids=" ".join,
)  # fmt: skip
def test_every_command_reads_only_regular_files(python_program, pipe, command):
    name = pipe.rename(pipe.with_suffix(".mp4" if command == ["movie"] else ".in"))
    (line,) = said(python_program(*command, name, folder=pipe.parent))
    assert "not a regular file" in line


def test_a_record_and_a_block_file_must_be_regular_files(program, write_input, pipe):
    recorded = changed(tower(), "motion", values=None, file="pipe", time_step=0.01)
    (line,) = said(program("run", write_input(recorded), folder=pipe.parent))
    assert "pipe" in line and "not a regular file" in line
    blocks = [*(g for g in tower() if g[0] != "layers"), ("blocks", {"file": "pipe"})]
    (line,) = said(program("run", write_input(blocks), folder=pipe.parent))
    assert "pipe" in line and "not a regular file" in line


def test_links_to_files_are_read(tmp_path):
    (tmp_path / "file").write_text("content")
    (tmp_path / "link").symlink_to("file")
    assert check_readable(tmp_path / "link") == 7
    assert read_bounded(tmp_path / "link", 7) == b"content"
    with pytest.raises(sitedda.InputError, match="larger than 6 bytes: it is 7 bytes long"):
        read_bounded(tmp_path / "link", 6)
    with pytest.raises(sitedda.InputError, match="no such file"):
        read_bounded(tmp_path / "none", 6)


@pytest.fixture(scope="module")
def output(tmp_path_factory) -> Path:
    """Return the output of a short run."""
    from model_text import namelist

    folder = tmp_path_factory.mktemp("whole")
    (folder / "tower.nml").write_text(namelist(tower()))
    return sitedda.run(folder / "tower.nml", output=folder / "tower.nc").output


def damage(output: Path, target: Path, change) -> Path:
    from damaged_outputs import rewrite

    rewrite(output, target, change)
    return target


def replaced(name: str, index, value):
    """Return a change of one value of a variable."""

    def change(variables, _):
        values = np.array(variables[name][2])
        values[index] = value
        variables[name][2] = values

    return change


WITHIN = Path(__file__).parents[2] / "data" / "within.nml"
DAMAGES = {
    "vertices": lambda variables, _: variables.pop("vertices"),
    "contact_gap": lambda variables, _: variables.pop("contact_gap"),
    "contact_edge": replaced("contact_edge", 0, 10**6),
    "contact_vertex": replaced("contact_vertex", 0, -1),
    "contact_frame": replaced("contact_frame", 0, 1),
    "vertex_block": replaced("vertex_block", 0, 3),
    "block_coordinates": replaced("block_coordinates", (0, 0, 0), np.nan),
    "block_stress": replaced("block_stress", (0, 0, 0), 1e300),
    "frame_time": replaced("frame_time", 0, 1e6),
    "block_material": replaced("block_material", 0, 99_999),
    "edge_joint": replaced("edge_joint", 0, 99_999),
    "time": lambda variables, _: variables["time"].__setitem__(0, "i4"),
    "block_rates": lambda variables, _: variables["block_rates"].__setitem__(
        1, ("frame", "coordinate_2", "block_2")
    ),
}


def test_boundaries_without_edges_or_length_are_not_drawn(main, tmp_path):
    ridge = sitedda.Model.read(INPUTS / "ridge.nml")
    ridge.control(duration=0.01)
    output = ridge.run(output=tmp_path / "ridge.nc").output

    def shorter(variables, _):
        for name in [name for name in variables if name.startswith("boundary_edge")]:
            variables[name][2] = variables[name][2][:2]

    def nothing(variables, _):
        variables["boundary_edge_to"][2] = variables["boundary_edge_from"][2]

    for change in (shorter, nothing):
        file = damage(output, tmp_path / "damaged.nc", change)
        main.ok("draw", file, folder=tmp_path)
    far_output = damage(output, tmp_path / "far.nc", replaced("boundary_edge_to", 0, 1e36))
    process = main("draw", far_output, folder=tmp_path)
    assert process.returncode == 5 and "variable boundary_edge_to:" in process.stderr


@pytest.mark.parametrize("name", [name for name in DAMAGES if name != "time"])
@pytest.mark.parametrize("command", ["draw", "report"])
def test_a_damaged_output_causes_one_error_with_file_and_variable(
    main, output, tmp_path, name, command
):
    file = damage(output, tmp_path / "damaged.nc", DAMAGES[name])
    process = main(command, file, folder=tmp_path)
    (line,) = process.stderr.strip().splitlines()
    assert process.returncode == 5
    assert "damaged.nc is damaged" in line and f"variable {name}:" in line


def test_a_copied_output_is_valid_and_bit_identical(output, tmp_path, same_bits):
    copy = damage(output, tmp_path / "copy.nc", lambda *_: None)
    with sitedda.open_output(copy) as data, netCDF4.Dataset(output) as original:
        assert np.array_equal(data.vertices, original["vertices"][...])
        assert set(data.variables) == set(original.variables)


def test_a_foreign_file_is_refused_as_output(main, tmp_path):
    with netCDF4.Dataset(tmp_path / "other.nc", "w") as data:
        data.createDimension("time", 3)
        data.createVariable("time", "f8", ("time",))[:] = 0.0
    process = main("draw", tmp_path / "other.nc")
    assert process.returncode == 5
    assert "or not an output of a run: variable time_step: it is missing" in process.stderr


def test_invalid_attributes_are_refused(main, output, tmp_path):
    def change(_, attributes):
        attributes["input_text"] = 3.0

    process = main("view", damage(output, tmp_path / "d.nc", change), "--no-open")
    assert process.returncode == 5 and "attribute input_text is not text" in process.stderr


@pytest.mark.parametrize(
    ("name", "text"),
    [("input_values", "{"), ("input_values", "[1]"), ("input_values", '{"joint": [3]}'),
     ("accuracy", "{"), ("accuracy", '{"figures": {"a": 1}}')],
)  # fmt: skip
def test_damaged_json_in_attributes_is_one_error(main, output, tmp_path, name, text):
    def change(_, attributes):
        attributes[name] = text

    process = main("report", damage(output, tmp_path / "d.nc", change), "-o", tmp_path / "p.html")
    assert process.returncode == 5 and f"damaged: its attribute {name}" in process.stderr
    assert len(process.stderr.strip().splitlines()) == 1 and not (tmp_path / "p.html").exists()


def test_a_site_needs_the_materials_of_its_blocks(main, tmp_path):
    def change(_, attributes):
        attributes["input_values"] = json.dumps(
            json.loads(attributes["input_values"]) | {"material": []}
        )

    site = sitedda.Model.read(INPUTS / "layered_site.nml")
    site.control(duration=0.5)
    site_output = site.run(tmp_path / "site.nc").output
    process = main("site", damage(site_output, tmp_path / "d.nc", change), "-o", tmp_path / "o.png")
    assert process.returncode == 5 and "its input lacks the material of a block" in process.stderr
    assert not (tmp_path / "o.png").exists()


def test_a_site_needs_a_block_at_each_of_its_points(main, tmp_path):
    site = sitedda.Model.read(INPUTS / "layered_site.nml")
    site.control(duration=0.5)
    site_output = site.run(tmp_path / "site.nc").output
    damaged_output = damage(site_output, tmp_path / "d.nc",
                            replaced("point_place", (0, 1), 99_999.0))  # fmt: skip
    process = main("site", damaged_output, "-o", tmp_path / "o.png")
    assert process.returncode in (1, 5) and "no block lies at the measured point" in process.stderr
    assert len(process.stderr.strip().splitlines()) == 1


def test_boundaries_of_one_name_are_drawn_by_their_number(tmp_path):
    from sitedda.facade.panels import curves_of
    from sitedda.output.output_file import load
    from sitedda.output.scene import Scene

    ridge = sitedda.Model.read(INPUTS / "ridge.nml")
    ridge.control(duration=0.1)
    history = load(sitedda.run(ridge, output=tmp_path / "ridge.nc").output)
    assert history.sizes["boundary"] > 1
    history = history.assign_coords(boundary=["one"] * history.sizes["boundary"])
    assert all(np.ndim(displacement) == 1 for _, displacement, *_ in curves_of(Scene.of(history)))


def test_an_output_of_an_earlier_version_is_refused(main, output, tmp_path):
    old_output = damage(output, tmp_path / "old.nc", lambda _,
                        attributes: attributes.pop("input_values"))  # fmt: skip
    process = main("draw", old_output, "-o", tmp_path / "o.png")
    assert process.returncode == 5 and "run its input again" in process.stderr


def test_an_output_contains_derived_values_of_its_input(tmp_path):
    text = WITHIN.read_text()
    file = tmp_path / "model.nml"
    file.write_text(
        text.replace(
            "young_modulus = 1e9, poisson_ratio = 0.25",
            "shear_velocity = 400, pressure_velocity = 700",
        )
    )
    history = sitedda.run(file, output=tmp_path / "o.nc").history
    values = input_values(history.attrs)
    (control,), (contact,), (material,) = (values[k] for k in ("control", "contact", "material"))
    with sitedda.Simulation(file) as run:
        assert contact["normal_stiffness"] == run.normal_stiffness
        assert json.loads(run.input_values) == values | {"output": values["output"]}
    assert (control["integration"], control["settle"]) == ("dda", True)
    assert control["gravity"] == [0, -9.81]
    shear = material["young_modulus"] / (2 * (1 + material["poisson_ratio"]))
    assert shear == pytest.approx(2400 * 400**2, rel=1e-12)
    assert values["joint"] == [values["joint"][0] | {"law": "coulomb", "cohesion": 1e4}]
    assert values["load"][0]["block"] == "left" and values["boundary"][0]["kind"] == "fixed"
    assert "block" not in values


@pytest.mark.parametrize("locked", [False, True])
def test_texts_and_late_errors_of_variables_read_on_first_use(output, tmp_path, locked):
    """A text selected from a row is a text; a thread that reads a file may lock it again."""
    file = tmp_path / "o.nc"
    file.write_bytes(Path(output).read_bytes())
    data = read_output(file)
    with FILES if locked else nullcontext():
        assert str(data.isel(block=0).block.values) == str(data.block.values[0])
        assert str(data.block[0].values) == str(data.block.values[0])
    vars(data["time"]).pop("values", None)
    data["time"]._source = None  # as a file that cannot be read later
    with pytest.raises(sitedda.OutputError, match=r"o\.nc cannot be read as an output"):
        _ = data["time"].values
