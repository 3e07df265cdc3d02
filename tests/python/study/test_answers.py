# SPDX-License-Identifier: GPL-3.0-or-later
"""Slip, opening and force of named joints; parameter values for target results."""

import math
import re

import numpy as np
import pytest
import xarray as xr

import sitedda
from sitedda import NoRootError, solve_for
from sitedda.study import measure
from sitedda.study.quantities import quantities_of
from sitedda.study.settings import read_settings

G = 9.8  # m/s²
SIDE, HEIGHT, DENSITY = 2.0, 0.1, 2500.0
WEIGHT = SIDE * HEIGHT * DENSITY * G  # N/m


def slider(
    slope=0.0, friction=20.0, push=0.0, push_time=0.4, duration=0.5, stiffness=1e11, **joint
):
    """A flat block on a floor; gravity is inclined by `slope` (degrees) to +x; push in m/s²."""
    angle = math.radians(slope)
    model = sitedda.Model("slider", time_step=1e-3)
    model.control(gravity=(G * math.sin(angle), -G * math.cos(angle)))
    model.contact(normal_stiffness=stiffness)
    model.material("rock", density=DENSITY, young_modulus=1e11, poisson_ratio=0.2)
    model.joint("plane", friction_angle=friction)
    model.block([-2, -1, 9, -1, 9, 0, -2, 0], name="floor")
    model.block([0, 0, SIDE, 0, SIDE, HEIGHT, 0, HEIGHT], name="slider")
    for x, y in ((-1, -0.5), (8, -0.5), (4, -0.9)):
        model.fixed_point(x, y)
    force = push * SIDE * HEIGHT * DENSITY
    model.load(1.0, HEIGHT / 2, "slider", name="push", time=[0, push_time], force_x=[force] * 2)
    model.measured_joint("base", **(joint or {"blocks": "slider", "against": "floor"}))
    model.stage("rest", "static")
    model.stage("motion", duration=duration, loads="push")
    return model


def slip_of(slope, friction, load, push_time):
    """Newmark: slip under a push (m/s²) until friction has stopped the block, m."""
    angle = math.radians(slope)
    deceleration = G * (math.tan(math.radians(friction)) * math.cos(angle) - math.sin(angle))
    return 0.5 * push_time**2 * (load - deceleration) * load / deceleration


@pytest.mark.parametrize("swapped", [False, True])
def test_slip_and_force_of_a_joint(swapped):
    sign = -1 if swapped else 1
    names = {"blocks": "floor", "against": "slider"} if swapped else {"blocks": "sl*"}
    run = slider(10.0, 20.0, 4.0, 0.4, 1.0, **names).run()
    history = run.history.sel(measured_joint="base")
    angle, friction = math.radians(10.0), math.tan(math.radians(20.0))
    normal = WEIGHT * math.cos(angle)
    assert history.joint_slip.values[-1] == pytest.approx(slip_of(10, 20, 4, 0.4), rel=2e-3)
    # From either block, the other one moves to the right.
    sliding = np.flatnonzero(abs(history.time.values - 0.2) < 1e-9)[0]
    assert history.joint_normal_force.values[sliding] == pytest.approx(normal, rel=1e-6)
    assert history.joint_shear_force.values[sliding] == pytest.approx(friction * normal, rel=1e-3)
    end = [float(history[f"joint_force_{axis}"][-1]) for axis in "xy"]
    expected_force = [-WEIGHT * math.sin(angle), normal]
    np.testing.assert_allclose(end, sign * np.array(expected_force), rtol=5e-3)
    assert history.joint_opening.values.max() == pytest.approx(0.0, abs=1e-9)
    values = run.verdict.values
    assert values["joint_slip_m[base]"] == pytest.approx(float(history.joint_slip[-1]), abs=1e-12)
    assert values["joint_normal_force_n_m[base]"] == pytest.approx(normal, rel=1e-5)
    assert any(line.largest == "largest_joint_slip_m[base]" for line in run.verdict.figures)


