# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports of `check` before a run: equal in both programs, and only with valid numbers."""

import math
import re

import numpy as np
import pytest
from model_text import ROCK, changed, flying_block, group, rectangle, tower

import sitedda
from sitedda.base.core import folded
from sitedda.input.examples import copy_example
from sitedda.scheme import Scheme


def finding(text: str, topic: str) -> str:
    """One finding of a report in one line, with its verdict."""
    joined_text = re.sub(r"\n {24}", " ", text)
    return next(line for line in joined_text.splitlines() if line[6:].startswith(topic))


def numbers_of(report) -> np.ndarray:
    """All numbers in the text of a report."""
    limits = [*report.bracket, report.residual, report.shift, *report.band]
    return np.array([report.omega_max, *limits])


# --- Damping over the band of the record ---------------------------------------------------------


def check_tower(write_input, time_step: float) -> sitedda.Report:
    """Report of the tower with a time step; its pulse has energy from 14 to 29 Hz."""
    report = sitedda.check(write_input(tower(time_step=time_step)))
    assert np.all(np.isfinite(numbers_of(report)))
    assert not re.search(r"Infinity|NaN|\*\*", report.text)
    return report


def test_damping_over_the_band_is_that_of_the_closed_form(write_input):
    report = check_tower(write_input, 1e-3)
    match = re.search(r"([\d.]+) … ([\d.]+) % over", finding(report.text, "damping"))
    expected = [50 * math.tan(math.pi * f * 1e-3) for f in report.band]
    assert [float(value) for value in match.groups()] == pytest.approx(expected, rel=5e-4)


def test_a_band_that_reaches_beyond_the_steps_has_damping_at_one_end(write_input):
    report = check_tower(write_input, 0.02)
    assert report.band[0] < 1 / (2 * 0.02) < report.band[1]
    line = finding(report.text, "damping")
    assert line.startswith("warn") and "beyond 1/(2 Δt) = 25 Hz" in line
    match = re.search(r"([\d.]+) % at 14.29 Hz; the band of the record reaches 28.57 Hz", line)
    expected = 50 * math.tan(math.pi * report.band[0] * 0.02)
    assert float(match[1]) == pytest.approx(expected, rel=5e-4)
    advised_step = float(re.search(r"time_step below ([\d.]+) s", line)[1])
    assert advised_step == pytest.approx(1 / (2 * report.band[1]), rel=5e-4)


@pytest.mark.parametrize("time_step", [0.05, 1e3])
def test_a_band_beyond_the_steps_is_reported(write_input, time_step):
    report = check_tower(write_input, time_step)
    assert 1 / (2 * time_step) < report.band[0]
    line = finding(report.text, "damping")
    assert line.startswith("warn") and "% over" not in line
    assert "the band of the record, 14.29 … 28.57 Hz, is beyond 1/(2 Δt)" in line


def test_a_record_of_nanoseconds_is_reported_in_short_numbers(write_input):
    report = sitedda.check(write_input(changed(tower(), "motion", time_step=1e-9)))
    assert "1.429e8 … 2.857e8 Hz, is beyond" in finding(report.text, "damping")


# --- Other findings -------------------------------------------------------------------------------


def test_a_first_mode_without_oscillation_fails(write_input):
    file = write_input(tower())
    first = sitedda.modes(file).frequency[0]
    smallest_step = 4 / (2 * math.pi * first)  # s, paper eq. 13
    line = finding(sitedda.check(file, time_step=1.01 * smallest_step).text, "first mode")
    assert line.startswith("FAIL") and "does not oscillate" in line
    line = finding(sitedda.check(file, time_step=0.99 * smallest_step).text, "first mode")
    assert line.startswith("warn")


def test_the_time_step_is_compared_with_the_highest_frequency(write_input):
    file = write_input(tower())
    limit = 4 / sitedda.check(file).omega_max
    text = sitedda.check(file, time_step=0.99 * limit).text
    assert finding(text, "time step").startswith("ok") and "lie beyond" not in text
    line = finding(sitedda.check(file, time_step=1.01 * limit).text, "time step")
    assert re.search(r"; \d+ of 24 modes lie beyond", line)


