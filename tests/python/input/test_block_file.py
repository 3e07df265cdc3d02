# SPDX-License-Identifier: GPL-3.0-or-later
"""Block files are equivalent to &block groups, bit-identically; wrong contents are detected."""

import resource
import struct
from contextlib import contextmanager
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from model_text import BONDED, DRY, ROCK, rectangle

import sitedda
from sitedda.block_file import LARGE, write_block_file
from sitedda.building import build_file


def two_on_a_base() -> sitedda.Model:
    """Three blocks of two materials whose edges name two joints; one block has no name."""
    model = sitedda.Model("Three blocks", time_step=1e-3, steps=30, gravity=(0.0, -9.81))
    model.material(**ROCK)
    model.material(**(ROCK | {"name": "clay", "density": 1900.0}))
    model.joint(**DRY)
    model.joint(**(BONDED | {"name": "cross"}))
    model.block(rectangle(-3, -1, 6, 1), "base")
    model.block(rectangle(-2, 0, 2, 1), "left", "clay", edge_joints=("bedding", "cross"))
    model.block(rectangle(0, 0, 2, 1.5), joint="cross")
    model.fixed_point(-2.5, -0.5)
    model.fixed_point(2.5, -0.5)
    model.measured_point("top", 1.0, 1.5)
    return model


def state(source) -> tuple:
    with sitedda.Simulation(source) as run:
        run.advance(30)
        return run.block_names, run.coordinates, run.block_materials, run.edge_joints


def test_a_block_file_equals_the_text(tmp_path):
    model = two_on_a_base()
    text = model.write(tmp_path / "text.nml", block_file=False)
    file = model.write(tmp_path / "file.nml", block_file=True)
    assert "&block " not in file.read_text() and (tmp_path / "file.blocks.nc").exists()
    for one, other in zip(state(text), state(file), strict=True):
        assert np.array_equal(one, other)
    (tmp_path / "below").mkdir()
    copied_file = sitedda.Model.read(file).write(tmp_path / "below" / "again.nml")
    assert np.array_equal(state(copied_file)[1], state(text)[1])


def test_blocks_that_overlap_are_refused_with_the_name_of_their_file(tmp_path):
    model = two_on_a_base()
    model.block(rectangle(1, 0, 2, 1), "right")
    file = model.write(tmp_path / "file.nml", block_file=True)
    with pytest.raises(sitedda.InputError, match=r"right overlaps block 3.*; block file .*nc$"):
        sitedda.Simulation(file)


def test_groups_keep_their_order(tmp_path):
    model = two_on_a_base()
    model.layers("stack", left=20.0, width=1.0, thickness=1.0, count=2)
    model.block(rectangle(30, 0, 1, 1), "last")
    file = model.write(tmp_path / "m.nml", block_file=True)
    assert state(file)[0] == ["base", "left", "", "stack_1", "stack_2", "last"]
    assert (tmp_path / "m.blocks_2.nc").exists()


def test_both_programs_read_block_files_bit_identically(tmp_path, binary, same_bits):
    two_on_a_base().write(tmp_path / "m.nml", block_file=True)
    sitedda.run(tmp_path / "m.nml", output=tmp_path / "python.nc")
    binary.ok("run", "m.nml", "-o", "native.nc", "-q", folder=tmp_path)
    same_bits(tmp_path / "python.nc", tmp_path / "native.nc")
    output = sitedda.open_output(tmp_path / "native.nc")
    assert output.block.values.tolist() == ["base", "left", "block 3"]
    assert output.block_material.values.tolist() == [0, 1, 0]
    assert output.edge_joint.values.tolist() == [0] * 4 + [0, 1, 0, 0] + [1] * 4
    assert output.attrs["block_files"].startswith("m.blocks.nc, CRC-64 ")


