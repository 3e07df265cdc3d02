# SPDX-License-Identifier: GPL-3.0-or-later
"""The interactive view as a widget of notebooks."""

from importlib.resources import files

import anywidget
import traitlets

from ...report.html import to_html
from . import view_page

_BUDGET = 5_000_000  # largest size of the view in a notebook, bytes


class ViewWidget(anywidget.AnyWidget):
    """The interactive view of a run; picked block and time are synchronised with Python.

    `picked`: name of the picked block, or names of both blocks of the picked joint; empty if none.
    `time`: time of the shown frame, s.
    """

    _esm = files(__package__).joinpath("widget.js").read_text(encoding="utf-8")
    page = traitlets.Unicode().tag(sync=True)
    picked = traitlets.Unicode("").tag(sync=True)
    time = traitlets.Float(0.0).tag(sync=True)

    def __init__(self, source, **options):
        """Encode the frames of a source; for the arguments see `view_page`."""
        super().__init__(page=to_html(view_page(source, **{"budget": _BUDGET} | options)))