def test_blocks_that_touch_nothing_are_reported(write_input):
    groups = [*flying_block(), group("block", vertices=rectangle(5.0, 0.0, 2.0, 1.0))]
    line = finding(sitedda.check(write_input(groups)).text, "contacts")
    assert line.startswith("warn") and "no contact is closed" in line


@pytest.mark.parametrize(("ratio", "kind"), [(1e3, "normal"), (1e-3, "shear")])
def test_the_spring_that_governs_is_named(write_input, ratio, kind):
    """The stiffest kind of springs (by a factor of 1000) governs the highest mode."""
    stiff = changed(
        tower(), "contact", normal_stiffness=1.5e12, shear_ratio=ratio, fixed_point_ratio=1e-3
    )
    line = finding(sitedda.check(write_input(stiff)).text, "highest frequency")
    assert f"governed by the {kind} contact spring between" in line


# --- Members of the time integration --------------------------------------------------------------

MEMBERS = ("dda", "midpoint", "theta", "backward_euler")


def test_ringing_is_reported_in_steps(write_input):
    report = sitedda.check(write_input(tower()))
    line = finding(report.text, "ringing")
    assert "normal contact springs" in line  # supports have a dashpot and do not ring
    phase_step, steps = map(float, re.search(r"Δt = ([\d.]+)\).* in ([\d.]+) steps", line).groups())
    assert report.ringing == pytest.approx(steps, rel=1e-3)  # four digits are printed
    expected = Scheme().vibration(phase_step / (2 * math.pi * 1e-3), 1e-3).ringing
    assert report.ringing == pytest.approx(float(expected), rel=2e-3)


def test_ringing_of_other_members(write_input):
    file = write_input(tower())
    endless = sitedda.check(file, integration="midpoint")
    assert endless.ringing > 1e12 and finding(endless.text, "ringing").startswith("warn")
    assert 0.0 < sitedda.check(file, integration="theta").ringing < 1.0  # root -1/3
    # roots 1/(1 ± iΩ) have a real part that stays positive
    assert sitedda.check(file, integration="backward_euler").ringing == 0.0


@pytest.mark.parametrize("integration", MEMBERS)
def test_modes_have_damping_and_period_of_the_member(write_input, integration):
    """Supports, integrated by backward Euler, hold 0.04 % of the energy."""
    modes = sitedda.modes(write_input(tower()), 3, integration=integration)
    expected = Scheme.named(integration).vibration(modes.frequency, 1e-3)
    assert modes.damping == pytest.approx(expected.damping, rel=2e-3, abs=2e-4)
    assert modes.elongation == pytest.approx(expected.elongation, rel=2e-3)


# --- The commands ---------------------------------------------------------------------------------


def test_both_programs_report_the_same_as_the_package(program, write_input):
    file = write_input(tower())
    process = program.ok("check", file)
    with sitedda.Simulation(file) as simulation:
        package_text = f"{folded(simulation.description)}\n{sitedda.check(simulation).text}"
    native_lines, package_lines = (
        re.sub(r"\S+ s at the speed", "", re.sub(r"\n {24}", " ", text)).splitlines()
        for text in (process.stdout, package_text)
    )
    assert native_lines[: len(package_lines)] == package_lines


def test_a_check_that_fails_is_status_2(program, write_input):
    process = program("check", write_input(tower(time_step=0.05)))
    assert process.returncode == 2
    assert "FAIL  first mode" in process.stdout and "the check fails" in process.stderr


def test_a_run_is_refused_by_a_check_that_fails(program, write_input, tmp_path):
    refused = write_input(tower(time_step=0.05, steps=3), "refused.nml")
    process = program("run", "--check", refused, "-o", tmp_path / "refused.nc")
    assert process.returncode == 2 and not list(tmp_path.glob("refused.nc*"))
    started_input = write_input(tower(steps=3))
    process = program("run", "--check", started_input, "-o", tmp_path / "started.nc", "-q")
    assert process.returncode == 0 and (tmp_path / "started.nc").exists()
    assert "damping" in process.stdout


