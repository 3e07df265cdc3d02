# SPDX-License-Identifier: GPL-3.0-or-later
"""Ground beside and below jointed rock, with boundaries, and with ties between both."""

import numpy as np
import shapely
from shapely.ops import split

from ..base.errors import InputError
from ..input import schema
from .meshing.settings import Mesh

# Stiffness of ties / stiffness of a cell.  Softer ties add compliance to the ground; stiffer ties
# prevent bending of non-matching faces.  Each error changes an S wave by 0.2 % over 40 cells.
_STIFF = 30.0
_STRENGTH = 1e12  # Pa, strength of ties
_ANGLE = 45.0  # degrees
_LARGEST_RATIO = 0.49  # largest Poisson's ratio for the stiffness of ties


class Ground(schema.GroundValues):
    """Meshed ground around a core of jointed rock: one body, or one on each side of the core."""

    def _check_values(self) -> None:
        """Check the sides, the outline of the core and the surface."""
        if not self.left < self.right:
            raise InputError(f"right = {self.right:g} must be above left = {self.left:g}")
        self.outline = self._core_outline()
        if self.outline is None and not len(self.surface):
            raise InputError("give `core`, or `surface` for ground without a core")
        if len(self.surface) and (np.diff(self.surface[:, 0]) <= 0).any():
            raise InputError("surface: x must increase from point to point")

    def _core_outline(self) -> shapely.Polygon | None:
        """Return the outline of the core, counter-clockwise; reject a core that meets a side."""
        if not len(self.core):
            return None
        outline = shapely.Polygon(self.core) if len(self.core) > 2 else shapely.Polygon()
        if outline.is_empty or not outline.is_valid:
            raise InputError("core: its outline is not a simple polygon")
        low, bottom, high, _ = outline.bounds
        if not (self.left < low and high < self.right and bottom >= self.bottom):
            raise InputError(
                f"core: it must lie between left = {self.left:g} and right = {self.right:g}, with "
                f"ground on both sides, and above bottom = {self.bottom:g}"
            )
        return shapely.orient_polygons(outline)

    def groups(self, folder, all_groups) -> tuple[list[tuple[str, dict]], list[str]]:
        """Generate blocks, bodies, region of the core, joints and boundaries; see `kinds`."""
        joints = [("joint", dict(friction_angle=_ANGLE, cohesion=_STRENGTH, name=name,
                                 tensile_strength=_STRENGTH, **variables))
                  for name, variables in self._side_joints(all_groups).items()]  # fmt: skip
        result = joints + self._ground_bodies() + base_and_sides(self)
        if self.outline is not None:
            values = {"name": self.core_name, "outline": self.core, "joint": f"{self.name} tie",
                      "material": self.core_material or self.material}  # fmt: skip
            result.append(("region", values))
        return result, []

    def _side_joints(self, all_groups) -> dict[str, dict]:
        """Return the variables of the joints at the core and at the sides, by joint name."""
        ties: dict[str, dict] = {f"{self.name} side": {}}
        if self.outline is None:
            return ties
        if any("restitution" in item for kind, item in all_groups if kind == "joint"):
            # Restitution requires the stiffness of &contact, not a stiffness per area.
            return ties | {f"{self.name} tie": {}}
        materials = {item.get("name", ""): item for kind, item in all_groups if kind == "material"}
        stiffness = 0.0
        for name in (self.material, self.core_material or self.material):
            name = name or next(iter(materials), "")
            material = materials.get(name, {})
            size = Mesh(blocks="*", size=self.size, frequency=self.frequency).size_of(
                name, material
            )
            stiffness = max(stiffness, _p_wave_modulus(name, material) / size)
        return ties | {f"{self.name} tie": {"normal_stiffness_per_area": _STIFF * stiffness}}

    def _ground_bodies(self) -> list[tuple[str, dict]]:
        """Return the blocks of the ground, and the meshes that divide them into cells."""
        result: list[tuple[str, dict]] = []
        bodies = shapely.get_parts(self._ground_polygon()).tolist()
        for i, body in enumerate(bodies, 1):
            name = self.name if len(bodies) == 1 else f"{self.name}_{i}"
            pieces = _split_at_hole(body)
            names = [f"{name}_{k}" for k in range(1, len(pieces) + 1)]
            for piece, label in zip(pieces, names, strict=True):
                result.append(("block", self._ground_block(label, piece)))
            refinement: dict = {}
            if self.fine_size is not None and self.outline is not None:
                refinement = {"fine_size": self.fine_size,
                        "fine_along": shapely.get_coordinates(self.outline.exterior)}  # fmt: skip
            result.append(("mesh", dict(blocks=", ".join(names), body=name, size=self.size,
                                       frequency=self.frequency, **refinement)))  # fmt: skip
        return result

    def _ground_polygon(self):
        """Return the polygon of the ground below the surface, without the core."""
        ends = {"left": self.left, "right": self.right}
        if len(self.surface):
            x, y = self.surface.T
            inner = (x > self.left) & (x < self.right)
            upper = [(x_end, np.interp(x_end, x, y)) for x_end in ends.values()]
            upper[1:1] = list(self.surface[inner])
        else:
            chain = _upper_side(self.outline)
            upper = [(self.left, chain[0, 1]), *chain, (self.right, chain[-1, 1])]
        if min(y for _, y in upper) <= self.bottom:
            raise InputError(f"bottom = {self.bottom:g} must lie below the surface")
        ground = shapely.Polygon(
            [(self.left, self.bottom), (self.right, self.bottom), *upper[::-1]]
        )
        if not ground.is_valid:
            raise InputError("the ground surface crosses the upper side of `core`; give `surface`")
        return ground if self.outline is None else shapely.difference(ground, self.outline)

    def _ground_block(self, name: str, polygon) -> dict:
        """Return a ground block; its edges at the core have the joint 'NAME tie'."""
        corners = shapely.get_coordinates(shapely.orient_polygons(polygon).exterior)[:-1]
        side, tie = f"{self.name} side", f"{self.name} tie"
        values = {"vertices": corners, "name": name, "joint": side, "material": self.material}
        if self.outline is not None:
            middle = shapely.points(0.5 * (corners + np.roll(corners, -1, axis=0)))
            tolerance = 1e-9 * shapely.length(self.outline.exterior)
            at_core = shapely.dwithin(middle, self.outline, tolerance).tolist()
            values["edge_joints"] = tuple(tie if is_core else side for is_core in at_core)
        return values


