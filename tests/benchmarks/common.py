# SPDX-License-Identifier: GPL-3.0-or-later
"""Options, processor times and the main job (inputs/layered_site.nml) for the benchmarks."""

import re
import resource
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "robustness"))

from options import parse_options  # noqa: E402, F401

INPUT = ROOT / "inputs" / "layered_site.nml"


def processor(entry: str) -> str:
    """Return the last value of an entry of /proc/cpuinfo, or ''."""
    matches = re.findall(rf"(?m)^{entry}\s*:\s*(.*)$", Path("/proc/cpuinfo").read_text())
    return matches[-1] if matches else ""


def processor_time() -> float:
    """Return the processor time of all ended child processes, s."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def changed(text: str, steps: int, interval: int) -> str:
    """Return the main job with other numbers of steps and samples, and without amplification."""
    text = re.sub(r"(?m)^&amplification.*$", "", text)
    for variable, value in (("steps", steps), ("history_interval", interval)):
        text, count = re.subn(rf"\b{variable}\s*=\s*\d+", f"{variable} = {value}", text)
        if count != 1:
            raise SystemExit(f"{INPUT}: expected one {variable}, found {count}")
    return text
