# SPDX-License-Identifier: GPL-3.0-or-later
"""Rules of &stop, and output at equal times."""

import math

import numpy as np
import pytest
from model_text import DRY, ROCK, changed, flying_block, group, rectangle

import sitedda

GRAVITY = 9.81


def falling(steps: int = 2000, step: float = 1e-3, **stop) -> list:
    """A free block beside two fixed blocks, without contact."""
    return [
        group("control", time_step=step, steps=steps, gravity=[0.0, -GRAVITY]),
        group("contact", normal_stiffness=1e9),
        ("material", dict(ROCK)),
        ("joint", dict(DRY)),
        *(group("block", name=f"b_{i}", vertices=rectangle(3 * i, 0, 2, 1)) for i in range(3)),
        *(group("fixed_point", x=3 * i + x, y=0.5) for i in (0, 1) for x in (0.4, 1.6)),
        group("output", file="fall.nc", block_interval=500),
        ("stop", stop),
    ]


def first_step(distance: float, step: float) -> int:
    """The first step at which a fall from rest exceeds a distance: ½ g (n Δt)², exact in DDA."""
    return math.floor(math.sqrt(2 * distance / GRAVITY) / step) + 1


def ended(groups, write_input) -> sitedda.Run:
    run = sitedda.run(write_input(groups))
    assert run.complete
    return run


@pytest.mark.parametrize("distance", [0.1, 0.7])
def test_a_fall_ends_in_the_step_that_exceeds_the_limit(write_input, distance):
    run = ended(falling(displacement=distance), write_input)
    assert run.history.time[-1] == pytest.approx(1e-3 * first_step(distance, 1e-3))
    ending = run.history.attrs["ending"]
    assert ending.startswith("stopped at t = ") and "block 3 'b_2' has moved by" in ending
    assert ending in " ".join(str(run.verdict).split())
    assert run.history.frame_time[-1] == run.history.time[-1]


def test_a_block_has_fallen_if_it_has_moved_by_its_size(write_input):
    run = ended(falling(fallen=1), write_input)
    assert run.history.time[-1] == pytest.approx(1e-3 * first_step(math.sqrt(2.0), 1e-3))
    assert "1 block has moved farther" in run.history.attrs["ending"]
    assert run.verdict.values["blocks_fallen"] == 1


def test_tilt_counts_in_both_senses(write_input):
    groups = [*flying_block(4000), group("stop", tilt=10.0)]
    for spin in (-0.5, 0.5):
        spun = changed(groups, "material", initial_velocity=[0.0, 0.0, spin])
        run = ended(spun, write_input)
        assert run.history.time[-1] == pytest.approx(math.radians(10) / 0.5, abs=2e-3)
        assert "has tilted by 10." in run.history.attrs["ending"]


def test_only_named_blocks_count_relative_to_the_reference(write_input):
    assert ended(falling(displacement=0.1, blocks="b_0, b_1"), write_input).history.time[-1] == 2.0
    run = ended(falling(displacement=0.1, reference="b_2"), write_input)
    assert "block 1 'b_0'" in run.history.attrs["ending"]
    assert run.history.time[-1] == pytest.approx(1e-3 * first_step(0.1, 1e-3))


def resting(**control) -> list:
    """A block that falls slightly onto a fixed one and comes to rest at 0.6 s."""
    return [
        ("control", {"time_step": 1e-3, "duration": 5.0, "gravity": [0.0, -GRAVITY], **control}),
        group("contact", normal_stiffness=1e8),
        ("material", dict(ROCK, young_modulus=1e8)),
        ("joint", dict(DRY)),
        group("block", name="table", vertices=rectangle(0, 0, 6, 1)),
        group("block", name="brick", vertices=rectangle(2, 1.01, 2, 1)),
        *(group("fixed_point", x=x, y=0.5, motion_x="m") for x in (1, 5)),
        group("motion", name="m", quantity="displacement", time_step=0.1,
              values=[0.0, 0.0, 0.0, 0.01, 0.02, 0.02, 0.02]),
        group("output", file="rest.nc", block_interval=100),
        group("stop", rest_time=0.2, rest_movement=1e-5),
    ]  # fmt: skip


def test_rest_comes_after_the_motions(write_input):
    run = ended(resting(), write_input)
    end = float(run.history.time[-1])
    assert 0.8 <= end < 4.0 and run.history.attrs["ending"].endswith("within 0.2 s")
    changed_input = changed(resting(), "motion", values=[0.0] * 31)  # the motion lasts 3 s
    time = float(ended(changed_input, write_input).history.time[-1])
    assert time == pytest.approx(3.2, abs=1.5e-3)


def test_rest_comes_after_the_loads_on_edges(write_input):
    """A traction that is constant after 2 s."""
    traction = {"along": [0.0, 1.0, 2.0, 1.0], "time": [0.0, 1.0, 2.0, 9.0],
                "normal": [0.0, 0.0, 1e3, 1e3]}  # fmt: skip
    groups = [*changed(resting(), "motion", values=[0.0, 0.0]), ("traction", traction)]
    assert float(ended(groups, write_input).history.time[-1]) == pytest.approx(2.2, abs=0.02)


