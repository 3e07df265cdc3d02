# SPDX-License-Identifier: GPL-3.0-or-later
"""A Dask scheduler and workers as separate processes, started from the command line."""

import json
import os
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

from environment import DEADLINE

_ENVIRONMENT = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def _start(module: str, *arguments: str) -> subprocess.Popen:
    return subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.dask_{module}", "--no-dashboard", *arguments],
        env=os.environ | _ENVIRONMENT, stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL)  # fmt: skip


class Cluster:
    """Processes by name: scheduler, and workers 0, 1 …"""

    def __init__(self, folder: Path, workers: int = 2):
        self.folder = folder
        self.workers: list[subprocess.Popen] = []
        self.scheduler: subprocess.Popen | None = None
        self.start(workers)

    def start(self, workers: int) -> None:
        """Start the scheduler and the workers."""
        self.file = self.folder / f"scheduler-{time.monotonic_ns()}.json"
        self.scheduler = _start("scheduler", "--host", "127.0.0.1", "--port", "0",
                                "--scheduler-file", str(self.file))  # fmt: skip
        until = time.monotonic() + DEADLINE
        while not self.file.exists():
            if time.monotonic() > until or self.scheduler.poll() is not None:
                raise RuntimeError("the scheduler of Dask does not start")
            time.sleep(0.05)
        time.sleep(0.1)
        self.workers = [self.new_worker() for _ in range(workers)]

    def new_worker(self) -> subprocess.Popen:
        """Start one more worker with one thread."""
        return _start("worker", "--scheduler-file", str(self.file), "--nthreads", "1",
                      "--no-nanny", "--local-directory", str(self.folder))  # fmt: skip

    @property
    def address(self) -> str:
        """Return the address of the scheduler."""
        return json.loads(self.file.read_text())["address"]

    def stop(self) -> None:
        """End all processes."""
        for process in [*self.workers, self.scheduler]:
            if process and process.poll() is None:
                process.kill()
                process.wait()


@contextmanager
def cluster(folder: Path, workers: int = 2):
    """Yield a cluster that ends with the context."""
    instance = Cluster(folder, workers)
    try:
        yield instance
    finally:
        instance.stop()
