#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Give hostile files to engine and package: each must be refused or computed within a time limit.

Kinds: inputs, records, files of lines and polygons, block files (checkpoints: `damage.py`).

usage: python tests/robustness/fuzz.py [--inputs N] [--records N] [--files N] [--seed S]
       [--probe PROBE] [--keep FOLDER] [--time-limit SECONDS] [--any-memory]

--probe names the executable `probe` of a native build (meson setup BUILD -Dtester=true); without it
the installed Python package is tested.  --files is the number of files of each kind; --any-memory
is for probes with an address sanitizer.  A file that causes a crash, a hang, lack of memory, or a
result that is not finite without an error is kept in a folder; the status is then 1.
"""

import collections
import contextlib
import os
import resource
import selectors
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "python")]

from mutated_files import mutated_file  # noqa: E402
from mutations import mutated_input, mutated_record  # noqa: E402
from options import parse_options  # noqa: E402

PYTHON_PROBE = [sys.executable, str(HERE / "probe.py")]
TIME_LIMIT = float(os.environ.get("FUZZ_TIME_LIMIT", "5"))  # processor time of one file, s
FAREWELL = 10.0  # wall-clock time of a probe to end, s
PATIENCE = 20  # wall-clock time limit over processor time limit, for a busy machine
MEMORY_LIMIT = 2 * 1024**3  # bytes of address space of the probe
LONGEST_MESSAGE = 2000  # bytes; users must be able to read it

MAKERS = {"input": mutated_input, "record": mutated_record}
FILES = ("csv", "wkt", "geojson", "dxf", "nc")


class Probe:
    """A process that answers requests; it is restarted after a crash or hang."""

    def __init__(self, command: list[str], limit_memory: bool = True):
        self.command = command
        self.limit_memory = limit_memory
        self.process = None
        self.errors = tempfile.TemporaryFile()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stop()
        self.errors.close()

    def _start(self) -> None:
        def limit():
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            if self.limit_memory:
                resource.setrlimit(resource.RLIMIT_AS, (MEMORY_LIMIT, MEMORY_LIMIT))

        environment = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(self.command, stdin=pipe, stdout=pipe, stderr=self.errors,
                                        preexec_fn=limit, env=environment)  # fmt: skip

    def stop(self) -> None:
        """End the process: close its input, then kill it if it continues."""
        if self.process:
            self.process.stdin.close()
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.process.wait(FAREWELL)
            self.kill()

    def kill(self) -> None:
        """Kill the process."""
        self.process.kill()
        self.process.wait()
        self.process.stdin.close()
        self.process.stdout.close()
        self.process = None

    def ask(self, request: str, limit: float) -> str:
        """Return the answer to a request, or ``crash …`` or ``hang``."""
        if self.process is None:
            self._start()
        begin = self.processor_time()
        self.process.stdin.write(request.encode() + b"\n")
        self.process.stdin.flush()
        answer = self._line(begin + limit, time.monotonic() + PATIENCE * limit)
        if answer is None:
            self.kill()
            return "hang"
        if not answer.endswith(b"\n"):
            status = self.process.wait()
            self.stop()
            return f"crash with status {status}: {self._last_words()}"
        return answer.decode("utf-8", "replace").rstrip("\n")

    def processor_time(self) -> float:
        """Return the processor time of the process, s; 0 if it has ended."""
        try:
            fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        except (OSError, AttributeError):
            return 0.0
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def _line(self, most_used: float, deadline: float) -> bytes | None:
        """Return bytes up to a line end or the end of the process; None after the time limit."""
        answer = b""
        with selectors.DefaultSelector() as selector:
            selector.register(self.process.stdout, selectors.EVENT_READ)
            while not answer.endswith(b"\n"):
                if not selector.select(0.25):
                    if self.processor_time() > most_used or time.monotonic() > deadline:
                        return None
                    continue
                chunk = os.read(self.process.stdout.fileno(), 65536)
                if not chunk:
                    break
                answer += chunk
        return answer

    def _last_words(self) -> str:
        self.errors.seek(0)
        text = self.errors.read().decode("utf-8", "replace").strip()
        self.errors.seek(0)
        self.errors.truncate()
        return text[:1500]


@dataclass
class Tally:
    """Counts of answers to the files."""

    answers: collections.Counter = field(default_factory=collections.Counter)
    failures: list[str] = field(default_factory=list)
    slowest: float = 0.0

    def __str__(self) -> str:
        summary = ", ".join(f"{count} {kind}" for kind, count in sorted(self.answers.items()))
        return f"{summary}; slowest {self.slowest:.2f} s; {len(self.failures)} failed"


def fault(answer: str, file: Path) -> str:
    """Return what is wrong with an answer; empty if it is correct."""
    if answer == "ok":
        return ""
    if not answer.startswith("refused "):
        return answer
    _, kind, message = answer.split(" ", 2)
    if len(message.encode()) > LONGEST_MESSAGE:
        return f"a message of {len(message)} characters"
    if kind == "1" and file.name not in message and not message.startswith("step "):
        return f"the message does not name the file: {message}"
    return "" if message.strip() else "an empty message"


def ask_about(probe: Probe, kind: str, file: Path, tally: Tally, limit: float = TIME_LIMIT) -> str:
    """Give one file to the probe; return what is wrong, or empty."""
    begin = probe.processor_time()
    answer = probe.ask(f"{kind} {file}", limit)
    tally.slowest = max(tally.slowest, probe.processor_time() - begin)
    wrong = fault(answer, file)
    tally.answers["failed" if wrong else answer.split(" ")[0]] += 1
    if wrong:
        tally.failures.append(f"{file.name}: {wrong}")
    return wrong


def fuzz(command, kind, seeds, keep=None, limit=TIME_LIMIT, limit_memory=True) -> Tally:
    """Give the files of these seeds to the probe; keep those with wrong answers."""
    tally = Tally()
    with tempfile.TemporaryDirectory() as folder, Probe(command, limit_memory) as probe:
        for seed in seeds:
            ending = kind if kind in FILES else "nml" if kind == "input" else "dat"
            file = Path(folder) / f"{kind}_{seed}.{ending}"
            file.write_bytes(mutated_file(kind, seed) if kind in FILES else MAKERS[kind](seed))
            request = ("blocks" if kind == "nc" else "outlines") if kind in FILES else kind
            wrong = ask_about(probe, request, file, tally, limit)
            if wrong and keep:
                keep.mkdir(parents=True, exist_ok=True)
                file.rename(keep / file.name)
                print(f"{file.name}: {wrong}", flush=True)
            else:
                file.unlink()
    return tally


def main() -> int:
    """Run many files of each kind."""
    options = parse_options(__doc__, inputs=10_000, records=2_000, files=1_000, seed=0, probe=str,
                   keep=Path("fuzz_failures"), time_limit=TIME_LIMIT, any_memory=False)  # fmt: skip
    command = [options.probe] if options.probe else PYTHON_PROBE
    failures = 0
    kinds = {"input": options.inputs, "record": options.records}
    kinds |= dict.fromkeys(FILES, options.files)
    for kind, count in kinds.items():
        seeds = range(options.seed, options.seed + count)
        probe_command = PYTHON_PROBE if kind in FILES else command
        tally = fuzz(probe_command, kind, seeds, options.keep, options.time_limit,
                     not options.any_memory)  # fmt: skip
        print(f"{count} {kind}s: {tally}", flush=True)
        failures += len(tally.failures)
    return min(failures, 1)


if __name__ == "__main__":
    sys.exit(main())
