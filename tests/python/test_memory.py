# SPDX-License-Identifier: GPL-3.0-or-later
"""Lack of memory causes an error with the required amount, never a crash."""

import os
import platform
import re
import subprocess
import sys
from pathlib import Path

import pytest
from environment import wait_for

sys.path.insert(0, str(Path(__file__).parents[1] / "robustness"))

import memory_limits  # noqa: E402
from memory_limits import DONE, MEBI, REFUSED, is_sound, limited, outcome, sweep, wall  # noqa: E402

BLOCKS = 2500
LITTLE = 240 * MEBI  # with 225 MB, OpenBLAS 0.3.29 never loads
# Kernels of a processor without AVX-512, with which each product of OpenBLAS uses a buffer.
PLAIN_CORE = "Nehalem" if platform.machine() == "x86_64" else ""


def test_a_model_that_does_not_fit_is_refused_before_it_is_built(binary, write_input, tmp_path):
    file = write_input(wall(20_000, "jacobi"))
    process = limited(binary.path, LITTLE, "run", file, folder=tmp_path)
    assert process.returncode == 7, process.stderr
    pattern = r"of \d+ blocks needs ([\d.]+) GB of memory, ([\d.]+) GB are"
    needed = re.search(pattern, process.stderr)
    assert float(needed[1]) > float(needed[2])
    assert [file_found.name for file_found in tmp_path.iterdir()] == [file.name]


@pytest.fixture(scope="module")
def enough_for_jacobi(binary, tmp_path_factory) -> int:
    """Return the address space of steps without a factor; it is too small for a check."""
    folder = tmp_path_factory.mktemp("jacobi")
    (folder / "model.nml").write_text(wall(BLOCKS, "jacobi", steps=2000))
    environment = os.environ | memory_limits.ONE_THREAD
    running = subprocess.Popen([binary.path, "run", "model.nml", "-q"], cwd=folder, env=environment)
    journal, sizes = folder / "model.nc.journal", set()

    def has_computed_steps() -> bool:
        sizes.update({journal.stat().st_size} if journal.exists() else ())
        return len(sizes) >= 4

    wait_for(has_computed_steps, running)
    status = Path(f"/proc/{running.pid}/status").read_text()
    running.kill()
    running.wait()
    return 1024 * int(re.search(r"VmPeak:\s*(\d+)", status)[1])


@pytest.mark.parametrize("solver", ["direct", "lagged"])
def test_a_factor_that_does_not_fit_is_named_and_jacobi_runs(
    solver, binary, enough_for_jacobi, write_input, tmp_path
):
    limit = enough_for_jacobi + 8 * MEBI
    file = write_input(wall(BLOCKS, solver))
    process = limited(binary.path, limit, "run", file, "-q", folder=tmp_path)
    assert process.returncode == 7, (process.stdout, process.stderr)
    assert "memory" in process.stderr and "'jacobi'" in process.stderr
    assert process.stderr.count("\n") == 1 and not (tmp_path / "model.nc").exists()
    file = write_input(wall(BLOCKS, "jacobi"))
    process = limited(binary.path, limit, "run", file, "-q", folder=tmp_path)
    assert process.returncode == 0, process.stderr


@pytest.mark.parametrize(("solver", "core"), [("direct", PLAIN_CORE), ("lagged", "")])
def test_with_any_limit_a_run_completes_or_states_its_need(
    solver, core, binary, enough_for_jacobi, tmp_path
):
    limits = range(enough_for_jacobi - 20 * MEBI, enough_for_jacobi + 60 * MEBI, 8 * MEBI)
    outcomes = sweep(binary.path, limits, solver, BLOCKS, tmp_path, core)
    assert is_sound(outcomes) and set(outcomes) == {REFUSED, DONE}, outcomes


def test_a_limit_without_room_for_blas_is_refused_at_once(binary, write_input, tmp_path):
    file = write_input(wall(16, "jacobi"))
    for command in ("run", "check"):
        process = limited(binary.path, LITTLE, command, file, folder=tmp_path, core=PLAIN_CORE)
        assert outcome(process) == REFUSED and "of addresses for BLAS" in process.stderr
        process = limited(binary.path, 1000 * MEBI, command, file, folder=tmp_path, core=PLAIN_CORE)
        assert outcome(process) == DONE
