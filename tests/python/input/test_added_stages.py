# SPDX-License-Identifier: GPL-3.0-or-later
"""Stages that are added to a run, and models that are opened as drawn."""

import numpy as np
import pytest
from model_text import DRY, ROCK, group, rectangle

import sitedda

COMPARED = ("time", "displacement", "vertices", "block_rates", "energy_friction", "energy_removed")


def pile(**control) -> list:
    """Three blocks on a table with two fixed points."""
    return [
        ("control", {"time_step": 1e-3, "duration": 0.3, "gravity": [0.0, -9.81], **control}),
        group("contact", normal_stiffness=1e9),
        ("material", ROCK),
        ("joint", dict(DRY, name="dry")),
        group("block", vertices=rectangle(0, 0, 6, 1), name="table"),
        group("block", vertices=rectangle(1, 1, 1, 1), name="low"),
        group("block", vertices=rectangle(1, 2, 1, 1), name="high"),
        group("fixed_point", x=0.5, y=0.5),
        group("fixed_point", x=5.5, y=0.5, name="right"),
        group("motion", name="m", time_step=0.1, values=[0.0, 1.0, -1.0, 0.0],
              quantity="acceleration"),
        group("measured_point", name="top", x=1.5, y=3.0),
        group("output", block_interval=20),
    ]  # fmt: skip


@pytest.mark.parametrize("adaptive", ["fixed", "adaptive"])
@pytest.mark.parametrize("settle", [False, True])
def test_the_input_with_added_stages_is_bit_identical(tmp_path, adaptive, settle, write_input):
    smooth = group("joint", name="smooth", friction_angle=1.0)
    groups = [*pile(time_step_control=adaptive, settle=settle), smooth]
    file = write_input(groups, "pile.nml")
    with sitedda.Simulation(file, output=tmp_path / "live.nc") as run:
        run.advance(77)
        run.begin_stage("digging", remove="low", release="right")
        run.advance(50)
        assert list(run.removed_blocks) == [False, True, False]
        run.begin_stage("smooth", change_joints="dry -> smooth")
        text = run.present_input
        while not run.advance(100):
            pass
        run.finish()
    copied_input = tmp_path / "again.nml"
    copied_input.write_text(text)
    repeated_run = sitedda.run(copied_input).history
    with sitedda.open_output(tmp_path / "live.nc") as live:
        assert live.attrs["stages"].split("\n")[-2:] == ["digging", "smooth"]
        for name in COMPARED:
            assert np.array_equal(live[name].values, repeated_run[name].values), name
        assert live.time[-1] == pytest.approx(0.3)


def test_a_killed_run_continues_with_its_added_stage(tmp_path, write_input):
    file = write_input(pile(), "pile.nml")
    ends = []
    for kills in (False, True):
        output = tmp_path / f"{kills}.nc"
        run = sitedda.Simulation(file, output=output)
        run.advance(77)
        run.begin_stage("digging", remove="low")
        run.advance(20)
        if kills:
            run.checkpoint()
            run.close()
            run = sitedda.Simulation(file, output=output, resume=True)
            assert "digging" in run.present_input
        run.advance(203)
        ends.append(run.block_states)
        assert run.done and run.removed_blocks[1]
        run.close()
    for one, other in zip(*ends, strict=True):
        assert np.array_equal(one, other)


def test_an_added_static_stage_brings_the_model_to_rest(write_input):
    file = write_input(pile(), "pile.nml")
    with sitedda.Simulation(file) as run:
        run.advance(50)
        run.begin_stage("rest", kind="static")
        run.advance(2)  # the static stage and the first step after it
        assert abs(run.rates[:, :2]).max() < 1e-3
        while not run.advance(100):
            pass
        assert run.time == pytest.approx(0.3)


def test_an_invalid_added_stage_is_refused_and_changes_nothing(write_input):
    file = write_input(pile(), "pile.nml")
    with sitedda.Simulation(file) as run:
        with pytest.raises(sitedda.InputError, match="only after the first step of the last stage"):
            run.begin_stage("too early", remove="low")
        run.advance(10)
        with pytest.raises(sitedda.InputError, match="an added stage cannot have hold"):
            run.begin_stage("x", hold="right")
        with pytest.raises(sitedda.InputError, match="no_such"):
            run.begin_stage("x", remove="no_such")
        assert "&stage" not in run.present_input and run.duration == pytest.approx(0.3)


def test_a_model_opened_as_drawn_settles_at_the_first_advance(tmp_path, write_input):
    file = write_input(pile(settle=True), "pile.nml")
    output = tmp_path / "pile.nc"
    with sitedda.Simulation(file, output=output, drawn=True) as run:
        assert np.array_equal(run.polygons[1], np.reshape(rectangle(1, 1, 1, 1), (4, 2)))
        assert not (tmp_path / "pile.nc.partial").exists()
        assert not run.advance(0)
        assert run.polygons[1][0, 1] < 1.0 and run.steps == 0
        while not run.advance(100):
            pass
        run.finish()
    with sitedda.open_output(output) as data:
        other = sitedda.run(file).history
        for name in COMPARED[:-1]:
            assert np.array_equal(data[name].values, other[name].values), name
