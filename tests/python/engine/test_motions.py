# SPDX-License-Identifier: GPL-3.0-or-later
"""Continuation of motions after their records; descriptions of motions and of the analysis."""

import re

import numpy as np
import pytest
from model_text import changed, group, namelist, rectangle, tower, without

import sitedda

STEP = 1e-3
PUSH, SAMPLE, LASTS = 2.0, 0.1, 0.2  # m/s², s: a rectangular pulse of three samples
LEFT = PUSH * LASTS  # m/s
ENDS = PUSH * LASTS**2 / 2  # m


def sled(motion=None, duration=0.5, **control):
    """A block on a floor that moves along x."""
    pulse = {"name": "pulse", "quantity": "acceleration", "time_step": SAMPLE, "drift_order": 0,
             "values": [PUSH] * 3} | (motion or {})  # fmt: skip
    return [
        ("control", {"time_step": STEP, "duration": duration, "gravity": [0.0, -9.81]} | control),
        group("contact", normal_stiffness=1e9),
        group("material", name="stone", density=2600.0, young_modulus=4e10, poisson_ratio=0.2),
        group("joint", name="rough", friction_angle=40.0),
        group("block", name="floor", vertices=rectangle(-1.0, -0.5, 4.0, 0.5)),
        group("block", name="stone", vertices=rectangle(0.0, 0.0, 0.8, 0.5)),
        ("motion", pulse),
        *(group("fixed_point", x=x, y=-0.25, motion_x="pulse") for x in (-0.9, 2.9)),
        group("measured_point", name="floor", x=1.0, y=-0.25, block="floor"),
        group("measured_point", name="stone", x=0.4, y=0.25, block="stone"),
    ]


def end_of(history, point="floor"):
    """Displacement and velocity along x at the end, m and m/s."""
    last = history.sel(point=point).isel(time=-1, axis=0)
    return float(last.displacement), float(last.velocity)


@pytest.mark.parametrize("integration", ["dda", "midpoint", "theta"])
def test_a_floor_continues_with_the_velocity_of_its_record(write_input, integration):
    groups = sled(integration=integration)
    history = sitedda.run(write_input(groups)).history
    after = float(history.time[-1]) - LASTS
    for point in ("floor", "stone"):
        assert end_of(history, point) == pytest.approx((ENDS + LEFT * after, LEFT), rel=2e-3)
    end_motion = history.sel(point="floor", time=slice(LASTS + 0.05, None)).isel(axis=0)
    assert abs(end_motion.acceleration).max() < 0.05 * PUSH  # no impact where the record ends
    work = float(abs(history.energy_input).max())
    assert float(abs(history.energy_balance).max()) < 1e-6 * work
    mass = 2600.0 * (4.0 * 0.5 + 0.8 * 0.5)
    assert float(history.energy_kinetic[-1]) == pytest.approx(0.5 * mass * LEFT**2, rel=5e-3)


def test_a_floor_stops_with_after_end_hold(write_input):
    history = sitedda.run(write_input(sled({"after_end": "hold"}))).history
    assert end_of(history)[0] == pytest.approx(ENDS, rel=1e-3)
    assert end_of(history)[1] == pytest.approx(0.0, abs=1e-3)
    acceleration = history.sel(point="floor").isel(axis=0).acceleration
    assert float(abs(acceleration).max()) > 0.1 * LEFT / STEP  # an impact, as described


UNCORRECTED = {"drift_order": None, "quantity": "displacement"}


@pytest.mark.parametrize(
    ("motion", "message"),
    [
        ({}, r"no drift removed; ends with 0.4 m/s at 0.04 m and continues with this velocity$"),
        ({"after_end": "hold"}, r"ends with 0.4 m/s at 0.04 m and is stopped .* an impact$"),
        ({"drift_order": 2}, r"changed it by up to 0.4 m/s and 0.04 m; ends with 0 m/s .*held"),
        ({"quantity": "velocity", "values": [0, 0.4, 0]}, r"0 m/s .*held there$"),
        ({"drift_order": None, "values": [0.1, 0.3, 0.1, 0.3, 0.1]}, r"PGV 0 m/s, PGD [1-9]"),
        ({"drift_order": None, "values": [0.1] * 20},
         r"PGA 0 m/s², PGV 0 m/s, PGD 0 m; .* 0 m/s at 0 m"),
        (UNCORRECTED | {"values": [0, 0.1, 0.3]},
         r"ends with 0 m/s at 0.3 m and is held there \(its last two samples move at 2 m/s: "
         r"after_end = 'continue' keeps this velocity\)$"),
        (UNCORRECTED | {"values": [0, 0.1, 0.2], "after_end": "continue"},
         r"ends with 1 m/s at 0.2 m and continues with this velocity$"),
    ],
)  # fmt: skip
def test_each_motion_has_a_line_in_run_and_check(write_input, binary, main, motion, message):
    file = write_input(changed(sled(duration=0.01), "motion", **motion))
    with sitedda.Simulation(file) as simulation:
        first, line = simulation.description.splitlines()
    assert first == "analysis: plane stress (the default)"
    assert re.match(r"motion 'pulse': PGA \S+ m/s², PGV \S+ m/s, PGD \S+ m; ", line)
    assert re.search(message, line)
    folder = file.parent
    for process in (binary("run", file, folder=folder), binary("check", file), main("check", file)):
        assert f"{first}\n{line}\n" in process.stdout.replace("\n      ", " ")


