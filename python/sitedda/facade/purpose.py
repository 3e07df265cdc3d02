# SPDX-License-Identifier: GPL-3.0-or-later
"""The purpose of a run, which determines its picture."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from ..drawing.quantities import movement_limits
from ..output.response import Amplification, amplifications
from ..output.scene import Scene
from ..site.surface import Surface, surface

if TYPE_CHECKING:
    import xarray as xr

LEAST_DRAWN = 1e-6  # smallest drawn displacement / size of the model, in runs without motions
_SURFACE = 4  # smallest number of points for a picture of the amplification along the surface


class Purpose(NamedTuple):
    """Purpose of a run ('site', 'surface', 'shake' or 'forces'), and its amplification, if any."""

    kind: str
    scene: Scene
    of: Amplification | Surface | None = None


def purpose_of(source: xr.Dataset | Scene) -> Purpose:
    """Return the purpose of a run, from its output."""
    scene = source if isinstance(source, Scene) else Scene.of(source)
    if scene.groups.get("amplification"):
        try:
            return Purpose("site", scene, amplifications(scene.data)[0])
        except (AttributeError, KeyError, ValueError):  # no amplification: the points do not move
            return Purpose("site", scene)
    if axis := _surface_of_run(scene):
        return Purpose("surface", scene, axis)
    groups = scene.groups
    moving = any(group["moved"] for group in scene.supports() + scene.boundaries(0))
    base = any(name.startswith("base") for name in groups.get("control", [{}])[0])
    dynamic = float(scene.data.time[-1]) > float(scene.data.time[0])
    shaken = (moving or base or groups.get("motion")) and dynamic
    return Purpose("shake" if shaken else "forces", scene)


def _surface_of_run(scene: Scene) -> Surface | None:
    """Return the amplification along the surface; None if points are few or joints slip."""
    if movement_limits(scene, "slip", [scene.frames - 1]).high > LEAST_DRAWN * scene.size:
        return None
    time = scene.data.time.values
    if len(time) < 3 or time[1] == time[0]:  # two static stages end at one time
        return None
    band = max(0.5, 2 / float(time[-1] - time[0])), min(15.0, 0.25 / float(time[1] - time[0]))
    try:
        result = surface(scene.data, lowest=band[0], highest=band[1])
    except ValueError:
        return None
    return result if len(result.names) >= _SURFACE else None