def test_a_check_of_bad_input_is_status_1(program, write_input):
    process = program("check", write_input(tower(time_step=-1.0)))
    assert process.returncode == 1 and "time_step" in process.stderr


def test_a_block_that_a_stage_removes_is_not_checked(root):
    """Its mass of 0 made modes NaN, block sizes over speeds 0 s, and penalty bounds invalid."""
    text = str(sitedda.check(root / "inputs" / "tunnel_roof.nml"))
    modes = finding(text, "lowest modes")
    assert modes.startswith("ok") and "rigid-body" not in modes
    assert "Δx/v = 0 s" not in finding(text, "CFL")
    assert finding(text, "penalty bounds").startswith("ok")


# --- Limits ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("ratio", "verdict"), [(0.08, "ok"), (0.15, "warn")])
def test_the_scheme_may_damp_the_first_mode_by_a_tenth(write_input, ratio, verdict):
    modes = finding(check_tower(write_input, 1e-3).text, "lowest modes")
    frequency = float(re.search(r"lowest modes +([\d.]+)", modes)[1])
    report = check_tower(write_input, float(sitedda.time_step_for_damping(ratio, frequency)))
    line = finding(report.text, "damping")
    percentage = float(re.search(r"damping ratio ([\d.]+) %", line)[1])
    assert line.startswith(verdict) and percentage == pytest.approx(100 * ratio, rel=0.1)


@pytest.mark.parametrize(("percent", "verdict"), [(0.8, "ok"), (1.2, "warn")])
def test_contacts_may_penetrate_by_a_hundredth_of_a_block(write_input, percent, verdict):
    line = finding(sitedda.check(write_input(standing(percent))).text, "penalty bounds")
    assert line.startswith(verdict) and f"penetrate by {percent} %" in line


def test_the_check_reports_cost_and_benefit_of_a_stiffer_penalty(write_input):
    """Each side of a layer has two contacts with κ = 1 + χ z k_n Δt²/m, χ = ½."""
    model = write_input(tower())
    mass, pattern = 15.0 * ROCK["density"], r"is about ([\d.e+]+); .* = (\S+) N/m, .* about (\S+) "
    line = finding(sitedda.check(model).text, "penalty ")
    cost, advised, its_cost = (float(number) for number in re.search(pattern, line).groups())
    assert cost == pytest.approx(1 + 4 * 1.5e12 * 1e-3**2 / (2 * mass), rel=1e-3)
    assert (its_cost - 1) / (cost - 1) == pytest.approx(advised / 1.5e12, rel=2e-3)
    exact = sitedda.penalty_for(model, accuracy=0.01).normal_stiffness
    assert advised == pytest.approx(exact, rel=1e-3)


def stack(n: int, width: float, gravity: float = 9.81, joint: dict | None = None, **material):
    """A stack of n blocks of 1 m height on a base; corners slip as gravity widens the blocks."""
    return [
        group("control", time_step=2e-4, duration=0.6, gravity=[0.0, -gravity], settle=gravity > 0,
              integration="midpoint"),
        group("material", **{"density": 2500.0, "young_modulus": 1e10, "poisson_ratio": 0.2}
              | material),
        group("joint", **{"friction_angle": 35.0} | (joint or {})),
        group("block", name="base", vertices=rectangle(-2 * width, -1.0, 4 * width, 1.0)),
        *(group("block", name=f"b{i}", vertices=rectangle(-width / 2, i, width, 1.0))
          for i in range(n)),
        *(group("fixed_point", x=x, y=-0.5) for x in (-1.5 * width, 1.5 * width)),
        group("measured_point", name="top", block=f"b{n - 1}", x=0.0, y=n - 0.01),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("blocks", "width", "gravity", "material"),
    [(20, 0.2, 0.0, {}), (60, 0.3, 0.0, {}), (5, 0.2, 9.81, {}),
     (3, 1.0, 0.0, {"damping_ratio": 0.05}), (5, 1.0, 9.81, {"damping_ratio": 0.1})],
)  # fmt: skip
def test_the_penalty_lowers_the_first_frequency_by_the_accuracy(
    write_input, blocks, width, gravity, material
):
    """Slender stacks bend with joints 1000 times as soft as blocks; moduli depend on frequency."""
    model = write_input(stack(blocks, width, gravity, **material))
    found = sitedda.penalty_for(model, accuracy=0.05)
    assert found.frequency == pytest.approx(0.95 * found.limit, rel=1e-6)
    changes = {"contact.normal_stiffness": found.normal_stiffness}
    assert sitedda.modes(model, 1, changes=changes).frequency == pytest.approx(found.frequency)
    assert sitedda.check(model, changes=changes).shift == pytest.approx(0.05, rel=1e-3)
    if not material:  # joints contribute to 1/f² in proportion to 1/k_n
        changes["contact.normal_stiffness"] *= 100
        (stiff,) = sitedda.modes(model, 1, "closed", changes).frequency
        assert (found.limit / stiff) ** 2 - 1 == pytest.approx((0.95**-2 - 1) / 100, rel=0.05)


