# SPDX-License-Identifier: GPL-3.0-or-later
"""Convert blocks of an input into the cells of bodies."""

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely

from ...base.errors import CostWarning, InputError, located
from .body import Cut, Part, mesh_body
from .graphs import MOST_CELLS
from .settings import Mesh, is_listed

_NAMED = 3  # largest number of positions in a message
_FLAT = 1e-8  # smallest area of a meshed block / square of its perimeter
_MANY = 100_000  # number of cells whose generation takes a minute
_FAR = 10  # if the estimate exceeds this multiple of MOST_CELLS, regions are not cut
LONGEST_NAME = 64  # longest name of a body, bytes


@dataclass
class Piece:
    """A block that may be meshed."""

    values: dict  # variables of its &block group
    region: str = ""  # region from which the block has been cut, or blank
    # Corners (m) and joints of the holes and blocks that it surrounds
    holes: list = field(default_factory=list)

    @property
    def name(self) -> str:
        """Return the name of the block."""
        return self.values.get("name", "")


def mesh_blocks(
    pieces: Sequence[Piece], meshes: Sequence[tuple[Mesh, str]], materials: dict[str, dict]
) -> tuple[list[dict], list[int], list[str]]:
    """Return the cells of the meshed blocks.

    `meshes`: meshes and their positions in the input.
    `materials`: variables of each material by its name, in the order of the input.
    Result: variables of the &block groups of the cells, indices of the meshed pieces, messages.
    """
    blocks, sources, messages = [], {}, []
    _check_estimate(pieces, meshes, materials)
    bodies: dict[str, str] = {}
    for mesh, source in meshes:
        with located(source):
            for body, members in _bodies_of_mesh(mesh, pieces):
                repeated = [pieces[i].name for i in members if i in sources]
                if repeated or body in bodies:
                    previous_labels = sources[members[0]] if repeated else bodies[body]
                    raise InputError(
                        f"{(repeated or [body])[0]!r} is already meshed by {previous_labels}"
                    )
                bodies[body] = source
                sources |= dict.fromkeys(members, source)
                cut = _cut_body(mesh, [pieces[i] for i in members], materials)
                blocks += _cell_values(body, cut, [pieces[i].values for i in members])
                messages += _unusual_notes(body, cut)
    return blocks, sorted(sources), messages


def _check_estimate(pieces, meshes, materials: dict[str, dict]) -> None:
    """Raise InputError for outlines without area and for too many cells, from an estimate."""
    cell_count = 0.0
    for mesh, source in meshes:
        with located(source):
            for _, members in _bodies_of_mesh(mesh, pieces):
                for i in members:
                    size = _cell_size(mesh, pieces[i], materials)
                    cell_count += max(1.0, _outline_area(pieces[i].values) / size / size)
            if cell_count > MOST_CELLS:
                raise _too_many_cells_error(size, cell_count)
    if cell_count > _MANY:
        text = f"about {cell_count:.2g} cells take minutes to generate; choose a larger cell size"
        warnings.warn(text, CostWarning, stacklevel=2)


def refuse_far_too_many(regions, meshes, materials: dict[str, dict]) -> None:
    """Raise InputError for far too many cells before regions are cut, when holes are unknown."""
    for mesh, source in meshes:
        if not mesh.regions:
            continue
        with located(source):
            sizes = (mesh.size_of(name, values) for name, values in materials.items())
            size = max(sizes, default=np.inf)
            meshed = (region.outline for region in regions if is_listed(region.name, mesh.regions))
            cells = sum(shapely.Polygon(outline).area for outline in meshed) / size / size
            if cells > _FAR * MOST_CELLS:
                raise _too_many_cells_error(size, cells)


def _cell_size(mesh: Mesh, piece: Piece, materials: dict[str, dict]) -> float:
    """Return the size of the cells of a piece, m."""
    material = piece.values.get("material") or next(iter(materials), "")
    return mesh.size_of(material, materials.get(material, {}))


def _too_many_cells_error(size: float, cells: float) -> InputError:
    """Return the error for a cell size (m) that would give too many cells."""
    return InputError(
        f"a cell size of {size:.4g} m would give about {cells:.2g} cells, more than {MOST_CELLS}; "
        "choose a larger size, a lower frequency or a smaller region"
    )


