# SPDX-License-Identifier: GPL-3.0-or-later
"""Run a study by Slurm: a job array of `sitedda-native`, without Python on the nodes."""

import math
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ..base.errors import InputError, OutputError, SiteddaError
from ..base.files import plain_text
from ..build.building import built_text
from ..input.source import needs_building
from .case import Work, check_first
from .plan import Plan
from .store import INPUT, PART, case_folder, file_checksum, write_whole

SCRIPT, TASKS = "submit.sh", "tasks.txt"
_MOST_TASKS = 1000  # largest size of a job array with Slurm's default MaxArraySize
_MIB = 2**20  # bytes
_BASE = 200.0  # MiB of the executable and its libraries
_OPTION = re.compile(r"--[a-z][a-z0-9-]*(=.*)?")
# Options of sbatch permitted in a study: place and time of tasks, and mail, but no files to read,
# write or execute.
_HARMLESS = frozenset(
    "account begin clusters comment constraint contiguous cores-per-socket cpu-freq "
    "deadline delay-boot dependency distribution exclude exclusive gres hint hold "
    "licenses mail-type mail-user mem-bind mem-per-cpu mincpus nice nodelist no-requeue "
    "oversubscribe partition power prefer priority qos reservation sockets-per-node "
    "spread-job switches thread-spec threads-per-core time-min tmp use-min-nodes wait "
    "wckey".split()
)

_TEMPLATE = """#!/bin/bash
#SBATCH --job-name={name}
#SBATCH --array=0-{last}
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --mem={memory}M
#SBATCH --time={time}
#SBATCH --requeue
#SBATCH --signal=B:USR1@120
#SBATCH --output={log}
{options}
# {count} cases, {each} a task, by {program_name}; written by sitedda study plan.
# To be submitted again and again: what is done stays done.
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
study={study}
program={program}

if [ "$(sha256sum < "$program" | cut -c 1-32)" != {digest} ]; then
   echo "$program is not the build that this study was planned for; plan it again" >&2
   exit 1
fi

set -C  # a file is made again, never written through a link
asked= child=
trap 'asked=1; [ -n "$child" ] && kill -USR1 "$child"' USR1 TERM

# One case: 0 done or given up, 6 interrupted, else to be tried again.
one() {{
   case "$1" in *[!0-9a-f]* | '') return 1 ;; esac
   cd "$study/cases/${{1:0:2}}/$1" || return 1
   [ -e result.json ] || [ -e failed.txt ] && return 0
   [ -L lock ] && return 1
   exec 9>> lock
   flock -n 9 || return 0
   if [ -e out.nc ]; then
      [ -e words.txt ] && return 0
      rm -f out.nc
   fi
   rm -f log.txt words.new
   "$program" resume {input} -q > log.txt 2> words.new &
   child=$!
   while :; do
      wait "$child"
      status=$?
      kill -0 "$child" 2> /dev/null || break
   done
   child=
   case $status in
      0) mv words.new words.txt; return 0 ;;
      1 | 2 | 3 | 4) mv words.new failed.txt; return 0 ;;
      5 | 6) cat words.new >&2; return $status ;;
   esac
   [ -n "$asked" ] && return 6
   echo "its process ended with status $status (137: by signal 9, as for want of memory)" \\
      >> words.new
   mv words.new failed.txt
}}

worst=0
first=$((SLURM_ARRAY_TASK_ID * {each} + 1))
for key in $(sed -n "${{first}},$((first + {each} - 1))p" "$study/{tasks}"); do
   [ -n "$asked" ] && worst=6 && break
   one "$key" || worst=$?
done
if [ $worst -eq 6 ] && command -v scontrol > /dev/null; then
   scontrol requeue "${{SLURM_ARRAY_JOB_ID}}_${{SLURM_ARRAY_TASK_ID}}"
fi
exit $worst
"""


@dataclass(frozen=True)
class Slurm:
    """Options of a study for Slurm.

    Attributes
    ----------
    program : str
        sitedda-native, that of this installation by default.
    each : int
        Cases of a task; 0: as few as make at most 1000 tasks.
    time : str
        Limit of a task, in the form of sbatch; by default three times the estimate.
    memory : float
        MiB of a task; by default by the model's estimate.
    options : sequence of str
        For sbatch, such as ``--partition=long``.
    """

    program: str = ""
    each: int = 0
    time: str = ""
    memory: float = 0.0
    options: Sequence[str] = field(default_factory=tuple)

    def __post_init__(self):
        for name, value in (("each", self.each), ("memory", self.memory)):
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not number or not 0 <= value < math.inf or (name == "each" and value != int(value)):
                raise InputError(f"{name} = {value!r}: give a number of 0 or more")
        if isinstance(self.options, str) or not all(
            isinstance(word, str) for word in (self.program, self.time, *self.options)
        ):
            raise InputError("program and time must be strings, options a list of strings")

    @classmethod
    def of_study(cls, values: Mapping) -> "Slurm":
        """Read options from a study file, which must not name files to write or execute.

        Raises
        ------
        InputError
            If it names a program, or an option that Slurm would write or execute something by.
        """
        if "program" in values:
            raise InputError(
                "program: a study must not name the executable; use sitedda study plan --program"
            )
        found = cls(**values)
        for option in found.options:
            if (name := option.lstrip("-").partition("=")[0]) not in _HARMLESS:
                raise InputError(
                    f"options: --{name} may write or execute something, or is set by the script; "
                    "give it on the command line of sbatch"
                )
        return found