def test_small_vibrations_of_a_run_are_those_of_the_linear_model(write_input, tmp_path):
    """Contacts at the limit of friction stick; contacts that can open act at the end of a step."""
    pulse = group(
        "load", block="b4", x=0.0, y=4.99, time=[0.0, 4e-3, 8e-3], force_x=[0.0, 20.0, 0.0]
    )
    model = write_input([*stack(5, 0.2), pulse, group("output", history_interval=1)])
    first = sitedda.modes(model, 1)
    (frequency,) = first.frequency
    assert frequency == pytest.approx(sitedda.modes(model, 1, "closed").frequency[0], rel=1e-3)
    sitedda.run(model, output=tmp_path / "run.nc")
    with sitedda.open_output(tmp_path / "run.nc") as data:
        motion = data["displacement"].sel(axis="x").squeeze()[200:].values
    spectrum = np.abs(np.fft.rfft((motion - motion.mean()) * np.hanning(len(motion)), 80_000))
    assert spectrum.argmax() / (80_000 * 2e-4) == pytest.approx(frequency, rel=0.01)
    period = round(1 / (frequency * 2e-4))
    early, late = (np.std(motion[k * period : (k + 1) * period]) for k in (2, 17))
    damping = math.log(early / late) / (2 * math.pi * 15)
    assert damping == pytest.approx(first.damping[0], rel=0.03) and damping > 0.005
    assert "of them slide" not in sitedda.modes(model, 1).words
    smooth = write_input(stack(5, 0.2, joint={"friction_angle": 0.0}))
    assert "10 of them slide" in sitedda.modes(smooth, 1).words


AREAL = {"normal_stiffness_per_area": 1e10}


@pytest.mark.parametrize(
    "joint",
    [AREAL, {"cohesion": 1e4}, {"contact_points": 5}, {"law": "plesha", "asperity_angle": 8.0},
     {"law": "mohr_coulomb", "residual_friction_angle": 25.0, "weakening_slip": 0.01},
     {"law": "crushing", "crushing_strength": 1e7, "contact_points": 9},
     {"law": "continuously_yielding", "initial_friction_angle": 45.0, "roughness": 1e-3,
      "shear_stiffness_per_area": 1e9} | AREAL],
)  # fmt: skip
def test_contacts_of_each_law_stick_in_small_vibrations(write_input, joint):
    model = write_input(stack(5, 0.2, joint=joint))
    assert sitedda.modes(model, 2).frequency == pytest.approx(
        sitedda.modes(model, 2, "closed").frequency, rel=1e-3
    )


def test_a_penalty_without_effect_or_limit_is_an_error(write_input, tmp_path):
    areal = write_input(stack(3, 1.0, joint={"normal_stiffness_per_area": 1e10}))
    with pytest.raises(sitedda.SiteddaError, match="no closed contact has the stiffness"):
        sitedda.penalty_for(areal)
    with pytest.raises(sitedda.SiteddaError, match="increases with the penalty without limit"):
        sitedda.penalty_for(copy_example("wedge", tmp_path)[0])
    with pytest.raises(sitedda.SiteddaError, match="the largest permitted value is 1e18 N/m"):
        sitedda.penalty_for(write_input(tower()), accuracy=1e-9)


