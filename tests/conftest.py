# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of the package, of the executable and of verification share."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

ROOT = Path(__file__).parents[1]
TESTS = ROOT / "tests" / "python"
sys.path[:0] = map(str, (TESTS, *TESTS.glob("[a-z]*/")))  # tests share what stands in others

from environment import ARGUMENTS, BROWSER, DEADLINE, executable  # noqa: E402
from model_text import namelist  # noqa: E402


@pytest.fixture(scope="session")
def root() -> Path:
    """Top of the source tree."""
    return ROOT


@pytest.fixture(scope="session", params=["sitedda", "sitedda-native"])
def program(request):
    """Each of the two programs: call it with arguments, get the completed process."""
    return caller(request.param)


@pytest.fixture(scope="session")
def native():
    """The executable without Python: call it with arguments."""
    return caller("sitedda-native")


@pytest.fixture(scope="session")
def python_program():
    """The command line of the package: call it with arguments."""
    return caller("sitedda")


def caller(name: str):
    """A function that runs a program with arguments and returns the completed process."""
    path = executable(name)

    def call(*arguments, folder=None, threads=None) -> subprocess.CompletedProcess:
        return subprocess.run(
            [path, *map(os.fspath, arguments)],
            cwd=folder,
            env=os.environ | ({"OMP_NUM_THREADS": str(threads)} if threads else {}),
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=DEADLINE,
            check=False,
        )

    call.path = path
    return named(call, name)


def named(call, name: str):
    """A caller with the name of its program and `ok`, a call that has to end with status 0."""

    def ok(*arguments, **options) -> subprocess.CompletedProcess:
        done = call(*arguments, **options)
        assert done.returncode == 0, done.stderr
        return done

    call.name, call.ok = name, ok
    return call


@pytest.fixture
def main(capfd, monkeypatch):
    """The command line of the package within this process, which spares the start of Python."""

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
    """A headless browser; without one the test is skipped."""
    if not BROWSER:
        pytest.skip("there is no Chromium")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=BROWSER, args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.fixture
def new_page(chromium):
    """An empty page that keeps every message, dialogue and request but to these addresses."""
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
    """Write groups, or a text, as an input file in the test's own folder, the working folder."""
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
    """A run of a roof on bolts; one of them is broken, and one is a cable past a third block."""
    from sitedda.model import Model

    model = Model.read(ROOT / "inputs" / "tunnel_roof_bolted.nml")
    model["stage"][1](steps=60)
    model["bolt"][0](rupture_elongation=1e-4)
    model["bolt"][3](to=(6.0, 7.0), through=[(2.9, 9.5)])
    model.output(block_interval=30)
    return model.run(output=tmp_path_factory.mktemp("bolted") / "roof.nc")


@pytest.fixture
def in_parts(tmp_path):
    """History of a run that is closed after so many steps, and resumed."""
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
    """Assert that two output files, or datasets, hold identical bits in every variable."""

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
def same_everywhere(in_parts, native, same_bits, tmp_path):
    """History of a run; in parts, and by the executable on one thread or two, it has its bits."""
    import sitedda

    def run(file, steps: int) -> xr.Dataset:
        whole = sitedda.run(file, tmp_path / "whole.nc").history
        same_bits(whole, in_parts(file, steps))
        for threads in (1, 2):
            output = tmp_path / f"native_{threads}.nc"
            native.ok("run", file, "-q", "-o", output, threads=threads)
            same_bits(whole, output)
        return whole

    return run


def load(source) -> xr.Dataset:
    """A dataset in memory."""
    if isinstance(source, xr.Dataset):
        return source
    with xr.open_dataset(source, engine="netcdf4") as dataset:
        return dataset.load()
