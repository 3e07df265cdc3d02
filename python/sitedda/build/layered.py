# SPDX-License-Identifier: GPL-3.0-or-later
"""Level layered ground: generate blocks, materials, base, sides and measured points."""

import math
from pathlib import Path

import numpy as np

from ..base.errors import InputError
from ..input import schema
from .ground import base_and_sides
from .profile import Ground, SoilProfile, parse_curve, read_curve_table, read_soil_profile

_CELLS = 12  # cells per wavelength of S waves at the highest frequency
_MOST = 100_000  # largest number of blocks
_STIFF = 1e3  # stiffness of welds between layers / stiffness of a block
_STRENGTH = 1e12  # Pa, strength of welds
_ANGLE = 45.0  # degrees
# Curves as in &material: number of required parameters, and names of all parameters.
_CURVES = {
    "darendeli": (0, ("plasticity_index", "ocr", "reference_frequency")),
    "hyperbolic": (1, ("reference_strain",)),
    "gqh": (6, ("reference_strain", "θ₁", "θ₂", "θ₃", "θ₄", "θ₅")),
    "mkz": (1, ("reference_strain", "curve_factor", "curve_power")),
}


class LayeredGround(schema.ProfileValues):
    """Level ground from a file of velocities over depth."""

    def groups(self, folder: Path, all_groups) -> tuple[list[tuple[str, dict]], list[str]]:
        """Generate the groups of the ground, and notes for the user; see `kinds`."""
        profile = read_soil_profile(Path(folder) / self.file)
        rigid = not self.base and profile.half_space is None
        self._check_profile(profile)
        cells = [self._count_block_rows(layer) for layer in profile.layers]
        if sum(cells) * self.columns > _MOST:
            raise InputError(f"{sum(cells) * self.columns} blocks exceed the limit of {_MOST}; "
                             "lower highest_frequency")  # fmt: skip
        result = self._make_materials(profile) + self._make_joints(profile, cells)
        result += self._make_blocks(profile, cells) + self._make_boundaries(profile)
        notes = []
        if rigid:
            notes = [f"{self.file} ends without a half-space, so the base is rigid and "
                     "reflects all waves; add a last row without thickness, or give base = "
                     "'fixed'"]  # fmt: skip
        if self.law == "linear" and any(layer.curve for layer in profile.layers):
            notes += [f"the curves of {self.file} have no effect, because the blocks are linear; "
                      "to use the curves, give law = 'hysteretic'"]  # fmt: skip
        if any(not math.isnan(value) for layer in profile.layers
               for value in (layer.shear_strength, layer.friction_angle)):  # fmt: skip
            notes += [f"the strengths of {self.file} (shear_strength, friction_angle) have no "
                      "effect on the blocks; a column has curves that end at the strength: "
                      "sitedda site"]  # fmt: skip
        return result + (self._measured_points(profile) if self.points else []), notes

    def _check_profile(self, profile: SoilProfile) -> None:
        """Set the default kind of base; reject a missing half-space or missing velocities."""
        if not self.base:
            self.base = "fixed" if profile.half_space is None else "compliant"
        if self.base == "compliant" and profile.half_space is None:
            raise InputError(f"base = 'compliant' needs a half-space, but {self.file} ends with a "
                             "layer: add a last row without thickness")  # fmt: skip
        for layer in (*profile.layers, *filter(None, [profile.half_space])):
            if math.isnan(layer.pressure_velocity):
                raise InputError(f"{self.file}, row {layer.row}: blocks need pressure_velocity or "
                                 "poisson_ratio")  # fmt: skip

    def _count_block_rows(self, layer: Ground) -> int:
        """Return the number of rows of blocks in a layer."""
        length = layer.shear_velocity / self.highest_frequency
        return max(1, math.ceil(_CELLS * layer.thickness / length * (1 - 1e-9)))

    def _base_ground(self, profile: SoilProfile) -> Ground:
        """Return the material of the block under the layers."""
        return profile.half_space or profile.layers[-1]

    def _make_materials(self, profile: SoilProfile) -> list[tuple[str, dict]]:
        """Return the materials of the layers from the surface, then the material of the base."""
        ground = (*profile.layers, self._base_ground(profile))
        laws = [*self._yield_laws(profile), {}]
        result = []
        for name, layer, law in zip(self._material_names(profile), ground, laws, strict=True):
            values = {"name": name, "density": layer.density,
                      "shear_velocity": layer.shear_velocity,
                      "pressure_velocity": layer.pressure_velocity}  # fmt: skip
            damping = {"damping_ratio": layer.damping} if layer.damping else {}
            result.append(("material", values | damping | law))
        return result

    def _yield_laws(self, profile: SoilProfile) -> list[dict]:
        """Return the yield-law variables of each layer; empty for a linear layer."""
        if self.law == "linear":
            return [{} for _ in profile.layers]
        table = math.inf if self.water_table is None else self.water_table
        stresses = profile.mean_stresses(table, self.pressure_at_rest)
        laws = [_hysteretic_law(layer, stress, profile.file)
                 for layer, stress in zip(profile.layers, stresses, strict=True)]  # fmt: skip
        if not any(laws):
            raise InputError(f"law = 'hysteretic': no layer of {self.file} has a curve")
        return laws

    def _material_names(self, profile: SoilProfile) -> list[str]:
        """Return the names of the materials: layers from the surface, then the base."""
        return [*(f"{self.name}_{i + 1}" for i in range(len(profile.layers))), f"{self.name}_base"]

    def _make_joints(self, profile: SoilProfile, cells: list[int]) -> list[tuple[str, dict]]:
        """Return the joints: welds between layers, and the vertical joint between columns."""
        stiff = max(layer.density * layer.pressure_velocity**2 * count / layer.thickness
                    for layer, count in zip(profile.layers, cells, strict=True))  # fmt: skip
        strength = {"friction_angle": _ANGLE, "cohesion": _STRENGTH, "tensile_strength": _STRENGTH}
        return [
            ("joint", {"name": f"{self.name}_weld", **strength,
                       "normal_stiffness_per_area": _STIFF * stiff}),
            ("joint", {"name": f"{self.name}_side", **strength}),
        ]  # fmt: skip

    def _make_blocks(self, profile: SoilProfile, cells: list[int]) -> list[tuple[str, dict]]:
        """Return the rectangular blocks from below, row by row."""
        names = self._material_names(profile)
        thick = [layer.thickness / count for layer, count in zip(profile.layers, cells,
                                                                 strict=True)]  # fmt: skip
        self.width = self.width or max(thick) * self.columns
        sides = np.linspace(self.left, self.left + self.width, self.columns + 1)
        floor, blocks = self.top - profile.depth, []
        if self.base != "none":
            ground = self._base_ground(profile)
            height = ground.shear_velocity / self.highest_frequency / _CELLS
            height = min(height, 0.25 * profile.depth)
            blocks += self._block_row(f"{self.name}_base", names[-1], sides, floor - height, floor)
        number = 1
        for i in range(len(cells) - 1, -1, -1):
            ends = self.top - np.linspace(profile.tops[i + 1], profile.tops[i], cells[i] + 1)
            for low, high in zip(ends, ends[1:], strict=False):
                blocks += self._block_row(f"{self.name}_{number}", names[i], sides, low, high)
                number += 1
        return blocks

    def _block_row(self, name: str, material: str, sides, low: float, high: float):
        """Yield a row of adjacent blocks with the same name."""
        weld, side = f"{self.name}_weld", f"{self.name}_side"
        for left, right in zip(sides, sides[1:], strict=False):
            corners = np.array([[left, low], [right, low], [right, high], [left, high]])
            yield "block", {"vertices": corners, "name": name, "material": material, "joint": weld,
                            "edge_joints": (weld, side, weld, side)}  # fmt: skip

    def _make_boundaries(self, profile: SoilProfile) -> list[tuple[str, dict]]:
        """Return the boundaries at the base and at the sides."""
        ground, base = self._base_ground(profile), {}
        if self.base == "compliant":
            base = {"density": ground.density, "shear_velocity": ground.shear_velocity,
                    "pressure_velocity": ground.pressure_velocity}  # fmt: skip
        elif self.base == "fixed":
            base = {"blocks": f"{self.name}_base"}
        return base_and_sides(self, **base)

    def _measured_points(self, profile: SoilProfile) -> list[tuple[str, dict]]:
        """Return measured points in the middle of the first column of blocks."""
        x = self.left + 0.5 * self.width / self.columns
        cells = [self._count_block_rows(layer) for layer in profile.layers]
        rows = [f"{self.name}_{sum(cells[i:])}" for i in range(len(cells))]  # uppermost of layers
        levels = [("surface", self.top, rows[0])]
        levels += [(f"depth_{depth:.6g}", self.top - depth, row)
                  for depth, row in zip(profile.tops[1:-1], rows[1:], strict=False)]  # fmt: skip
        if self.base != "none":
            levels.append(("base", self.top - profile.depth, f"{self.name}_base"))
        return [("measured_point", {"name": name, "x": x, "y": y, "block": block})
                for name, y, block in levels]  # fmt: skip


def _hysteretic_law(layer: Ground, stress: float, file: Path) -> dict:
    """Return the &material variables for the curve of a layer at a mean stress (Pa)."""
    source = f"{file}, row {layer.row}"
    name, numbers = parse_curve(layer.curve, source)
    if not name:
        return {}
    if name not in _CURVES:
        strain, reduction, damping = read_curve_table(file.parent / name)
        table = {"strains": strain, "reductions": reduction, "dampings": damping}
        return {"law": "hysteretic", "curve": "table"} | table
    minimum, variables = _CURVES[name]
    if not minimum <= len(numbers) <= len(variables):
        required = f"(at least the first {minimum})" if minimum else ""
        raise InputError(f"{source}: curve = {layer.curve!r}: give after {name}: "
                         f"{', '.join(variables)}{required}")  # fmt: skip
    stress_values = {"mean_stress": stress} if name == "darendeli" else {}
    parameters = dict(zip(variables, numbers, strict=False))
    if name == "gqh":
        parameters = {"reference_strain": numbers[0], "curve_fit": numbers[1:]}
    return {"law": "hysteretic", "curve": name} | stress_values | parameters
