# SPDX-License-Identifier: GPL-3.0-or-later
"""A run that has ended, with history, verdict and pictures."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from ..engine.maxima import Maximum, maxima_of

if TYPE_CHECKING:
    import xarray as xr


class EndedRun:
    """A run that has ended.

    `history`: the whole output, in memory.
    `complete`: false if the run was stopped before its end.
    `output`: the output file, if there is one.
    `summary`: summary of the step control.
    """

    def __init__(self, history: xr.Dataset, complete: bool, output: Path | None, summary: str):
        self.history = history
        self.complete = complete
        self.output = output
        self.summary = summary

    @cached_property
    def verdict(self):
        """Return the results in words, a `Verdict`: ``print(run.verdict)``."""
        from ..output.verdict import verdict

        return verdict(self.history)

    @cached_property
    def maxima(self) -> dict[str, Maximum]:
        """Return the largest values of all steps by name, each a `sitedda.maxima.Maximum`.

        ``run.maxima["tilt"].value``, ``.time``, ``.blocks``, ``.residual``; see docs/output.md.
        """
        return maxima_of(self.history)

    def draw(self, **options):
        """Draw the blocks, see `sitedda.draw`; return matplotlib axes."""
        from ..drawing.pictures import draw

        return draw(self, **options)

    def animate(self, **options):
        """Return the frames as an animation for notebooks, see `sitedda.movie.animate`."""
        from ..drawing.movie import animate

        return animate(self, **options)

    def view(self, file=None, **options):
        """Write the interactive view to a page, see `sitedda.view.write_view`; return its path."""
        from ..drawing.view import write_view

        return write_view(self, file or Path("view.html"), **options)

    def _repr_html_(self) -> str:
        """Return the verdict for a notebook."""
        from ..report import Facts
        from ..report.html import fragment

        state = "complete" if self.complete else "incomplete"
        head = ("run", f"{self.history.attrs.get('title', '')} ({state})")
        return fragment(Facts([head, *self.verdict.lines]))

    def __repr__(self) -> str:
        """Return title, state and summary in one line."""
        state = "complete" if self.complete else "incomplete"
        return f"<sitedda.Run {self.history.attrs.get('title', '')!r}, {state}: {self.summary}>"
