# SPDX-License-Identifier: GPL-3.0-or-later
"""Execute a case of a study in a worker: run or resume the input, and write the results."""

import json
import shutil
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..base.errors import CheckpointError, InterruptedRun, OutputError, SiteddaError, lacks_memory
from .arrays import Array
from .quantities import NotBegun, Quantity, check_names, measure, split_value
from .store import (
    FAILED,
    INPUT,
    OUTPUT,
    WARNINGS,
    case_folder,
    locked,
    read_result,
    refuse_links,
    write_result,
    write_whole,
)

_STATE = ("", ".partial", ".journal", ".checkpoint", ".checkpoint.previous", ".checkpoint.coming",
          ".writing")  # fmt: skip
_LIMITED = ("time", "memory", "process")  # kinds of failure that larger limits may prevent
_CHECKED_CASES = 3  # largest number of cases with which the check of names is attempted
KINDS = {1: "input", 2: "check", 3: "convergence", 4: "solver", 6: "time", 7: "memory"}


@dataclass(frozen=True)
class Work:
    """Settings of a study that a worker needs."""

    study: Path  # folder of the study
    model: Callable | None = None  # the model, if it is a function
    task: str | Callable = "run"  # ``'run'`` or a function of the path of the input
    quantities: list[Quantity] = field(default_factory=list)
    time_limit: float = np.inf  # largest duration of a case, s (wall clock)
    keep: bool = True  # whether to keep outputs after the extraction of results
    again: bool = False  # whether failed cases are repeated
    start: bool = True  # whether to run inputs; otherwise only complete outputs are read
    memory: float | None = None  # bytes that a case may allocate; None: unlimited

    @property
    def requested(self) -> list[list[str]]:
        """Return the labels and names of the quantities."""
        return [[item.label, item.name] for item in self.quantities]

    def check(self, file: Path) -> None:
        """Check before a run that the output will contain the quantities."""
        check_names(file, self.quantities)

    @property
    def limits(self) -> list:
        """Return the limits of time and memory of a case."""
        return [self.time_limit, self.memory]

    def fail(self, folder: Path, message: str, kind: str) -> dict:
        """Write the failure of a case, and the settings on which it depends."""
        settings: dict = {"limits": self.limits} if kind in _LIMITED else {}
        is_complete = (folder / WARNINGS).exists()
        if is_complete:  # the extraction of a result has failed
            settings["asked"] = self.requested
        return write_result(folder, "failed", message, kind=kind, **settings)


def check_first(work: Work, keys: Sequence[str]) -> None:
    """Check the names of results and tasks on the first case that can start.

    `keys`: keys of the cases that will be run.
    """
    check = getattr(work.task, "check", None) if callable(work.task) else work.check
    if work.model is not None or not work.start or not check:
        return
    for key in keys[:_CHECKED_CASES]:
        with suppress(NotBegun):
            return check(case_folder(work.study, key) / INPUT)


def carry_out(work: Work, key: str, wait: bool = False) -> dict:
    """Execute a case unless it has a result.

    `key`: key of the case; `wait`: whether to wait for another process that executes the case.

    Result: ``status``: 'complete', 'failed', 'missing', 'interrupted', 'unfinished' (the disk has
    failed) or 'busy' (another process executes the case); ``message``.
    """
    folder = case_folder(work.study, key)
    if not folder.is_dir():
        raise OutputError(f"{folder} is missing: workers must see the folder of the study "
                          "under the same path")  # fmt: skip
    with locked(folder, wait) as acquired:
        if not acquired:
            return {"status": "busy", "message": ""}
        result = valid_result(work, folder)
        if result is None:
            result = _obtain_result(work, folder)
    return {"status": result["status"], "message": result["message"]}


def valid_result(work: Work, folder: Path) -> dict | None:
    """Return the result of a case if it was obtained with the present settings."""
    result = read_result(folder)
    if result is None:
        return None
    failed = result["status"] == "failed"
    if failed and (work.again or (work.start and result.get("limits", work.limits) != work.limits)):
        return None
    is_same = result.get("asked", work.requested if failed else None) == work.requested
    return result if is_same else None


def take_output(folder: Path, output: Path) -> None:
    """Use the complete output of a run of this build for a case with the same input."""
    if not (folder / WARNINGS).exists():
        shutil.copyfile(output, folder / OUTPUT)
        write_whole(folder / WARNINGS, "")  # the output contains the warnings