def test_build_writes_block_files_of_large_models_or_on_request(tmp_path, root, main):
    arch = tmp_path / "arch.nml"
    arch.write_text((root / "inputs" / "arch.nml").read_text())
    main.ok("build", arch, "--block-file")
    output, built_text = build_file(arch, tmp_path / "text.nml")
    assert "&blocks" not in output.read_text()
    for one, other in zip(state(output), state(tmp_path / "arch_blocks.nml"), strict=True):
        assert np.array_equal(one, other)
    large_model = sitedda.Model(time_step=1e-3, steps=1)
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    large_model.add_blocks([square + [2.0 * i, 0.0] for i in range(LARGE)])
    assert large_model.write(tmp_path / "many.nml").stat().st_size < 1000


def test_another_block_file_is_another_input(tmp_path):
    """A checkpoint and a complete output belong to their blocks."""
    model = two_on_a_base()
    file = model.write(tmp_path / "m.nml", block_file=True)
    with sitedda.Simulation(file, tmp_path / "o.nc") as run:
        run.advance(10)
        run.checkpoint()
    model.groups[4].name = "slab"  # the text of the input does not change
    content = file.read_text()
    model.write(file, block_file=True)
    assert file.read_text() == content
    with pytest.raises(sitedda.OutputError, match="another input or block file"):
        sitedda.resume(file, tmp_path / "o.nc")
    sitedda.run(file, tmp_path / "o.nc")
    assert "is complete" in sitedda.Simulation(file, tmp_path / "o.nc", resume=True).notice
    model.groups[4].name = "plate"
    model.write(file, block_file=True)
    assert "is complete" not in sitedda.Simulation(file, tmp_path / "o.nc", resume=True).notice


def test_a_file_that_cannot_be_replaced_leaves_no_other_file(tmp_path):
    (tmp_path / "m.nc").mkdir()
    with pytest.raises(sitedda.OutputError, match="m.nc is a folder, not a file name"):
        write_block_file(tmp_path / "m.nc", [{"vertices": rectangle(0.0, 0.0, 1.0, 1.0)}])
    assert [path.name for path in tmp_path.iterdir()] == ["m.nc"]


def test_reading_takes_time_in_proportion_to_the_blocks(tmp_path, binary):
    """Four times as many blocks need at most four times the time (16 if quadratic)."""
    times = [time_to_read(side, tmp_path, binary) for side in (158, 316)]
    assert times[1] < 8.0 * times[0]


def time_to_read(side: int, tmp_path, binary) -> float:
    """Processor time (s) in which the executable reads side² blocks from a file."""
    x, y = (v.ravel() for v in np.meshgrid(np.arange(side), np.arange(side)))
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    squares = np.stack([x, y], axis=1)[:, None] + corners
    blocks = [{"name": f"block_{i}", "vertices": square} for i, square in enumerate(squares)]
    write_block_file(tmp_path / "m.nc", blocks)
    (tmp_path / "m.nml").write_text(
        "&control time_step = 1e-3, steps = 1 /\n&blocks file = 'm.nc' /\n"
        "&material density = 2e3, young_modulus = 1e9, poisson_ratio = 0.2 /\n"
        "&joint friction_angle = 30 /\n&blocks file = 'none.nc' /\n"  # stops after the first
    )
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    process = binary("run", "m.nml", folder=tmp_path)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert "&blocks (line 5): none.nc cannot be read" in process.stderr
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


# --- Wrong contents -------------------------------------------------------------------------------


SQUARES = np.reshape(rectangle(0.0, 0.0, 1.0, 1.0) + rectangle(2.0, 0.0, 1.0, 1.0), (-1, 2))


def dataset(**changes):
    """Write a file of two squares with changed variables: (dimensions, kind, values)."""
    variables = {
        "vertices": (("vertex", "axis"), "f8", SQUARES),
        "corners": (("block",), "i4", [4, 4]),
        "material": (("block",), "i4", [1, 0]),
        "edge_joint": (("vertex",), "i4", [1, 0, 0, 0, 0, 0, 0, 1]),
        "material_name": (("m", "l"), "S1", [list("rock")]),
        "joint_name": (("j", "n"), "S1", [list("bedding")]),
    } | changes

    def write(file):
        with netCDF4.Dataset(file, "w", format="NETCDF3_64BIT_OFFSET") as data:
            for name, variable in variables.items():
                if variable is not None:
                    define(data, name, *variable)

    return write