def _outline_area(values: dict) -> float:
    """Return the area within the outline of a block, m²."""
    outline = shapely.Polygon(np.reshape(values["vertices"], (-1, 2)))
    if outline.is_valid and outline.area > _FLAT * outline.length**2:
        return outline.area
    raise InputError(
        f"block {values.get('name', '')!r} cannot be meshed: its outline crosses or touches "
        "itself, repeats a vertex, or encloses almost no area"
    )


def _bodies_of_mesh(mesh: Mesh, pieces: Sequence[Piece]) -> Iterator[tuple[str, list[int]]]:
    """Yield the name of each body of a mesh and the indices of its pieces."""
    kind = "regions" if mesh.regions else "blocks"
    patterns = mesh.regions or mesh.blocks
    for pattern in filter(None, map(str.strip, patterns.split(","))):
        if not any(is_listed(_mesh_key(piece, kind), pattern) for piece in pieces):
            names = sorted({_mesh_key(piece, kind) for piece in pieces} - {""})
            raise InputError(
                f"{kind} = {pattern!r} matches none of the {kind}"
                + (f" {', '.join(names[:12])}" if names else ": there are none")
                + (" …" if len(names) > 12 else "")
                + "; blocks of &layers, &drums, &wall and &blocks cannot be meshed"
            )
    members = [i for i, piece in enumerate(pieces) if is_listed(_mesh_key(piece, kind), patterns)]
    if mesh.body:
        yield _check_name(mesh.body), members
        return
    for i in members:
        if not pieces[i].name:
            raise InputError(f"{kind} = {patterns!r} matches a block that lacks a name; name it")
        yield _check_name(pieces[i].name), [i]


def _mesh_key(piece: Piece, kind: str) -> str:
    """Return the name by which &mesh selects a piece: its region or its block."""
    return piece.region if kind == "regions" else piece.name


def _check_name(name: str) -> str:
    """Return the name of a body; raise InputError if it is too long."""
    if len(name.encode()) > LONGEST_NAME:
        raise InputError(f"body {name!r} must have at most {LONGEST_NAME} bytes")
    return name


def _cut_body(mesh: Mesh, pieces: Sequence[Piece], materials: dict[str, dict]) -> Cut:
    """Return the cells of a body that consists of pieces; an error names the body."""
    parts = []
    for piece in pieces:
        values, size = piece.values, _cell_size(mesh, piece, materials)
        outline = np.reshape(values["vertices"], (-1, 2))
        joints = list(values.get("edge_joints", ()))
        joint = values.get("joint", "")
        joints = [name or joint for name in joints] + [joint] * (len(outline) - len(joints))
        parts.append(Part(outline, joints, size, piece.holes))
    fine = list(shapely.points(mesh.fine_at))
    if len(mesh.fine_along):
        fine.append(shapely.linestrings(mesh.fine_along))
    with located(f"body {mesh.body or pieces[0].name!r}"):
        return mesh_body(parts, mesh.cells, fine, mesh.fine_size, mesh.seed)


def _cell_values(body: str, cut: Cut, values: Sequence[dict]) -> Iterator[dict]:
    """Yield the variables of the &block groups of the cells."""
    rows = zip(cut.polygons, cut.joints, cut.parts.tolist(), strict=True)
    for polygon, joints, part in rows:
        polygon.flags.writeable = False
        block: dict = {"body": body}
        block |= {k: v for k in ("material", "joint") if (v := values[part].get(k))}
        block["vertices"] = polygon
        joint = block.get("joint", "")
        if any(edge_joint not in ("", joint) for edge_joint in joints):
            block["edge_joints"] = tuple(edge_joint or joint for edge_joint in joints)
        yield block


def _unusual_notes(body: str, cut: Cut) -> Iterator[str]:
    """Yield notes on sides of cells that are much shorter or longer than the local size."""
    for points, size_text in ((cut.short, "shorter than 0.05"), (cut.long, "longer than 1.6")):
        if len(points):
            examples = ", ".join(f"({x:.6g}, {y:.6g})" for x, y in points[:_NAMED])
            yield (
                f"body {body!r}: {len(points)} sides of cells are {size_text} times the local cell "
                f"size, for example at {examples}{' …' if len(points) > _NAMED else ''}"
            )
