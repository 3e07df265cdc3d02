# SPDX-License-Identifier: GPL-3.0-or-later
"""Threads that other programs leave no processors for."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from environment import DEADLINE
from model_text import DRY, ROCK, changed, group, namelist

WALL = [
    group("control", time_step=1e-3, steps=12, gravity=[0.0, -9.81]),
    ("material", dict(ROCK)),
    ("joint", dict(DRY)),
    group("wall", brick_length=1.0, brick_height=0.5, bricks=23, courses=23),
    group("fixed_point", x=0.5, y=0.25),
]


def run(native, file, output, threads: int) -> str:
    """What a run with so many threads prints."""
    done = subprocess.run(
        [native.path, "run", file, "-q", "-o", output],
        env=os.environ | {"OMP_NUM_THREADS": str(threads)},
        capture_output=True, text=True, timeout=DEADLINE,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture
def busy_processors():
    """As many programs as this one may use processors, two at most, which it keeps to."""
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, sorted(before)[:2])
    others = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2)]
    yield
    for other in others:
        other.kill()
        other.wait()
    os.sched_setaffinity(0, before)


@pytest.mark.skipif(
    not Path("/proc/thread-self/schedstat").exists(), reason="the system counts no waiting time"
)
def test_threads_make_room_for_other_programs(
    native, write_input, tmp_path, busy_processors, same_bits
):
    file = write_input(namelist(WALL))
    assert "other programs" not in run(native, file, tmp_path / "one.nc", 1)
    words = run(native, file, tmp_path / "two.nc", 2)
    assert "note: other programs used the processors: " in words
    assert "with fewer than 2 threads" in words
    same_bits(tmp_path / "one.nc", tmp_path / "two.nc")


LAWS = {
    "cohesive": {"cohesion": 3e4, "tensile_strength": 1e3, "fracture_energy": 0.1},
    "crushing": {"crushing_strength": 1e5, "crushing_energy": 1e3},
    "plesha": {"asperity_angle": 10.0, "asperity_wear": 1e-3},
    "continuously_yielding": {"initial_friction_angle": 45.0, "roughness": 1e-3},
    "rate_state": {
        "direct_effect": 0.01,
        "evolution_effect": 0.015,
        "threshold_velocity": 1e-6,
        "state_distance": 1e-4,
    },
}


@pytest.mark.parametrize("law", LAWS)
def test_joint_laws_have_the_same_bits_with_any_threads(
    native, write_input, tmp_path, same_bits, law
):
    """With points between corners: more contacts than one thread is left to."""
    points = {"law": law, "contact_points": 3, "normal_stiffness_per_area": 1e10}
    file = write_input(namelist(changed(WALL, "joint", **LAWS[law], **points)))
    for threads in (1, 2, 4):
        run(native, file, tmp_path / f"{threads}.nc", threads)
    for threads in (2, 4):
        same_bits(tmp_path / "1.nc", tmp_path / f"{threads}.nc")
