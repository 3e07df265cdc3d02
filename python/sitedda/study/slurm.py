# SPDX-License-Identifier: GPL-3.0-or-later
"""Run a study by Slurm as a job array of `sitedda-native`; the nodes do not need Python."""

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
_MOST_TASKS = 1000  # largest size of a job array with the default MaxArraySize of Slurm
_MIB = 2**20  # bytes
_BASE = 200.0  # memory of the executable and its libraries, MiB
_OPTION = re.compile(r"--[a-z][a-z0-9-]*(=.*)?")
# Options of sbatch that a study may contain: resources, times and mail, but no files or programs.
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
# {count} cases, {each} per task, by {program_name}; written by sitedda study plan.
# Submit this script repeatedly until all cases are done; results are kept.
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
study={study}
program={program}

if [ "$(sha256sum < "$program" | cut -c 1-32)" != {digest} ]; then
   echo "$program is not the build with which this study was planned; plan it again" >&2
   exit 1
fi

set -C  # redirections create files and never write through links
asked= child=
trap 'asked=1; [ -n "$child" ] && kill -USR1 "$child"' USR1 TERM

# Run one case; status 0: complete or failed, 6: interrupted, otherwise: run it again.
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
   echo "the process ended with status $status (137: signal 9, for example lack of memory)" \\
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
    """Options of a study for Slurm."""

    program: str = ""  # path of sitedda-native; default: the executable of this installation
    each: int = 0  # number of cases per task; 0: the smallest number with at most 1000 tasks
    time: str = ""  # limit of a task in the format of sbatch; default: three times the estimate
    memory: float = 0.0  # MiB; default: twice the estimate of `sitedda check`, plus 200 MiB
    options: Sequence[str] = field(default_factory=tuple)  # of sbatch, such as --partition=long

    def __post_init__(self):
        for name, value in (("each", self.each), ("memory", self.memory)):
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not number or not 0 <= value < math.inf or (name == "each" and value != int(value)):
                raise InputError(f"{name} = {value!r}: give a number of 0 or more")
        texts = (self.program, self.time, *self.options)
        if isinstance(self.options, str) or not all(isinstance(text, str) for text in texts):
            raise InputError("program and time must be strings, options a list of strings")

    @classmethod
    def of_study(cls, values: Mapping) -> "Slurm":
        """Return the options in a study file, which must not name files to write or execute."""
        if "program" in values:
            raise InputError("a study must not name the program: use sitedda study plan --program")
        options = cls(**values)
        for option in options.options:
            if (name := option.lstrip("-").partition("=")[0]) not in _HARMLESS:
                raise InputError(
                    f"options: --{name} may name a file to write or execute, or the script sets "
                    "this option; give it on the command line of sbatch"
                )
        return options


def write_batch(plan: Plan, slurm: Slurm) -> Path:
    """Write the script for sbatch, and its list of cases, into the folder of a written plan."""
    if callable(plan.model) or plan.task != "run":
        raise InputError(
            "a script for Slurm can only run inputs by sitedda-native, and this study requires "
            "Python: use sitedda study run, with --dask on a cluster"
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
        options="\n".join(f"#SBATCH {_escape_option(option)}" for option in slurm.options),
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
    """Submit a script by sbatch; return the output of sbatch."""
    try:
        reply = subprocess.run(["sbatch", str(script)], capture_output=True, text=True, check=False)
    except OSError as error:
        raise OutputError(f"sbatch cannot be started: {error.strerror}; on a machine with "
                          f"Slurm, run sbatch {shlex.quote(str(script))}") from error  # fmt: skip
    if reply.returncode:
        raise OutputError(f"sbatch rejects {script}: {reply.stderr.strip()}")
    return reply.stdout.strip()


def native_program(name: str = "") -> Path:
    """Return the path of sitedda-native: of this name, beside this Python, or in PATH."""
    local = Path(sys.executable).parent / "sitedda-native"
    program = shutil.which(name) if name else str(local) if local.exists() else None
    program = program or (None if name else shutil.which("sitedda-native"))
    if not program:
        raise InputError(f"{name or 'sitedda-native'} is not found; give its path by --program")
    return Path(plain_text("program", str(Path(program).resolve())))


def build_inputs(plan: Plan) -> None:
    """Replace joint sets, masonry and similar groups in the inputs of all cases by blocks."""
    for key in dict.fromkeys(plan.keys):
        file = case_folder(plan.folder, key) / INPUT
        text = file.read_text("utf-8", "surrogateescape")
        if needs_building(text) and (built_input := built_text(text, file)[0]) != text:
            write_whole(file, built_input)


def estimate_of(file: Path) -> Mapping[str, float]:
    """Return ``memory`` (MiB) and ``seconds`` of a run, estimated by a check; 0 if this fails."""
    from ..engine.checking import check

    try:
        report = check(file)
    except SiteddaError:
        return {"memory": 0.0, "seconds": 0.0}
    return {"memory": report.memory / _MIB, "seconds": report.seconds}


def _escape_for_sbatch(text: str) -> str:
    """Escape special characters of a word by backslashes for an #SBATCH line.

    Line ends raise an error, because they end the comment even within quotes.
    """
    return re.sub(r"([^\w./=:@,%+-])", r"\\\1", plain_text("a word for sbatch", text))


def _escape_option(text: str) -> str:
    """Return an option of sbatch with its value escaped; raise InputError if it is invalid."""
    if not _OPTION.fullmatch(text):
        raise InputError(f"{text!r} is not an option of sbatch, such as --partition=long")
    name, equals, value = text.partition("=")
    return f"{name}={_escape_for_sbatch(value)}" if equals else name
