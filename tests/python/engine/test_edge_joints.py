# SPDX-License-Identifier: GPL-3.0-or-later
"""Edges that name different joints: friction, order of the blocks, output, resumption."""

import numpy as np
import pytest
import xarray as xr
from model_text import ROCK, group, rectangle
from test_checkpoint import stopped

import sitedda

WEIGHT = ROCK["density"] * 9.81  # weight of the slider of 1 m², N/m
ROUGH, SMOOTH, SIDE = 0, 1, 2  # indices in the list of joints
ANGLES = {ROUGH: 35.0, SMOOTH: 15.0, SIDE: 5.0}
SLIDE = 1


def slider(floor="edges", speed: float = 6.0, load=None, steps=900, reverse=False) -> list:
    """A block of 1 m x 1 m on a floor whose joint changes at x = 0; smoother sides."""
    sides = ["", "side", "side", "side"]
    outline = [-4.0, -1.0, 4.0, -1.0, 4.0, 0.0, 0.0, 0.0, -4.0, 0.0]
    joints = ["side", "side", "smooth", "rough", "side"]
    floors = [group("block", name="floor", vertices=outline, edge_joints=joints)]
    if floor == "blocks":
        floors = [group("block", name=name, vertices=rectangle(left, -1.0, 4.0, 1.0),
                        edge_joints=["side", "side", name, "side"])
                  for name, left in (("rough", -4.0), ("smooth", 0.0))]  # fmt: skip
    block = {"name": "slider", "vertices": rectangle(-1.3, 0.0, 1.0, 1.0), "material": "moving"}
    blocks = [*floors, ("block", block | {"joint": "top", "edge_joints": sides})]
    if reverse:
        blocks.reverse()
    loads = [] if load is None else [group("load", x=-0.8, y=0.5, block="slider", **load)]
    fixed_points = [(x, y) for x in (-3.5, -0.5, 0.5, 3.5) for y in (-0.9, -0.1)]
    return [
        group("control", time_step=5e-4, steps=steps, gravity=[0.0, -9.81]),
        group("contact", normal_stiffness=1e9),
        ("material", dict(ROCK)),
        ("material", ROCK | {"name": "moving", "initial_velocity": [speed, 0.0, 0.0]}),
        *(
            group("joint", name=name, friction_angle=ANGLES[joint])
            for name, joint in (("rough", ROUGH), ("smooth", SMOOTH), ("side", SIDE))
        ),
        group("joint", name="top", friction_angle=45.0),
        *blocks,
        *(group("fixed_point", x=x, y=y) for x, y in fixed_points),
        *loads,
        group("output", file="slider.nc", block_interval=50),
    ]


def sampled_contacts(file, interval: int = 5, push: float = 0.0):
    """Contacts of the slider with positions of their vertices, and its coordinates, at intervals.

    If the slider is pushed, to a speed in m/s, it first comes to rest.
    """
    with sitedda.Simulation(file) as run:
        if push:
            run.advance(400)
            rates = run.rates
            rates[np.argmax(run.coordinates[:, 1]), 0] = push
            run.rates = rates
        at_end = False
        while not at_end:
            at_end = run.advance(interval)
            polygons, contacts = run.polygons, run.contacts
            block = np.repeat(np.arange(len(polygons)), [len(p) for p in polygons])
            top_block = np.argmax(run.coordinates[:, 1])
            of_contact = block[[contacts["vertex"], contacts["edge"]]]
            is_of_slider = (of_contact == top_block).any(axis=0)
            contacts = {name: values[is_of_slider] for name, values in contacts.items()}
            contacts["x"] = np.concatenate(polygons)[contacts["vertex"], 0]
            yield contacts, polygons[top_block][:, 0].min()


@pytest.mark.parametrize("floor", ["edges", "blocks"])
def test_friction_follows_the_edge_below(write_input, floor):
    tan = {joint: np.tan(np.deg2rad(angle)) for joint, angle in ANGLES.items()}
    before, after = [], []
    for contacts, left in sampled_contacts(write_input(slider(floor, 0.0, steps=1300)), push=6.0):
        is_pressed = contacts["normal_force"] > 1e-3 * WEIGHT
        joint, x = contacts["joint"][is_pressed], contacts["x"][is_pressed]
        assert set(joint) <= {ROUGH, SMOOTH}
        assert (joint[x < -0.01] == ROUGH).all()
        assert (joint[x > 0.01] == SMOOTH).all()
        sliding = is_pressed & (contacts["state"] == SLIDE)
        bound = contacts["normal_force"] * [tan[j] for j in contacts["joint"]]
        shear = np.abs(contacts["shear_force"][sliding])
        np.testing.assert_allclose(shear, bound[sliding], atol=1e-8 * WEIGHT)
        force = -shear.sum()
        normal = contacts["normal_force"].sum()
        if left + 1.0 < -0.02:
            before.append((force, -tan[ROUGH] * normal))
        elif left > 0.02:
            after.append((force, -tan[SMOOTH] * normal))
    assert len(before) > 5 and len(after) > 20
    for forces in (before, after):
        force, expected = np.transpose(forces)
        np.testing.assert_allclose(force, expected, atol=1e-8 * WEIGHT)
    mean = np.mean([force for force, _ in after[-20:]])
    assert mean == pytest.approx(-tan[SMOOTH] * WEIGHT, rel=0.05)


