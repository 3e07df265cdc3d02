# SPDX-License-Identifier: GPL-3.0-or-later
"""Interrupted runs continue bit-identically from a checkpoint; mismatches are refused."""

import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import xarray as xr
from environment import DEADLINE, captured, wait_for
from model_text import changed, tower

import sitedda

sys.path.insert(0, str(Path(__file__).parents[2] / "robustness"))
from damage import crc64  # noqa: E402

STEPS = 400
LONG = 200_000  # steps that take longer than a test waits


def shaken_tower(steps: int = STEPS, interval: int = 0, **control) -> list:
    """Loose layers that slide, with frames and checkpoints at intervals."""
    bedding = {"name": "bedding", "friction_angle": 5.0}
    groups = tower(4, steps, bedding, gravity=[0.0, -9.81], **control)
    return changed(groups, "output", checkpoint_interval=interval, block_interval=30)


def stopped(file, output, after: int, **changes):
    """A run that is closed after some steps, with a checkpoint."""
    with sitedda.Simulation(file, output, **changes) as simulation:
        simulation.advance(after)


def written(file) -> int | None:
    """Modification time of a file, ns; None while the file is missing."""
    try:
        return file.stat().st_mtime_ns
    except FileNotFoundError:
        return None


def interrupted(program, file, folder, number=signal.SIGTERM, command="run"):
    """A run that receives a signal after its first checkpoint."""
    newest = folder / "tower.nc.checkpoint"
    before = written(newest)
    running = program.start(command, file, folder=folder)
    wait_for(lambda: written(newest) not in (None, before), running)
    running.send_signal(number)
    out, err = running.communicate(timeout=DEADLINE)
    return subprocess.CompletedProcess(command, running.returncode, out, err)


def files_beside(output) -> set[str]:
    return {file.name.removeprefix(output.name) for file in output.parent.glob(f"{output.name}*")}


# --- Bit-identical runs--------------------------------------------------------------------------


@pytest.mark.parametrize(
    "control",
    [
        *({"solver": name} for name in ("auto", "direct", "lagged", "jacobi", "sor")),
        {"time_step_control": "adaptive", "max_displacement_ratio": 2e-5},
        {"dynamic_factor": 0.95},
        {"integration": "midpoint"},
        {"contact": {"contact_rules": "original"}},
        {"contact": {"penetration_tolerance": 1e-7}},
        {"material": {"damping_ratio": 0.05}},
        {"joint": {"restitution": 0.2, "cohesion": 0.0, "tensile_strength": 0.0}},
    ],
    ids=str,
)
def test_a_resumed_run_equals_an_uninterrupted_one(write_input, tmp_path, same_bits, control):
    file = write_input(shaken_tower())
    reference = sitedda.run(file, **control)
    stopped(file, tmp_path / "out.nc", 211, **control)
    resumed_run = sitedda.resume(file, tmp_path / "out.nc", **control)
    assert resumed_run.complete
    same_bits(reference.history, resumed_run.history)
    assert files_beside(tmp_path / "out.nc") == {""}


LAWS = {
    "mohr_coulomb": {"friction_angle": 5.0, "residual_friction_angle": 4.0, "cohesion": 1e3,
                     "weakening_slip": 0.001, "dilation_angle": 2.0},
    "plesha": {"asperity_angle": 1.0, "asperity_wear": 1e-3},
    "cohesive": {"cohesion": 2e3, "tensile_strength": 1e3, "fracture_energy": 0.1,
                 "normal_stiffness_per_area": 1e9},
    "continuously_yielding": {"initial_friction_angle": 3.0, "roughness": 1e-3},
    "rate_state": {"direct_effect": 1e-3, "evolution_effect": 2e-3, "threshold_velocity": 1e-6,
                   "state_distance": 1e-3},
    "crushing": {"crushing_strength": 5e4, "crushing_energy": 1e3},
    "barton_bandis": {"jrc": 8.0, "jcs": 1e7, "max_closure": 1e-3,
                      "normal_stiffness_per_area": 1e9},
}  # fmt: skip
LAWS = {law: {"law": law, "friction_angle": 1.0} | values for law, values in LAWS.items()}
LAWS["points"] = {"cohesion": 1e3, "contact_points": 5}
FIVE = {"contact_points": 5, "normal_stiffness_per_area": 1e9}
LAWS |= {f"{law} at 5 points": LAWS[law] | FIVE for law in ("plesha", "cohesive")}


