# SPDX-License-Identifier: GPL-3.0-or-later
"""Provenance of a report: program, commit, date, command, machine."""

import os
import platform
import shlex
import sys
from datetime import UTC, datetime
from pathlib import Path

from ..base.core import commit, version


def provenance(**facts: str) -> list[tuple[str, str]]:
    """Return names and values of the provenance; `facts` come first: ``input="slope.nml"``."""
    lines = [(name.replace("_", " "), value) for name, value in facts.items() if value]
    program, source_commit = f"sitedda {version()}", commit()
    full_name = f"{program}, commit {source_commit}" if source_commit else program
    computed_by = facts.get("computed_by")  # the program is not listed twice
    if computed_by not in (full_name, program):
        lines.append(("program", program))
    if source_commit and computed_by != full_name:
        lines.append(("commit", source_commit))
    return [
        *lines,
        ("date", datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")),
        ("command", command()),
        ("machine", machine()),
    ]


def command() -> str:
    """Return the command line of this process without the folder of the program."""
    arguments = [Path(sys.argv[0]).name or "python", *sys.argv[1:]] if sys.argv else ["python"]
    return shlex.join(arguments)


def machine() -> str:
    """Return system, processor and number of cores."""
    python = f"Python {platform.python_version()}"
    system = f"{platform.system()} {platform.machine()}"
    return f"{system}, {_processor_name()}{os.cpu_count()} cores, {python}"


def _processor_name() -> str:
    """Return the name of the processor, followed by a comma; blank if unknown."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return ""
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{names[0]}, " if names else ""
