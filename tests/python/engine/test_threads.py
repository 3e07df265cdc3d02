# SPDX-License-Identifier: GPL-3.0-or-later
"""Threads that other programs leave no processors for."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from model_text import DRY, ROCK, changed, group, namelist
from test_checkpoint import LAWS

WALL = [
    group("control", time_step=1e-3, steps=12, gravity=[0.0, -9.81]),
    ("material", dict(ROCK)),
    ("joint", dict(DRY)),
    group("wall", brick_length=1.0, brick_height=0.5, bricks=23, courses=23),
    group("fixed_point", x=0.5, y=0.25),
]


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
    alone = native.ok("run", file, "-q", "-o", tmp_path / "one.nc", threads=1).stdout
    words = native.ok("run", file, "-q", "-o", tmp_path / "two.nc", threads=2).stdout
    assert "other programs" not in alone
    assert "note: other programs used the processors: " in words
    assert "with fewer than 2 threads" in words
    same_bits(tmp_path / "one.nc", tmp_path / "two.nc")


@pytest.mark.parametrize("law", [law for law in LAWS if " " not in law])
def test_joint_laws_have_the_same_bits_with_any_threads(
    native, write_input, tmp_path, same_bits, law
):
    """With points between corners: more contacts than one thread is left to."""
    points = {"contact_points": 3, "normal_stiffness_per_area": 1e10}
    file = write_input(namelist(changed(WALL, "joint", **(points | LAWS[law]))))
    for threads in (1, 2, 4):
        native.ok("run", file, "-q", "-o", tmp_path / f"{threads}.nc", threads=threads)
    for threads in (2, 4):
        same_bits(tmp_path / "1.nc", tmp_path / f"{threads}.nc")