@pytest.mark.parametrize("law", LAWS)
def test_resumed_joint_laws_are_bit_identical(binary, write_input, tmp_path, same_bits, law):
    """Checkpoints contain the state of joints; the number of threads has no effect."""
    file = write_input(changed(shaken_tower(), "joint", **LAWS[law]))
    reference = sitedda.run(file)
    assert float(reference.history.energy_friction[-1]) > 0
    stopped(file, tmp_path / "out.nc", 150)
    binary.ok("resume", file, "-q", "-o", tmp_path / "out.nc", threads=2)
    same_bits(reference.history, tmp_path / "out.nc")


def test_stopping_after_each_step_changes_nothing(write_input, tmp_path, same_bits):
    file = write_input(shaken_tower(60))
    reference = sitedda.run(file)
    stopped(file, tmp_path / "out.nc", 0)
    at_end = False
    while not at_end:
        with sitedda.Simulation(file, tmp_path / "out.nc", resume=True) as simulation:
            at_end = simulation.advance(7)
            simulation.finish()
    with xr.open_dataset(tmp_path / "out.nc") as history:
        same_bits(reference.history, history.load())


def test_many_checkpoints_change_nothing(program, write_input, tmp_path, same_bits):
    for interval, name in ((0, "none.nc"), (1, "each.nc")):
        file = write_input(shaken_tower(100, interval), f"{name}.nml")
        program.ok("run", file, "-q", "-o", tmp_path / name)
        assert files_beside(tmp_path / name) - {".nml"} == {""}
    same_bits(tmp_path / "none.nc", tmp_path / "each.nc", attributes=("step_control",))


def test_the_number_of_threads_may_change(binary, write_input, tmp_path, same_bits):
    wall = [pair for pair in tower(1, 6) if pair[0] not in ("layers", "measured_point")]
    wall += [
        ("layers", {"bottom": -1.0, "width": 60.0, "thickness": 1.0}),
        ("wall", {"brick_length": 1.0, "brick_height": 0.5, "bricks": 55, "courses": 10}),
    ]
    file = write_input(wall)
    reference = sitedda.run(file)
    for threads in (1, 2):
        output = tmp_path / f"out{threads}.nc"
        stopped(file, output, 3)
        binary.ok("resume", file, "-q", "-o", output, threads=threads)
        same_bits(reference.history, output)


def test_rates_that_were_set_are_part_of_the_state(write_input, tmp_path, same_bits):
    file = write_input(shaken_tower(50))

    def push(output):
        simulation = sitedda.Simulation(file, output)
        simulation.advance(10)
        rates = simulation.rates.copy()
        rates[2, 0] += 0.1
        simulation.rates = rates
        return simulation

    with push(tmp_path / "whole.nc") as simulation:
        simulation.advance(50)
        simulation.finish()
    push(tmp_path / "out.nc").close()
    sitedda.resume(file, tmp_path / "out.nc")
    same_bits(tmp_path / "whole.nc", tmp_path / "out.nc")


# --- Signals -------------------------------------------------------------------------------------


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGUSR1, signal.SIGINT])
def test_a_signal_ends_a_run_that_can_be_resumed(
    program, binary, write_input, tmp_path, same_bits, number
):
    file = write_input(shaken_tower(LONG, 50))
    process = interrupted(program, file, tmp_path, number)
    assert process.returncode == 6, process.stderr
    assert f"to continue: {program.name} resume {file}" in process.stderr
    assert len(process.stderr.strip().splitlines()[-1:]) == 1 and "Traceback" not in process.stderr
    with xr.open_dataset(tmp_path / "tower.nc.partial", engine="netcdf4") as partial_output:
        assert partial_output.attrs["complete"] == "no"
        steps = partial_output.sizes["time"] - 1
    assert steps >= 50
    with sitedda.Simulation(file, tmp_path / "tower.nc", resume=True) as simulation:
        assert simulation.steps == steps
        assert f"resumed at step {steps}" in simulation.notice


