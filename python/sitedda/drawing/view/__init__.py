# SPDX-License-Identifier: GPL-3.0-or-later
"""The interactive view of blocks: a part of a report, or a page of its own.

One HTML file without any library: WebGL 2, the browser's own inflation of streams, Canvas 2D where
WebGL is refused.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib import colormaps

from ...output.scene import Scene
from ...report import Page, View, provenance, write_html
from ..pictures import BOLT, BROKEN, MAGNITUDE, SIGNED, STONES
from .encode import encode as encoded
from .encode import encode_histories

BUDGET = 25_000_000  # bytes of a page
_REST = 600_000  # of them for everything but frames and forces
_STOPS = 33  # of a colour map


def view(source, budget: int = BUDGET, color: str | None = None) -> View:
    """The view of an input or an output as a part of a page.

    Parameters
    ----------
    source : path, Run, Simulation, xarray.Dataset or Scene
    budget : int
        Bytes that it may take: frames are thinned, and the page says so.
    color : {'material', 'displacement', 'velocity', 'rotation', 'stress'}, optional
        What it shows first.
    """
    scene = source if isinstance(source, Scene) else Scene.of(source)
    found = encoded(scene, budget - _REST)
    encode_histories(found, scene)
    meta = found.meta | {
        "color": color or ("material" if scene.frames < 2 else "displacement"),
        "stones": list(STONES),
        "bolt": {"color": BOLT, "broken": BROKEN},
        "maps": {
            "magnitude": _stops(MAGNITUDE),
            "signed": _stops(SIGNED),
            "joint": _stops("inferno_r"),
        },
    }
    return View(meta, found.streams)


def _stops(name: str) -> list[list[int]]:
    """A colour map as steps of red, green, blue."""
    colors = colormaps[name](np.linspace(0, 1, _STOPS))[:, :3]
    return (255 * colors).round().astype(int).tolist()


def write_view(source, file, budget: int = BUDGET, color: str | None = None) -> Path:
    """Write a page that holds the view alone.

    Parameters
    ----------
    source : path, Run, Simulation, xarray.Dataset or Scene
    file : path
        The page.
    budget : int
        Bytes.
    color : str, optional
        See `view`.
    """
    scene = source if isinstance(source, Scene) else Scene.of(source)
    page = Page(scene.title or "Blocks")
    page.add("Blocks", view(scene, budget, color))
    page.provenance = provenance(
        input=str(scene.data.attrs.get("input_file", "")),
        computed_by=str(scene.data.attrs.get("source", "")),
    )
    return write_html(page, file)
