# SPDX-License-Identifier: GPL-3.0-or-later
"""The frames of a model or an output, for pictures, movies, the view and exports."""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..base.arrays import parts_of
from ..base.core import FILES
from ..base.errors import ConvergenceError, InputError, RestWarning
from ..base.numbers import counted
from ..base.reading import check_readable
from ..engine.simulation import Simulation
from ..input.input_text import input_values
from .output_file import damaged, open_output, read

if TYPE_CHECKING:
    import xarray as xr

PARALLEL = np.cos(np.radians(2.0))  # edges within 2° of antiparallel can form an interface
# Quantities that only some outputs contain: error of the stress of cells (Pa), largest plastic
# strain of yielding blocks, largest damage of the faces of a cell.
OWN_QUANTITIES = ("stress_error", "plastic_strain", "damage")
_LOST_DISTANCE = 1.0  # smallest distance of a lost block from the first view / size of the view
_TIME_TOLERANCE = 0.01  # largest distance of a requested time from the frames / duration


@dataclass(frozen=True)
class Interfaces:
    """Segments of edges that two blocks share, each of shape (k,).

    Attributes
    ----------
    first, second : ndarray of int
        The blocks.
    first_edge, second_edge : ndarray of int
        Edges of the blocks; each has the number of the vertex where it begins.
    start, end : ndarray, shape (k, 2)
        Ends of the shared segment in the first frame, m.
    normal : ndarray, shape (k, 2)
        Unit vectors from the first block into the second.
    """

    first: np.ndarray
    second: np.ndarray
    first_edge: np.ndarray
    second_edge: np.ndarray
    start: np.ndarray
    end: np.ndarray
    normal: np.ndarray

    def __len__(self) -> int:
        return len(self.first)


