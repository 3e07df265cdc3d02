# SPDX-License-Identifier: GPL-3.0-or-later
"""Threads that other programs leave no processors for."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from environment import DEADLINE
from model_text import DRY, ROCK, namelist

WALL = [
    ("control", {"time_step": 1e-3, "steps": 12, "gravity": [0.0, -9.81]}),
    ("material", dict(ROCK)),
    ("joint", dict(DRY)),
    ("wall", {"brick_length": 1.0, "brick_height": 0.5, "bricks": 23, "courses": 23}),
    ("fixed_point", {"x": 0.5, "y": 0.25}),
]
SLOWER = 2.0  # times, at most: a machine with other programs measures no better
TRIES = 3  # on a machine with more of them either run may be slow by chance


def run(native, file, output, threads: int) -> tuple[float, str]:
    """Seconds of the clock, and what a run with so many threads prints."""
    begun = time.monotonic()
    done = subprocess.run(
        [native.path, "run", file, "-q", "-o", output],
        env=os.environ | {"OMP_NUM_THREADS": str(threads)},
        capture_output=True, text=True, timeout=DEADLINE,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return time.monotonic() - begun, done.stdout


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
    for _ in range(TRIES):
        alone, words = run(native, file, tmp_path / "one.nc", 1)
        assert "other programs" not in words
        both, words = run(native, file, tmp_path / "two.nc", 2)
        assert "note: other programs used the processors: " in words
        assert "with fewer than 2 threads" in words
        if both < SLOWER * alone:
            break
    else:
        pytest.fail(f"{both} s with two threads, {alone} s with one")
    same_bits(tmp_path / "one.nc", tmp_path / "two.nc")
