#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kill studies (client, worker, scheduler or job array) at random moments; compare the tables.

usage: python tests/robustness/study_kill.py [--kills N] [--seed S] [--cases N] [--duration S]
       [--program PROGRAM]

Each study has columns of ten drums.  One of its processes is killed (SIGKILL) at a random moment.
Then the study is restarted, one time in three killed again, until it ends.  Its table must equal
that of an uninterrupted study bitwise.  Ends with status 1 if any differs.
"""

import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import xarray as xr

sys.path.insert(0, str(Path(__file__).parents[1] / "python"))
import slurm_stand_in  # noqa: E402
from dask_cluster import Cluster  # noqa: E402
from interrupted import INPUTS, binary  # noqa: E402
from options import parse_options  # noqa: E402

STUDY = """model = "{model}"
folder = "{folder}"
results = ["displacement[top].y", "largest_tilt_rad", "energy_balance.last"]
[fixed]
"control.duration" = {duration}
"output.checkpoint_interval" = 100
[parameters]
"joint[drums].friction_angle" = {{from = 20, to = 40, count = {cases}}}
[slurm]
each = 2
"""
VICTIMS = ("client", "worker", "dask client", "dask worker", "scheduler", "job array")


class Trial:
    """One study that is killed."""

    def __init__(self, victim: str, folder: Path, options, rng: random.Random):
        self.victim, self.folder, self.rng = victim, folder, rng
        self.study = folder / "study"
        self.file = folder / "study.toml"
        self.program = binary(options.program)
        values = {"model": INPUTS / "column.nml", "folder": self.study, "cases": options.cases}
        self.file.write_text(STUDY.format(duration=options.duration, **values))
        self.cluster = Cluster(folder) if victim in VICTIMS[2:5] else None

    def command(self) -> tuple[list[str], dict[str, str]]:
        """Return the command of the study, and its environment."""
        command_line = [sys.executable, "-m", "sitedda", "study", "run", str(self.file), "-q"]
        if self.victim == "job array":
            path = slurm_stand_in.install(self.folder / "bin")
            seed = str(self.rng.randrange(1000))
            path = f"{path}{os.pathsep}{os.environ['PATH']}"
            command_line += ["--slurm", "--program", self.program]
            return command_line, os.environ | {"PATH": path, "STAND_IN_SEED": seed}
        executor = ["--dask", self.cluster.address] if self.cluster else ["--workers", "2"]
        return command_line + executor, dict(os.environ)

    def start(self) -> subprocess.Popen:
        """Start the client as a process group."""
        arguments, environment = self.command()
        return subprocess.Popen(arguments, start_new_session=True, env=environment,
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)  # fmt: skip

    def kill(self, client: subprocess.Popen) -> None:
        """Kill the victim."""
        if self.victim == "job array":
            os.killpg(client.pid, signal.SIGKILL)
        elif self.victim in ("client", "dask client"):
            client.kill()
        elif self.victim == "worker":
            children = Path(f"/proc/{client.pid}/task/{client.pid}/children")
            threads = Path(f"/proc/{client.pid}/task").glob("*/children")
            texts = [file.read_text() for file in [children, *threads]]
            processes = [int(pid) for text in texts for pid in text.split()]
            if processes:
                os.kill(self.rng.choice(processes), signal.SIGKILL)
        elif self.victim == "dask worker":
            index = self.rng.randrange(len(self.cluster.workers))
            self.cluster.workers[index].kill()
            self.cluster.workers[index].wait()
            self.cluster.workers[index] = self.cluster.new_worker()
        else:
            self.cluster.stop()
            client.kill()  # without its scheduler it would wait for its time-out
            self.cluster.start(2)

    def begun(self, client: subprocess.Popen) -> bool:
        """Wait until the first case is running; False if the study ends before."""
        while client.poll() is None:
            if next(self.study.glob("cases/*/*/lock"), None):
                return True
            time.sleep(0.01)
        return False

    def carry_out(self, time_limit: float) -> int:
        """Kill and restart until the study ends; return how often it was killed."""
        kills, is_running = 0, True
        while True:
            client = self.start()
            if is_running and self.begun(client):
                time.sleep(self.rng.uniform(0.0, time_limit))
                if client.poll() is None:
                    self.kill(client)
                    kills += 1
                    is_running = self.rng.random() < 0.33
            _, output = client.communicate()
            if client.returncode == 0:
                break
            if client.returncode > 0 and not kills:
                raise SystemExit(f"{self.victim}: {output.decode()}")
        if self.cluster:
            self.cluster.stop()
        return kills

    def table(self) -> xr.Dataset:
        """Return the table of results."""
        from sitedda.study import collect, gather

        if self.victim == "job array":
            gather(self.study, 1)
        return collect(self.study).drop_vars("seconds").load()


def main() -> int:
    """Kill and compare."""
    options = parse_options(__doc__, kills=30, seed=1, cases=6, duration=4.0, program=str)
    rng = random.Random(options.seed)
    os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    kills, studies, wrong = 0, 0, 0
    with tempfile.TemporaryDirectory() as scratch:
        left_alone = Trial("client", Path(scratch), options, rng)
        begun = time.monotonic()
        subprocess.run(left_alone.command()[0], check=True, stdout=subprocess.DEVNULL)
        duration, reference = time.monotonic() - begun, left_alone.table()
        print(f"left alone: {duration:.1f} s", flush=True)
        while kills < options.kills:
            victim = VICTIMS[studies % len(VICTIMS)]
            folder = Path(scratch) / f"trial {studies}"
            folder.mkdir()
            trial = Trial(victim, folder, options, rng)
            count = trial.carry_out(0.5 * duration)
            is_identical = reference.identical(trial.table())
            kills, studies, wrong = kills + count, studies + 1, wrong + (not is_identical)
            print(
                f"{victim:12s} {count} kills: {'same bits' if is_identical else 'DIFFERS'}",
                flush=True,
            )
            shutil.rmtree(folder)
    print(f"{kills} kills, {studies} studies, {wrong} tables differ")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