class Scene:
    """A model before its run, or all frames of an output.

    Parameters
    ----------
    data : xarray.Dataset
        Contains the variables of an output; frames and contacts are read when needed.
    before : bool
        Whether the model has not been run.
    absolute : bool
        Whether displacements are absolute, not relative to the base.
    """

    def __init__(self, data: xr.Dataset, before: bool = False, absolute: bool = False):
        self.data = data
        self.before = before
        self.absolute = absolute
        self.owner = data["vertex_block"].values.astype(int)
        self.blocks = int(self.owner[-1]) + 1
        self.first = np.searchsorted(self.owner, np.arange(self.blocks + 1))
        self.time = np.atleast_1d(data["frame_time"].values)
        self.title = str(data.attrs.get("title", "")).strip()
        self.groups = input_values(data.attrs)
        names = data["block"].values.tolist() if "block" in data else [""] * self.blocks
        self.names = [str(name) or f"block {i + 1}" for i, name in enumerate(names)]
        self.body = np.zeros(self.blocks, dtype=int)
        self.welded = np.zeros(len(self.owner), dtype=bool)
        if "block_body" in data:
            self.body = data["block_body"].values.astype(int)
            self.welded = data["edge_welded"].values.astype(bool)
        self._set_materials()

    @property
    def bodies(self) -> int:
        """Return the number of blocks that are not cells, plus the number of meshed bodies."""
        return int(np.sum(self.body == 0)) + len(np.unique(self.body[self.body > 0]))

    @property
    def size_words(self) -> str:
        """Return the number of blocks in words, and of cells if bodies are meshed."""
        text = counted(self.bodies, "block", "blocks")
        return text if self.bodies == self.blocks else f"{text} of {self.blocks:,} cells"

    @classmethod
    def of(cls, source, absolute: bool = False) -> Scene:
        """Return the scene of a file (input or output), Run, Dataset, Simulation or model."""
        if isinstance(source, cls):
            return cls(source.data, source.before, True) if absolute else source
        source = getattr(source, "history", source)
        if hasattr(source, "attrs"):
            return cls(source, absolute=absolute)
        if isinstance(source, Simulation):
            return cls._of_simulation(source)
        if isinstance(source, str | os.PathLike):
            source = Path(source)
            if is_netcdf(source):
                return cls(open_output(source), absolute=absolute)
        try:
            with Simulation(source) as simulation:
                return cls._of_simulation(simulation)
        except ConvergenceError as error:
            warnings.warn(f"{error}; shown as drawn", RestWarning, stacklevel=2)
        with Simulation(source, drawn=True) as simulation:
            return cls._of_simulation(simulation)

    @classmethod
    def _of_simulation(cls, simulation: Simulation) -> Scene:
        """Return the scene of the present state of a simulation."""
        return cls(_present_state(simulation), simulation.steps == 0)

    def _set_materials(self) -> None:
        """Set material of blocks and joint of edges; the first of the input if unknown."""
        self.material_names, self.joint_names = (
            [str(group.get("name", "")) or f"{kind} {i}"
             for i, group in enumerate(self.groups.get(kind, []), 1)] or [kind]
            for kind in ("material", "joint")
        )  # fmt: skip
        self.material = np.zeros(self.blocks, dtype=int)
        self.joint = np.zeros(len(self.owner), dtype=int)
        if "block_material" in self.data:
            self.material = self.data["block_material"].values.astype(int)
            self.joint = self.data["edge_joint"].values.astype(int)

    # --- frames ------------------------------------------------------------------------------

    @property
    def frames(self) -> int:
        """Return the number of frames."""
        return len(self.time)

    def frame_at(self, time: float | None, stage: str | None = None) -> int:
        """Return the frame of a stage nearest to a time (s); the last frame for None."""
        begin, end = float(self.time[0]), float(self.time[-1])
        tolerance = _TIME_TOLERANCE * (end - begin)
        if time is not None and not begin - tolerance <= time <= end + tolerance:
            raise InputError(f"there is no frame at t = {time:g} s: choose {begin:g} to {end:g} s")
        frames = np.arange(self.frames)
        if stage is not None:
            names = str(self.data.attrs.get("stages", "")).split("\n")
            number = self.data["frame_stage"].values if "frame_stage" in self.data else frames * 0
            frames = np.flatnonzero(number == (names.index(stage) + 1 if stage in names else -1))
            if len(frames) == 0:
                raise InputError(f"stage {stage!r} has no frame; the stages are {', '.join(names)}")
        return int(frames[-1] if time is None else frames[np.argmin(abs(self.time[frames] - time))])

    def vertices(self, frame: int) -> np.ndarray:
        """Return the positions of all vertices, shape (vertices, 2), m."""
        return read(self.data, "vertices", frame)

    def polygons(self, frame: int) -> list[np.ndarray]:
        """Return the vertices of each block, shape (vertices, 2), m."""
        return self.split(self.vertices(frame))

    def split(self, vertices: np.ndarray) -> list[np.ndarray]:
        """Split an array over all vertices into one per block."""
        return parts_of(vertices, self.first)

    def coordinates(self, frame: int) -> np.ndarray:
        """Return block coordinates, shape (blocks, 6): m, rad, strains in axes of the block."""
        return read(self.data, "block_coordinates", frame)

    def rates(self, frame: int) -> np.ndarray:
        """Return the rates of the block coordinates, shape (blocks, 6), per second."""
        return read(self.data, "block_rates", frame)

    def stress(self, frame: int) -> np.ndarray:
        """Return stresses, shape (blocks, 3): sigma_x, sigma_y, tau_xy, Pa, tension positive."""
        return read(self.data, "block_stress", frame)

    @property
    def own_quantities(self) -> list[str]:
        """Return the names in `OWN_QUANTITIES` that the model has."""
        variables = {"damage": ("edge_damage", "contact_damage")}
        return [n for n in OWN_QUANTITIES
                if any(k in self.data for k in variables.get(n, (f"block_{n}",)))]  # fmt: skip

    def own_quantity(self, name: str, frame: int) -> np.ndarray:
        """Return one of `OWN_QUANTITIES`, shape (blocks,); 0 if the model does not have it."""
        if name not in self.own_quantities:
            return np.zeros(self.blocks)
        if name == "damage":
            return np.maximum.reduceat(self.edge_damage(frame), self.first[:-1])
        return read(self.data, f"block_{name}", frame)

    def edge_damage(self, frame: int) -> np.ndarray:
        """Return the damage of welded faces and cohesive joints, shape (edges,); 1: broken.

        Only joints that are bonded in the first frame are included.
        """
        if "edge_damage" in self.data:
            damage = np.array(read(self.data, "edge_damage", frame), dtype=float)
        else:
            damage = np.zeros(len(self.owner))
        if "contact_damage" in self.data:
            start, current = self._cohesive_contacts(0), self._cohesive_contacts(frame)
            bonded_edges = np.unique(start["edge"][start["bonded"] > 0])
            open_edges = np.setdiff1d(bonded_edges, current["edge"])
            is_glued = np.isin(current["edge"], bonded_edges)
            np.maximum.at(damage, current["edge"][is_glued], current["damage"][is_glued])
            damage[open_edges] = 1.0
        return damage

    def _cohesive_contacts(self, frame: int) -> dict[str, np.ndarray]:
        """Return edge, bond, damage and joint of the contacts of cohesive joints in a frame."""
        rows = slice(*self._first_contacts[frame : frame + 2])
        names = ("edge", "bonded", "damage", "joint")
        values_by_name = {name: read(self.data, f"contact_{name}", rows) for name in names}
        laws = [joint.get("law") == "cohesive" for joint in self.groups.get("joint", [])]
        cohesive = np.array(laws, dtype=bool)[values_by_name["joint"]]
        return {name: values[cohesive] for name, values in values_by_name.items()}

    @cached_property
    def base(self) -> np.ndarray:
        """Return the reference displacement of the base, shape (frames, 2), m; see `origin`."""
        return self._base_displacement("frame_base", self.frames)

    @cached_property
    def base_history(self) -> np.ndarray:
        """Return the reference displacement of the base at the samples, shape (times, 2), m."""
        return self._base_displacement("base_displacement", self.data.sizes.get("time", 0))

    def _base_displacement(self, name: str, rows: int) -> np.ndarray:
        """Return a base displacement of the output, shape (rows, 2), m; 0 if not subtracted."""
        if self.absolute or name not in self.data:
            return np.zeros((rows, 2))
        return self.data[name].values

    @property
    def origin(self) -> str:
        """Return the reference of displacements in words: 'relative to …' or 'absolute'."""
        text = str(self.data.attrs.get("maxima_base", ""))
        if self.absolute or text.startswith("absolute"):
            return "absolute" if self.groups.get("motion") else ""
        return text if self.base.any() else ""

    def displacement(self, frame: int) -> np.ndarray:
        """Return displacements of the centroids since the first frame, shape (blocks, 2), m.

        Relative to the `base`.
        """
        shift = self.coordinates(frame)[:, :2] - self.coordinates(0)[:, :2]
        return shift - self.base[frame]

    @cached_property
    def _first_contacts(self) -> np.ndarray:
        """Return the index of the first contact of each frame, shape (frames + 1,)."""
        frame = read(self.data, "contact_frame")
        return np.searchsorted(frame, np.arange(self.frames + 1))

    def contacts(self, frame: int) -> dict[str, np.ndarray]:
        """Return the contacts of a frame: vertex, edge, state, bonded, gap, forces and others."""
        names = ("vertex", "edge", "state", "bonded", "gap", "normal_force", "shear_force")
        names += tuple(n for n in ("place", "damage") if f"contact_{n}" in self.data.variables)
        rows = slice(*self._first_contacts[frame : frame + 2])
        return {name: read(self.data, f"contact_{name}", rows) for name in names}

    # --- geometry ----------------------------------------------------------------------------

    @cached_property
    def next_vertex(self) -> np.ndarray:
        """Return the vertex that follows each vertex of a block, counter-clockwise."""
        next_vertices = np.arange(len(self.owner)) + 1
        next_vertices[self.first[1:] - 1] = self.first[:-1]
        return next_vertices

    @cached_property
    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the lower left and upper right corner of the first frame, m."""
        vertices = self.vertices(0)
        return vertices.min(0), vertices.max(0)

    @property
    def size(self) -> float:
        """Return the larger side of the first frame, m."""
        low, high = self.box
        return float((high - low).max())

    def areas(self, frame: int = 0) -> np.ndarray:
        """Return the areas of the blocks, shape (blocks,), m²."""
        vertices = self.vertices(frame)
        centre = vertices[self.first[:-1]][self.owner]
        x, y = (vertices - centre).T
        cross = x * y[self.next_vertex] - x[self.next_vertex] * y
        return 0.5 * np.add.reduceat(cross, self.first[:-1])

    def slivers(self) -> np.ndarray:
        """Return blocks whose area is tiny relative to others or to their squared perimeter."""
        vertices = self.vertices(0)
        side = np.linalg.norm(vertices[self.next_vertex] - vertices, axis=1)
        outline = np.add.reduceat(side, self.first[:-1])
        area = self.areas()
        is_sliver = area < 0.001 * outline**2  # as for a rectangle with sides 1 : 250
        return np.flatnonzero(is_sliver | (area < 1e-3 * np.median(area)))

    def lost(self, frame: int) -> np.ndarray:
        """Return the blocks whose distance from the first view exceeds the size of the view."""
        low, high = self.box
        centre, half_width = 0.5 * (low + high), (0.5 + _LOST_DISTANCE) * self.size
        return np.flatnonzero(np.any(abs(self.coordinates(frame)[:, :2] - centre) > half_width,
                                     axis=1))  # fmt: skip

    def contact_points(self, frame: int, contacts: dict) -> tuple[np.ndarray, np.ndarray]:
        """Return positions and unit normals (outward from the edge) of contacts, each (k, 2)."""
        vertices = self.vertices(frame)
        begin, end = vertices[contacts["edge"]], vertices[self.next_vertex[contacts["edge"]]]
        tangents = (end - begin) / np.linalg.norm(end - begin, axis=1, keepdims=True)
        return self.touching(vertices, contacts), np.column_stack([tangents[:, 1], -tangents[:, 0]])

    def contact_forces(self, contacts: dict, normal: np.ndarray) -> np.ndarray:
        """Return the forces of contacts on the blocks of their vertices, (k, 2), N/m."""
        along = np.column_stack([-normal[:, 1], normal[:, 0]])
        return contacts["normal_force"][:, None] * normal - contacts["shear_force"][:, None] * along

    def touching(self, vertices: np.ndarray, contacts: dict) -> np.ndarray:
        """Return the contact points, (k, 2), at given positions of all vertices."""
        corner = contacts["vertex"]
        if "place" not in contacts:
            return vertices[corner]
        fraction = contacts["place"][:, None]
        return vertices[corner] + fraction * (vertices[self.next_vertex[corner]] - vertices[corner])

    @cached_property
    def interfaces(self) -> Interfaces:
        """Return the shared segments of edges in contact in the first frame."""
        contacts, vertices = self.contacts(0), self.vertices(0)
        own_edges = np.concatenate([contacts["vertex"], self.previous_vertex[contacts["vertex"]]])
        edges = np.concatenate([contacts["edge"]] * 2)
        count = np.int64(len(vertices))
        pairs = np.unique(np.minimum(own_edges, edges) * count + np.maximum(own_edges, edges))
        a, b = np.divmod(pairs, count)
        begin, directions = vertices[a], vertices[self.next_vertex[a]] - vertices[a]
        length = np.linalg.norm(directions, axis=1)
        opposite_directions = vertices[self.next_vertex[b]] - vertices[b]
        unit = directions / length[:, None]
        cosine = np.sum(unit * opposite_directions, axis=1) / np.linalg.norm(
            opposite_directions, axis=1
        )
        s = np.column_stack(
            [np.sum((vertices[c] - begin) * unit, axis=1) for c in (self.next_vertex[b], b)]
        )
        low, high = np.maximum(s[:, 0], 0), np.minimum(s[:, 1], length)
        gap = vertices[b] - begin
        is_close = abs(unit[:, 0] * gap[:, 1] - unit[:, 1] * gap[:, 0]) < 1e-3 * length
        valid = (cosine < -PARALLEL) & is_close & (high - low > 1e-6 * length)
        a, b, low, high, unit, begin = (v[valid] for v in (a, b, low, high, unit, begin))
        return Interfaces(
            self.owner[a],
            self.owner[b],
            a,
            b,
            begin + low[:, None] * unit,
            begin + high[:, None] * unit,
            np.column_stack([unit[:, 1], -unit[:, 0]]),
        )

    @cached_property
    def interface_joints(self) -> np.ndarray:
        """Return the joint of each interface: the weaker joint of its two edges, as in contacts."""
        weakness = [
            (float(g.get("friction_angle", 0.0)), float(g.get("cohesion", 0.0) or 0.0))
            for g in self.groups.get("joint", [])
        ] or [(0.0, 0.0)]
        rank = np.empty(len(weakness), dtype=int)
        rank[sorted(range(len(weakness)), key=weakness.__getitem__)] = np.arange(len(weakness))
        a, b = self.joint[self.interfaces.first_edge], self.joint[self.interfaces.second_edge]
        return np.where(rank[b] < rank[a], b, a)

    @cached_property
    def previous_vertex(self) -> np.ndarray:
        """Return the vertex that precedes each vertex of a block, counter-clockwise."""
        previous = np.empty_like(self.next_vertex)
        previous[self.next_vertex] = np.arange(len(previous))
        return previous

    def carried(self, blocks: np.ndarray, points: np.ndarray, frame: int) -> np.ndarray:
        """Return positions in a frame of points that move with blocks, shape (k, 2), m.

        A point moves with its block: x = x0 + R(θ) (I + ε) ρ.
        """
        coordinates = self.coordinates(frame)[blocks]
        return (
            coordinates[:, :2]
            + (deformation_gradient(coordinates) @ self.offsets(blocks, points)[..., None])[..., 0]
        )

    def offsets(self, blocks: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Return reference offsets ρ of points of blocks from centroids, shape (k, 2), m."""
        start = self.coordinates(0)[blocks]
        return np.linalg.solve(deformation_gradient(start), (points - start[:, :2])[..., None])[
            ..., 0
        ]

    def joint_movement(self, frame: int) -> tuple[np.ndarray, np.ndarray]:
        """Return slip and opening of `interfaces` since the first frame, each (k,), m.

        The values are the larger ones of both ends; opening is positive, slip has no sign.
        """
        along, normal = self._relative_displacement(frame)
        faces = self.interfaces
        present = ~(self.removed(frame)[faces.first] | self.removed(frame)[faces.second])
        return abs(along).max(axis=0) * present, normal.max(axis=0) * present

    def joint_sense(self, frame: int) -> np.ndarray:
        """Return the direction of slip of the second block of `interfaces` on the first, (k,).

        1: from start to end of the shared segment; -1: reverse; 0: no slip.
        """
        along, _ = self._relative_displacement(frame)
        return np.sign(np.where(abs(along[0]) >= abs(along[1]), *along))

    def _relative_displacement(self, frame: int) -> tuple[np.ndarray, np.ndarray]:
        """Return tangential and normal displacement between two blocks, each (2, k), m."""
        faces, tangential, normals = self.interfaces, [], []
        angle = self.coordinates(frame)[faces.first, 2] - self.coordinates(0)[faces.first, 2]
        cos, sin = np.cos(angle), np.sin(angle)
        x, y = faces.normal.T
        normal = np.column_stack([cos * x - sin * y, sin * x + cos * y])
        for ends in (faces.start, faces.end):
            relative = self.carried(faces.second, ends, frame) - self.carried(
                faces.first, ends, frame
            )
            normals.append(np.sum(relative * normal, axis=1))
            tangential.append(normal[:, 0] * relative[:, 1] - normal[:, 1] * relative[:, 0])
        return np.array(tangential), np.array(normals)

    @cached_property
    def _removal_stage(self) -> np.ndarray:
        """Return the stage that removes each block; 0: none."""
        if "block_removal" not in self.data:
            return np.zeros(self.blocks, dtype=int)
        return self.data["block_removal"].values.astype(int)

    def removed(self, frame: int) -> np.ndarray:
        """Return whether each block has been removed up to a frame, shape (blocks,)."""
        if not self._removal_stage.any() or "frame_stage" not in self.data:
            return np.zeros(self.blocks, dtype=bool)
        return (self._removal_stage > 0) & (
            self._removal_stage <= int(self.data["frame_stage"][frame])
        )

    def stage_starts(self) -> list[tuple[str, float]]:
        """Return names and first times (s) of stages if a run has several dynamic ones."""
        if "stage" not in self.data or "stages" not in self.data.attrs:
            return []
        names = str(self.data.attrs["stages"]).split("\n")
        stage, time = self.data["stage"].values.astype(int), self.data["time"].values
        indices = np.flatnonzero(np.diff(stage, prepend=0))
        # A stage starts at the last sample of the preceding stage.
        starts = [(names[stage[i] - 1], float(time[max(i - 1, 0)])) for i in indices]
        return starts if len(starts) > 1 and len(names) >= stage.max() else []

    # --- what the input adds -----------------------------------------------------------------

    def supports(self) -> list[dict]:
        """Return the fixed points: x, y (m), direction, moved (bool)."""
        return [
            {
                "x": float(group.get("x", 0.0)),
                "y": float(group.get("y", 0.0)),
                "direction": str(group.get("direction", "xy")).strip() or "xy",
                "moved": bool(group.get("motion_x") or group.get("motion_y")),
            }
            for group in self.groups.get("fixed_point", [])
        ]

    def boundaries(self, frame: int) -> list[dict]:
        """Return edges of the groups &boundary: kind, moved (bool), start and end (k, 2), m."""
        if "boundary_edge" not in self.data:
            return []
        vertices = self.vertices(frame)
        edge, group = (self.data[n].values for n in ("boundary_edge", "boundary_edge_group"))
        begin, edge_vectors = vertices[edge], vertices[self.next_vertex[edge]] - vertices[edge]
        start, end = (begin + self.data[f"boundary_edge_{name}"].values[:, None] * edge_vectors
                      for name in ("from", "to"))  # fmt: skip
        return [
            {
                "kind": str(item["kind"]).strip(),
                "moved": bool(item.get("motion_x") or item.get("motion_y")),
                "start": start[group == i],
                "end": end[group == i],
            }
            for i, item in enumerate(self.groups.get("boundary", []))
        ]

    def loads(self) -> list[dict]:
        """Return loads: x, y (m) and the largest force (N/m) as fx, fy."""
        result = []
        for group in self.groups.get("load", []):
            fx, fy = (np.atleast_1d(group.get(f"force_{a}", 0.0)).astype(float) for a in "xy")
            n = max(len(fx), len(fy))
            fx, fy = (np.pad(f, (0, n - len(f))) for f in (fx, fy))
            peak = int(np.argmax(np.hypot(fx, fy)))
            result.append({"x": group["x"], "y": group["y"], "fx": fx[peak], "fy": fy[peak]})
        return result

    def bolt_routes(self) -> list[tuple[str, np.ndarray, np.ndarray]]:
        """Return names of bolts, and blocks (k,) and initial positions (k, 2), m, of their points.

        The points of a cable are its ends and the points that it passes.  The points of a grouted
        bolt are its ends and the joints that it crosses. Before a run, all points belong to the
        first block, because no block moves.
        """
        routes = []
        for group in self.groups.get("bolt", []):
            name = str(group.get("name", ""))
            inner_points = np.ravel(group.get("through", []))
            points = np.reshape([*group["from"], *inner_points, *group["to"]],
                                (-1, 2)).astype(float)  # fmt: skip
            blocks = np.zeros(len(points), dtype=int)
            if "bolt_force" in self.data:
                blocks, points = self._initial_bolt_points(name, points)
            routes.append((name, blocks, points))
        return routes

    def _initial_bolt_points(self, name: str, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return blocks and initial positions of the points of a bolt, as in the output."""
        with FILES:
            points_of_bolt = np.flatnonzero(self._bolt_names == name)
            if len(points_of_bolt) == 0:
                raise damaged(self.data, "bolt", f"the bolt {name!r} of the input is missing")
            blocks = self.data["bolt_block"].values.astype(int)[points_of_bolt]
            ends_at = self.data["bolt_place"].values.reshape(-1, 2, 2)[points_of_bolt]
            if len(points) > 2:
                mask = self.data["bolt_through"].values == points_of_bolt[0]
                inner_blocks = self.data["bolt_through_block"].values.astype(int)[mask]
                return np.array([blocks[0, 0], *inner_blocks, blocks[0, 1]]), points
        blocks, ends_at = blocks.ravel(), ends_at.reshape(-1, 2)
        if np.allclose(ends_at[0], ends_at[1]):  # a grouted bolt, whose springs are at joints
            blocks = np.array([blocks[0], *blocks, blocks[-1]])
            ends_at = np.vstack([points[:1], ends_at, points[1:]])
        return blocks, ends_at

    @cached_property
    def _bolt_names(self) -> np.ndarray:
        """Return the bolt name of each spring, shape (springs,)."""
        return np.char.strip(self.data["bolt"].values.astype(str))

    def bolts(self, frame: int) -> list[dict]:
        """Return the present bolts: name, positions (k, 2) (m), force (N/m, nan: unknown), state.

        The force combines axial and shear force; in a grouted bolt, the largest at its joints.
        """
        has_force = "bolt_force" in self.data
        if has_force:
            with FILES:
                k = self.sample_of(frame)
                axial, shear = (self.data[f"bolt_{n}"][k].values for n in ("force", "shear_force"))
                force, states = np.hypot(axial, shear), self.data["bolt_state"][k].values
        result = []
        for name, blocks, points in self.bolt_routes():
            peak, state = np.nan, 1
            if has_force:
                is_of_bolt = self._bolt_names == name
                peak, state = force[is_of_bolt].max(), states[is_of_bolt].max()
            if state:
                bolt = {"name": name, "places": self.carried(blocks, points, frame)}
                result.append(bolt | {"force": float(peak), "state": int(state)})
        return result

    @cached_property
    def water_lines(self) -> tuple[np.ndarray, np.ndarray]:
        """Return a block beside each channel of water, (k,), and initial ends, (k, 2, 2), m."""
        if "flow_pressure" not in self.data:
            return np.zeros(0, dtype=int), np.zeros((0, 2, 2))
        with FILES:
            blocks = self.data["flow_channel_block"].values[:, 0].astype(int)
            return blocks, self.data["flow_node_place"].values[self._channel_nodes]

    @cached_property
    def _channel_nodes(self) -> np.ndarray:
        """Return the two nodes of each flow channel, shape (channels, 2)."""
        return self.data["flow_channel_node"].values.astype(int)

    def water(self, frame: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return mean pressure (Pa), whether full, and flux (m²/s) of each channel, each (k,)."""
        with FILES:
            sample = self.sample_of(frame)
            pressure, saturation, flux = (
                self.data[f"flow_{name}"][sample].values
                for name in ("pressure", "saturation", "flux")
            )
        nodes = self._channel_nodes
        return pressure[nodes].mean(1), saturation[nodes].min(1) >= 1, flux

    def sample_of(self, frame: int) -> int:
        """Return the sample of a frame; static stages have several samples at the same time."""
        time = self.data["time"].values
        earlier_frames = int(np.sum(self.time[:frame] == self.time[frame]))
        sample = int(np.searchsorted(time, self.time[frame])) + earlier_frames
        return min(sample, int(np.searchsorted(time, self.time[frame], "right")) - 1)

    def points(self) -> list[dict]:
        """Return the measured points: name, x, y (m), and the named block, if any."""
        return [
            {
                "name": str(group.get("name", "")),
                "x": float(group["x"]),
                "y": float(group["y"]),
                "block": str(group.get("block", "")),
            }
            for group in self.groups.get("measured_point", [])
        ]


def principal_stresses(stress: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return larger and smaller principal stress of (…, 3) stresses, Pa, tension positive."""
    mean = 0.5 * (stress[..., 0] + stress[..., 1])
    radius = np.hypot(0.5 * (stress[..., 0] - stress[..., 1]), stress[..., 2])
    return mean + radius, mean - radius


def is_netcdf(file: Path) -> bool:
    """Return whether a file begins like a netCDF file."""
    check_readable(file)
    with file.open("rb") as stream:
        first_bytes = stream.read(8)
    return first_bytes.startswith((b"\x89HDF\r\n\x1a\n", b"CDF"))


def deformation_gradient(coordinates: np.ndarray) -> np.ndarray:
    """Return the deformation gradients R(θ) (I + ε) of blocks, shape (k, 2, 2)."""
    _, _, angle, ex, ey, gxy = coordinates.T
    cos, sin = np.cos(angle), np.sin(angle)
    axes = np.array([[cos, -sin], [sin, cos]])
    strain = np.array([[1 + ex, 0.5 * gxy], [0.5 * gxy, 1 + ey]])
    return np.einsum("ijk,jlk->kil", axes, strain)


def _present_state(simulation: Simulation) -> xr.Dataset:
    """Return the state of a simulation as a dataset of one frame."""
    import xarray as xr

    polygons, contacts = simulation.polygons, simulation.contacts
    owner = np.repeat(np.arange(len(polygons)), [len(p) for p in polygons])
    frame = {
        "vertices": (("frame", "vertex", "axis"), np.concatenate(polygons)[None]),
        "block_coordinates": (("frame", "block", "coordinate"), simulation.coordinates[None]),
        "block_rates": (("frame", "block", "coordinate"), simulation.rates[None]),
        "block_stress": (("frame", "block", "component"), simulation.stresses[None]),
        "frame_time": ("frame", [simulation.time]),
        "vertex_block": ("vertex", owner),
        "contact_frame": ("contact", np.zeros(len(contacts["vertex"]), dtype=int)),
    } | {f"contact_{name}": ("contact", values) for name, values in contacts.items()}
    frame |= {
        "block": ("block", simulation.block_names),
        "block_material": ("block", simulation.block_materials),
        "edge_joint": ("vertex", simulation.edge_joints),
        "block_body": ("block", simulation.block_bodies),
        "edge_welded": ("vertex", simulation.welded_edges),
    }
    block_values = {"stress_error": simulation.stress_errors,
                    "plastic_strain": simulation.plastic_strains}  # fmt: skip
    frame |= {f"block_{k}": (("frame", "block"), v[None])
              for k, v in block_values.items() if v.any()}  # fmt: skip
    if (damages := simulation.edge_damages).any():
        frame["edge_damage"] = (("frame", "vertex"), damages[None])
    edges = simulation.boundary_edges
    if len(edges["edge"]):
        frame["boundary_edge"] = ("boundary_edge", edges.pop("edge"))
        frame |= {f"boundary_edge_{n}": ("boundary_edge", v) for n, v in edges.items()}
    water = simulation.water
    if count := len(water["block"]):
        nodes = np.arange(2 * count).reshape(-1, 2)
        frame |= {
            "time": ("time", [simulation.time]),
            "flow_node_place": (("flow_node", "axis"), water["places"].reshape(-1, 2)),
            "flow_channel_node": (("flow_channel", "side"), nodes),
            "flow_channel_block": (("flow_channel", "side"), np.tile(water["block"], (2, 1)).T),
            "flow_pressure": (("time", "flow_node"), water["pressure"].reshape(1, -1)),
            "flow_saturation": (("time", "flow_node"), water["saturation"].reshape(1, -1)),
            "flow_flux": (("time", "flow_channel"), water["flux"][None]),
        }
    names = {"title": simulation.title, "input_file": str(simulation.file)}
    texts = {"input_text": simulation.input_text, "input_values": simulation.input_values}
    return xr.Dataset(frame, attrs=names | texts)