@pytest.mark.parametrize("after", [3, 700])
def test_a_resumed_run_stops_bit_identically(write_input, tmp_path, same_bits, binary, after):
    file = write_input(resting())
    reference = sitedda.run(file)
    with sitedda.Simulation(file, tmp_path / "out.nc") as simulation:
        assert not simulation.advance(after) and simulation.ending == ""
    resumed_run = sitedda.resume(file, tmp_path / "out.nc")
    attributes = ("title", "input_text", "step_control", "ending")
    same_bits(reference.history, resumed_run.history, attributes)
    if after == 3:
        process = binary("run", file, "-q", "-o", tmp_path / "native.nc")
        assert reference.history.attrs["ending"] in " ".join(process.stdout.split())
        same_bits(reference.history, tmp_path / "native.nc", attributes)


@pytest.mark.parametrize(
    ("stop", "message"),
    [
        ({}, "give displacement or tilt or fallen or rest_time"),
        ({"tilt": -1.0}, "tilt = -1 must be a positive number"),
        ({"displacement": 0.0}, "displacement = 0 must be a positive number"),
        ({"fallen": 4}, "only 3 blocks are selected"),
        ({"rest_movement": 1.0, "tilt": 1.0}, "rest_time is missing: rest_movement needs it"),
        ({"tilt": 1.0, "blocks": "c_*"}, "nothing is named 'c_*'"),
        ({"tilt": 1.0, "reference": "c"}, "reference = 'c' is not the name of a &block"),
    ],
)
def test_a_wrong_rule_is_refused(write_input, stop, message):
    with pytest.raises(sitedda.InputError, match="&stop") as error_info:
        sitedda.run(write_input(falling(**stop)))
    assert message in str(error_info.value)


# --- Output at equal times ------------------------------------------------------------------------


def test_seconds_are_steps_where_steps_are_fixed(write_input, same_bits):
    groups = changed(flying_block(100), "control", gravity=[0.0, -GRAVITY])
    by_steps = [*groups, group("output", history_interval=5, block_interval=20)]
    by_time = [*groups, group("output", history_seconds=5e-3, block_seconds=2e-2)]
    one, other = (sitedda.run(write_input(g)).history for g in (by_steps, by_time))
    same_bits(one, other, ("title", "step_control"))
    assert one.sizes["frame"] == 6


def bouncing(**output) -> list:
    """A block that falls onto a fixed one; the adaptive step decreases at the impact."""
    groups = changed(resting(), "control", time_step_control="adaptive", duration=0.3,
                     max_displacement_ratio=2e-4, time_step=4e-3)  # fmt: skip
    groups = [pair for pair in groups if pair[0] not in ("stop", "output")]
    return [*groups, ("output", output)]


@pytest.mark.parametrize(
    "output", [{"block_interval": 10}, {"history_seconds": 7e-3, "block_seconds": 0.05}], ids=str
)
def test_an_adaptive_run_resumes_with_its_own_time_step(write_input, same_bits, in_parts, output):
    file = write_input(bouncing(**output))
    history = sitedda.run(file).history
    assert "history_seconds" in output or history.time_step[41] < 2e-3
    same_bits(history, in_parts(file, 41))


def test_samples_of_adaptive_steps_are_at_equal_times(write_input):
    history = sitedda.run(write_input(bouncing(history_seconds=7e-3, block_seconds=0.05))).history
    samples = 1 + round(0.3 // 7e-3)
    assert history.time.values[:samples] == pytest.approx(7e-3 * np.arange(samples), abs=1e-14)
    assert history.sizes["time"] == samples + 1  # and the end
    assert history.frame_time.values == pytest.approx(0.05 * np.arange(7), abs=1e-14)
    assert history.time_step.values.min() < 3e-3  # steps do shrink
    fall = sitedda.run(write_input(bouncing(block_seconds=7e-3))).history
    time = 7e-3 * np.arange(7)  # it lands after 45 ms
    assert fall.frame_time.values[:7] == pytest.approx(time, abs=1e-14)
    height = fall.block_coordinates.sel(block="brick", coordinate="y").values
    assert height[:7] == pytest.approx(1.51 - 0.5 * GRAVITY * time**2, abs=1e-12)


@pytest.mark.parametrize(
    ("output", "message"),
    [
        ({"history_seconds": 2.5e-3}, "is not a whole number of steps of 0.001 s"),
        ({"block_seconds": 1e-4}, "block_seconds = 1e-4 is not a whole number"),
        ({"block_seconds": -1.0}, "block_seconds = -1 must be a positive number"),
        ({"block_seconds": 1.0, "block_interval": 3}, "give either block_interval"),
    ],
)
def test_output_times_that_no_step_meets_are_refused(write_input, output, message):
    with pytest.raises(sitedda.InputError, match="&output") as error_info:
        sitedda.run(write_input([*flying_block(10), ("output", output)]))
    assert message in str(error_info.value)
