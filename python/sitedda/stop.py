# SPDX-License-Identifier: GPL-3.0-or-later
"""Signals that ask a run to stop."""

from __future__ import annotations

import signal
import threading


class Stop:
    """While it is entered, the signals only set `asked`; a step then ends as it should.

    Only the main thread can receive signals, and handlers that an application has set itself are
    left alone.
    """

    def __init__(self, signals):
        self.signals = signals
        self.asked = False
        self._before = {}

    def __enter__(self) -> Stop:
        """Watch the signals."""
        if threading.current_thread() is threading.main_thread():
            for number in self.signals:
                if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
                    self._before[number] = signal.signal(number, self._ask)
        return self

    def __exit__(self, *_) -> None:
        """Leave the signals as they were."""
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _ask(self, *_) -> None:
        self.asked = True
