# SPDX-License-Identifier: GPL-3.0-or-later
"""Encode the frames of a scene as compressed streams of small whole numbers.

A block needs six numbers per frame: displacement of the centroid (2), rotation and strains (3)
since the first frame.  They are rounded so that the error of each vertex is below 10⁻⁵ of the size
of the model.  Their differences in time are zigzag-coded, split into planes of bytes and deflated.
Browsers can inflate the streams (`DecompressionStream`).
"""

import base64
import zlib
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from ...output.energies import budget
from ...output.scene import Scene, principal_stresses
from ..quantities import rounding

# Rounding steps of displacement, and of displacement by rotation and by strain / model size.
POSITION, ROTATION, STRAIN = 0.6e-5, 0.4e-5, 0.2e-5
_FINE = 32767  # number of steps of a quantity that is stored in 16 bits
_COARSE = 255  # number of colour steps in large models
_PLACES = 101  # number of positions along an edge, including both ends
_LEAST_STEPS = 500  # smallest number of rounding steps of displacements in large models
_SAMPLE = 12  # number of frames from which the total size is estimated
_LEVEL = 6  # level of deflate
_MOST_LINES = 8  # largest number of curves of a chart
NOT_FULL = 2  # state of a water channel that is not full


@dataclass
class Encoded:
    """Streams by name, and the data that describe them."""

    meta: dict = field(default_factory=dict)  # plain values for JSON
    streams: dict[str, str] = field(default_factory=dict)  # deflated bytes, base64

    def put(self, name: str, data: bytes) -> None:
        """Add a stream."""
        self.streams[name] = base64.b64encode(data).decode("ascii")

    def put_array(self, name: str, values, kind: str) -> None:
        """Add an array of a little-endian type, such as ``'<f4'``."""
        kind = np.dtype(kind)
        if kind.kind == "f":  # infinite positions of lost blocks become the largest number
            values = np.clip(values, -np.finfo(kind).max, np.finfo(kind).max)
        self.put(name, zlib.compress(np.ascontiguousarray(values, dtype=kind).tobytes(), _LEVEL))

    @property
    def size(self) -> int:
        """Return the number of characters of all streams."""
        return sum(map(len, self.streams.values()))


@dataclass
class Channel:
    """A quantity of many objects over all frames, with its rounding."""

    name: str
    values: np.ndarray  # shape (frames, things)
    quantum: float  # rounding step of the values, or of their roots
    root: bool = False  # whether signed square roots are stored, which resolve small values better

    @classmethod
    def rooted(cls, name: str, values: np.ndarray, steps: int) -> "Channel":
        """Return a channel of square roots that are rounded to `steps` steps."""
        quantum = float(np.sqrt(abs(values).max(initial=0.0))) / steps or 1.0
        return cls(name, values, quantum, True)

    @property
    def whole(self) -> np.ndarray:
        """Return the values (or roots) as numbers of quanta."""
        values = self.values
        if self.root:
            values = np.sign(values) * np.sqrt(abs(values))
        return np.rint(values / self.quantum).astype(np.int32)


