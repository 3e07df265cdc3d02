# SPDX-License-Identifier: GPL-3.0-or-later
"""What blocks, joints and forces are coloured and scaled by: names, units, limits, and rounding."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..output.scene import OWN_QUANTITIES, Scene, principal_stresses

_SHARE = 0.01  # of the area: what the colours may leave beyond their ends
_FAR = 1.5  # times the limit by area: nearer values are within the scale
_ROUNDING, _STILL = 100 * np.finfo(float).eps, 1e-9  # shares, as in `dda_rest_bound`
_GRAVITY = 9.81  # m/s²


@dataclass(frozen=True)
class Quantity:
    """A quantity of blocks or joints.

    Attributes
    ----------
    name : str
        Of the option that asks for it, and in the view.
    label : str
        At its colour bar, without the unit.
    unit : str
    signed : bool
        Its colours are those of both signs.
    """

    name: str
    label: str
    unit: str
    signed: bool = False


_ALL = (
    Quantity("displacement", "displacement", "m"),
    Quantity("displacement_x", "displacement along x", "m", True),
    Quantity("displacement_y", "displacement along y", "m", True),
    Quantity("velocity", "velocity", "m/s"),
    Quantity("rotation", "rotation, anticlockwise +", "°", True),
    Quantity("compression", "largest compression", "Pa"),
    Quantity("tension", "largest tension", "Pa"),
    Quantity("stress_error", "error of the stress of cells", "Pa"),
    Quantity("plastic_strain", "largest plastic strain", "%"),
    Quantity("damage", "largest damage of faces and joints", "%"),
)
QUANTITIES = {one.name: one for one in _ALL}
MOVEMENTS = {
    "slip": Quantity("slip", "slip of the joints", "m"),
    "opening": Quantity("opening", "opening of the joints", "m"),
}
COLORINGS = ("material", *QUANTITIES)
CONTACTS = ("force", "chain", *MOVEMENTS)
ARROWS = ("displacement", "velocity")


def quantity(scene: Scene, name: str, frame: int, since: int = 0) -> np.ndarray:
    """A quantity of the blocks in its unit, shape (blocks,); of movements since another frame."""
    if name.startswith("displacement"):
        moved = scene.displacement(frame) - scene.displacement(since)
        axis = {"x": 0, "y": 1}.get(name[-1] if "_" in name else "")
        return np.linalg.norm(moved, axis=1) if axis is None else moved[:, axis]
    if name == "velocity":
        return np.linalg.norm(scene.rates(frame)[:, :2], axis=1)
    if name == "rotation":
        return np.degrees(scene.coordinates(frame)[:, 2] - scene.coordinates(since)[:, 2])
    if name in OWN_QUANTITIES:
        shares = ("plastic_strain", "damage")
        return scene.own_quantity(name, frame) * (100.0 if name in shares else 1.0)
    largest, smallest = principal_stresses(scene.stress(frame))
    return -smallest if name == "compression" else largest


@dataclass(frozen=True)
class Limits:
    """What a scale spans.

    Attributes
    ----------
    low, high : float
    below, above : bool
        There are values beyond its ends.
    """

    low: float
    high: float
    below: bool = False
    above: bool = False

    @property
    def extend(self) -> str:
        """The ends of the bar with an arrow, in words of matplotlib."""
        return {(0, 0): "neither", (1, 0): "min", (0, 1): "max"}.get(
            (self.below, self.above), "both"
        )

    @property
    def most(self) -> float:
        """The larger end by size."""
        return max(abs(self.low), abs(self.high))


def limits(values, weights, signed: bool = False) -> Limits:
    """Limits that leave at most 1 % of the area beyond them, and that only if it is far beyond.

    They leave so little of all frames and of the last one, which the others lead to.

    Parameters
    ----------
    values : ndarray, shape (frames, things) or (things,)
    weights : ndarray, shape (things,)
        Areas of the blocks (m²), lengths of the joints (m).
    signed : bool
        The same limit for both signs.
    """
    values = np.atleast_2d(values)
    sizes = np.broadcast_to(weights, values.shape)
    known = np.isfinite(values)
    if not known.any():
        return Limits(0.0, 0.0)
    flat = values[known]
    taken = [(flat, sizes[known]), (values[-1][known[-1]], sizes[-1][known[-1]])]
    low = -max(_usual_end(-x, w) for x, w in taken if x.size)
    high = max(_usual_end(x, w) for x, w in taken if x.size)
    if signed:
        high = max(-low, high)
        low = -high
    return Limits(low, high, bool(flat.min() < low), bool(flat.max() > high))


def _usual_end(values, weights) -> float:
    """The upper limit of values with weights, 0 or more."""
    order = np.argsort(-values)
    beyond = np.cumsum(weights[order])
    at = int(np.searchsorted(beyond, _SHARE * beyond[-1], side="right"))
    usual, most = (max(float(values[order[i]]), 0.0) for i in (min(at, len(order) - 1), 0))
    return usual if most > _FAR * usual and usual > 0 else most


def limits_of(scene: Scene, name: str, frames: Sequence[int], since: int = 0) -> Limits:
    """Limits of a quantity of the blocks over frames."""
    values = np.stack([quantity(scene, name, frame, since) for frame in frames])
    gone = np.stack([scene.removed(frame) for frame in frames])
    values = np.where(gone, np.nan, values)
    return limits(values, scene.areas(), QUANTITIES[name].signed)


def movement_limits(scene: Scene, name: str, frames: Sequence[int]) -> Limits:
    """Limits of slip or opening of the joints over frames."""
    which = list(MOVEMENTS).index(name)
    values = np.stack([np.maximum(scene.joint_movement(f)[which], 0.0) for f in frames])
    faces = scene.interfaces
    return limits(values, np.linalg.norm(faces.end - faces.start, axis=1))


def rounding(scene: Scene) -> dict[str, float]:
    """Values that are no more than rounding, by unit.

    Without a motion, places are sure to 1e-9 of the model's size; with one, to that share of what
    has moved, or to the rounding of places.
    """
    said = str(scene.data.attrs.get("verdict", ""))
    share = _STILL
    if scene.groups.get("motion") and "at rest" not in said and scene.size > 0:
        moved = float(scene.data.attrs.get("largest_displacement_m", 0.0))
        share = max(_ROUNDING, _STILL * moved / scene.size)
    weight = 0.0
    if "block_density" in scene.data:
        weight = _GRAVITY * float(np.max(scene.data["block_density"].values)) * scene.size
    return {
        "m": share * scene.size,
        "m/s": share * np.sqrt(_GRAVITY * scene.size),
        "m/s²": share * _GRAVITY,
        "°": np.degrees(share),
        "%": 100.0 * share,
        "Pa": _STILL * weight,
        "N/m": _STILL * weight * scene.size,
    }


def some_of(frames: Sequence[int], most: int = 40) -> list[int]:
    """Frames that stand for many, the first and the last among them."""
    frames = sorted(set(frames))
    if len(frames) <= most:
        return frames
    return [frames[i] for i in np.linspace(0, len(frames) - 1, most).round().astype(int)]
