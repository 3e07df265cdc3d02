# SPDX-License-Identifier: GPL-3.0-or-later
"""Signals that request a run, or the program, to stop."""

import signal
import sys
import time

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)
_RETRY = 0.02  # s between looks at whether an import has ended
_PAUSE = 1.0  # s in which a second signal does not interrupt the cleanup of the first
_AGAIN = 1.0  # s of processor time within which an exception must end the program


class Interruption:
    """While it is entered, signals end the program that this process is, by KeyboardInterrupt.

    For programs alone: a library has no business with the handlers of its host.  An import is let
    end: compiled modules print tracebacks of what interrupts them.  Libraries lose exceptions, in
    callbacks and where attributes are looked for: what continues is interrupted again.

    Attributes
    ----------
    heard : bool
        A signal has come.
    """

    def __init__(self):
        self.heard = False
        self._last = -_PAUSE
        self._before = {}

    def __enter__(self) -> "Interruption":
        """Watch the signals that nobody else watches."""
        self._before = _install_handler((*SIGNALS, signal.SIGALRM, signal.SIGPROF), self._on_signal)
        self._report = sys.unraisablehook
        sys.unraisablehook = self._raise_later
        return self

    def __exit__(self, *_) -> None:
        """Leave the signals as they were."""
        self._rest()
        sys.unraisablehook = self._report
        _restore_handlers(self._before)

    def ignore(self) -> None:
        """Ignore further signals: nothing is left to stop."""
        self._rest()
        sys.unraisablehook = self._raise_later
        for number in self._before:
            signal.signal(number, signal.SIG_IGN)

    def _rest(self) -> None:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.setitimer(signal.ITIMER_PROF, 0.0)

    def _on_signal(self, number, frame) -> None:
        self.heard = True
        if _imports(frame):
            signal.setitimer(signal.ITIMER_REAL, _RETRY)
        elif number == signal.SIGPROF or time.monotonic() - self._last >= _PAUSE:
            self._last = time.monotonic()
            signal.setitimer(signal.ITIMER_PROF, _AGAIN)
            raise KeyboardInterrupt

    def _raise_later(self, trouble) -> None:
        """Raise it again if it was raised where exceptions are lost, as in a finaliser.

        After a signal, finalisers of objects that were never completed fail: nobody is told.
        """
        if isinstance(trouble.exc_value, KeyboardInterrupt):
            self._last = -_PAUSE
            signal.raise_signal(signal.SIGINT)
        elif not self.heard:
            self._report(trouble)


class Stop:
    """While it is entered, the signals only set `asked`, here and in the engine: a step ends first.

    Only the main thread can receive signals, and handlers that an application has set itself are
    left alone; those of `Interruption` too, unless it is the run that the program is for.
    """

    def __init__(self, signals, program: bool = False):
        self.signals, self.program = signals, program
        self.asked = False
        self._before = {}

    def __enter__(self) -> "Stop":
        """Watch the signals."""
        self._before = _install_handler(self.signals, self._on_stop, self.program)
        return self

    def __exit__(self, *_) -> None:
        """Leave the signals as they were."""
        if self.asked:
            _notify_engine(0)
        _restore_handlers(self._before)

    def _on_stop(self, number, _) -> None:
        self.asked = True
        _notify_engine(number)


def program_hears() -> bool:
    """Whether Ctrl-C ends this process, which is the program."""
    return _is_program(signal.getsignal(signal.SIGINT))


def _is_program(handler) -> bool:
    return isinstance(getattr(handler, "__self__", None), Interruption)


def _imports(frame) -> bool:
    """Whether a module is being imported."""
    while frame is not None and frame.f_code.co_filename != "<frozen importlib._bootstrap>":
        frame = frame.f_back
    return frame is not None


def _install_handler(signals, handler, program: bool = True) -> dict:
    """Set a handler instead of those of the program, or the default ones; the former ones."""
    before = {}
    for number in signals:
        found = signal.getsignal(number)
        if (program and _is_program(found)) or found in (
            signal.SIG_DFL,
            signal.default_int_handler,
        ):
            try:
                before[number] = signal.signal(number, handler)
            except ValueError:  # only the main thread receives signals
                break
    return before


def _restore_handlers(before: dict) -> None:
    for number, handler in before.items():
        signal.signal(number, handler)


def _notify_engine(number: int) -> None:
    from .core import api

    api.stop_engine(number)
