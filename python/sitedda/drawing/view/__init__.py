# SPDX-License-Identifier: GPL-3.0-or-later
"""The interactive view of blocks: a part of a report, or a page of its own.

One HTML file without any library: WebGL 2, the browser's own inflation of streams, Canvas 2D where
WebGL is refused.
"""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import numpy as np
from matplotlib import colormaps

from ...output.scene import Scene
from ...report import Page, View, provenance, write_html
from ...report.style import BOLT, JOINT_MAP, MAGNITUDE, RESTING, SIGNED, STONES
from ..forces import force_scale
from ..pictures import BROKEN
from ..quantities import MOVEMENTS, QUANTITIES, limits_of, movement_limits, rounding, some_of
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
    color : str, optional
        What it shows first, see `pictures.draw`.
    """
    scene = source if isinstance(source, Scene) else Scene.of(source)
    found = encoded(scene, budget - _REST)
    encode_histories(found, scene)
    meta = found.meta | {
        "color": color or ("material" if scene.frames < 2 else "displacement"),
        "stones": list(STONES),
        "resting": RESTING,
        "bolt": {"color": BOLT, "broken": BROKEN},
        "maps": {
            "magnitude": _stops(colormaps[MAGNITUDE]),
            "signed": _stops(colormaps[SIGNED]),
            "joint": _stops(JOINT_MAP),
        },
    }
    return View(meta | _scales(scene), found.streams)


def _scales(scene: Scene) -> dict:
    """Quantities, their limits over all frames, and what is no more than rounding."""
    frames = some_of(range(scene.frames)) if not scene.before else []
    found = {}
    if frames:
        found = {name: asdict(limits_of(scene, name, frames)) for name in QUANTITIES}
        found |= {name: asdict(movement_limits(scene, name, frames)) for name in MOVEMENTS}
    return {
        "quantities": [asdict(one) for one in QUANTITIES.values()],
        "movements": [asdict(one) for one in MOVEMENTS.values()],
        "ranges": found,
        "floors": rounding(scene),
        "force": force_scale(scene, frames) if frames else 0.0,
    }


def _stops(shades) -> list[list[int]]:
    """A colour map as steps of red, green, blue."""
    return (255 * shades(np.linspace(0, 1, _STOPS))[:, :3]).round().astype(int).tolist()


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