@pytest.mark.parametrize("accuracy", [0.0, 1.0, -0.1, math.nan, [0.01], None])
def test_the_reduction_of_the_first_frequency_must_be_between_0_and_1(write_input, accuracy):
    with pytest.raises(sitedda.SiteddaError, match=r"accuracy = .* must be a number from 1e-09"):
        sitedda.penalty_for(write_input(tower()), accuracy=accuracy)


@pytest.mark.parametrize("percent", [4.9, 5.1])
def test_a_run_warns_if_a_penetration_exceeds_a_twentieth_of_a_block(write_input, percent):
    verdict = sitedda.run(write_input(standing(percent)), output=False).verdict
    assert ("penetration" in [doubt.topic for doubt in verdict.doubts]) == (percent > 5)


def standing(percent: float) -> list:
    """A cube of 1 m on two corners of a base: each penetrates by half the weight over k_n."""
    weight = 2500.0 * 9.81
    return [
        group("run"),
        group("control", time_step=1e-3, steps=1, gravity=[0.0, -9.81], settle=True),
        group("contact", normal_stiffness=weight / 2 / (percent / 100)),
        group("material", density=2500.0, young_modulus=1e10, poisson_ratio=0.2),
        group("joint", friction_angle=30.0),
        group("block", name="base", vertices=rectangle(-2.0, -1.0, 4.0, 1.0)),
        group("block", vertices=rectangle(-0.5, 0.0, 1.0, 1.0)),
        group("fixed_point", x=-1.5, y=-0.5),
        group("fixed_point", x=1.5, y=-0.5),
    ]


# --- Warnings of the check in a run ---------------------------------------------------------------


def drums(**joint) -> list:
    """Two drums that settle on a floor."""
    shapes = [rectangle(-1, -0.2, 2, 0.2), *(rectangle(-0.5, y, 1, 1) for y in (0, 1))]
    return [
        group("control", time_step=1e-3, steps=5, gravity=[0.0, -9.81]),
        group("material", density=2000.0, young_modulus=1e10, poisson_ratio=0.2),
        group("contact", normal_stiffness=1e8),
        ("joint", {"friction_angle": 35.0} | joint),
        *(group("block", vertices=at) for at in shapes),
        *(group("fixed_point", block=1, x=x, y=-0.1) for x in (-0.9, 0.9)),
    ]


def check_lines_of_run(file, **changes) -> list[str]:
    lines = str(sitedda.run(file, **changes).verdict).splitlines()
    return [line for line in lines if line.startswith(("doubt  check: ", "what to change: "))]


def test_a_run_prints_each_warning_of_its_check_in_a_line(write_input):
    """Two drums have four contacts; a static model has no relevant modes."""
    file = write_input(drums())
    *doubts, last = check_lines_of_run(file)
    assert any("lower the frequency by " in line and "(4 contacts)" in line for line in doubts)
    assert last == "what to change: sitedda check FILE.nml"
    assert max(map(len, doubts)) <= 80
    assert check_lines_of_run(file, settle=True) == []


def test_measured_stiffness_is_no_penalty(write_input, main):
    measured = drums(normal_stiffness_per_area=1e8, shear_stiffness_per_area=1e8)
    file = write_input(measured)
    assert not any("rigid joints" in line for line in check_lines_of_run(file))
    assert finding(main("check", file).stdout, "penalty").startswith("ok")