def write_batch(plan: Plan, slurm: Slurm) -> Path:
    """Write the files for sbatch beside a written plan; return the script.

    Raises
    ------
    InputError
        If the study needs Python, or an option is not permitted.
    """
    if callable(plan.model) or plan.task != "run":
        raise InputError(
            "a script for Slurm runs inputs by sitedda-native, but functions and strength "
            "reduction need Python: use sitedda study run, with --dask on a cluster"
        )
    if not re.fullmatch(r"[\d:-]*", slurm.time):
        raise InputError(f"time = {slurm.time!r} is not a time limit of Slurm, such as 2:00:00")
    check_first(Work(plan.folder, quantities=plan.quantities), plan.keys)
    build_inputs(plan)
    keys = list(dict.fromkeys(plan.keys))
    each = slurm.each or math.ceil(len(keys) / _MOST_TASKS)
    files = [case_folder(plan.folder, key) / INPUT for key in keys]
    estimate = estimate_of(max(files, key=lambda file: file.stat().st_size))
    minutes = math.ceil((600.0 + 3.0 * each * estimate["seconds"]) / 60.0)
    write_whole(plan.folder / TASKS, "".join(f"{key}\n" for key in keys), PART)
    program = native_program(slurm.program)
    text = _TEMPLATE.format(
        name=re.sub(r"\W+", "_", plan.folder.name)[:60] or "study",
        last=math.ceil(len(keys) / each) - 1,
        memory=math.ceil(slurm.memory or _BASE + 2.0 * estimate["memory"]),
        time=slurm.time or f"{minutes // 60}:{minutes % 60:02d}:00",
        log=_escape_for_sbatch(str(plan.folder).replace("%", "%%")) + "/slurm-%A_%a.log",
        options="\n".join(f"#SBATCH {_check_option(one)}" for one in slurm.options),
        count=len(keys),
        each=each,
        program_name=program.name,
        study=shlex.quote(str(plan.folder)),
        program=shlex.quote(str(program)),
        digest=file_checksum(program),
        input=INPUT,
        tasks=TASKS,
    )
    write_whole(plan.folder / SCRIPT, text, PART)
    return plan.folder / SCRIPT


def submit(script: Path) -> str:
    """Submit a script by sbatch; return its answer."""
    try:
        done = subprocess.run(["sbatch", str(script)], capture_output=True, text=True, check=False)
    except OSError as trouble:
        raise OutputError(f"sbatch cannot be started: {trouble.strerror}; on a machine that has "
                          f"it: sbatch {shlex.quote(str(script))}") from trouble  # fmt: skip
    if done.returncode:
        raise OutputError(f"sbatch refuses {script}: {done.stderr.strip()}")
    return done.stdout.strip()


def native_program(name: str = "") -> Path:
    """Find sitedda-native by name, beside this Python, or on the path."""
    beside = Path(sys.executable).parent / "sitedda-native"
    found = shutil.which(name) if name else str(beside) if beside.exists() else None
    found = found or (None if name else shutil.which("sitedda-native"))
    if not found:
        raise InputError(f"{name or 'sitedda-native'} is not found; name it with --program")
    return Path(plain_text("program", str(Path(found).resolve())))


def build_inputs(plan: Plan) -> None:
    """Convert joints and masonry in the inputs of all cases into blocks."""
    for key in dict.fromkeys(plan.keys):
        file = case_folder(plan.folder, key) / INPUT
        text = file.read_text("utf-8", "surrogateescape")
        if needs_building(text) and (built := built_text(text, file)[0]) != text:
            write_whole(file, built)


def estimate_of(file: Path) -> Mapping[str, float]:
    """Return ``memory`` (MiB) and ``seconds`` of a run by `sitedda check`; 0 if it fails."""
    from ..engine.checking import check

    try:
        report = check(file)
    except SiteddaError:
        return {"memory": 0.0, "seconds": 0.0}
    return {"memory": report.memory / _MIB, "seconds": report.seconds}


def _escape_for_sbatch(text: str) -> str:
    """Escape special characters of a word by backslashes for an #SBATCH line.

    Line ends are rejected, because they end a comment even within quotes.
    """
    return re.sub(r"([^\w./=:@,%+-])", r"\\\1", plain_text("a word for sbatch", text))


def _check_option(text: str) -> str:
    if not _OPTION.fullmatch(text):
        raise InputError(f"{text!r} is not an option of sbatch, such as --partition=long")
    name, equals, value = text.partition("=")
    return f"{name}={_escape_for_sbatch(value)}" if equals else name