def _obtain_result(work: Work, folder: Path) -> dict:
    """Execute a case and write its result or failure; return status and message."""
    start = time.time()
    try:
        numbers, arrays, extra = _compute_results(work, folder)
    except (InterruptedRun, KeyboardInterrupt):
        return {"status": "interrupted", "message": ""}
    except Missing:
        return {"status": "missing", "message": ""}
    except OutputError as error:  # the disk has failed, not the case, which can be repeated
        return {"status": "unfinished", "message": str(error)}
    except SiteddaError as error:
        text = str(error).replace(f"{folder}/", "")
        return work.fail(folder, text, KINDS.get(error.kind, "input"))
    except Exception as error:  # an error of the user's function fails only this case
        if lacks_memory(error):
            return work.fail(folder, "not enough memory", "memory")
        text = f"{type(error).__name__}: {error}"
        return work.fail(folder, text, "function")
    data = {f"{k}|{d}": np.asarray(c) for k, a in arrays.items() for d, c in a.coordinates.items()}
    data |= {name: array.values for name, array in arrays.items()}
    return write_result(
        folder,
        "complete",
        asked=work.requested,
        numbers=numbers,
        arrays=data,
        shapes={k: {"dims": a.dims, "shape": a.values.shape, "units": a.units}
                for k, a in arrays.items()},
        seconds=round(time.time() - start, 3),
        **extra,
    )  # fmt: skip


def _compute_results(work: Work, folder: Path) -> tuple[dict[str, float], dict[str, Array], dict]:
    """Execute a case; return its numbers, arrays and warning."""
    if work.model is not None:
        values = json.loads((folder / "values.json").read_text())
        return *_numbers_and_arrays(split_value("value", work.model(**values))), {}
    if callable(work.task):
        value = work.task(folder / INPUT)
        warning = value.pop("warning", "") if isinstance(value, dict) else ""
        return *_numbers_and_arrays(split_value("value", value)), {"warning": str(warning)}
    _raise_stored_failure(folder, work.again)
    if not work.start and not (folder / WARNINGS).exists():
        raise Missing
    warning = run_input(folder, work.time_limit)
    notes: list[str] = []
    numbers, arrays = measure(folder / OUTPUT, work.quantities, notes)
    if not work.keep:
        remove_output(folder)
    return numbers, arrays, {"warning": "\n".join(filter(None, [warning, *notes]))}


def _numbers_and_arrays(values: dict) -> tuple[dict[str, float], dict[str, Array]]:
    arrays = {name: value for name, value in values.items() if isinstance(value, Array)}
    return {n: v for n, v in values.items() if n not in arrays}, arrays


def run_input(folder: Path, time_limit: float = np.inf) -> str:
    """Run or resume the input of a case, unless its output is complete; return its warnings."""
    if (folder / OUTPUT).exists():
        if (texts := warnings_of(folder)) is not None:
            return texts
        remove_output(folder)  # the process was killed before it wrote the warnings
    try:
        return _run_to_end(folder, time_limit)
    except CheckpointError:
        remove_output(folder)
        return _run_to_end(folder, time_limit)


def _run_to_end(folder: Path, time_limit: float) -> str:
    """Run or resume the input of a case to its end; write and return its warnings."""
    from ..engine.simulation import completed_run

    start = time.monotonic()

    def check_time(simulation) -> None:
        if time.monotonic() - start > time_limit:
            raise TimeLimit(f"stopped at t = {simulation.time:g} s of {simulation.duration:g} s: "
                            f"the time limit of {time_limit:g} s is exceeded")  # fmt: skip

    files = folder / INPUT, folder / OUTPUT
    with completed_run(*files, check_time, waits=True, resume=True) as (_, simulation):
        texts = filter(None, [simulation.warning, *simulation.peak_warnings])
        write_whole(folder / WARNINGS, "\n".join(texts))
    return warnings_of(folder)


class Missing(SiteddaError):
    """The case has not been run yet."""


def _raise_stored_failure(folder: Path, repeat: bool) -> None:
    """Raise the error with which a Slurm task has failed, unless the case is repeated."""
    file = folder / FAILED
    if repeat:
        file.unlink(missing_ok=True)
    elif file.exists():
        text = refuse_links(folder, file).read_text("utf-8", "replace").strip()
        raise SiteddaError(text.removeprefix("sitedda-native: ") or "it failed without a message")


class TimeLimit(SiteddaError):
    """The case has exceeded its time limit."""

    kind = 6


def warnings_of(folder: Path) -> str | None:
    """Return the warnings of a complete run, one per line; None if the run is incomplete."""
    try:
        text = (folder / WARNINGS).read_text("utf-8", "replace")
    except OSError:
        return None
    return "\n".join(line.removeprefix("warning: ") for line in text.splitlines() if line.strip())


def remove_output(folder: Path) -> None:
    """Delete the output of a case, complete or not, with its checkpoints and warnings."""
    for end in _STATE:
        (folder / f"{OUTPUT}{end}").unlink(missing_ok=True)
    (folder / WARNINGS).unlink(missing_ok=True)
