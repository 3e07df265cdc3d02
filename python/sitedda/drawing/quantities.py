# SPDX-License-Identifier: GPL-3.0-or-later
"""Quantities that colour blocks and joints: names, units, limits of scales, rounding errors."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..output.scene import OWN_QUANTITIES, Scene, principal_stresses

_SHARE = 0.01  # fraction of the area whose values may exceed the usual range of a scale
_FAR = 1.5  # if the largest value is at most this factor times the usual range, the scale is linear
_USUAL = 0.7  # fraction of the colours of each sign that show its usual range
_ROUNDING, _STILL = 100 * np.finfo(float).eps, 1e-9  # fractions as in `dda_rest_bound`
_GRAVITY = 9.81  # m/s²


@dataclass(frozen=True)
class Quantity:
    """A quantity of blocks or joints."""

    name: str  # name in options and in the view
    label: str  # label of the colour bar, without the unit
    unit: str
    signed: bool = False  # whether the colour scale has positive and negative values


_ALL = (Quantity("displacement", "displacement", "m"),
        Quantity("displacement_x", "displacement along x", "m", True),
        Quantity("displacement_y", "displacement along y", "m", True),
        Quantity("velocity", "velocity", "m/s"),
        Quantity("rotation", "rotation, anticlockwise positive", "°", True),
        Quantity("compression", "largest compressive stress", "Pa"),
        Quantity("tension", "largest tensile stress", "Pa"),
        Quantity("stress_error", "stress error of cells", "Pa"),
        Quantity("plastic_strain", "largest plastic strain", "%"),
        Quantity("damage", "largest damage of faces and joints", "%"))  # fmt: skip
QUANTITIES = {one.name: one for one in _ALL}
MOVEMENTS = {
    "slip": Quantity("slip", "slip of the joints", "m"),
    "opening": Quantity("opening", "opening of the joints", "m"),
}
COLORINGS = ("material", *QUANTITIES)
CONTACTS = ("force", "chain", *MOVEMENTS)
ARROWS = ("displacement", "velocity")


def quantity(scene: Scene, name: str, frame: int, since: int = 0) -> np.ndarray:
    """Return a quantity of the blocks, shape (blocks,); displacements are since another frame."""
    if name.startswith("displacement"):
        displacement = scene.displacement(frame) - scene.displacement(since)
        axis = {"x": 0, "y": 1}.get(name[-1] if "_" in name else "")
        return np.linalg.norm(displacement, axis=1) if axis is None else displacement[:, axis]
    if name == "velocity":
        return np.linalg.norm(scene.rates(frame)[:, :2], axis=1)
    if name == "rotation":
        return np.degrees(scene.coordinates(frame)[:, 2] - scene.coordinates(since)[:, 2])
    if name in OWN_QUANTITIES:
        fractions = ("plastic_strain", "damage")
        return scene.own_quantity(name, frame) * (100.0 if name in fractions else 1.0)
    largest, smallest = principal_stresses(scene.stress(frame))
    return -smallest if name == "compression" else largest


@dataclass(frozen=True)
class Limits:
    """Limits of a scale that includes all values, but is coarser above the usual values."""

    low: float
    high: float
    usual: float  # largest usual value, for both signs; equal to `most` if the scale is linear

    @property
    def most(self) -> float:
        """Return the largest absolute value of the scale."""
        return max(abs(self.low), abs(self.high))

    def over(self, size: float) -> "Limits":
        """Return the limits in a unit of a given size."""
        return Limits(self.low / size, self.high / size, self.usual / size)

    @property
    def nodes(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the values between which the scale is linear, and their positions, 0 … 1."""
        inner = (value for value in (-self.usual, 0.0, self.usual) if self.low < value < self.high)
        values = np.array([self.low, *inner, self.high])
        sizes = abs(values)
        excess = (sizes - self.usual) / ((self.most - self.usual) or 1.0)
        linear = sizes / (self.usual or 1.0)
        if self.most > self.usual:
            linear = np.where(sizes > self.usual, _USUAL + (1 - _USUAL) * excess, _USUAL * linear)
        positions = np.sign(values) * linear
        return values, (positions - positions[0]) / (np.ptp(positions) or 1.0)

    def share(self, values) -> np.ndarray:
        """Return the positions of values on the scale, 0 … 1."""
        return np.interp(values, *self.nodes)


