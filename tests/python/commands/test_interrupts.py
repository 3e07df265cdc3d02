# SPDX-License-Identifier: GPL-3.0-or-later
"""A signal ends each command in one sentence, soon; a host program keeps its handlers."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from environment import executable
from model_text import tower
from test_command import NEVER_ENDING

import sitedda
from sitedda import stop

INPUTS = Path(__file__).parents[3] / "inputs"
SOON = 6.0  # processor time, s; a running import is completed first
STATIC = [INPUTS / "retaining_wall.nml"]
TICKS = os.sysconf("SC_CLK_TCK")


def processor_time(process) -> float:
    """Processor time of a process, s."""
    fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def stopped(command, after: float, number, folder) -> tuple[int, float, list[str]]:
    """Return status, processor time after a signal (s), and lines on stderr."""
    process = subprocess.Popen(
        list(map(str, command)),
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        # In the background, the shell makes tests ignore Ctrl-C.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    while process.poll() is None and processor_time(process) < after:
        time.sleep(0.005)
    assert process.poll() is None, "it ended too early to be stopped"
    begun = last = processor_time(process)
    process.send_signal(number)
    while process.poll() is None and last - begun < 5 * SOON:
        last = max(last, processor_time(process))
        time.sleep(0.005)
    process.kill()
    output = process.communicate()[1].decode()
    return process.returncode, last - begun, output.splitlines()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["interrupt", "terminate"])
@pytest.mark.parametrize("delay", [0.12, 0.4, 1.5])
def test_signals_end_static_analyses_at_any_time(tmp_path, number, delay):
    command = [executable("sitedda"), "safety", *STATIC]
    status, seconds, output = stopped(command, delay, number, tmp_path)
    assert (status, output) == (6, ["sitedda: interrupted"])
    assert seconds < SOON
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "command",
    [["check"], ["run", "--no-plot", "-q"], ["build", "-o", "built.nml"], ["draw", "-o", "a.png"],
     ["view", "--no-open", "-o", "a.html"], ["report", "-o", "a.html"]],
    ids=lambda words: words[0],
)  # fmt: skip
def test_every_command_ends_in_one_sentence(tmp_path, command):
    arguments = [executable("sitedda"), command[0], *STATIC, *command[1:]]
    status, seconds, output = stopped(arguments, 0.3, signal.SIGINT, tmp_path)
    assert (status, output) == (6, ["sitedda: interrupted"])
    assert seconds < SOON
    assert not any(file.suffix in (".png", ".html", ".nml") for file in tmp_path.iterdir())


@pytest.fixture(scope="module")
def outputs(tmp_path_factory) -> Path:
    """Folder of the outputs of two runs."""
    folder = tmp_path_factory.mktemp("shown")
    for name, duration in (("ridge", 0.05), ("layered_site", 0.5)):
        model = sitedda.Model.read(INPUTS / f"{name}.nml")
        model.control(duration=duration)
        model.output(block_interval=1)
        model.run(output=folder / f"{name}.nc")
    return folder


@pytest.mark.parametrize(
    "command",
    [["movie", "ridge.nc", "-q", "-o", "a.gif"], ["export", "ridge.nc", "--vtk", "vtk"],
     ["surface", "ridge.nc", "--lowest", "20", "--highest", "200", "-o", "a.png"],
     ["site", "layered_site.nc", "-o", "a.png"], ["validate"]],
    ids=lambda words: words[0],
)  # fmt: skip
def test_commands_that_show_outputs_end_in_one_sentence(tmp_path, outputs, command):
    command = [outputs / argument if argument.endswith(".nc") else argument for argument in command]
    command = [executable("sitedda"), *command]
    status, seconds, output = stopped(command, 0.2, signal.SIGTERM, tmp_path)
    assert (status, output) == (6, ["sitedda: interrupted"])
    assert seconds < SOON
    assert not [file for file in tmp_path.iterdir() if file.is_file()]


def test_a_suppressed_interrupt_is_repeated(monkeypatch):
    monkeypatch.setattr(stop, "_REPEAT_DELAY", 0.1)
    with stop.Interruption() as interruption:
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        begun = time.process_time()
        with pytest.raises(KeyboardInterrupt):
            while time.process_time() - begun < 10.0:
                pass
        assert interruption.heard
    before = time.process_time()
    while time.process_time() - before < 0.3:  # it is over now
        pass


class Incomplete:
    """An object whose finaliser fails, as after an interrupted construction."""

    def __del__(self):
        raise AttributeError("_never_set")


def test_finalisers_that_fail_after_a_signal_are_not_reported(monkeypatch):
    reports = []
    monkeypatch.setattr(sys, "unraisablehook", lambda event: reports.append(event.exc_type))
    with stop.Interruption():
        Incomplete()
        assert reports == [AttributeError]
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        Incomplete()
        assert reports == [AttributeError]
    Incomplete()  # handlers of the host are restored
    assert reports == 2 * [AttributeError]


@pytest.fixture
def listening():
    """Make SIGINT effective, which a shell ignores in background processes."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_an_interrupt_during_a_run_ends_the_command(write_input, listening):
    file = write_input(tower(steps=NEVER_ENDING))
    with stop.Interruption():
        killer = threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT))
        killer.start()
        with pytest.raises(KeyboardInterrupt):
            sitedda.run(file)


