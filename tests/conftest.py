# SPDX-License-Identifier: GPL-3.0-or-later
"""Fixtures that the tests of the package, of the executable and of verification share."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

ROOT = Path(__file__).parents[1]
TESTS = ROOT / "tests" / "python"
sys.path[:0] = map(str, (TESTS, *TESTS.glob("[a-z]*/")))  # tests import modules of other folders

from environment import ARGUMENTS, BROWSER, DEADLINE, executable  # noqa: E402
from model_text import namelist  # noqa: E402


@pytest.fixture(scope="session")
def root() -> Path:
    """Return the top of the source tree."""
    return ROOT


@pytest.fixture(scope="session", params=["sitedda", "sitedda-native"])
def program(request):
    """Return a caller of each of the two programs: arguments in, completed process out."""
    return program_runner(request.param)


@pytest.fixture(scope="session")
def binary():
    """Return a caller of the executable without Python."""
    return program_runner("sitedda-native")


@pytest.fixture(scope="session")
def python_program():
    """Return a caller of the command line of the package."""
    return program_runner("sitedda")


def program_runner(program_name: str):
    """Return a function that runs a program with arguments and returns the completed process."""
    path = executable(program_name)

    def run_program(*arguments, folder=None, threads=None) -> subprocess.CompletedProcess:
        return subprocess.run(
            [path, *map(os.fspath, arguments)], cwd=folder,
            env=os.environ | ({"OMP_NUM_THREADS": str(threads)} if threads else {}),
            capture_output=True, encoding="utf-8", errors="replace", timeout=DEADLINE,
            check=False)  # fmt: skip

    def start_program(*arguments, folder, **options) -> subprocess.Popen:
        return subprocess.Popen([path, *map(os.fspath, arguments)], cwd=folder, text=True,
            # In the background, the shell makes tests ignore Ctrl-C.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
            **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options)  # fmt: skip

    run_program.path, run_program.start = path, start_program
    return named(run_program, program_name)


def named(call, name: str):
    """Add to a caller the name of its program and `ok`, a call that must end with status 0."""

    def ok(*arguments, **options) -> subprocess.CompletedProcess:
        done = call(*arguments, **options)
        assert done.returncode == 0, done.stderr
        return done

    call.name, call.ok = name, ok
    return call


@pytest.fixture
def main(capfd, monkeypatch):
    """Return a caller of the command line in this process, which saves the start of Python."""

    def call(*arguments, folder=None) -> subprocess.CompletedProcess:
        from sitedda.command import main

        if folder:
            monkeypatch.chdir(folder)
        capfd.readouterr()
        try:
            status = main([os.fspath(argument) for argument in arguments])
        except SystemExit as stop:
            status = stop.code
        return subprocess.CompletedProcess(arguments, status, *capfd.readouterr())

    return named(call, "sitedda")


@pytest.fixture(scope="session")
def chromium():
    """Yield a headless browser; skip the test if there is none."""
    if not BROWSER:
        pytest.skip("there is no Chromium")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=BROWSER, args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.fixture
def new_page(chromium):
    """Return a maker of empty pages that record all messages, dialogues and foreign requests."""
    contexts = []

    def enter(known: tuple[str, ...], **options):
        context = chromium.new_context(**options)
        context.set_default_timeout(1000 * DEADLINE)  # ms
        contexts.append(context)
        page = context.new_page()
        page.complaints = []
        page.on("console", lambda message: page.complaints.append(message.text))
        page.on("pageerror", lambda error: page.complaints.append(str(error)))
        page.on("dialog", lambda dialog: (page.complaints.append("dialog"), dialog.dismiss()))
        page.on("request", lambda request: None if request.url.startswith(known)
                else page.complaints.append(request.url[:80]))  # fmt: skip
        return page

    yield enter
    for context in contexts:
        context.close()


@pytest.fixture
def write_input(tmp_path, monkeypatch):
    """Return a writer of inputs (groups or text) in the folder of the test, the working folder."""
    monkeypatch.chdir(tmp_path)

    def write(groups, name: str = "model.nml") -> Path:
        file = tmp_path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        text = groups if isinstance(groups, str | bytes) else namelist(groups)
        file.write_bytes(text if isinstance(text, bytes) else text.encode())
        return file

    return write


@pytest.fixture(scope="session")
def bolted(tmp_path_factory):
    """Run a roof on bolts; one bolt is broken, and one is a cable over three blocks."""
    from sitedda.model import Model

    model = Model.read(ROOT / "inputs" / "tunnel_roof_bolted.nml")
    model["stage"][1](steps=60)
    model["bolt"][0](rupture_elongation=1e-4)
    model["bolt"][3](to=(6.0, 7.0), through=[(2.9, 9.5)])
    model.output(block_interval=30)
    return model.run(output=tmp_path_factory.mktemp("bolted") / "roof.nc")


@pytest.fixture
def in_parts(tmp_path):
    """Return a runner that closes a run after a number of steps and resumes it."""
    import sitedda

    def run(file, steps: int) -> xr.Dataset:
        with sitedda.Simulation(file, tmp_path / "parts.nc") as first:
            first.advance(steps)
        rest = sitedda.resume(file, tmp_path / "parts.nc")
        assert rest.complete
        return rest.history

    return run


@pytest.fixture(scope="session")
def same_bits():
    """Return a function that asserts that two outputs or datasets are bit-identical."""

    def compare(one, other, attributes=("title", "input_text", "step_control")):
        one, other = load(one), load(other)
        assert set(one.variables) == set(other.variables)
        for name in one.variables:
            left, right = one[name].values, other[name].values
            assert (left.shape, left.dtype) == (right.shape, right.dtype), name
            if left.dtype == object:
                assert left.tolist() == right.tolist(), name
            elif left.tobytes() != right.tobytes():
                pytest.fail(f"{name} differs by up to {np.max(np.abs(left - right))}")
        for name in attributes:
            assert one.attrs[name] == other.attrs[name], name

    return compare


@pytest.fixture
def same_everywhere(in_parts, binary, same_bits, tmp_path):
    """Return a runner that asserts bit-identical results in parts, natively and with threads."""
    import sitedda

    def run(file, steps: int) -> xr.Dataset:
        whole = sitedda.run(file, tmp_path / "whole.nc").history
        same_bits(whole, in_parts(file, steps))
        for threads in (1, 2):
            output = tmp_path / f"native_{threads}.nc"
            binary.ok("run", file, "-q", "-o", output, threads=threads)
            same_bits(whole, output)
        return whole

    return run


def load(source) -> xr.Dataset:
    """Return a dataset in memory."""
    if isinstance(source, xr.Dataset):
        return source
    with xr.open_dataset(source, engine="netcdf4") as dataset:
        return dataset.load()