def test_each_program_resumes_what_the_other_began(
    binary, python_program, write_input, tmp_path, same_bits
):
    file = write_input(shaken_tower(20_000, 50))
    interrupted(binary, file, tmp_path)
    assert interrupted(python_program, file, tmp_path, command="resume").returncode in (0, 6)
    binary.ok("resume", file, "-q", folder=tmp_path)
    same_bits(sitedda.run(file).history, tmp_path / "tower.nc")


def test_a_growing_output_can_be_read_at_every_moment(binary, write_input, tmp_path):
    groups = changed(shaken_tower(10 * LONG, 500), "output", history_interval=50, block_interval=0)
    file = write_input(groups)
    running = subprocess.Popen([binary.path, "run", file, "-q"], cwd=tmp_path)
    partial_output = tmp_path / "tower.nc.partial"
    sizes, deadline = [0], time.monotonic() + DEADLINE
    while len(set(sizes)) < 3 and time.monotonic() < deadline:
        if partial_output.exists():
            with xr.open_dataset(partial_output, engine="netcdf4") as dataset:
                sizes.append(dataset.sizes["time"])
                assert bool(dataset.displacement[-1].notnull().all())
        time.sleep(0.01)
    running.terminate()
    assert running.wait(60) == 6
    assert sizes == sorted(sizes) and len(set(sizes)) == 3


# --- Mismatches ----------------------------------------------------------------------------------


@pytest.fixture
def two_checkpoints(write_input, tmp_path):
    """An input, and an output with two checkpoints."""
    file = write_input(shaken_tower())
    output = tmp_path / "out.nc"
    with sitedda.Simulation(file, output) as simulation:
        simulation.advance(100)
        simulation.checkpoint()
        simulation.advance(100)
        simulation.checkpoint()
        simulation.advance(1)
        shutil.copytree(tmp_path, tmp_path / "kept")
    for copied_file in (tmp_path / "kept").glob("out.nc*"):
        shutil.copy(copied_file, tmp_path)
    return file, output


def beside(output, suffix):
    return output.with_name(output.name + suffix)


def spoil(path, position=-100):
    data = bytearray(path.read_bytes())
    data[position] ^= 1
    path.write_bytes(data)


def test_the_newest_checkpoint_is_used(program, two_checkpoints):
    file, output = two_checkpoints
    process = program("resume", file, "-q", "-o", output)
    assert "resumed at step 200, t = 0.2 s, from" in process.stdout


def test_the_previous_checkpoint_replaces_a_damaged_one(program, two_checkpoints, same_bits):
    file, output = two_checkpoints
    spoil(beside(output, ".checkpoint"))
    process = program.ok("resume", file, "-q", "-o", output)
    assert "resumed at step 100" in process.stdout
    assert "checkpoint.previous, because" in process.stdout and "damaged" in process.stdout
    same_bits(sitedda.run(file).history, output)


def test_the_previous_checkpoint_replaces_a_missing_one(two_checkpoints):
    file, output = two_checkpoints
    beside(output, ".checkpoint").unlink()
    with sitedda.Simulation(file, output, resume=True) as simulation:
        assert simulation.steps == 100


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (lambda data: data[:-100], "cut short"),
        (lambda data: data[:10], "cut short"),
        (lambda data: b"", "cut short"),
        (lambda data: b"CDF\x01" + data[4:], "not a checkpoint"),
        (lambda data: data[:8] + b"\x63" + data[9:], "format version 99"),
        (lambda data: data[:-1] + bytes([data[-1] ^ 255]), "checksum"),
        (lambda data: data[:5000] + b"x" + data[5001:], "checksum"),
    ],
    ids=["cut", "head cut", "empty", "another file", "format", "sum", "state"],
)
def test_a_damaged_checkpoint_is_refused_with_a_reason(two_checkpoints, data, reason):
    file, output = two_checkpoints
    beside(output, ".checkpoint.previous").unlink()
    newest = beside(output, ".checkpoint")
    newest.write_bytes(data(newest.read_bytes()))
    with pytest.raises(sitedda.OutputError, match=f"out.nc.checkpoint.*{reason}"):
        sitedda.resume(file, output)
    assert newest.exists() and not output.exists()


def test_both_damaged_checkpoints_are_named(program, two_checkpoints):
    file, output = two_checkpoints
    spoil(beside(output, ".checkpoint"))
    spoil(beside(output, ".checkpoint.previous"))
    process = program("resume", file, "-q", "-o", output)
    assert process.returncode == 5
    assert len(process.stderr.strip().splitlines()) == 1
    assert "out.nc.checkpoint is damaged" in process.stderr
    assert "out.nc.checkpoint.previous is damaged" in process.stderr


