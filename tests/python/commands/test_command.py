# SPDX-License-Identifier: GPL-3.0-or-later
"""Both command lines: sitedda run and sitedda-native run."""

import contextlib
import fcntl
import importlib.metadata
import os
import re
import shutil
import signal
import struct
import subprocess
import termios
import threading

import pytest
import xarray as xr
from environment import DEADLINE, captured, executable, wait_for
from model_text import changed, group, tower, without

from sitedda.errors import AuditWarning, CostWarning
from sitedda.program import _print_warning

NEVER_ENDING = 20_000_000  # steps; its output would still fit on a small disk
OLDER = b"CDF\1 an older result"


def dataset(file) -> xr.Dataset:
    with xr.open_dataset(file, engine="netcdf4") as data:
        return data.load()


# --- Output of both ------------------------------------------------------------------------------


def test_version_is_that_of_the_package(program):
    process = program.ok("--version")
    assert process.stdout == f"{program.name} {importlib.metadata.version('sitedda')}\n"


def test_help_names_the_command(program):
    process = program.ok("--help")
    assert "run" in process.stdout and "usage" in process.stdout.lower()


def test_a_run_writes_its_output_and_prints_its_path(program, write_input, tmp_path):
    file = write_input(tower(steps=40))
    process = program.ok("run", file, folder=tmp_path)
    assert "40 steps" in process.stdout
    assert "output: tower.nc" in process.stdout
    data = dataset(tmp_path / "tower.nc")
    assert data.sizes["time"] == 41 and data.attrs["complete"] == "yes"
    assert not list(tmp_path.glob("*.partial"))


def test_output_goes_to_the_given_path(program, write_input, tmp_path):
    process = program.ok("run", write_input(tower(steps=5)), "--output", tmp_path / "elsewhere.nc")
    assert f"output: {tmp_path / 'elsewhere.nc'}" in process.stdout
    assert dataset(tmp_path / "elsewhere.nc").sizes["time"] == 6


def test_an_older_output_is_replaced_when_the_new_one_is_complete(program, write_input, tmp_path):
    (tmp_path / "tower.nc").write_bytes(OLDER)
    program.ok("run", write_input(tower(steps=5)), "-q", folder=tmp_path)
    assert dataset(tmp_path / "tower.nc").sizes["time"] == 6


def test_amplification_is_printed_in_the_same_words_by_both(
    binary, python_program, write_input, tmp_path
):
    request = group("amplification", lowest=1.0, highest=200.0)
    file = write_input([*tower(layers=4, steps=800), request])
    lines = []
    for program in (binary, python_program):
        process = program.ok("run", file, "-o", tmp_path / f"{program.name}.nc", "-q")
        lines.append(re.search(r"^amplification .*?\)$", process.stdout, re.M | re.S)[0])
        assert all(len(line) <= 80 for line in lines[-1].splitlines())
    assert lines[0] == lines[1]
    text = " ".join(lines[0].split())
    assert re.search(r'surface/base \("within"\): [\d.]+ at [\d.]+ Hz \(bin width', text)


def test_a_picture_is_drawn_beside_the_output_unless_unwanted(
    python_program, write_input, tmp_path
):
    request = group("amplification", lowest=1.0, highest=200.0)
    file = write_input([*tower(layers=2, steps=300), request])
    plain = python_program("run", file, "-o", tmp_path / "plain.nc", "--no-plot")
    process = python_program("run", file, "-o", tmp_path / "drawn.nc")
    assert (plain.returncode, process.returncode) == (0, 0), process.stderr
    assert sorted(f.name for f in tmp_path.glob("*.png")) == ["drawn.png"]
    assert (tmp_path / "drawn.png").read_bytes().startswith(b"\x89PNG")


def test_set_changes_variables_of_all_groups(main, write_input, tmp_path):
    file = write_input(tower(steps=3))
    changes = ["output.file=other.nc", "joint[bedding].friction_angle=30"]
    changes.append("material[*].density=2000")
    options = [text for change in changes for text in ("--set", change)]
    main.ok("run", file, "-q", *options, folder=tmp_path)
    data = dataset(tmp_path / "other.nc")
    assert set(data.block_density.values) == {2000.0}
    assert "friction_angle = 30" in data.attrs["input_text"]


@pytest.mark.parametrize("command", ["run", "resume", "check"])
@pytest.mark.parametrize("change", ["file=x.smc", "output=x.nc", "progress=1", "time_stp=1"])
def test_set_of_an_invalid_name_is_reported_in_one_line(main, write_input, command, change):
    process = main(command, write_input(tower()), "--set", change)
    assert process.returncode == 1
    assert process.stderr.startswith("sitedda: ") and process.stderr.count("\n") == 1


def test_check_uses_the_changes_of_set(main, write_input):
    file = write_input(tower(time_step=1e-3, steps=3))
    main.ok("check", file)
    assert main("check", file, "--set", "time_step=0.05").returncode == 2
    process = main("run", "--check", file, "--set", "time_step=0.05")
    assert process.returncode == 2 and "the check fails" in process.stderr


