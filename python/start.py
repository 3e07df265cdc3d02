#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Install everything on a Debian or Ubuntu machine, then run an example, the tests or the linters.

usage: python3 python/start.py site    the paper's layered site under a real earthquake
       python3 python/start.py test    all tests
       python3 python/start.py lint    the rules of the source alone, without a build

Installs missing system packages (with sudo if needed), creates a virtual environment in .venv,
builds and installs sitedda into it.  Requires only Python 3.11 or later.
"""

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent.parent
VENV = HERE / ".venv"
BUILD = HERE / "build"
PACKAGES = """gcc gfortran pkg-config python3-dev python3-venv libopenblas-dev libarpack2-dev
libfftw3-dev libnetcdff-dev libsuitesparse-dev libmetis-dev""".split()
BROWSERS = ("chromium", "chromium-browser", "google-chrome")  # of the tests of pages


def call(*command, **options):
    """Run a command; end with its status if it fails."""
    status = subprocess.run([str(argument) for argument in command], cwd=HERE, **options).returncode
    if status:
        sys.exit(f"failed ({status}): {' '.join(map(str, command))}")


def install_packages(packages: list[str]) -> None:
    """Install the system packages that are missing."""
    if shutil.which("dpkg-query") is None:
        print("not a Debian system: the packages of docs/install.md must already be installed")
        return
    missing = [name for name in packages if not installed(name)]
    if not missing:
        return
    sudo = [] if os.geteuid() == 0 else ["sudo"]
    quiet = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
    call(*sudo, "apt-get", "update", "-qq", env=quiet)
    call(*sudo, "apt-get", "install", "-y", "-qq", "--no-install-recommends", *missing, env=quiet)


def installed(package: str) -> bool:
    """Return whether the package manager has installed a package."""
    query = ["dpkg-query", "-W", "-f", "${Status}", package]
    answer = subprocess.run(query, capture_output=True, text=True)
    return "install ok installed" in answer.stdout


def install(*words: str) -> None:
    """Create the virtual environment, then build and install into it."""
    if not (VENV / "bin" / "pip").exists():
        call(sys.executable, "-m", "venv", VENV)
    own_processor = "-Csetup-args=-Dnative_arch=true"
    call(VENV / "bin" / "pip", "install", "--quiet", own_processor, *words)


def site() -> None:
    """Run the layered site of the paper."""
    install(".")
    call(VENV / "bin" / "sitedda", "run", "inputs/layered_site.nml")


def test() -> None:
    """Run the Fortran suites, then the Python tests."""
    install(".[test]", "./python/evidence")
    path = f"{VENV / 'bin'}{os.pathsep}{os.environ['PATH']}"
    threads = {"OPENBLAS_NUM_THREADS": "1", "OMP_WAIT_POLICY": "passive"}
    environment = os.environ | {"PATH": path} | threads
    options = ["-Dpython=false", "-Dtester=true"]
    if not (BUILD / "build.ninja").exists():
        call("meson", "setup", BUILD, *options, env=environment)
    call("meson", "compile", "-C", BUILD, env=environment)
    call("meson", "test", "-C", BUILD, "--print-errorlogs", env=environment)
    workers = ("-n", "logical", "--maxprocesses", "8", "--dist", "worksteal")
    call(VENV / "bin" / "python", "-m", "pytest", *workers, env=environment)


def lint() -> None:
    """Run the linters and the rules of `tests/python/test_lint.py`."""
    project = tomllib.loads((HERE / "pyproject.toml").read_text())["project"]
    install(*project["optional-dependencies"]["lint"])
    tests = ("--noconftest", "tests/python/test_lint.py")
    call(VENV / "bin" / "python", "-m", "pytest", *tests)


if __name__ == "__main__":
    jobs = {"site": site, "test": test, "lint": lint}
    if len(sys.argv) != 2 or sys.argv[1] not in jobs:
        sys.exit(__doc__)
    install_packages(["python3-venv"] if sys.argv[1] == "lint" else PACKAGES)
    if sys.argv[1] == "test" and not any(map(shutil.which, BROWSERS)):
        install_packages(["chromium"])
    jobs[sys.argv[1]]()
