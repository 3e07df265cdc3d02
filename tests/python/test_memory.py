# SPDX-License-Identifier: GPL-3.0-or-later
"""Too little memory is an error of its own that says how much is needed, never a crash."""

import os
import re
import resource
import subprocess
import time
from pathlib import Path

import pytest
from model_text import DRY, ROCK, namelist

MEBI = 2**20
# Threads reserve addresses of their own, by chance more or fewer.
ONE_THREAD = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
BLOCKS = 2500


def lattice(blocks: int, solver: str, steps: int = 1) -> str:
    """A wall that is as wide as it is high, at rest."""
    side = int(blocks**0.5)
    return namelist(
        [
            ("control", {"time_step": 1e-4, "steps": steps, "solver": solver}),
            ("material", dict(ROCK)),
            ("joint", dict(DRY)),
            ("wall", {"brick_length": 1.0, "brick_height": 0.5, "bricks": side, "courses": side}),
            ("fixed_point", {"x": 0.5, "y": 0.25}),
        ]
    )


def limited(program, limit: int, *arguments, folder) -> subprocess.CompletedProcess:
    """A run that may have so many bytes of addresses."""
    return subprocess.run(
        [program.path, *arguments],
        cwd=folder,
        env=ONE_THREAD,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)),
        capture_output=True,
        text=True,
        timeout=60,
    )


def test_a_model_that_does_not_fit_is_refused_before_it_is_made(native, write_input, tmp_path):
    file = write_input(lattice(20_000, "jacobi"))
    done = limited(native, 150 * MEBI, "run", file, folder=tmp_path)
    assert done.returncode == 7, done.stderr
    needed = re.search(r"of \d+ blocks needs ([\d.]+) GB of memory, ([\d.]+) GB are", done.stderr)
    assert float(needed[1]) > float(needed[2])
    assert [one.name for one in tmp_path.iterdir()] == [file.name]


@pytest.fixture(scope="module")
def enough_for_jacobi(native, tmp_path_factory) -> int:
    """Bytes of addresses that steps without a factor take."""
    folder = tmp_path_factory.mktemp("jacobi")
    (folder / "model.nml").write_text(lattice(BLOCKS, "jacobi", steps=10_000_000))
    running = subprocess.Popen([native.path, "run", "model.nml", "-q"], cwd=folder, env=ONE_THREAD)
    journal, sizes = folder / "model.nc.journal", set()
    deadline = time.monotonic() + 60
    while len(sizes) < 4:  # steps
        assert running.poll() is None and time.monotonic() < deadline
        time.sleep(0.05)
        sizes |= {journal.stat().st_size} if journal.exists() else set()
    status = Path(f"/proc/{running.pid}/status").read_text()
    running.kill()
    running.wait()
    return 1024 * int(re.search(r"VmPeak:\s*(\d+)", status)[1])


@pytest.mark.parametrize("solver", ["direct", "banded", "lagged"])
def test_a_factor_that_does_not_fit_is_named_and_jacobi_runs(
    solver, native, enough_for_jacobi, write_input, tmp_path
):
    limit = enough_for_jacobi + 8 * MEBI
    file = write_input(lattice(BLOCKS, solver))
    done = limited(native, limit, "run", file, "-q", folder=tmp_path)
    assert done.returncode == 7, (done.stdout, done.stderr)
    assert "memory" in done.stderr and "'jacobi'" in done.stderr
    assert done.stderr.count("\n") == 1 and not (tmp_path / "model.nc").exists()
    file = write_input(lattice(BLOCKS, "jacobi"))
    done = limited(native, limit, "run", file, "-q", folder=tmp_path)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("solver", ["direct", "lagged"])
def test_whatever_the_limit_a_run_ends_or_says_what_it_needs(
    solver, native, enough_for_jacobi, write_input, tmp_path
):
    file = write_input(lattice(BLOCKS, solver))
    found = []
    for limit in range(enough_for_jacobi - 20 * MEBI, enough_for_jacobi + 60 * MEBI, 8 * MEBI):
        done = limited(native, limit, "run", file, "-q", folder=tmp_path)
        found.append(done.returncode)
        assert done.returncode == 0 or "GB of memory" in done.stderr, done.stderr
    assert found == sorted(found, reverse=True) and set(found) == {0, 7}