def define(data, name, dimensions, kind, values, **options) -> None:
    """Define a variable and write its values; a shape instead of values writes nothing."""
    shape = values if isinstance(values, tuple) else np.shape(values)
    for dimension, size in zip(dimensions, shape, strict=True):
        if dimension not in data.dimensions:
            data.createDimension(dimension, size)
    variable = data.createVariable(name, kind, dimensions, **options)
    if not isinstance(values, tuple):
        variable[:] = np.asarray(values, dtype=kind)


def moved_vertex(*index):
    squares = SQUARES.copy()
    squares[5] = index
    return ("vertex", "axis"), "f8", squares


def claims(**lengths):
    """Write a valid file whose header contains other lengths of dimensions."""

    def write(file):
        dataset()(file)
        data = bytearray(file.read_bytes())
        for name, length in lengths.items():
            padded = name.encode() + b"\0" * (-len(name) % 4)
            at = data.index(struct.pack(">i", len(name)) + padded) + 4 + len(padded)
            data[at : at + 4] = struct.pack(">i", length)
        file.write_bytes(data)

    return write


BILLION = 1_000_000_000
LIES = {
    "no vertices": (dataset(vertices=None), "no variable 'vertices'"),
    "no corners": (dataset(corners=None), "no variable 'corners'"),
    "no blocks": (dataset(corners=(("none",), "i4", (0,)), material=None, edge_joint=None),
                  "vertices contains 8 values, more than 0"),
    "too few corners": (dataset(corners=(("block",), "i4", [4, 2])), "block 2 has 2 corners"),
    "too many corners": (dataset(corners=(("block",), "i4", [600, 4])), "block 1 has 600 corners"),
    "negative corners": (dataset(corners=(("block",), "i4", [-4, 12])), "block 1 has -4 corners"),
    "other sum": (dataset(corners=(("block",), "i4", [4, 5])), "9 corners, but vertices"),
    "corners of reals": (dataset(corners=(("block",), "f8", [4.7, 4.2])),
                         "corners must contain whole numbers"),
    "corners of text": (dataset(corners=(("block",), "S1", list("44"))), "must contain numbers"),
    "not a number": (dataset(vertices=moved_vertex(np.nan, 0)), "vertex 6 is at (NaN, 0)"),
    "infinite": (dataset(vertices=moved_vertex(3, -np.inf)), "vertex 6 is at (3, -Inf"),
    "too far": (dataset(vertices=(("vertex", "axis"), "f8", 1e10 * SQUARES)), "reaches farther"),
    "crossing": (dataset(vertices=moved_vertex(2.5, 3)), "block 2: vertices: the polygon crosses"),
    "three axes": (dataset(vertices=(("vertex", "axis"), "f8", np.zeros((8, 3)))),
                   "x and y of each vertex, not 3 numbers"),
    "one axis": (dataset(vertices=(("vertex",), "f8", np.zeros(8))), "2 dimensions, not 1"),
    "clockwise": (
        dataset(
            vertices=(("vertex", "axis"), "f8", [[0, 0], [0, 1], [1, 0]]),
            corners=(("block",), "i4", [3]), material=None, edge_joint=None,
        ),
        "block 1: vertices run clockwise",
    ),
    "no such material": (dataset(material=(("block",), "i4", [1, 2])),
                         "material(2) = 2 is not one of the 1 names in material_name"),
    "negative joint": (dataset(edge_joint=(("vertex",), "i4", [0] * 7 + [-1])),
                       "edge_joint(8) = -1 is not one of the 1 names in joint_name"),
    "too few joints": (dataset(edge_joint=(("e",), "i4", [0] * 5)), "contains 5 values, not 8"),
    "unknown name": (dataset(joint_name=(("j", "n"), "S1", [list("beding")])),
                     "joint_name = 'beding' is not the name of a &joint; is 'bedding' meant?"),
    "long names": (dataset(name=(("block", "long"), "S1", [["x"] * 65] * 2)),
                   "names of 65 bytes; at most 64"),
    "other names": (dataset(name=(("b", "l"), "S1", [list("rock")])), "contains 1 names, not 2"),
    "a billion vertices": (claims(vertex=BILLION), "bad.nc: cannot be read as netCDF"),
    "a billion blocks": (claims(block=BILLION), "bad.nc: cannot be read as netCDF"),
    "a million vertices": (claims(vertex=1_000_000), "bad.nc"),
    "a negative length": (claims(vertex=-5), "bad.nc"),
    "a few more": (claims(vertex=9), "bad.nc"),
    "a few less": (claims(vertex=7), "bad.nc"),
}  # fmt: skip