# --- Progress ------------------------------------------------------------------------------------


def test_native_progress_states_time_fraction_and_time_left(binary, write_input, tmp_path):
    process = binary("run", write_input(tower(steps=500)), folder=tmp_path)
    line = [line for line in process.stdout.splitlines() if line.startswith("t = ")][-1]
    assert re.fullmatch(r"t = 0?\.500 of 0?\.500 s, 100\.0 %, spent .* s, left .* s", line), line


def test_the_bar_is_for_terminals_and_a_closed_terminal_is_no_error(write_input, tmp_path):
    command = [executable("sitedda"), "run", write_input(tower(steps=500)), "--no-plot"]
    terminal, writer_end = os.openpty()
    fcntl.ioctl(writer_end, termios.TIOCSWINSZ, struct.pack("4H", 24, 99, 0, 0))
    parts = []
    reading = threading.Thread(target=_read_all, args=(terminal, parts), daemon=True)
    reading.start()  # a terminal that is not read blocks the writer
    subprocess.run(command, stdout=subprocess.DEVNULL, stderr=writer_end, cwd=tmp_path, check=True)
    reader, writer = os.pipe()
    os.close(reader)
    process = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, cwd=tmp_path)
    os.close(writer)
    assert process.returncode == 128 + signal.SIGPIPE and not process.stderr
    os.close(writer_end)
    reading.join(10)
    output = b"".join(parts).decode()
    assert "0.5/0.5 s" in output and "100%" in output


def _read_all(end: int, parts: list[bytes]) -> None:
    with contextlib.suppress(OSError):  # the other end is closed
        while part := os.read(end, 4096):
            parts.append(part)


def test_only_warnings_of_the_program_are_printed(capsys, monkeypatch):
    """Warnings in the verdict and warnings of libraries are not printed again."""
    monkeypatch.setattr("sys.warnoptions", [])
    location = ("site-packages/some.py", 3)
    for warning in (CostWarning("slow"), AuditWarning("energy"), RuntimeWarning("of a library")):
        _print_warning(warning, type(warning), *location)
    assert capsys.readouterr().err == "sitedda: slow\n"
    texts = []
    monkeypatch.setattr("sys.warnoptions", ["default"])
    monkeypatch.setattr(
        "sitedda.program._plain_showwarning", lambda *arguments: texts.append(arguments)
    )
    _print_warning("of a library", RuntimeWarning, *location)
    assert texts == [("of a library", RuntimeWarning, *location)]


def test_quiet_shows_no_progress(program, write_input, tmp_path):
    process = program.ok("run", write_input(tower(steps=500)), "--quiet", folder=tmp_path)
    assert process.stderr == ""
    assert "t = " not in process.stdout


# --- Notes ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", ["run", "check"])
def test_probable_mistakes_are_reported(program, command, write_input, tmp_path):
    options = [] if command == "check" else ["-q"]
    begin = "warn  input" if command == "check" else "note: "
    good = program(command, write_input(tower(steps=3)), *options, folder=tmp_path)
    assert begin not in good.stdout
    unusual_input = changed(tower(steps=3, gravity=[0.0, -9.81]), "material", density=2.5)
    unusual_input = without(unusual_input, "fixed_point")
    output = program(command, write_input(unusual_input), *options, folder=tmp_path).stdout
    output = re.sub(r"\n( {24}| {6})", " ", output)  # lines are wrapped
    notes = [line for line in output.splitlines() if line.startswith(begin)]
    assert len(notes) == 3, output
    assert "density = 2.5" in notes[0] and "g/cm³?" in notes[0]
    assert "nothing supports the blocks" in notes[1] and "'pulse' is not used" in notes[2]


# --- Exit statuses -------------------------------------------------------------------------------


def test_an_output_that_cannot_be_written_is_status_5(program, write_input, tmp_path):
    process = program("run", write_input(tower()), "-o", tmp_path / "no/such/folder/out.nc")
    assert process.returncode == 5
    assert "no/such/folder/out.nc" in process.stderr
    assert len(process.stderr.strip().splitlines()) == 1


@pytest.mark.parametrize(
    "arguments",
    [("walk", "a.nml"), ("run",), ("run", "a.nml", "b.nml"), ("run", "a.nml", "--colour"),
     ("run", "a.nml", "--output")],
)  # fmt: skip
def test_a_wrong_command_line_fails_with_a_message(program, arguments):
    """Status 2 of argparse is not used, because it means that a check failed."""
    process = program(*arguments)
    assert process.returncode == 1
    assert process.stderr.strip() and "Traceback" not in process.stderr
    assert arguments[-1] != "--output" or "--output" in process.stderr


# --- Ctrl-C --------------------------------------------------------------------------------------