def test_the_check_of_a_large_model_is_ended_by_signals(tmp_path, write_input):
    text = (
        "&control time_step = 1e-3, duration = 1.0, gravity = 0.0, -9.81 /\n"
        "&contact normal_stiffness = 2e10 /\n&joint friction_angle = 35.0 /\n"
        "&material density = 2500.0, young_modulus = 1e10, poisson_ratio = 0.25 /\n"
        "&layers name = 'base', left = -1.0, bottom = -0.5, width = 302.0, thickness = 0.5 /\n"
        "&wall name = 'b', left = 0.0, bottom = 0.0, brick_length = 1.0, brick_height = 0.5, "
        "bricks = 300, courses = 57 /\n"
        "&fixed_point x = 0.0, y = -0.25 /\n&fixed_point x = 290.0, y = -0.25 /\n"
    )
    command = [executable("sitedda-native"), "check", write_input(text)]
    status, seconds, output = stopped(command, 1.5, signal.SIGTERM, tmp_path)
    assert (status, output) == (6, ["sitedda-native: interrupted"])
    assert seconds < SOON


HOST = """
import signal, sys
import scipy.spatial, sitedda, sitedda.cutting.blocks
before = [signal.getsignal(n) for n in (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)]
safety = sitedda.safety
try:
    safety(sys.argv[1])
except KeyboardInterrupt:
    assert before == [signal.getsignal(n) for n in (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)]
    sys.exit(42)
"""


def test_a_host_gets_its_own_exception_and_keeps_its_handlers(tmp_path):
    status, seconds, output = stopped(
        [sys.executable, "-c", HOST, *STATIC], 3.0, signal.SIGINT, tmp_path
    )
    assert (status, output) == (42, [])
    assert seconds < SOON


def test_a_handler_without_exception_does_not_stop_a_run(write_input):
    signals = []
    before = signal.signal(signal.SIGINT, lambda *_: signals.append(1))
    try:
        with sitedda.Simulation(write_input(tower())) as simulation:
            os.kill(os.getpid(), signal.SIGINT)
            simulation.advance(20)
            assert simulation.steps == 20
    finally:
        signal.signal(signal.SIGINT, before)
    assert signals


def test_the_paper_ends_its_workers(tmp_path):
    command = [executable("sitedda"), "paper", "-q", "layers", "--folder", "page"]
    process = subprocess.Popen(
        command, cwd=tmp_path, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    tasks = Path(f"/proc/{process.pid}/task")
    while process.poll() is None and not any(file.read_text() for file in tasks.glob("*/children")):
        time.sleep(0.05)
    time.sleep(2.0)  # they are at work
    process.send_signal(signal.SIGTERM)
    try:
        assert process.communicate(timeout=30)[1] == "sitedda: interrupted\n"
        assert process.returncode == 6
        with pytest.raises(ProcessLookupError):
            os.killpg(process.pid, 0)  # nobody of its session is left
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