def test_peaks_of_the_line_are_those_of_the_record(write_input):
    values = [0.0, 0.5, 1.5, -0.7, -2.25, 0.3, 0.0]
    groups = changed(sled(), "motion", values=values, time_step=0.05)
    velocity = 0.05 * np.cumsum([0.0, *np.add(values[1:], values[:-1]) / 2])
    with sitedda.Simulation(write_input(groups)) as simulation:
        line = simulation.description.splitlines()[1]
    assert f"PGA 2.25 m/s², PGV {abs(velocity).max():.4g} m/s" in line
    assert f"ends with {velocity[-1]:.4g} m/s" in line


def test_a_resumed_run_after_the_record_is_bit_identical(write_input, same_bits, in_parts):
    file = write_input(sled())
    same_bits(sitedda.run(file).history, in_parts(file, 350))  # after the end of the record


def test_a_compliant_base_continues_with_its_outcrop(write_input):
    """A bonded stack on a half-space has the final velocity of the free surface."""
    groups = [
        group("control", time_step=STEP, duration=1.5, analysis="plane_strain"),
        group("contact", normal_stiffness=1e11),
        group("material", density=2000.0, shear_velocity=300.0, pressure_velocity=600.0),
        group("joint", friction_angle=40.0, cohesion=1e9, tensile_strength=1e9),
        group("layers", name="layer", width=10.0, thickness=2.0, count=3),
        sled()[6],
        group("boundary", kind="compliant", side="bottom", motion_x="pulse"),
        group("measured_point", name="top", x=5.0, y=6.0),
    ]
    for direction in ("x", "xy"):
        with_direction = changed(groups, "boundary", direction=direction)
        history = sitedda.run(write_input(with_direction)).history
        assert end_of(history, "top")[1] == pytest.approx(LEFT, rel=1e-2)
        work = float(abs(history.energy_input).max())
        assert float(abs(history.energy_balance).max()) < 1e-6 * work


def test_rest_on_a_moving_floor_ends_a_run(write_input):
    """After the record, nothing moves relative to the floor: rest_time of &stop is reached."""
    groups = [*sled(duration=3.0), group("stop", rest_time=0.2, rest_movement=1e-3)]
    run = sitedda.run(write_input(groups))
    assert LASTS + 0.2 <= float(run.history.time[-1]) < 1.0
    sliding_groups = changed(groups, "joint", friction_angle=5.0)  # the stone slides for a while
    later_run = sitedda.run(write_input(sliding_groups))
    assert float(later_run.history.time[-1]) > float(run.history.time[-1]) + 0.05


def test_body_force_has_the_impulse_of_a_record_that_ends_within_a_step(write_input):
    """A free block in the frame of the base has −a T, also if T is not a multiple of the step."""
    for duration in (0.02, 0.0203, 0.0206, 0.0209):
        groups = changed(sled(duration=0.04), "control", base_motion_x="pulse", gravity=None)
        groups = without(without(groups, "fixed_point"), "measured_point")
        groups = changed(groups, "motion", values=[PUSH, PUSH], time_step=duration)
        with sitedda.Simulation(write_input(groups)) as simulation:
            while not simulation.advance(10):
                pass
            assert simulation.rates[:, 0] == pytest.approx(-PUSH * duration, rel=1e-9)


HELD = changed(sled(), "motion", after_end="hold")
STAGES = [group("stage", name="push", duration=0.4), group("stage", name="rest", kind="static")]


@pytest.mark.parametrize(
    ("groups", "message"),
    [
        (changed(sled(), "motion", after_end="stop"), r"&motion.*'stop' must be one of"),
        (without(changed(HELD, "control", base_motion_x="pulse"), "fixed_point"),
         r"&control .*base_motion_x: a body force cannot stop the base"),
        ([*changed(sled(), "control", duration=None), *STAGES],
         r"stage 'rest' .*'pulse' of &motion continues with 0.4 m/s .*after_end = 'hold'"),
    ],
)  # fmt: skip
def test_contradictory_motions_are_refused(write_input, groups, message):
    with pytest.raises(sitedda.InputError, match=message):
        sitedda.run(write_input(groups))


def test_a_static_stage_after_a_held_motion_rests(write_input):
    groups = [*changed(HELD, "control", duration=None), *STAGES]
    assert sitedda.run(write_input(groups)).complete


VELOCITIES = {"young_modulus": None, "poisson_ratio": None, "shear_velocity": 800.0,
              "pressure_velocity": 1600.0}  # fmt: skip


@pytest.mark.parametrize(
    ("groups", "cause"),
    [
        (changed(tower(), "material", **VELOCITIES), "material"),
        *(([*without(tower(), "fixed_point"), group("boundary", kind=kind, side=side)], "boundary")
          for kind, side in (("viscous", "bottom"), ("compliant", "bottom"),
                             ("free_field", "left"))),
    ],
)  # fmt: skip
def test_models_with_waves_require_a_choice_of_the_analysis(write_input, groups, cause):
    file = write_input(groups)
    message = rf"model\.nml, group &{cause} \(line \d+\).*'plane_strain'.*'plane_stress'"
    with pytest.raises(sitedda.InputError, match=message):
        sitedda.Simulation(file)
    for choice in ("plane_strain", "plane_stress"):
        complete_input = namelist(changed(groups, "control", analysis=choice))
        file.write_text(complete_input)
        try:
            with sitedda.Simulation(file) as simulation:
                assert simulation.description.startswith(f"analysis: {choice.replace('_', ' ')}\n")
        except sitedda.InputError as other:
            assert "analysis" not in str(other)


def test_other_models_use_plane_stress_by_default(write_input, binary):
    for kind in ("fixed", "roller"):
        groups = [*without(tower(), "fixed_point"), group("boundary", kind=kind, side="bottom")]
        file = write_input(groups)
        with sitedda.Simulation(file) as simulation:
            assert simulation.description.startswith("analysis: plane stress (the default)\n")
    output = binary("check", file).stdout
    assert output.startswith("analysis: plane stress (the default)\n")