def test_opening_of_a_joint_and_quantities_of_it(tmp_path, binary, same_bits):
    file = slider().write(tmp_path / "lifted.nml")
    lifting_load = {"load.time": (0.0, 9.0), "load.force_y": (2 * WEIGHT, 2 * WEIGHT)}
    run = sitedda.run(file, tmp_path / "out.nc", changes=lifting_load)
    assert run.history.joint_opening.values[-1, 0] == pytest.approx(0.5 * G * 0.5**2, rel=1e-3)
    assert run.history.joint_normal_force.values[-1, 0] == 0
    quantities = ["joint_opening[base].last", "largest_joint_opening_m[base]", "joint_slip[base]"]
    numbers, arrays = measure(tmp_path / "out.nc", quantities_of(quantities), [])
    assert numbers[quantities[0]] == pytest.approx(0.5 * G * 0.5**2, rel=1e-3)
    assert numbers[quantities[1]] == numbers[quantities[0]]
    assert len(arrays[quantities[2]].values) == run.history.sizes["time"]
    text = tmp_path / "same.nml"
    text.write_text(run.history.attrs["input_text"])
    binary.ok("run", text, "-o", tmp_path / "native.nc", "-q")
    same_bits(tmp_path / "out.nc", tmp_path / "native.nc")


def test_a_joint_continues_after_a_checkpoint(tmp_path, same_bits, in_parts):
    file = slider(10.0, 20.0, 4.0).write(tmp_path / "a.nml")
    same_bits(sitedda.run(file).history, in_parts(file, 177))


def test_a_joint_at_rest_has_no_slip_of_rounding():
    run = slider(0.0, 35.0, 0.0, 0.1, 0.1).run()
    assert 0 < abs(run.history.joint_slip.values).max() < 1e-9
    assert run.verdict.values["largest_joint_slip_m[base]"] == 0
    assert re.search(r"slip +0 m +0 m +base", str(run.verdict))


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"blocks": "nothing"}, "blocks: nothing is named 'nothing'"),
        ({"blocks": "slider", "against": "s*"}, "'slider' is in both `blocks` and `against`"),
        ({"blocks": "*"}, "none remains for `against`"),
        ({"blocks": "slider", "against": "far"}, "no block of `blocks` touches a block"),
    ],
)
def test_invalid_measured_joints_are_refused(values, message):
    model = slider(**values)
    model.block([20, 0, 21, 0, 21, 1, 20, 1], name="far")
    for x, y in ((20.1, 0.1), (20.9, 0.1), (20.5, 0.9)):
        model.fixed_point(x, y)
    with pytest.raises(sitedda.InputError, match=message):
        model.run()


def test_a_repeated_name_is_refused():
    model = slider()
    model.measured_joint("base", "slider")
    with pytest.raises(sitedda.InputError, match="'base' is used twice"):
        model.run()


# --- solve_for ----------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(20))
def test_back_analysis_of_a_sliding_block(seed):
    """Newmark's block: the friction angle of a slip is found to 0.1 %."""
    rng = np.random.default_rng(seed)
    slope, acceleration = rng.uniform(0, 15), rng.uniform(3, 7)
    push_time = 1e-3 * rng.integers(200, 500)
    tangent = 0.8 * acceleration / G + math.sin(math.radians(slope))
    largest_friction = math.degrees(math.atan(tangent / math.cos(math.radians(slope))))
    friction = rng.uniform(slope + 5, max(largest_friction, slope + 6))
    target = slip_of(slope, friction, acceleration, push_time)
    stops = 2 * target / (push_time * acceleration)  # s
    model = slider(slope, 30.0, acceleration, push_time, duration=0.1 + push_time + 2 * stops,
                   stiffness=1e13)  # fmt: skip
    root = solve_for(model, "joint[plane].friction_angle", "joint_slip[base].last", target,
                      between=(slope + 3, 60.0), tolerance=2e-4, accuracy=seed < 2)  # fmt: skip
    assert root.value == pytest.approx(friction, rel=1e-3)
    assert root.low <= root.value <= root.high
    assert abs(root.value - friction) <= root.bar + 1e-3 * friction
    if seed < 2:
        assert "only the bracket" not in root.doubt