def start(program, file, folder) -> subprocess.Popen:
    """Start a run in the background and wait until it has written something."""
    running, partial_output = program.start("run", file, folder=folder), folder / "tower.nc.partial"
    wait_for(lambda: partial_output.exists() and partial_output.stat().st_size > 100_000, running)
    return running


def test_ctrl_c_keeps_the_start_of_the_complete_output(python_program, write_input, tmp_path):
    final = tmp_path / "tower.nc"
    final.write_bytes(OLDER)
    running = start(python_program, write_input(tower(steps=NEVER_ENDING)), tmp_path)
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=DEADLINE)
    assert running.returncode == 6, err
    assert "Traceback" not in err
    assert "interrupted" in err and "tower.nc.partial" in out
    assert final.read_bytes() == OLDER
    partial_output = dataset(tmp_path / "tower.nc.partial")
    assert partial_output.attrs["complete"] == "no"
    steps = partial_output.sizes["time"] - 1
    assert steps > 100
    full_input = changed(tower(steps=steps), "output", file="whole.nc", block_interval=0)
    python_program.ok("run", write_input(full_input, "whole.nml"), folder=tmp_path)
    history = dataset(tmp_path / "whole.nc")
    for name in ("time", "displacement", "velocity", "acceleration", "energy_balance"):
        assert partial_output[name].values.tobytes() == history[name].values.tobytes(), name


def test_a_second_run_on_the_same_output_does_not_disturb_the_first(program, write_input, tmp_path):
    running = start(program, write_input(tower(steps=NEVER_ENDING)), tmp_path)
    second = program("run", write_input(tower(steps=3), "second.nml"), "-q", folder=tmp_path)
    assert second.returncode == 5
    assert "tower.nc" in second.stderr
    assert running.poll() is None
    running.send_signal(signal.SIGINT)
    running.communicate(timeout=DEADLINE)
    partial_output = dataset(tmp_path / "tower.nc.partial")
    assert partial_output.attrs["complete"] == "no" and partial_output.sizes["time"] > 100


def test_a_killed_run_leaves_the_older_output_alone(program, write_input, tmp_path):
    final = tmp_path / "tower.nc"
    final.write_bytes(OLDER)
    running = start(program, write_input(tower(steps=NEVER_ENDING)), tmp_path)
    running.kill()
    running.communicate(timeout=DEADLINE)
    assert final.read_bytes() == OLDER


def test_a_log_is_written_at_once_and_in_order(binary, write_input, tmp_path):
    """Each line is written when its event occurs; errors follow the earlier lines."""
    log = tmp_path / "log"
    with log.open("wb") as stream:
        running = binary.start("resume", write_input(tower(steps=NEVER_ENDING)), folder=tmp_path,
                               stdout=stream, stderr=subprocess.STDOUT)  # fmt: skip
    wait_for(lambda: log.read_text().endswith("starting at time 0\n"), running)
    running.send_signal(signal.SIGINT)
    assert running.wait(timeout=DEADLINE) == 6
    lines = log.read_text().splitlines()
    assert lines[0].startswith("analysis: ") and "interrupted" in lines[-1]
    assert "starting at time 0" in "\n".join(lines[:-1])


def test_help_of_the_executable_names_every_option(binary):
    output = binary("--help").stdout
    for option in ("-o, --output", "--check", "-q, --quiet", "-h, --help", "--version"):
        assert option in output
    assert "6 interrupted" in output


# --- The environment -----------------------------------------------------------------------------


def test_the_executable_needs_no_python(binary, write_input, tmp_path):
    linked = captured([shutil.which("ldd"), binary.path])
    assert "libpython" not in linked.stdout
    bare = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    command = [binary.path, "run", write_input(tower(steps=5)), "-q"]
    process = captured(command, cwd=tmp_path, env=bare | {"PATH": "/nowhere"})
    assert process.returncode == 0, process.stderr


@pytest.mark.parametrize("command", [("draw",), ("view", "--no-open"), ("report",)])
def test_a_picture_or_page_that_cannot_be_written_is_named(main, write_input, tmp_path, command):
    target = tmp_path / "no" / "such.png"
    process = main(*command, write_input(tower(steps=2)), "-o", target)
    assert process.returncode == 5
    assert process.stderr == f"sitedda: {target}: the folder {target.parent} does not exist\n"


def test_an_output_never_replaces_the_record(program, write_input, tmp_path):
    record = tmp_path / "record.txt"
    record.write_text("".join(f"{0.01 * i} {(-1) ** i}\n" for i in range(20)))
    shaken_input = changed(tower(steps=3), "motion", values=None, time_step=None, file="record.txt",
                     format="text", unit="m/s2")  # fmt: skip
    text = record.read_bytes()
    process = program("run", write_input(shaken_input), "-q", "-o", tmp_path / "record.txt")
    assert record.read_bytes() == text
    assert process.returncode in (1, 5) and "record.txt" in process.stderr