@pytest.mark.parametrize("group", ["control", "material", "output"])
def test_a_checkpoint_of_another_input_is_refused(two_checkpoints, group):
    file, output = two_checkpoints
    text = file.read_text().replace(f"&{group}", f"&{group} ! changed\n", 1)
    file.write_text(text)
    with pytest.raises(sitedda.OutputError, match="another input"):
        sitedda.resume(file, output)


def test_a_checkpoint_with_other_records_is_refused(write_input, tmp_path):
    record = tmp_path / "record.txt"
    lines = [f"{0.01 * i} {(-1) ** i}\n" for i in range(20)]
    record.write_text("".join(lines))
    shaken_input = changed(shaken_tower(50), "motion", values=None, time_step=None,
                           file="record.txt", format="text", unit="m/s2")  # fmt: skip
    file = write_input(shaken_input)
    stopped(file, tmp_path / "out.nc", 10)
    record.write_text("".join([*lines[:7], "0.07 2\n", *lines[8:]]))
    with pytest.raises(sitedda.OutputError, match="other records"):
        sitedda.resume(file, tmp_path / "out.nc")
    record.write_text("".join(lines))
    assert sitedda.resume(file, tmp_path / "out.nc").complete


def test_a_checkpoint_of_another_version_is_refused(two_checkpoints):
    file, output = two_checkpoints
    version = sitedda.__version__.encode()
    for suffix in (".checkpoint", ".checkpoint.previous"):
        path = beside(output, suffix)
        data = path.read_bytes()[:-8].replace(version, b"9" * len(version), 1)
        path.write_bytes(data + crc64(data))
    with pytest.raises(sitedda.OutputError, match="was made by version '9"):
        sitedda.resume(file, output)


def test_a_shortened_journal_is_refused(two_checkpoints):
    file, output = two_checkpoints
    journal = beside(output, ".journal")
    data = journal.read_bytes()
    journal.write_bytes(data[:1000])
    with pytest.raises(sitedda.OutputError, match="out.nc.journal has changed"):
        sitedda.resume(file, output)
    spoil(journal, 500)
    with pytest.raises(sitedda.OutputError, match="out.nc.journal has changed"):
        sitedda.resume(file, output)
    journal.write_bytes(data + b"what the killed run had not finished")
    assert sitedda.resume(file, output).complete


def test_without_a_checkpoint_a_run_begins_at_the_start(program, write_input, tmp_path):
    process = program.ok("resume", write_input(tower(steps=20)), "-q", folder=tmp_path)
    assert "no checkpoint of tower.nc: starting at time 0" in process.stdout
    assert (tmp_path / "tower.nc").exists()


def test_a_complete_output_is_not_run_again(program, write_input, tmp_path):
    """A batch job that is submitted again must not repeat the computation."""
    file = write_input(tower(steps=20))
    program.ok("run", file, "-q", folder=tmp_path)
    output = tmp_path / "tower.nc"
    before = output.read_bytes(), output.stat().st_mtime_ns
    process = program.ok("resume", file, "-q", folder=tmp_path)
    assert "tower.nc is complete" in process.stdout
    assert (output.read_bytes(), output.stat().st_mtime_ns) == before
    left = {path.name for path in tmp_path.iterdir()}
    assert not [name for name in left if name.startswith("tower.nc.")], left
    other = write_input(tower(steps=21))
    process = program("resume", other, "-q", folder=tmp_path)
    assert "starting at time 0" in process.stdout and "is complete" not in process.stdout
    assert output.read_bytes() != before[0]


def test_a_complete_output_is_returned_by_resume(write_input, tmp_path, same_bits):
    file = write_input(tower(steps=20))
    first = sitedda.run(file, tmp_path / "out.nc")
    resumed_run = sitedda.resume(file, tmp_path / "out.nc")
    assert resumed_run.complete and resumed_run.summary == first.summary
    same_bits(first.history, resumed_run.history)
    with sitedda.Simulation(file, tmp_path / "out.nc", resume=True) as simulation:
        assert simulation.notice.endswith("out.nc is complete")
        assert simulation.advance(5) and simulation.time == simulation.duration