def has_slipped(run) -> float:
    return float(run.history.joint_slip[-1, 0] > 0.05)


@pytest.mark.parametrize(
    ("values", "bracket", "mode"),
    [
        ({"target": -0.01}, (10, 40), "outside"),
        ({"target": 1.1 * slip_of(5, 10, 4, 0.3)}, (10, 40), "outside"),
        ({"target": 0.01}, (35, 60), "flat"),
        ({"target": 0.5, "result": has_slipped}, (6, 40), "jump"),
        ({"target": 0.1, "parameter": "joint[plane].cohesion"}, (0, 1), "flat"),
    ],
)
def test_cases_without_a_root(values, bracket, mode):
    model = slider(5.0, 20.0, 4.0, 0.3, duration=1.5)
    if mode == "jump":  # the block falls off the floor or stays on it
        model.stop(displacement=2.5)
    friction = "joint[plane].friction_angle"
    arguments = {"parameter": friction, "result": "joint_slip[base].last"} | values
    with pytest.raises(NoRootError, match="no root") as error_info:
        solve_for(model, between=bracket, accuracy=False, **arguments)
    assert error_info.value.mode == mode
    assert len(error_info.value.trials) >= 2


def cubic(x):
    """Roots −1, 1 and 3 at 0."""
    return (x + 1) * (x - 1) * (x - 3)


@pytest.mark.parametrize("target", [0.0, 0.7, -2.0])
def test_roots_of_a_function(target):
    root = solve_for(lambda x: cubic(x), "x", "value", target, between=(2, 4), tolerance=1e-9)
    assert cubic(root.value) == pytest.approx(target, abs=1e-8)
    assert len(root.trials) < 20  # bisection would need 30
    assert root.crossings == 1


def test_the_lowest_of_several_roots():
    root = solve_for(cubic, "x", "value", 0.5, between=(2, 5), tolerance=1e-6)
    assert root.crossings == 1
    root = solve_for(cubic, "x", "value", -0.5, between=(0, 4), tolerance=1e-6)
    assert root.crossings == 2
    assert cubic(root.value) == pytest.approx(-0.5, abs=1e-5)
    assert root.value < 1.5
    assert "the lowest of 2" in str(root)


def test_a_jump_is_an_error_unless_it_is_accepted():
    def step(x):
        return 5.0 if x > math.pi else -1.0

    with pytest.raises(NoRootError, match="jumps from -1 to 5") as error_info:
        solve_for(step, "x", "value", 2.0, between=(0, 10))
    assert error_info.value.mode == "jump"
    assert error_info.value.bracket[0] <= math.pi <= error_info.value.bracket[1]
    root = solve_for(step, "x", "value", 2.0, between=(0, 10), jumps=True)
    assert root.jumps
    assert root.low <= math.pi <= root.high
    assert root.high - root.low < 1e-3 * math.pi


def test_invalid_results_and_failed_runs_are_reported():
    with pytest.raises(NoRootError) as error_info:
        solve_for(lambda x: math.nan, "x", "value", 1.0, between=(0, 1))
    assert error_info.value.mode == "no number"
    model = slider(5.0)
    model.control(gravity=(8.0, -1.0))
    with pytest.raises(NoRootError) as error_info:
        solve_for(model, "joint[plane].friction_angle", "joint_slip[base].last", 1.0,
                  between=(10, 40))  # fmt: skip
    assert error_info.value.mode == "fails"


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"between": (1, 1)}, "must differ"),
        ({"between": (1,)}, "two numbers"),
        ({"between": 3}, "two numbers"),
        ({"target": math.nan}, "target"),
        ({"tolerance": 0}, "tolerance"),
        ({"result": "joint_slip[base]"}, "not a number"),
        ({"result": "joint_slip[none].last"}, "there is no measured_joint 'none'"),
        ({"parameter": "joint[plane].angle"}, "angle"),
        ({"task": "dance"}, "task"),
    ],
)
def test_invalid_arguments_are_refused(values, message):
    arguments = {"parameter": "joint[plane].friction_angle", "result": "joint_slip[base].last",
             "target": 0.1, "between": (10, 40)}  # fmt: skip
    with pytest.raises(sitedda.InputError, match=message):
        solve_for(slider(duration=0.01), **arguments | values)


