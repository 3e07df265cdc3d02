# SPDX-License-Identifier: GPL-3.0-or-later
"""Fortran programs that link the engine: the installed module sitedda."""

import os
import subprocess
from types import SimpleNamespace

import numpy as np
import pytest
from environment import captured, executable

import sitedda


@pytest.fixture(scope="module")
def library(root, tmp_path_factory):
    """Install the library from the build folder; return an environment for pkg-config."""
    build, path = root / "build", tmp_path_factory.mktemp("installed")
    assert (build / "build.ninja").exists(), "meson setup build; ninja -C build"
    call(executable("meson"), "install", "-C", build, "--no-rebuild", "--quiet", "--tags", "devel",
         "--destdir", path)  # fmt: skip
    (description,) = path.rglob("sitedda.pc")
    paths = {"PKG_CONFIG_PATH": f"{description.parent}", "PKG_CONFIG_SYSROOT_DIR": f"{path}"}
    return SimpleNamespace(place=path, environment=os.environ | paths)


def call(*arguments, **options) -> subprocess.CompletedProcess:
    """Return the output of a command; fail if the command fails."""
    process = subprocess.run([*map(str, arguments)], capture_output=True, text=True, **options)
    assert process.returncode == 0, process.stdout + process.stderr
    return process


def by_compiler(library, source, folder):
    """Compile the program with one command line of gfortran."""
    flags = call("pkg-config", "--cflags", "--libs", "sitedda", env=library.environment).stdout
    call("gfortran", source / "crest.f90", "-o", folder / "crest", *flags.split())


def by_meson(library, source, folder):
    """Build the program as a meson project."""
    call(executable("meson"), "setup", folder, source, env=library.environment)
    call(executable("ninja"), "-C", folder)


@pytest.fixture(scope="module", params=[by_compiler, by_meson], ids=["pkg-config", "meson"])
def crest(request, root, library, tmp_path_factory):
    """Build the program of the handbook."""
    folder = tmp_path_factory.mktemp("program")
    request.param(library, root / "docs" / "program", folder)
    return folder / "crest"


def test_only_required_files_are_installed(library):
    names = {file.name for file in library.place.rglob("*") if file.is_file()}
    assert names == {"libsitedda_engine.a", "sitedda.mod", "sitedda.pc"}


def test_the_program_prints_results_of_a_run(crest, root, tmp_path):
    process = call(crest, root / "inputs" / "wedge.nml", "head", cwd=tmp_path)
    run = sitedda.run(root / "inputs" / "wedge.nml")
    displacement = np.hypot(
        *run.history.displacement.sel(point="head").transpose("axis", "time").values
    )
    fields = process.stdout.splitlines()[-1].split()
    assert fields[:1] + fields[2:5] == ["largest", "m", "at", "t"]
    assert float(fields[1]) == pytest.approx(displacement.max(), rel=1e-5)
    time = float(run.history.time[displacement.argmax()])
    assert float(fields[6]) == pytest.approx(time, abs=1e-3)


@pytest.mark.parametrize(
    ("file", "point", "message"),
    [
        ("none.nml", "head", "none.nml: there is no such file"),
        ("wedge.nml", "had", "there is no measured point 'had'; there are head"),
    ],
)
def test_errors_are_returned_to_the_program(crest, root, tmp_path, file, point, message):
    (tmp_path / "wedge.nml").write_text((root / "inputs" / "wedge.nml").read_text())
    process = captured([crest, file, point], cwd=tmp_path)
    assert (process.returncode, process.stderr.count("\n")) == (1, 1) and message in process.stderr