def test_wavelength_and_cell_size_are_compared_per_material(write_input):
    """Large blocks of rock below small blocks of soil resolve the waves in their own material."""
    soil = {"density": 1800.0, "shear_velocity": 100.0, "pressure_velocity": 200.0}
    rock = {"density": 2500.0, "shear_velocity": 2000.0, "pressure_velocity": 3500.0}
    groups = [
        group("control", time_step=1e-3, steps=2, analysis="plane_strain"),
        group("material", name="rock", **rock),
        group("material", name="soil", **soil),
        group("joint", name="j", friction_angle=30.0),
        group("block", name="below", material="rock", vertices=(0, 0, 12, 0, 12, 12, 0, 12)),
        group("block", name="above", material="soil", vertices=(0, 12, 1, 12, 1, 13, 0, 13)),
        group("motion", name="m", file="m.csv", quantity="acceleration", unit="m/s2"),
        group("fixed_point", x=1, y=1, motion_x="m"),
        group("fixed_point", x=11, y=1, motion_x="m"),
    ]
    file = write_input(groups)
    time = np.arange(0.0, 4.0, 0.005)
    wave = np.sin(2 * np.pi * 5.0 * time) * np.sin(np.pi * time / 4.0) ** 2
    np.savetxt(file.parent / "m.csv", np.column_stack([time, wave]), delimiter=",",
               header="time (s),acceleration (m/s^2)", comments="")  # fmt: skip
    report = sitedda.check(file)
    line = finding(report.text, "element size")
    assert line.startswith("ok")  # 1/20 of a wavelength in the soil; 0.6 with the rock


# --- Block sizes, and notes on probable mistakes --------------------------------------------------


@pytest.mark.parametrize("degrees", [0.0, 30.0, 90.0])
def test_the_size_of_a_thin_block_does_not_depend_on_its_direction(write_input, degrees):
    """Waves of 1000 m/s cross slabs of 0.1 m in 1e-4 s."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    slabs = [rectangle(0.0, 0.1 * i, 10.0, 0.1) for i in range(3)]
    turned = [np.reshape(slab, (-1, 2)) @ [[c, s], [-s, c]] for slab in slabs]
    points = np.array([[1.0, 0.05], [9.0, 0.05]]) @ [[c, s], [-s, c]]
    report = sitedda.check(write_input([
        group("control", time_step=1e-3, steps=1, analysis="plane_strain"),
        group("material", density=2000.0, pressure_velocity=1000.0, shear_velocity=500.0),
        group("joint", friction_angle=30.0, cohesion=1e9, tensile_strength=1e9),
        *(group("block", vertices=slab.ravel().tolist()) for slab in turned),
        *(group("fixed_point", x=x, y=y, block="1") for x, y in points),
    ]))  # fmt: skip
    line = finding(report.text, "CFL")
    assert "1e-4 s (P), 2e-4 s (S)" in line or "1.0e-4 s (P)" in line


def test_the_error_of_a_start_includes_the_notes_on_the_model(write_input):
    groups = changed(stack(2, 1.0), "control", gravity=[0.0, 9.81])
    with pytest.raises(sitedda.SiteddaError, match=r"fall.*note: gravity = 0, 9.81 m/s² points up"):
        sitedda.check(write_input(groups))


def test_an_unused_material_that_determines_the_penalty_is_noted(write_input):
    steel = group("material", name="steel", density=7850.0, young_modulus=2e11, poisson_ratio=0.3)
    groups = changed(stack(2, 1.0), "material", name="stone")
    groups = [(n, g | {"material": "stone"} if n == "block" else g) for n, g in groups]
    note = "no block has material 'steel', but its young_modulus determines the default"
    assert note in finding(sitedda.check(write_input([*groups, steel])).text, "input")
    own = [*groups, steel, group("contact", normal_stiffness=1e12)]
    assert "no block has" not in sitedda.check(write_input(own)).text


@pytest.mark.parametrize(("later", "warns"), [(1e-3, False), (2e-2, True)])
def test_longer_steps_of_a_later_stage_are_reported(write_input, later, warns):
    stages = [
        group("stage", name=name, kind="dynamic", duration=0.1, time_step=step)
        for name, step in (("short", 1e-3), ("long", later))
    ]
    groups = [
        (name, {k: v for k, v in values.items() if k not in ("duration", "settle")})
        for name, values in stack(2, 1.0)
    ]
    lines = sitedda.check(write_input([*groups, *stages])).lines
    text = "".join(line.words for line in lines if line.topic == "stages")
    assert ("describe stage 'short'; stage 'long' has time_step = 0.02 s" in text) == warns