STUDY = """
model = "slider.nml"
[solve]
parameter = "joint[plane].friction_angle"
result = "joint_slip[base].last"
target = 0.05
between = [10, 40]
"""


def test_a_study_solves_each_of_its_cases(tmp_path, main):
    slider(5.0, 20.0, 4.0, 0.4, duration=1.2).write(tmp_path / "slider.nml")
    file = tmp_path / "back.toml"
    file.write_text(f'{STUDY}[parameters]\n"control.time_step" = [1e-3, 5e-4]\n')
    output = main.ok("study", file, "-q", "-w", "1").stdout
    assert "root: time_step = 0.001: joint[plane].friction_angle = " in output
    with xr.open_dataset(tmp_path / "back_study" / "table.nc") as table:
        deceleration = 4.0 / (1 + 2 * 0.05 / (4.0 * 0.4**2))
        angle = math.radians(5.0)
        expected = math.degrees(math.atan((deceleration / G + math.sin(angle)) / math.cos(angle)))
        np.testing.assert_allclose(table.root.values, expected, rtol=2e-3)
        assert (table.root_bar.values > 0).all()


def test_a_study_with_one_case_prints_its_root(tmp_path, main):
    slider(5.0, 20.0, 4.0, 0.4, duration=1.2).write(tmp_path / "slider.nml")
    file = tmp_path / "back.toml"
    prefix = "root: joint[plane].friction_angle = "
    for target, text, status in (("0.05", prefix, 0), ("50", "no root: ", 1)):
        file.write_text(STUDY.replace("0.05", target))
        process = main("study", file, "-q", "-w", "1")
        assert process.returncode == status and text in process.stdout


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("target = 0.05", "", "target is missing"),
        ("[10, 40]", "[10]", "two numbers"),
        ("result =", "outcome =", "there is no name 'outcome'"),
        ("[solve]", 'results = ["verdict"]\n[solve]', "remove the keys `task` and `results`"),
    ],
)
def test_bad_tables_of_a_study_are_refused(tmp_path, old, new, message):
    slider().write(tmp_path / "slider.nml")
    file = tmp_path / "back.toml"
    file.write_text(STUDY.replace(old, new))
    with pytest.raises(sitedda.InputError, match=message):
        read_settings(file)


def test_an_output_named_by_the_caller_is_written(tmp_path):
    model = slider(duration=0.01)
    for name in ("a.nc", "b.nc"):
        target = str(tmp_path / name)
        changes = {"output.file": target} if name == "a.nc" else {"output": {"file": target}}
        assert sitedda.run(model, changes=changes).output == tmp_path / name
        assert (tmp_path / name).exists()
    assert sitedda.run(model).output is None


@pytest.mark.parametrize("form", ["model", "file"])
def test_an_output_named_by_the_input_is_written(tmp_path, monkeypatch, form):
    """It is relative to the working folder; output=False keeps the results in memory."""
    monkeypatch.chdir(tmp_path)
    model = slider(duration=0.01)
    model.output(file="named.nc")
    model.write(tmp_path / "slider.nml")
    source = model if form == "model" else tmp_path / "slider.nml"
    assert sitedda.run(source, False).output is None
    assert not (tmp_path / "named.nc").exists()
    assert sitedda.run(source).output.resolve() == tmp_path / "named.nc"
    assert (tmp_path / "named.nc").exists()
