# SPDX-License-Identifier: GPL-3.0-or-later
"""The interactive view of blocks, as part of a report or as a separate page.

A single HTML file without libraries: WebGL 2, decompression by the browser, and Canvas 2D if WebGL
is not available.
"""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
from matplotlib import colormaps

from ...base.errors import InputError
from ...output.scene import OWN_QUANTITIES, Scene
from ...report import Page, View, provenance, write_html
from ...report.page import Part
from ...report.style import BOLT, JOINT_MAP, MAGNITUDE, RESTING, SIGNED, STONES, WATER
from ..forces import force_scale
from ..pictures import BROKEN
from ..quantities import MOVEMENTS, QUANTITIES, limits_of, movement_limits, rounding, select_frames
from .encode import NOT_FULL, encode_histories
from .encode import encode as encoded

BUDGET = 25_000_000  # largest size of a page, bytes
_REST = 600_000  # bytes reserved for all content except frames and forces
_STOPS = 33  # number of colours of a colour map


def view(source, budget: int = BUDGET, color: str | None = None) -> View:
    """Return the view of an input or an output as a part of a page.

    `budget`: largest size in bytes; if necessary, frames are omitted, and the page states this;
    `color`: quantity of the initial colours, see `pictures.draw`.
    """
    scene = Scene.of(source)
    encoding = encoded(scene, budget - _REST)
    encode_histories(encoding, scene)
    bolts = {"color": BOLT, "dashed": BROKEN, "words": "bolt, largest force", "unit": "N/m"}
    water = {"color": WATER, "dashed": NOT_FULL, "words": "water in joints, largest pressure",
             "unit": "Pa"}  # fmt: skip
    maps = {"magnitude": colormaps[MAGNITUDE], "signed": colormaps[SIGNED], "joint": JOINT_MAP}
    meta = encoding.meta | {
        "color": color or ("material" if scene.frames < 2 else "displacement"),
        "stones": list(STONES),
        "resting": RESTING,
        "line_styles": {"bolts": bolts, "water": water},
        "maps": {name: _color_stops(colors) for name, colors in maps.items()},
    }
    return View(meta | _find_scales(scene), encoding.streams)


def _find_scales(scene: Scene) -> dict:
    """Return quantities, limits over all frames, rounding errors and the force scale."""
    frames = select_frames(range(scene.frames)) if not scene.before else []
    unavailable = set(OWN_QUANTITIES) - set(scene.own_quantities)
    available = [item for item in QUANTITIES.values() if item.name not in unavailable]
    spans = {}
    if frames:
        spans = {item.name: asdict(limits_of(scene, item.name, frames)) for item in available}
        spans |= {name: asdict(movement_limits(scene, name, frames)) for name in MOVEMENTS}
    return {
        "quantities": [asdict(item) for item in available],
        "movements": [asdict(item) for item in MOVEMENTS.values()],
        "ranges": spans,
        "floors": rounding(scene),
        "force": force_scale(scene, frames) if frames else 0.0,
    }


def names_of(*scenes: Scene) -> list[str]:
    """Return distinct names of scenes: titles, or file names of inputs."""
    titles = [scene.title for scene in scenes]
    if len(set(titles)) == len(titles):
        return titles
    return [f"{'ab'[i]}: {scene.data.encoding.get('source', title)}".rpartition("/")[2]
            for i, (scene, title) in enumerate(zip(scenes, titles, strict=True))]  # fmt: skip


def check_alike(first: Scene, second: Scene) -> None:
    """Raise InputError for two scenes whose difference is meaningless."""
    if first.names != second.names:
        pairs = zip(first.names, second.names, strict=False)
        mismatch = next((pair for pair in pairs if pair[0] != pair[1]), None)
        reason = f"{mismatch[0]!r} is not {mismatch[1]!r}" if mismatch else "one has more"
        raise InputError(f"runs of {first.blocks} and {second.blocks} blocks have no difference: "
                         f"{reason}; show them side by side")  # fmt: skip
    if first.frames != second.frames or not np.allclose(first.time, second.time, rtol=1e-9):
        raise InputError(f"runs have no difference if times differ: {first.frames} frames up to "
                         f"{first.time[-1]:g} s, {second.frames} frames up to "
                         f"{second.time[-1]:g} s; show them side by side")  # fmt: skip


def _color_stops(shades) -> list[list[int]]:
    """Return `_STOPS` colours of a colour map as red, green and blue, 0 … 255."""
    return (255 * shades(np.linspace(0, 1, _STOPS))[:, :3]).round().astype(int).tolist()


def write_view(source, file, **options) -> Path:
    """Write a page with one view, or two views with a common cursor, see `view_page`."""
    return write_html(view_page(source, **options), file)


def view_page(
    source,
    budget: int = BUDGET,
    color: str | None = None,
    other=None,
    difference=False,
    below: Sequence[Part] = (),
    absolute: bool = False,
) -> Page:
    """Return a page with one view, or two views with a common cursor.

    `budget`: largest size of the page, bytes.
    `color`: see `view`.
    `other`: second run, shown beside the first.
    `difference`: whether to colour the first run by its values minus the values of the second.
    `below`: text below the blocks.
    `absolute`: see `pictures.draw`.
    """
    scene = Scene.of(source, absolute)
    page = Page(scene.title or "Blocks")
    first = view(scene, budget if other is None else budget // 2, color)
    if other is None:
        page.add("Blocks", first, *below)
    else:
        second = Scene.of(other, absolute)
        if difference:
            check_alike(scene, second)
        partner = view(second, budget // 2, color)
        first.meta["pair"] = "difference" if difference else "beside"
        first.meta["name"], partner.meta["name"] = names_of(scene, second)
        page.add("Two runs", first, partner)
    page.provenance = provenance(
        input=str(scene.data.attrs.get("input_file", "")),
        computed_by=str(scene.data.attrs.get("source", "")),
    )
    return page
