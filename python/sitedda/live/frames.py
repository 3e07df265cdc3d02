# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of a run as messages; they are stored for pages that open later."""

import numpy as np

from ..drawing.view.encode import NOT_FULL
from ..engine.simulation import Simulation
from .drawn import pack_message

_BYTES = 128_000_000  # largest total size of the stored frames
_CONTACTS = 40_000  # number of contacts above which a frame has no contact forces
_ENERGIES = ("kinetic", "strain", "contact", "input", "friction", "balance")


def frame_message(simulation: Simulation, start: np.ndarray) -> bytes:
    """Return the present state of a run as a message.

    `start`: reference of the block coordinates: positions (m) and rotations in the first frame of
    the output, strains in the drawing.

    Notes
    -----
    ``blocks``: ten quantities, each for all blocks (float32): displacement (2, m), rotation (rad)
    and strains (3) since the start, speed (m/s), stresses (3, Pa).  ``base``: displacement of the
    base (m), which the page subtracts.  ``pairs``: vertex, edge, and position on this edge in
    hundredths of its length (int32) per closed contact.  ``forces``: normal and shear force of
    this contact (float32, N/m).  ``bolts``: force (N/m) and state of each bolt (float32).
    ``water``: pressure (Pa) and state of each channel (float32).
    """
    coordinates, rates, stresses = simulation.block_states
    speed = np.hypot(rates[:, 0], rates[:, 1])
    blocks = np.vstack([(coordinates - start).T, speed[None], stresses.T]).astype("<f4")
    streams = {"blocks": blocks.tobytes()} | _contact_streams(simulation)
    bolts = simulation.bolts
    force = np.hypot(bolts["force"], bolts["shear_force"])
    streams["bolts"] = np.column_stack([force, bolts["state"]]).astype("<f4").tobytes()
    water = simulation.water
    pressure = np.clip(water["pressure"].mean(1), 0, None)
    state = np.where(water["saturation"].min(1) >= 1, 1, NOT_FULL)
    streams["water"] = np.column_stack([pressure, state]).astype("<f4").tobytes()
    energies = simulation.energies
    header = {"kind": "frame", "time": simulation.time, "step": simulation.steps,
              "removed": np.flatnonzero(simulation.removed_blocks).tolist(),
              "base": simulation.base_displacement.tolist(),
              "moved": simulation.point_motions[0].round(12).ravel().tolist(),
              "energies": {name: energies[name] for name in _ENERGIES}}  # fmt: skip
    return pack_message(header, streams)


def _contact_streams(simulation: Simulation) -> dict[str, bytes]:
    """Return ``pairs`` and ``forces`` of the closed contacts; nothing if there are too many."""
    contacts = simulation.closed_contacts
    if len(contacts) > _CONTACTS:
        return {}
    contacts[:, 2] = np.rint(100 * contacts[:, 2])
    pairs = contacts[:, :3].astype("<i4", order="C")
    forces = contacts[:, 3:].astype("<f4", order="C")
    return {"pairs": pairs.tobytes(), "forces": forces.tobytes()}


class Frames:
    """Stored frames of a run; if they exceed `_BYTES`, every second one is deleted."""

    def __init__(self):
        self._kept: list[bytes] = []
        self._size = 0
        self._every = 1
        self._count = 0

    def add(self, message: bytes) -> None:
        """Store a frame; after deletions, store only every second, fourth … frame."""
        self._count += 1
        if (self._count - 1) % self._every:
            return
        messages = self._kept
        messages.append(message)
        self._size += len(message)
        if self._size > _BYTES and len(messages) > 2:
            messages = messages[::2]
            self._every *= 2
            self._size = sum(map(len, messages))
        self._kept = messages

    def __iter__(self):
        return iter(self._kept)

    def __len__(self) -> int:
        return len(self._kept)
