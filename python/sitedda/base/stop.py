# SPDX-License-Identifier: GPL-3.0-or-later
"""Handle signals that stop a run or the program."""

import signal
import sys
import time

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)
_RETRY = 0.02  # s between checks whether an import has ended
_PAUSE = 1.0  # s during which a second signal does not interrupt the cleanup after the first signal
_REPEAT_DELAY = 1.0  # s of processor time after which KeyboardInterrupt is raised again


class Interruption:
    """Context in which signals end the program by KeyboardInterrupt.

    Only for programs: a library must not replace the handlers of its host.  A running import is
    completed first, because compiled modules print tracebacks if they are interrupted.  Some
    libraries swallow exceptions; a program that continues is then interrupted again.

    `heard`: whether a signal has arrived.
    """

    def __init__(self):
        self.heard = False
        self._last = -_PAUSE
        self._before = {}

    def __enter__(self) -> "Interruption":
        """Install handlers for the signals that have no other handler."""
        self._before = _install_handler(
            (*SIGNALS, signal.SIGALRM, signal.SIGPROF), self._handle_signal
        )
        self._report = sys.unraisablehook
        sys.unraisablehook = self._raise_suppressed
        return self

    def __exit__(self, *_) -> None:
        """Restore the previous signal handlers."""
        self._cancel_timers()
        sys.unraisablehook = self._report
        _restore_signal_handlers(self._before)

    def ignore(self) -> None:
        """Ignore further signals because the program is already ending."""
        self._cancel_timers()
        sys.unraisablehook = self._raise_suppressed
        for number in self._before:
            signal.signal(number, signal.SIG_IGN)

    def _cancel_timers(self) -> None:
        """Cancel the timers that raise KeyboardInterrupt later or again."""
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.setitimer(signal.ITIMER_PROF, 0.0)

    def _handle_signal(self, number, frame) -> None:
        """Raise KeyboardInterrupt, or set a timer that raises it after a running import."""
        self.heard = True
        if _is_importing(frame):
            signal.setitimer(signal.ITIMER_REAL, _RETRY)
        elif number == signal.SIGPROF or time.monotonic() - self._last >= _PAUSE:
            self._last = time.monotonic()
            signal.setitimer(signal.ITIMER_PROF, _REPEAT_DELAY)
            raise KeyboardInterrupt

    def _raise_suppressed(self, error) -> None:
        """Raise KeyboardInterrupt again if it was suppressed, for example in a finaliser.

        After a signal, finalisers of incomplete objects fail; their messages are suppressed.
        """
        if isinstance(error.exc_value, KeyboardInterrupt):
            self._last = -_PAUSE
            signal.raise_signal(signal.SIGINT)
        elif not self.heard:
            self._report(error)


class Stop:
    """Context in which a signal requests a stop at the end of the present step.

    Only the main thread can receive signals.  Handlers of an application are not replaced.  Those
    of `Interruption` are replaced only if `program` is true: the process exists for this run.
    """

    def __init__(self, signals, program: bool = False):
        self.signals, self.program = signals, program
        self.requested = False
        self._before = {}

    def __enter__(self) -> "Stop":
        """Install the signal handlers."""
        self._before = _install_handler(self.signals, self._request_stop, self.program)
        return self

    def __exit__(self, *_) -> None:
        """Restore the previous signal handlers."""
        if self.requested:
            _send_signal_to_engine(0)
        _restore_signal_handlers(self._before)

    def _request_stop(self, number, _) -> None:
        """Handle a signal: the engine stops at the end of the present step."""
        self.requested = True
        _send_signal_to_engine(number)


def program_handles_interrupt() -> bool:
    """Return whether Ctrl-C ends this process, because it is the program itself."""
    return _is_program_handler(signal.getsignal(signal.SIGINT))


def _is_program_handler(handler) -> bool:
    """Return whether a signal handler is that of `Interruption`."""
    return isinstance(getattr(handler, "__self__", None), Interruption)


def _is_importing(frame) -> bool:
    """Return whether a module is being imported."""
    while frame is not None and frame.f_code.co_filename != "<frozen importlib._bootstrap>":
        frame = frame.f_back
    return frame is not None


def _install_handler(signals, handler, program: bool = True) -> dict:
    """Replace default and program handlers of signals; return the replaced handlers by signal."""
    old_handlers = {}
    for number in signals:
        current = signal.getsignal(number)
        if (program and _is_program_handler(current)) or current in (
            signal.SIG_DFL,
            signal.default_int_handler,
        ):
            try:
                old_handlers[number] = signal.signal(number, handler)
            except ValueError:  # only the main thread receives signals
                break
    return old_handlers


def _restore_signal_handlers(old_handlers: dict) -> None:
    for number, handler in old_handlers.items():
        signal.signal(number, handler)


def _send_signal_to_engine(number: int) -> None:
    """Make the engine stop for a signal; number 0 withdraws the request."""
    from .core import api

    api.stop_engine(number)
