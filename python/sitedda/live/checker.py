# SPDX-License-Identifier: GPL-3.0-or-later
"""Check a model in a separate process, which is killed when the user edits the model.

As a program, this module reads an input from its standard input and prints findings as JSON.
"""

import ctypes
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

_DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG of prctl(2)


class Checker:
    """Checker of inputs; a new check ends the previous one.

    `publish`: called with the findings as a dict, from a thread of the checker.
    """

    def __init__(self, publish: Callable[[dict], None]):
        self._publish = publish
        self._process: subprocess.Popen | None = None
        self._lock = threading.Lock()

    def start(self, text: str, file: Path, version: int) -> None:
        """Start a check of an input; its findings are published with the version of the input."""
        with self._lock:
            self._kill_check()
            self._process = subprocess.Popen(
                [sys.executable, "-m", __name__, os.fspath(file)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # only the server handles Ctrl-C
            )
            process = self._process
        self._publish({"kind": "check", "version": version, "state": "running"})
        arguments = (process, text, version)
        threading.Thread(target=self._report_findings, args=arguments, daemon=True).start()

    def _report_findings(self, process: subprocess.Popen, text: str, version: int) -> None:
        """Send the input to the checking process, wait for its findings and report them."""
        reply, _ = process.communicate(text.encode("utf-8", "surrogateescape"))
        with self._lock:
            if process is not self._process:
                return
        try:
            findings = json.loads(reply)
        except ValueError:
            findings = {"error": f"the check ended with status {process.returncode}"}
        self._publish({"kind": "check", "version": version, "state": "done"} | findings)

    def stop(self) -> None:
        """End the running check."""
        with self._lock:
            self._kill_check()

    def _kill_check(self) -> None:
        process, self._process = self._process, None
        if process is not None and process.poll() is None:
            process.kill()


def main() -> None:
    """Check the input on the standard input and print the findings as JSON."""
    ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGKILL)
    from ..base.errors import SiteddaError
    from ..engine.checking import check
    from ..input.source import InputOfRun

    text = sys.stdin.buffer.read().decode("utf-8", "surrogateescape")
    try:
        report = check(InputOfRun(Path(sys.argv[1]), text))
    except SiteddaError as error:
        print(json.dumps({"error": str(error)}))
        return
    lines = [[line.verdict, line.topic, line.words, line.advice] for line in report.lines]
    print(json.dumps({"verdict": report.verdict, "words": report.conclusion, "lines": lines}))


if __name__ == "__main__":
    main()
