# SPDX-License-Identifier: GPL-3.0-or-later
"""Worker processes with the interface of `concurrent.futures.Executor`.

Unlike in a `ProcessPoolExecutor`, the death of a process fails only its own task, and another
process replaces it.  Memory and time of a task can be limited.
"""

import os
import pickle
import queue
import resource
import signal
import socket
import subprocess
import sys
import threading
import time
from concurrent.futures import Executor, Future
from multiprocessing.connection import Connection, wait
from numbers import Real

from ..base.errors import InputError

_GRACE = 5.0  # s after the time limit until a process is killed
_POLL = 0.5  # s between checks of the parent process
_LARGEST_LIMIT = 1e15  # largest limit of memory (bytes) or time (s)
_UNLIMITED = 2.0**62  # limits of memory from this size (bytes) on are ignored
_LONGEST_LIMIT = 1e6  # time limits from this value (s) on are ignored


class WorkerDied(Exception):
    """The process of a task has died; the message contains the reason."""


class TaskTooLong(Exception):
    """The process of a task was killed because the task exceeded its time limit."""


def check_limits(memory: float | None, time_limit: float) -> None:
    """Check the limits of memory and time of a case.

    `memory`: bytes; `time_limit`: s.
    """
    for name, value in (("memory", memory), ("time_limit", time_limit)):
        number = isinstance(value, Real) and not isinstance(value, bool)
        is_unlimited = value == float("inf") or (name == "memory" and value is None)
        if not is_unlimited and not (number and 0 < value <= _LARGEST_LIMIT):
            limits = f"above 0, at most {_LARGEST_LIMIT:g}"
            raise InputError(f"{name} = {value!r}: give a number {limits}")


class Workers(Executor):
    """An executor with worker processes.

    Parameters
    ----------
    count : int
        Number of processes.
    memory : float
        Bytes that a process may allocate.
    time_limit : float
        Largest duration of a task, s (wall clock).
    """

    def __init__(self, count: int, memory: float = float("inf"), time_limit: float = float("inf")):
        self.count, self.memory, self.time_limit = count, memory, time_limit
        self._tasks: queue.SimpleQueue = queue.SimpleQueue()
        self._closed = threading.Event()
        self._processes: set[subprocess.Popen] = set()
        target = self._feed_process
        self._threads = [threading.Thread(target=target, daemon=True) for _ in range(count)]
        for thread in self._threads:
            thread.start()

    def submit(self, function, /, *arguments, **options) -> Future:
        """Submit a function to be called in one of the processes."""
        future: Future = Future()
        self._tasks.put((future, _serialise_task(function, arguments, options)))
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes after their tasks; if cancelled, stop the tasks with checkpoints."""
        self._closed.set()
        if cancel_futures:
            for process in list(self._processes):
                process.terminate()
        for _ in self._threads:
            self._tasks.put(None)
        if wait:
            for thread in self._threads:
                thread.join()

    def _feed_process(self) -> None:
        """Send tasks to a process, and replace the process if it dies."""
        process = None
        while (task := self._tasks.get()) is not None:
            future, data = task
            if self._closed.is_set() or not future.set_running_or_notify_cancel():
                future.cancel()
                continue
            try:
                process = process or _Process(self.memory, self._processes)
                future.set_result(process.call(data, self.time_limit + _GRACE))
            except BaseException as error:
                if isinstance(error, WorkerDied | TaskTooLong):
                    process = None
                future.set_exception(error)
        if process:
            process.close()


def _serialise_task(*task) -> bytes:
    """Return a task as bytes; functions of the main program require cloudpickle."""
    try:
        from cloudpickle import dumps
    except ImportError:
        pass
    else:
        return dumps(task)
    try:
        data = pickle.dumps(task)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise InputError(f"the task cannot be sent to a process: {error}; define functions in "
                         "a module, or pip install cloudpickle") from error  # fmt: skip
    if b"__main__" in data:
        raise InputError(
            "a function that is defined in the main program or a notebook requires cloudpickle: "
            "pip install cloudpickle, or define the function in a module"
        )
    return data


class _Process:
    """A worker process and the connection to it."""

    def __init__(self, memory: float, processes: set):
        own_end, child_end = socket.socketpair()
        threads = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        with child_end:
            self.process = subprocess.Popen(
                [sys.executable, "-c", "from sitedda.study.workers import main; main()",
                 str(child_end.fileno())],
                pass_fds=[child_end.fileno()],
                env=os.environ | threads | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
                stdin=subprocess.DEVNULL,
            )  # fmt: skip
        self.processes = processes
        processes.add(self.process)
        self.connection = Connection(own_end.detach())
        self.connection.send(memory)

    def call(self, data: bytes, time_limit: float):
        """Send a task to the process and return its value."""
        try:
            self.connection.send_bytes(data)
            timeout = None if time_limit > _LONGEST_LIMIT else time_limit
            if not wait([self.connection], timeout):
                self._end_process(signal.SIGKILL)
                raise TaskTooLong("the task exceeded its time limit")
            succeeded, value = self.connection.recv()
        except (EOFError, OSError) as error:
            raise WorkerDied(self._end_process(None)) from error
        if not succeeded:
            raise value
        return value

    def _end_process(self, number: int | None) -> str:
        """End the process by a signal, or wait for its end; return the reason of its end."""
        if number:
            self.process.send_signal(number)
        status = self.process.wait()
        self.connection.close()
        self.processes.discard(self.process)
        if status < 0:
            reason = " (for example because of lack of memory)" if status == -signal.SIGKILL else ""
            return f"its process was ended by signal {-status}{reason}"
        return f"its process ended with status {status}"

    def close(self) -> None:
        """Close the connection, which ends the process, and wait for its end."""
        self.connection.close()
        self.process.wait()
        self.processes.discard(self.process)


def main() -> None:
    """Run a worker process: call the received functions until the connection ends."""
    connection = Connection(int(sys.argv[-1]))
    threading.Thread(target=_stop_with_parent, args=(os.getppid(),), daemon=True).start()
    memory = connection.recv()
    if memory < _UNLIMITED:
        limit = resource.getrlimit(resource.RLIMIT_DATA)[1]  # limit of a parent worker, if any
        limit = int(memory) if limit == resource.RLIM_INFINITY else min(int(memory), limit)
        resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
    while True:
        try:
            data = connection.recv_bytes()
        except (EOFError, OSError):
            return
        try:
            function, arguments, options = pickle.loads(data)
            answer = (True, function(*arguments, **options))
        except KeyboardInterrupt:  # the client receives signals of the terminal as well
            return
        except Exception as error:
            answer = (False, error)
        connection.send(answer)


def _stop_with_parent(parent: int) -> None:
    """Stop this process, with a checkpoint of its run, if the client has died."""
    while os.getppid() == parent:
        time.sleep(_POLL)
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(_GRACE)
    os._exit(1)