def base_and_sides(ground, **base) -> list[tuple[str, dict]]:
    """Return the boundaries below and beside ground; `base`: variables of the lower boundary."""
    motion = {"motion_x": ground.motion_x, "motion_y": ground.motion_y}
    result: list[tuple[str, dict]] = []
    if ground.base != "none":
        values = {"name": f"{ground.name}_base", "kind": ground.base, "side": "bottom"}
        result.append(("boundary", values | base | motion))
    elif any(motion.values()):
        raise InputError("base = 'none' has no motion: omit motion_x and motion_y, or set base")
    if ground.sides == "tied":
        result.append(("boundary", {"kind": "tied"}))
    elif ground.sides != "none":
        direction = "y" if ground.sides == "roller" else ""
        result += [("boundary", {"kind": ground.sides, "side": side, "direction": direction})
                  for side in ("left", "right")]  # fmt: skip
    return result


def _p_wave_modulus(name: str, material: dict) -> float:
    """Return the P-wave modulus ρ V_p² of a material, Pa."""
    try:
        if "pressure_velocity" in material:
            return material["density"] * material["pressure_velocity"] ** 2
        nu = min(material["poisson_ratio"], _LARGEST_RATIO)
        return material["young_modulus"] * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    except KeyError:
        missing = "young_modulus and poisson_ratio, or velocities"
        raise InputError(f"material {name!r} needs {missing}") from None


def _upper_side(outline) -> np.ndarray:
    """Return the corners on the upper side of an outline, from left to right, m."""
    corners = shapely.get_coordinates(outline.exterior)[:-1]
    x, y = corners.T
    size = float(np.ptp(corners, axis=0).max())
    first, last = (
        int(np.flatnonzero(abs(x - end) <= 1e-9 * size)[np.argmax(y[abs(x - end) <= 1e-9 * size])])
        for end in (x.min(), x.max())
    )
    return np.roll(corners, -last, axis=0)[: (first - last) % len(corners) + 1][::-1]


def _split_at_hole(polygon) -> list:
    """Return a polygon, or its halves on both sides of a vertical line through its hole."""
    if not len(polygon.interiors):
        return [polygon]
    x = polygon.interiors[0].centroid.x
    _, low, _, high = polygon.bounds
    return list(split(polygon, shapely.LineString([(x, low - 1.0), (x, high + 1.0)])).geoms)
