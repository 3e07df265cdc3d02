#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Execute the steps of the GitHub workflows in clean Debian systems, as root.

usage: python tests/packaging/workflow.py [-n] [JOB ...] [--systems FOLDER] [--before COMMIT]
       python tests/packaging/workflow.py "test 14"    one row of a matrix

Debian 13 replaces Ubuntu 24.04, Debian 12 replaces Ubuntu 22.04.  Each job begins with Python and
the programs of the runners (git, sudo, pipx), as a user without rights; jobs of a container run as
root.  Actions are replaced by their effect; an unknown one is an error.  A variable NAME=VALUE
among the jobs reaches every step, such as PYTEST_ADDOPTS.  Needs PyYAML and debootstrap.
"""

import argparse
import itertools
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import yaml
from wheel import ROOT, SETTINGS, call, make_bare

RELEASES = {"ubuntu-24.04": "trixie", "ubuntu-22.04": "bookworm", "debian:13": "trixie"}
RUNNER = ("git", "sudo", "pipx", "python3-pip", "python3-dev")
ENTER = """mount -t proc proc "$2/proc" && mount --rbind /dev "$2/dev"
exec chroot "$@" bash -e /tmp/step.sh"""
PATH = "/opt/python/bin:/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin"


def main() -> None:
    """Execute the jobs, or list them."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("jobs", nargs="*", help="jobs, and variables NAME=VALUE (all jobs)")
    parser.add_argument("-n", "--list", action="store_true", help="list the jobs")
    parser.add_argument("--systems", type=Path, help="folder of systems, kept (temporary)")
    parser.add_argument("--before", default="HEAD~10", help="last commit that was pushed before")
    options = parser.parse_args()
    extra = dict(choice.split("=", 1) for choice in options.jobs if "=" in choice)
    selection = {choice for choice in options.jobs if "=" not in choice}
    before = call("git", "-C", ROOT, "rev-parse", options.before).strip()
    jobs = {k: job for k, job in all_jobs() if not selection or selection & {k, k.split()[0]}}
    if options.list or not jobs:
        sys.exit("\n".join(jobs) or f"there is no job {selection}")
    with tempfile.TemporaryDirectory() as folder:
        for name, job in jobs.items():
            Job(name, job, (options.systems or Path(folder)).resolve(), before, extra).execute()


def all_jobs():
    """Name and content of each job of each workflow, once for each row of its matrix."""
    for file in sorted((ROOT / ".github/workflows").glob("*.yml")):
        for name, job in yaml.safe_load(file.read_text())["jobs"].items():
            matrix = job.get("strategy", {}).get("matrix", {})
            for row in itertools.product(*matrix.values()):
                values = {f"matrix.{key}": str(one) for key, one in zip(matrix, row, strict=True)}
                yield " ".join((name, *values.values())), job | {"values": values}


class Job:
    """A job in a system of its own."""

    def __init__(self, name: str, job: dict, systems: Path, before: str, extra: dict):
        """Make the system: Python, the programs of the runners and their user."""
        self.name, self.job, self.extra, self.artifacts = name, job, extra, systems / "artifacts"
        self.values = {"github.event": before} | job["values"]
        release = RELEASES[job.get("container", job["runs-on"])]
        self.user = "root" if "container" in job else "runner"
        bare, runner = systems / release, systems / f"{release}-runner"
        self.system = systems / "job"
        make_bare(release, bare)
        if not runner.exists():
            call("cp", "-a", bare, runner)
            quiet = ("env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-qq")
            call("chroot", runner, *quiet, "update")
            call("chroot", runner, *quiet, "install", "-y", "--no-install-recommends", *RUNNER)
            call("chroot", runner, "useradd", "-m", "runner")
            (runner / "etc/sudoers.d/runner").write_text("runner ALL=(ALL) NOPASSWD: ALL\n")
        shutil.rmtree(self.system, ignore_errors=True)
        call("cp", "-a", runner, self.system)

    def execute(self) -> None:
        """Execute all steps; the first that fails ends the program."""
        for step in self.job["steps"]:
            if "uses" in step:
                action = step["uses"].partition("@")[0].rpartition("/")[2].replace("-", "_")
                inputs = step.get("with", {}).items()
                getattr(self, action)(**{key.replace("-", "_"): value for key, value in inputs})
                continue
            begin = time.monotonic()
            variables = self.extra | self.job.get("env", {}) | step.get("env", {})
            variables = {name: self.expand(value) for name, value in variables.items()}
            self.run(self.expand(step["run"]), **variables)
            print(f"{self.name}: {step.get('name', step['run']).strip()[:70]}",
                  f"({time.monotonic() - begin:.0f} s)", flush=True)  # fmt: skip

    def expand(self, text: str) -> str:
        """Replace the expressions of a workflow."""
        names = re.compile(r"\$\{\{ *(matrix\.\w+|github\.event)[^}]*\}\}")
        return names.sub(lambda match: self.values[match[1]], str(text))

    def run(self, script: str, **environment) -> None:
        """Execute a script as the runners do; they have no rights but by sudo."""
        (self.system / "tmp/step.sh").write_text(f"cd /home/runner/work\n{script}\n")
        settings = {name: value for name, value in os.environ.items() if SETTINGS.match(name)}
        variables = {"PATH": PATH, "CI": "true"} | settings | environment
        assignments = (f"{name}={value}" for name, value in variables.items())
        isolation = ("unshare", "--mount", "--pid", "--fork", "sh", "-ec", ENTER, "sh")
        enter = (*isolation, f"--userspec={self.user}", self.system)
        process = subprocess.run([*enter, "env", "-i", "HOME=/home/runner", *assignments])
        if process.returncode:
            sys.exit(f"{self.name}: failed ({process.returncode}): {script}")

    def checkout(self, **_) -> None:
        """Clone the last commit, with all others."""
        call("git", "clone", "-q", "--no-local", ROOT, self.system / "home/runner/work")
        call("chroot", self.system, "chown", "-R", "runner:", "/home/runner")

    def setup_python(self, python_version: str) -> None:
        """A Python of this version whose `pip` installs into it."""
        call("chroot", self.system, "python3", "-m", "venv", "/opt/python")
        call("chroot", self.system, "chown", "-R", "runner:", "/opt/python")
        self.run(f"python --version | grep -F 'Python {python_version}.'")

    def upload_artifact(self, name: str, path: str) -> None:
        """Keep a folder, which must have files."""
        folder = self.system / "home/runner/work" / path
        if not any(folder.iterdir()):
            sys.exit(f"{self.name}: {path} is empty")
        shutil.copytree(folder, self.artifacts / name, dirs_exist_ok=True)

    def download_artifact(self, name: str, path: str) -> None:
        """Copy a folder that a job has kept."""
        shutil.copytree(self.artifacts / name, self.system / "home/runner/work" / path)

    def gh_action_pypi_publish(self) -> None:
        """Check the files that would be published."""
        self.run("python3 -m venv /tmp/twine && /tmp/twine/bin/pip install -q twine"
                 " && /tmp/twine/bin/twine check --strict dist/*")  # fmt: skip


if __name__ == "__main__":
    main()