def test_a_variable_of_an_unknown_type_is_refused(tmp_path):
    """The library divides by the size of a type, which is 0 for unknown types."""
    file = tmp_path / "bad.nc"
    dataset()(file)
    data = bytearray(file.read_bytes())
    header = b"\0\0\0\x08material" + b"\0\0\0\x01"  # length of the name, name, one dimension
    kind = data.index(header) + len(header) + 4 + 8  # its number, no attributes
    assert data[kind : kind + 4] == b"\0\0\0\x04"
    data[kind + 3] = 12
    file.write_bytes(data)
    assert "bad.nc is damaged" in refused(tmp_path)


def refused(tmp_path) -> str:
    """Return the error for an input that names the file."""
    (tmp_path / "model.nml").write_text(
        "&control time_step = 1e-3, steps = 1 /\n"
        "&material name = 'rock', density = 2e3, young_modulus = 1e9, poisson_ratio = 0.2 /\n"
        "&joint name = 'bedding', friction_angle = 30 /\n"
        "&blocks file = 'bad.nc' /\n"
    )
    with pytest.raises(sitedda.InputError) as error:
        sitedda.Simulation(tmp_path / "model.nml")
    return str(error.value)


@contextmanager
def more_memory(limit: int):
    """Limit the additional memory of the process within the context, in bytes."""
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (size + limit, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


@pytest.mark.parametrize("fault", LIES)
def test_wrong_contents_are_refused_in_one_message(fault, tmp_path):
    write, phrase = LIES[fault]
    write(tmp_path / "bad.nc")
    with more_memory(200_000_000):
        message = refused(tmp_path)
    assert phrase in message
    assert "group &blocks (line 4): " in message and message.count("\n") == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.nc", "model.nml"]


def test_other_files_are_refused_as_block_files(tmp_path, binary):
    invalid_file = tmp_path / "bad.nc"
    invalid_file.write_bytes(b"CDF\x01")
    assert "bad.nc is damaged, or does not have the classic netCDF format" in refused(tmp_path)
    for content in (b"", b"no netCDF", b"\x89HDF\r\n\x1a\n" + b"\0" * 100):
        invalid_file.write_bytes(content)
        assert "bad.nc does not have the classic netCDF format" in refused(tmp_path)
    invalid_file.unlink()
    assert "bad.nc cannot be read: No such file" in refused(tmp_path)
    invalid_file.mkdir()
    assert "bad.nc" in refused(tmp_path)
    process = binary("run", "model.nml", folder=tmp_path)
    assert process.returncode == 1 and process.stderr.count("\n") == 1


def test_a_truncated_file_is_refused(tmp_path):
    complete = tmp_path / "whole.nc"
    dataset()(complete)
    data = complete.read_bytes()
    for fraction in (0.2, 0.5, 0.9, 0.99):
        (tmp_path / "bad.nc").write_bytes(data[: int(fraction * len(data))])
        assert "bad.nc" in refused(tmp_path)
