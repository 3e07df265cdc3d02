# SPDX-License-Identifier: GPL-3.0-or-later
"""Submit the cases of a study to an executor, a limited number at a time."""

import queue
from collections import Counter, deque
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor, CancelledError

from ..base.errors import InterruptedRun, OutputError, SiteddaError
from .case import Work, carry_out, check_first, valid_result
from .store import case_folder, locked
from .workers import TaskTooLong, WorkerDied

_DEATHS = 3  # number of worker processes that may die in a case before it counts as failed
_WINDOW = 256  # number of submitted cases if the number of workers is unknown


def distribute(executor, work: Work, keys: Sequence[str], progress: Callable | None = None) -> None:
    """Execute all cases that have no result.

    Cases that another client executes come last. A case whose process dies is repeated twice at
    most, and then marked as failed.

    `keys`: keys of the cases; `progress`: called with the numbers of ended and failed cases.
    """
    unique_keys = list(dict.fromkeys(keys))
    todo = [key for key in unique_keys if valid_result(work, case_folder(work.study, key)) is None]
    check_first(work, todo)
    loop = _CaseLoop(executor, work, todo)
    complete, failures = len(unique_keys) - len(todo), 0
    if progress:
        progress(complete, failures)
    for status in loop.results():
        complete, failures = complete + 1, failures + (status == "failed")
        if progress:
            progress(complete, failures)


def workers_of(executor) -> int | None:
    """Return the number of workers of an executor; None if unknown."""
    return getattr(executor, "count", None) or getattr(executor, "_max_workers", None)


class _CaseLoop:
    def __init__(self, executor, work: Work, keys: Sequence[str]):
        self.executor, self.work = executor, work
        self.fresh, self.busy = deque(keys), deque()
        self.running: dict = {}
        self.ended: queue.SimpleQueue = queue.SimpleQueue()
        self.deaths: Counter = Counter()
        workers = workers_of(executor)
        self.window = 2 * workers if workers else _WINDOW

    def results(self):
        """Yield the status of each case when the case ends."""
        while self.fresh or self.busy or self.running:
            self._submit_cases()
            future = self.ended.get()
            key = self.running.pop(future)
            status = self._status_or_retry(key, future)
            if status is not None:
                yield status

    def _submit_cases(self) -> None:
        """Submit cases until `window` cases are submitted; first those that no client executes."""
        while len(self.running) < self.window and (self.fresh or self.busy):
            wait = not self.fresh
            key = self.busy.popleft() if wait else self.fresh.popleft()
            try:
                future = self.executor.submit(carry_out, self.work, key, wait)
            except (BrokenExecutor, RuntimeError) as error:
                raise _lost_executor_error(error) from error
            self.running[future] = key
            future.add_done_callback(self.ended.put)

    def _status_or_retry(self, key: str, future) -> str | None:
        """Return the status of a submitted case; None if it will be submitted again."""
        try:
            result = future.result()
        except TaskTooLong:
            return self._record_failure(
                key, f"the time limit of {self.work.time_limit:g} s is exceeded", "time"
            )
        except (BrokenExecutor, CancelledError) as error:
            raise _lost_executor_error(error) from error
        except SiteddaError:
            raise
        except Exception as error:
            if not isinstance(error, WorkerDied) and type(error).__name__ != "KilledWorker":
                raise
            return self._resubmit_or_fail(key, error)
        if result["status"] == "busy":
            self.busy.append(key)
            return None
        if result["status"] == "interrupted":
            raise InterruptedRun("interrupted; call again to continue")
        if result["status"] == "unfinished":
            raise OutputError(f"case {key}: {result['message']}")
        return result["status"]

    def _resubmit_or_fail(self, key: str, error: Exception) -> str | None:
        """Resubmit a case whose worker has died; after `_DEATHS` deaths return 'failed'."""
        self.deaths[key] += 1
        if self.deaths[key] >= _DEATHS:
            return self._record_failure(key, str(error), "process")
        self.fresh.append(key)
        return None

    def _record_failure(self, key: str, message: str, kind: str) -> str:
        """Write the failure of a case and return 'failed'."""
        folder = case_folder(self.work.study, key)
        with locked(folder, wait=True):
            self.work.fail(folder, message, kind)
        return "failed"


def _lost_executor_error(error: BaseException) -> OutputError:
    name = type(error).__name__
    return OutputError(f"the executor has stopped ({name}: {error}); results are kept: start "
                       "another executor and call again to continue")  # fmt: skip