def planes(steps: np.ndarray) -> tuple[bytes, int]:
    """Return whole numbers (frames, objects), zigzag-coded, as byte planes, and their count."""
    zigzag = ((steps << 1) ^ (steps >> 31)).astype("<u4")
    width = max(1, (int(zigzag.max(initial=0)).bit_length() + 7) // 8)
    split = zigzag.view(np.uint8).reshape(*zigzag.shape, 4)[..., :width]
    return np.ascontiguousarray(np.moveaxis(split, -1, 1)).tobytes(), width


def encode(scene: Scene, budget: int) -> Encoded:
    """Encode a scene for the view, within a limit of characters.

    If the data exceed the limit, colours become coarse, then frames are omitted at even intervals.
    Contact forces are omitted if they exceed the remaining space.
    """
    result = Encoded()
    _add_model(result, scene)
    room = budget - result.size
    reduced = _estimate_size(scene, reduced=False) * scene.frames > 0.7 * room
    cost = _estimate_size(scene, reduced)
    count = scene.frames if cost * scene.frames < room else max(2, int(0.95 * room / cost))
    while True:
        frames = np.unique(np.linspace(0, scene.frames - 1, count).round().astype(int))
        streams = Encoded()
        _add_channels(streams, motion_channels(scene, frames, reduced), "channels")
        if streams.size <= room or count <= 2:
            break
        count = max(2, int(0.93 * count * room / streams.size))
    result.meta |= streams.meta
    result.streams |= streams.streams
    result.meta |= {
        "time": [float(scene.time[f]) for f in frames],
        "all_frames": scene.frames,
        "base": np.round(scene.base[frames], 12).tolist(),
        "coarse": bool(reduced),
        "removals": _find_removals(scene, frames),
        "stages": [[name, begin] for name, begin in scene.stage_starts()],
        "stage_frames": _stage_frames(scene, frames),
        "loops": bool(scene.data.attrs.get("loops", False)),
    }
    _add_bolts_and_water(result, scene, frames)
    _add_contacts(result, scene, frames, budget - result.size)
    return result


def _stage_frames(scene: Scene, frames: np.ndarray) -> list[list]:
    """Return the name of each stage and the index of its last frame."""
    names = str(scene.data.attrs.get("stages", "")).split("\n")
    if "frame_stage" not in scene.data or len(names) < 2:
        return []
    number = scene.data["frame_stage"].values[frames].astype(int)
    end_frames = {int(n): i for i, n in enumerate(number) if 0 < n <= len(names)}
    return [[names[n - 1], i] for n, i in end_frames.items()]


def _find_removals(scene: Scene, frames: np.ndarray) -> list[list[int]]:
    """Return each removed block and the index of the first frame without it."""
    if not scene.removed(scene.frames - 1).any():
        return []
    removed = np.stack([scene.removed(f) for f in frames])
    return [[int(b), int(np.argmax(removed[:, b]))] for b in np.flatnonzero(removed.any(axis=0))]


def _add_model(result: Encoded, scene: Scene) -> None:
    """Add shapes and names, which do not change with time."""
    start = scene.coordinates(0)
    low, high = scene.box
    origin = 0.5 * (low + high)
    result.meta |= {
        "blocks": scene.blocks,
        "origin": origin.tolist(),
        "box": [*(low - origin).tolist(), *(high - origin).tolist()],
        "size": scene.size,
        "materials": list(scene.material_names),
    }
    result.put_array("start", np.hstack([start[:, :2] - origin, start[:, 2:]]), "<f4")
    result.put_array("offsets", scene.offsets(scene.owner, scene.vertices(0)), "<f4")
    result.put_array("counts", np.diff(scene.first), "<u2")
    result.put_array("material", scene.material, "<u1" if scene.material.max() < 256 else "<u2")
    names = "\n".join(" ".join(name.split("\n")) for name in scene.names)
    result.put("names", zlib.compress(names.encode("utf-8", "replace"), _LEVEL))
    faces = scene.interfaces
    result.put_array("face_blocks", np.column_stack([faces.first, faces.second]), "<i4")
    ends = np.hstack([faces.start - origin, faces.end - origin, faces.normal])
    result.put_array("face_ends", ends, "<f4")
    result.meta["faces"] = len(faces)


def motion_channels(scene: Scene, frames: np.ndarray, reduced: bool) -> list[Channel]:
    """Return displacements, rotations, strains, speeds and stresses of blocks as channels."""
    start = scene.coordinates(0)
    change = np.stack([scene.coordinates(f) for f in frames]) - start
    _stop_lost_blocks(change, scene)
    offsets = scene.offsets(scene.owner, scene.vertices(0))
    reach = float(np.sqrt((offsets**2).sum(axis=1).max()))
    quanta = (POSITION, ROTATION / reach, STRAIN / reach)
    names = ("u", "v", "turn", "ex", "ey", "gxy")
    channels = []
    for k, name in enumerate(names):
        quantum = quanta[0 if k < 2 else 1 if k == 2 else 2] * scene.size
        largest = float(abs(change[..., k]).max())
        steps = _LEAST_STEPS if reduced and k < 3 else 0 if reduced else _FINE
        if steps and largest:
            quantum = min(quantum, largest / steps)
        channels.append(Channel(name, change[..., k], quantum))
    speed = np.stack([np.hypot(*scene.rates(f)[:, :2].T) for f in frames])
    stress = np.stack([scene.stress(f) for f in frames])
    if reduced:
        colors = {"speed": speed, "compression": -principal_stresses(stress)[1]}
    else:
        parts = (stress[..., k] for k in range(3))
        colors = {"speed": speed} | dict(zip(("sx", "sy", "txy"), parts, strict=True))
    for name in scene.own_quantities:
        colors[name] = np.stack([scene.own_quantity(name, f) for f in frames])
    steps = _COARSE if reduced else _FINE
    return channels + [Channel.rooted(name, values, steps) for name, values in colors.items()]


def _stop_lost_blocks(change: np.ndarray, scene: Scene) -> None:
    """Fix each lost block at its last position within reach of the first view."""
    low, high = scene.box
    reach = 2.0 * scene.size
    centre = scene.coordinates(0)[:, :2] - 0.5 * (low + high)
    outside = np.any(abs(change[..., :2] + centre) > reach, axis=2)
    for block in np.flatnonzero(outside.any(axis=0)):
        loss = int(np.argmax(outside[:, block]))
        change[loss:, block] = change[max(loss - 1, 0), block]


def _add_channels(result: Encoded, channels: list[Channel], key: str) -> None:
    """Add the streams of channels, and their description under a key."""
    described = []
    for channel in channels:
        integers = channel.whole
        data, width = planes(np.diff(integers, axis=0, prepend=np.zeros_like(integers[:1])))
        result.put(channel.name, zlib.compress(data, _LEVEL))
        needs_32_bits = bool(abs(integers).max(initial=0) > np.iinfo(np.int16).max)
        description = {"name": channel.name, "quantum": channel.quantum, "root": channel.root}
        described.append(description | {"bytes": width, "wide": needs_32_bits})
    result.meta[key] = described


def _estimate_size(scene: Scene, reduced: bool) -> float:
    """Estimate the characters per frame from consecutive frames in the middle of the run."""
    begin = max(0, (scene.frames - _SAMPLE) // 2)
    frames = np.arange(begin, min(scene.frames, begin + _SAMPLE))
    total = 0
    for channel in motion_channels(scene, frames, reduced):
        integers = channel.whole
        steps = np.diff(integers, axis=0) if len(frames) > 1 else integers
        total += len(zlib.compress(planes(steps)[0], _LEVEL))
    return 4 / 3 * total / max(1, len(frames) - 1)


def _add_bolts_and_water(result: Encoded, scene: Scene, frames: np.ndarray) -> None:
    """Add the bolts and the water channels, with their values and states in the frames."""
    bolts = scene.bolt_routes()
    water = [(np.repeat(block, 2), ends) for block, ends in zip(*scene.water_lines, strict=True)]
    result.meta["lines"] = {}
    for kind, routes, reader in (
        ("bolts", [route[1:] for route in bolts], partial(_bolt_forces, scene, bolts)),
        ("water", water, partial(_water_pressures, scene)),
    ):
        if not routes:
            continue
        result.meta["lines"][kind] = [
            {"blocks": blocks.tolist(), "offsets": scene.offsets(blocks, points).ravel().tolist()}
            for blocks, points in routes
        ]
        size, state = np.stack([reader(frame) for frame in frames]).swapaxes(0, 1)
        of_size = Channel.rooted(f"{kind}_size", size, _FINE)
        _add_channels(result, [of_size, Channel(f"{kind}_state", state, 1.0)], f"{kind}_channels")


def _bolt_forces(scene: Scene, routes: list, frame: int) -> np.ndarray:
    """Return forces (N/m) and states of the bolts, shape (2, bolts)."""
    bolts_by_name = {bolt["name"]: bolt for bolt in scene.bolts(frame)}
    no_bolt = {"force": 0.0, "state": 0}
    bolts = [bolts_by_name.get(name, no_bolt) for name, _, _ in routes]
    return np.array([[np.nan_to_num(b["force"]) for b in bolts], [b["state"] for b in bolts]])


def _water_pressures(scene: Scene, frame: int) -> np.ndarray:
    """Return pressures (Pa) and states of water channels, shape (2, channels)."""
    pressure, saturated, _ = scene.water(frame)
    return np.array([np.clip(pressure, 0, None), np.where(saturated, 1, NOT_FULL)])


def _add_contacts(result: Encoded, scene: Scene, frames: np.ndarray, budget: int) -> None:
    """Add forces of contacts that close in a frame; none if they exceed `budget` characters.

    A contact is a vertex, an edge, and the position of the contact point in hundredths of the edge
    that begins at the vertex.
    """
    frame_contacts = [scene.contacts(f) for f in frames]
    vertices = len(scene.owner)
    keys, masks = [], []
    for contacts in frame_contacts:
        mask = contacts["normal_force"] > 0
        pair = contacts["vertex"][mask].astype(np.int64) * vertices + contacts["edge"][mask]
        position = contacts["place"][mask] if "place" in contacts else np.zeros(len(pair))
        keys.append(_PLACES * pair + np.rint((_PLACES - 1) * position).astype(np.int64))
        masks.append(mask)
    pairs = np.unique(np.concatenate(keys)) if keys else np.zeros(0, dtype=np.int64)
    result.meta["pairs"] = 0
    if len(pairs) == 0:
        return
    # Each pair and frame needs two bytes before deflation; the factor 3 is an optimistic ratio of
    # deflation.
    too_long = "Contact forces are omitted to limit the size of the page."
    if len(pairs) * len(frames) > 3 * budget:
        result.meta["no_forces"] = too_long
        return
    normal = np.zeros((len(frames), len(pairs)), dtype=np.float32)
    shear = np.zeros_like(normal)
    for i, (contacts, key, mask) in enumerate(zip(frame_contacts, keys, masks, strict=True)):
        columns = np.searchsorted(pairs, key)
        normal[i, columns] = contacts["normal_force"][mask]
        shear[i, columns] = contacts["shear_force"][mask]
    largest = float(normal.max())
    streams = Encoded()
    parts = (("normal", normal), ("shear", shear))
    forces = [Channel.rooted(name, values, _COARSE) for name, values in parts]
    _add_channels(streams, forces, "force_channels")
    pair, position = np.divmod(pairs, _PLACES)
    positions = np.column_stack([*np.divmod(pair, vertices), position])
    streams.put_array("pairs", positions, "<i4")
    if streams.size > budget:
        result.meta["no_forces"] = too_long
        return
    result.meta |= streams.meta | {"pairs": len(pairs), "largest_force": largest}
    result.streams |= streams.streams


def encode_histories(result: Encoded, scene: Scene, count: int = 1500) -> None:
    """Add the charts of histories: displacements and accelerations of points, energies."""
    data = scene.data
    if scene.before or data.sizes.get("time", 0) < 3:
        result.meta["charts"] = []
        return
    time = data["time"].values
    charts, floors = [], rounding(scene)
    from_base = scene.base_history
    moving = [(i, point["name"]) for i, point in enumerate(scene.points())
              if np.any(abs(data.displacement.values[:, i] - from_base) > floors["m"])]  # fmt: skip
    bases = {"displacement": ("m", from_base), "acceleration": ("m/s²", 0 * from_base)}
    for name, (unit, base) in bases.items():
        lines = {f"{point}, {'xy'[axis]}": data[name].values[:, i, axis] - base[:, axis]
                 for i, point in moving for axis in (0, 1)}  # fmt: skip
        lines = {label: y for label, y in lines.items() if np.any(abs(y) > floors[unit])}
        lines = dict(list(lines.items())[:_MOST_LINES])
        suffix = f", {scene.origin}" if scene.origin and name == "displacement" else ""
        charts.append((f"{name} of the measured points{suffix}", unit, lines))
    energies = budget(data)
    parts = energies.parts if energies.given.any() else {}
    charts.append(("energies, stacked curves", "J/m", parts))
    if parts:
        charts.append(("residual of the energy audit", "J/m", {"residual": energies.residual}))
    result.meta["charts"] = []
    for title, unit, lines in charts:
        if not lines:
            continue
        described, stacked = [], title.endswith("stacked")
        for label, values in lines.items():
            stream = f"line{len(result.streams)}"
            outline = np.sum(list(lines.values()), axis=0) if stacked else values
            samples = thin_samples(outline, count)
            result.put_array(stream, np.concatenate([time[samples], values[samples]]), "<f4")
            described.append({"label": label, "stream": stream, "samples": len(samples)})
        chart = {"title": title, "unit": unit, "lines": described, "stacked": stacked}
        result.meta["charts"].append(chart)


def thin_samples(values: np.ndarray, count: int) -> np.ndarray:
    """Return the indices of first, smallest and largest sample in count/3 bins, and the last."""
    n = len(values)
    if n <= count:
        return np.arange(n)
    edges = np.linspace(0, n, count // 3 + 1).astype(int)
    indices = {0, n - 1}
    for a, b in zip(edges[:-1], edges[1:], strict=True):
        indices |= {int(a), a + int(np.argmin(values[a:b])), a + int(np.argmax(values[a:b]))}
    return np.array(sorted(indices))
