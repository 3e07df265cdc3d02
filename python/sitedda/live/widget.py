# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda live` as a widget of a notebook whose browser is on the same machine."""

import re
import subprocess
import sys
import threading
import weakref
from html import unescape
from importlib.resources import files
from pathlib import Path

import anywidget

from ..base.errors import SiteddaError


class LiveWidget(anywidget.AnyWidget):
    """The page of `sitedda live`; its server ends with the widget or by `close`.

    `file`: input to open; None: the start page for the current folder.
    """

    _esm = files(__package__).joinpath("widget.js").read_text(encoding="utf-8")

    def __init__(self, file=None):
        """Start a server and send its address to the frames of this widget."""
        super().__init__()
        arguments = [] if file is None else [str(file)]
        server = subprocess.Popen(
            [sys.executable, "-m", "sitedda", "live", "--notebook", *arguments],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        )  # fmt: skip
        self._end = weakref.finalize(self, server.terminate)
        output_text = ""
        while "to enter, open " not in output_text:
            line = server.stdout.readline()
            if not line:
                raise SiteddaError(output_text.strip())
            output_text += line
        threading.Thread(target=server.stdout.read, daemon=True).start()  # keeps the pipe empty
        path = Path(output_text.partition("to enter, open ")[2].strip())
        redirect_page = path.read_text(encoding="utf-8")
        address = unescape(re.search(r"href='(.+?)'", redirect_page)[1])
        # The address contains the token; unlike traits, messages are not stored in the notebook.
        self.on_msg(lambda widget, *_: widget.send({"address": address}))

    def close(self) -> None:
        """End the server and the frames."""
        self._end()
        super().close()
