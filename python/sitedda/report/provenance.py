# SPDX-License-Identifier: GPL-3.0-or-later
"""Provenance of a report: program, commit, date, command, machine."""

import os
import platform
import shlex
import sys
from datetime import UTC, datetime
from pathlib import Path

from ..base.core import commit, version


def provenance(**more: str) -> list[tuple[str, str]]:
    """Return names and values of the provenance; `more` come first: ``input="slope.nml"``."""
    lines = [(name.replace("_", " "), value) for name, value in more.items() if value]
    program, made_of = f"sitedda {version()}", commit()
    whole = f"{program}, commit {made_of}" if made_of else program
    computed_by = more.get("computed_by")  # the program is not listed twice
    if computed_by not in (whole, program):
        lines.append(("program", program))
    if made_of and computed_by != whole:
        lines.append(("commit", made_of))
    return [
        *lines,
        ("date", datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")),
        ("command", command()),
        ("machine", machine()),
    ]


def command() -> str:
    """Return the command line of this process without the folder of the program."""
    words = [Path(sys.argv[0]).name or "python", *sys.argv[1:]] if sys.argv else ["python"]
    return shlex.join(words)


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