def test_a_new_run_begins_at_the_start(two_checkpoints):
    file, output = two_checkpoints
    with sitedda.Simulation(file, output) as simulation:
        assert simulation.steps == 0
        assert not beside(output, ".checkpoint").exists()


def test_an_active_run_cannot_be_resumed(write_input, tmp_path):
    file = write_input(shaken_tower())
    with sitedda.Simulation(file, tmp_path / "out.nc") as first:
        first.advance(10)
        first.checkpoint()
        with pytest.raises(sitedda.OutputError, match="being written by another run"):
            sitedda.resume(file, tmp_path / "out.nc")
        first.advance(10)


# --- Disks that are full -------------------------------------------------------------------------


@pytest.mark.parametrize("size", [0, 500_000])
def test_a_full_disk_ends_in_one_message_and_the_run_can_be_resumed(
    binary, write_input, tmp_path, same_bits, size
):
    import resource

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    file = write_input(shaken_tower(4000, 100))
    arguments = [binary.path, "run", file, "-q", "-o", tmp_path / "out.nc"]
    process = subprocess.run(
        arguments, preexec_fn=limit, capture_output=True, text=True, check=False
    )
    assert process.returncode == 5
    assert len(process.stderr.strip().splitlines()) == 1, process.stderr
    assert "out.nc" in process.stderr and "File too large" in process.stderr
    second_process = binary.ok("resume", file, "-q", "-o", tmp_path / "out.nc")
    assert ("resumed at step" in second_process.stdout) == (size > 300_000)
    same_bits(sitedda.run(file).history, tmp_path / "out.nc")


# --- From Python ---------------------------------------------------------------------------------


def test_only_an_output_can_be_resumed(write_input):
    with pytest.raises(ValueError, match="output"):
        sitedda.Simulation(write_input(tower()), resume=True)


def test_a_run_that_is_asked_to_stop_can_be_resumed(write_input, tmp_path, same_bits):
    def interrupt(simulation):
        raise KeyboardInterrupt

    file = write_input(shaken_tower())
    first = sitedda.run(file, tmp_path / "out.nc", progress=interrupt)
    assert not first.complete
    second = sitedda.resume(file, tmp_path / "out.nc")
    assert second.complete and second.output == tmp_path / "out.nc"
    same_bits(sitedda.run(file).history, second.history)


def test_a_run_continues_after_an_error_of_the_caller(write_input, tmp_path, same_bits):
    def fail(simulation):
        raise RuntimeError("mine")

    file = write_input(shaken_tower())
    with pytest.raises(RuntimeError, match="mine"):
        sitedda.run(file, tmp_path / "out.nc", progress=fail)
    same_bits(sitedda.run(file).history, sitedda.resume(file, tmp_path / "out.nc").history)


def test_a_fork_does_not_change_files_of_its_parent(write_input, tmp_path, same_bits):
    file = write_input(shaken_tower())
    script = f"""
import os, sys, sitedda
simulation = sitedda.Simulation({str(file)!r}, {str(tmp_path / "out.nc")!r})
simulation.advance(101)
child = os.fork()
if child == 0:
    try:
        simulation.advance(10)
    except sitedda.InputError as error:
        assert "another process" in str(error)
        simulation.close()
        sys.exit(0)
    sys.exit(1)
assert os.waitpid(child, 0)[1] == 0
simulation.advance({STEPS})
simulation.finish()
"""
    subprocess.run([sys.executable, "-c", script], check=True, capture_output=True)
    same_bits(sitedda.run(file).history, tmp_path / "out.nc")


# --- Random campaigns --------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments",
    [
        ("kill.py", "--quick", "--kills", "12", "--signals", "KILL,KILL,TERM"),
        ("full_disk.py", "--quick", "--cases", "5"),
        ("damage.py", "--cases", "60"),
        ("study_kill.py", "--kills", "3", "--cases", "2", "--duration", "0.3"),
    ],
    ids=lambda arguments: arguments[0],
)
def test_a_short_campaign(root, binary, arguments):
    script = root / "tests" / "robustness" / arguments[0]
    command = [sys.executable, script, *arguments[1:], "--program", binary.path]
    process = captured(command)
    assert process.returncode == 0, process.stdout + process.stderr