@pytest.mark.parametrize("floor", ["edges", "blocks"])
def test_the_order_of_the_blocks_does_not_matter(write_input, floor):
    def forces(reverse):
        file = write_input(slider(floor, 0.0, steps=1300, reverse=reverse), f"{reverse}.nml")
        for contacts, left in sampled_contacts(file, 50, push=6.0):
            is_closed = contacts["normal_force"] > 0.0
            columns = ("normal_force", "shear_force", "joint")
            rows = sorted(zip(*(contacts[name][is_closed] for name in columns), strict=True))
            yield left, np.array(rows)

    for (left, one), (other_left, other) in zip(forces(False), forces(True), strict=True):
        assert left == pytest.approx(other_left, abs=1e-9)
        assert one.shape == other.shape
        np.testing.assert_allclose(one, other, atol=1e-4 * WEIGHT)


@pytest.mark.parametrize(("offset", "joint"), [(2e-6, SMOOTH), (-2e-6, ROUGH)])
def test_a_corner_at_the_end_of_an_edge_does_not_change_its_joint(write_input, offset, joint):
    """Elastic shear below friction moves its foot to and fro over the change of joints."""
    groups = slider(speed=0.0, steps=400, load={"time": [0.0, 0.04, 0.08, 0.12, 0.16, 0.2]})
    load = next(values for name, values in groups if name == "load")
    load["force_x"] = [0.0, 0.25 * WEIGHT, -0.25 * WEIGHT, 0.25 * WEIGHT, -0.25 * WEIGHT, 0.0]
    block = next(v for name, v in groups if name == "block" and v["name"] == "slider")
    block["vertices"] = rectangle(offset, 0.0, 1.0, 1.0)
    load["x"] = 0.5
    xs, joints = [], set()
    for contacts, _ in sampled_contacts(write_input(groups), 1):
        corner = np.abs(contacts["x"]) < 0.1
        is_pressed = corner & (contacts["normal_force"] > 0.01 * WEIGHT)
        xs += list(contacts["x"][is_pressed])
        joints |= set(contacts["joint"][is_pressed])
    assert min(xs) < -1e-6 < 1e-6 < max(xs)
    assert joints == {joint}


def test_output_and_simulation_contain_the_joint(program, write_input, tmp_path):
    file = write_input(slider(steps=200))
    program.ok("run", file, "-q", "-o", tmp_path / "o.nc")
    with sitedda.Simulation(file) as run, xr.open_dataset(tmp_path / "o.nc") as out:
        run.advance(200)
        last = out.contact_frame == out.contact_frame.max()
        assert (out.contact_joint[last].values == run.contacts["joint"]).all()
        assert [str(name) for name in out.joint.values] == ["rough", "smooth", "side", "top"]
        assert set(out.contact_joint.values) <= {ROUGH, SMOOTH, SIDE}


@pytest.mark.parametrize("after", [1, 420, 600])
def test_a_resumed_slider_is_bit_identical(write_input, tmp_path, same_bits, binary, after):
    file = write_input(slider(steps=700))
    binary.ok("run", file, "-q", "-o", tmp_path / "whole.nc")
    stopped(file, tmp_path / "out.nc", after)
    sitedda.resume(file, tmp_path / "out.nc")
    same_bits(tmp_path / "whole.nc", tmp_path / "out.nc")


@pytest.mark.parametrize(
    ("joints", "phrases"),
    [
        (["rough"] * 6, ["6 names", "5 edges"]),
        (["rough"] * 5 + [""], ["6 names", "5 edges"]),
        (["rough", "gravel"], ["edge_joints(2) = 'gravel'", "&joint"]),
        (["rough", "a" * 300], ["edge_joints(2)", "at most 64 bytes"]),
        ([3.5], ["edge_joints(1)", "3.5"]),
        (["rough"] * 600, ["edge_joints"]),
        (["rough'\n/ &block x = '"], ["edge_joints"]),
    ],
    ids=["more", "blank more", "unknown", "long", "number", "far too many", "quote"],
)
def test_bad_edge_joints_are_refused(write_input, program, joints, phrases):
    groups = slider()
    floor = next(values for name, values in groups if name == "block")
    floor["edge_joints"] = joints
    file = write_input(groups)
    line = 1 + file.read_text().partition("&block")[0].count("\n")
    process = program("run", file)
    assert process.returncode == 1
    message = process.stdout + process.stderr
    assert str(file.name) in message and "&block" in message and f"line {line}" in message
    for phrase in phrases:
        assert phrase in message


def test_blank_and_missing_edges_use_the_joint_of_the_block(write_input, same_bits):
    """A block whose edges all name its joint equals a block without edge_joints."""
    plain = [(name, dict(values)) for name, values in slider(steps=300)]
    for name, values in plain:
        if name == "block":
            values["joint"] = "rough"
            values.pop("edge_joints")
    with_names = [(name, dict(values)) for name, values in plain]
    lists = iter([["", "rough", "", "rough", "rough"], ["rough"]])
    for name, values in with_names:
        if name == "block":
            values["edge_joints"] = next(lists)
    runs = [sitedda.run(write_input(groups, f"{len(groups)}{i}.nml"))
            for i, groups in enumerate((plain, with_names))]  # fmt: skip
    same_bits(*(run.history for run in runs), attributes=("title", "step_control"))