def limits(values, weights, signed: bool = False) -> Limits:
    """Return the limits of values; at most 1 % of the area exceeds the usual range.

    This is true for all frames together and for the last frame.

    `values`: shape (frames, things) or (things,); `weights`: areas of the blocks (m²), lengths of
    the joints (m); `signed`: whether the limits are symmetric to 0.
    """
    values = np.atleast_2d(values)
    sizes = np.broadcast_to(weights, values.shape)
    finite = np.isfinite(values)
    if not finite.any():
        return Limits(0.0, 0.0, 0.0)
    flat = values[finite]
    low, high = min(float(flat.min()), 0.0), max(float(flat.max()), 0.0)
    samples = [(abs(flat), sizes[finite]), (abs(values[-1][finite[-1]]), sizes[-1][finite[-1]])]
    usual = max(_usual_limit(x, w) for x, w in samples if x.size)
    if signed:
        high = max(-low, high)
        low = -high
    peak = max(-low, high)
    return Limits(low, high, usual if peak > _FAR * usual > 0 else peak)


def _usual_limit(values, weights) -> float:
    """Return the value that a fraction `_SHARE` of the weights exceeds; at least 0."""
    order = np.argsort(-values)
    sums = np.cumsum(weights[order])
    index = int(np.searchsorted(sums, _SHARE * sums[-1], side="right"))
    return max(float(values[order[min(index, len(order) - 1)]]), 0.0)


def limits_of(scene: Scene, name: str, frames: Sequence[int], since: int = 0) -> Limits:
    """Return the limits of a quantity of the blocks over frames."""
    values = np.stack([quantity(scene, name, frame, since) for frame in frames])
    removed = np.stack([scene.removed(frame) for frame in frames])
    values = np.where(removed, np.nan, values)
    return limits(values, scene.areas(), QUANTITIES[name].signed)


def movement_limits(scene: Scene, name: str, frames: Sequence[int]) -> Limits:
    """Return the limits of slip or opening of the joints over frames."""
    index = list(MOVEMENTS).index(name)
    values = np.stack([np.maximum(scene.joint_movement(f)[index], 0.0) for f in frames])
    faces = scene.interfaces
    return limits(values, np.linalg.norm(faces.end - faces.start, axis=1))


def rounding(scene: Scene) -> dict[str, float]:
    """Return the largest values that are treated as rounding errors, by unit.

    Without a motion, the error of positions is 1e-9 of the size of the model; with a motion, it is
    1e-9 of the largest displacement or 100 times the machine precision, whichever is larger.
    """
    conclusion = str(scene.data.attrs.get("verdict", ""))
    fraction = _STILL
    if scene.groups.get("motion") and "at rest" not in conclusion and scene.size > 0:
        peak = float(scene.data.attrs.get("largest_displacement_m", 0.0))
        fraction = max(_ROUNDING, _STILL * peak / scene.size)
    weight = 0.0
    if "block_density" in scene.data:
        weight = _GRAVITY * float(np.max(scene.data["block_density"].values)) * scene.size
    return {
        "m": fraction * scene.size,
        "m/s": fraction * np.sqrt(_GRAVITY * scene.size),
        "m/s²": fraction * _GRAVITY,
        "°": np.degrees(fraction),
        "%": 100.0 * fraction,
        "Pa": _STILL * weight,
        "N/m": _STILL * weight * scene.size,
    }


def select_frames(frames: Sequence[int], count: int = 40) -> list[int]:
    """Return at most `count` evenly spaced frames, including the first and the last."""
    frames = sorted(set(frames))
    if len(frames) <= count:
        return frames
    return [frames[i] for i in np.linspace(0, len(frames) - 1, count).round().astype(int)]
