# SPDX-License-Identifier: GPL-3.0-or-later
"""Threads on processors that other programs use."""

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
    """Run as many programs as this process may use processors, at most two."""
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, sorted(before)[:2])
    processes = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2)]
    yield
    for process in processes:
        process.kill()
        process.wait()
    os.sched_setaffinity(0, before)


@pytest.mark.skipif(
    not Path("/proc/thread-self/schedstat").exists(), reason="the system counts no waiting time"
)
def test_runs_use_fewer_threads_on_busy_processors(
    binary, write_input, tmp_path, busy_processors, same_bits
):
    file = write_input(namelist(WALL))
    text_of_one_thread = binary.ok("run", file, "-q", "-o", tmp_path / "one.nc", threads=1).stdout
    output = binary.ok("run", file, "-q", "-o", tmp_path / "two.nc", threads=2).stdout
    assert "other programs" not in text_of_one_thread
    assert "note: other programs used the processors: " in output
    assert "with fewer than 2 threads" in output
    same_bits(tmp_path / "one.nc", tmp_path / "two.nc")


@pytest.mark.parametrize("law", [law for law in LAWS if " " not in law])
def test_joint_laws_are_bit_identical_with_any_number_of_threads(
    binary, write_input, tmp_path, same_bits, law
):
    """Points between corners: the number of contacts is too large for one thread."""
    points = {"contact_points": 3, "normal_stiffness_per_area": 1e10}
    file = write_input(namelist(changed(WALL, "joint", **(points | LAWS[law]))))
    for threads in (1, 2, 4):
        binary.ok("run", file, "-q", "-o", tmp_path / f"{threads}.nc", threads=threads)
    for threads in (2, 4):
        same_bits(tmp_path / "1.nc", tmp_path / f"{threads}.nc")
