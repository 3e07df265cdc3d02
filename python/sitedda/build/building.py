# SPDX-License-Identifier: GPL-3.0-or-later
"""Convert groups of joints, masonry and ground into the blocks that the engine reads."""

import os
import re
from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from ..base.errors import InputError, located
from ..base.files import OWN_INPUT, is_same, write
from ..input.block_file import LARGE, write_block_file
from ..input.changes import with_files
from ..input.groups import checked, group_text, is_made, nearest, read_values
from ..input.input_text import ParsedGroup, find_groups
from ..input.source import Built, blocks_text, read_input
from ..input.values import Values, is_given
from .magnitudes import doubtful_sizes

_NAMED = ("material", "joint", "region")  # kinds of groups to which other groups refer by name

_MESH = re.compile(r"^[^!\n]*&mesh\b", re.IGNORECASE | re.MULTILINE)


@cache
def kinds() -> dict[str, Any]:
    """Return the class of each group that is converted; new modules are registered here.

    `blocks()` of a class returns its blocks; `groups(folder, others)` returns groups (names and
    variables) and notes, from the folder and all groups (names and variables) of the input.
    """
    from . import ground, layered, masonry, wall
    from .cutting import geometry
    from .meshing import settings

    return {
        item.group: item
        for module in (geometry, masonry, settings, wall, layered, ground)
        for item in vars(module).values()
        if isinstance(item, type) and issubclass(item, Values) and item.group
    }


def build_blocks(groups: Sequence[tuple[str, dict, str]], folder) -> Built:
    """Build the blocks from the groups of an input.

    `groups`: name, variables, and position in the file for messages of each group; `folder`: folder
    to which file names are relative.
    """
    built = Built()
    pieces: list[dict] = []
    groups = [*groups, *_expand_groups(built, pieces, groups, folder)]
    names = _names_by_kind(groups)
    composed = [group for group in groups if is_made(group[0])]
    for _, values, source in composed:
        _check_names(names, values, source)
    parts: dict[str, list] = defaultdict(list)
    meshes, first_source, sources = [], "", {}
    for name, values, source in composed:
        if _expands_to_groups(name):
            continue
        with located(source):
            if name == "mesh":
                meshes.append((_make_object("mesh", values), source))
            elif name == "polygons":
                pieces += _import_blocks(values, folder)
            elif hasattr(kinds()[name], "blocks"):
                stones = _make_object(name, values).blocks()
                pieces += [_block_values(vars(stone)) for stone in stones]
            else:
                objects = _read_objects(name, values, folder)
                parts[name] += objects
                sources |= {id(part): source for part in objects}
                first_source = first_source or source
    cut = None
    if meshes:
        from .meshing.meshed import refuse_far_too_many

        refuse_far_too_many(parts["region"], meshes, _materials_by_name(groups))
    if any(parts.values()):
        try:
            cut = _cut_regions(built, parts, next(iter(names["joint"]), ""), bool(meshes))
        except InputError as error:
            with located(sources.get(id(error.cause), first_source)):
                raise
    built.blocks += pieces
    built.messages += doubtful_sizes(groups)
    if meshes:
        _mesh_pieces(built, groups, meshes, cut)
    return built


def _expands_to_groups(name: str) -> bool:
    """Return whether a group, such as a masonry wall, expands to other groups."""
    return hasattr(kinds().get(name), "groups")


def _expand_groups(built: Built, pieces: list[dict], groups, folder) -> list[tuple[str, dict, str]]:
    """Return the groups that composed groups expand to; append their blocks to `pieces`."""
    result: list[tuple[str, dict, str]] = []
    pairs = [(name, values) for name, values, _ in groups]
    for name, values, source in groups:
        if not _expands_to_groups(name):
            continue
        with located(source):
            parts, notes = _make_object(name, values).groups(folder, pairs)
            parts = [
                (kind, {n: checked(kind, n, v) for n, v in content.items() if is_given(v)})
                for kind, content in parts
            ]
        pieces += [dict(content) for kind, content in parts if kind == "block"]
        joints = [(kind, content) for kind, content in parts if kind != "block"]
        built.groups += [(kind, content) for kind, content in joints if not is_made(kind)]
        built.messages += notes
        result += [(kind, content, source) for kind, content in joints]
    return result


def _mesh_pieces(built: Built, groups, meshes, cut) -> None:
    """Replace meshed blocks by their cells."""
    from .meshing.meshed import Piece, mesh_blocks

    typed = [i for i, group in enumerate(groups) if group[0] == "block"]
    pieces = [Piece(block) for block in built.blocks]
    if cut is not None:
        for piece, region, holes in zip(pieces, cut.regions, cut.holes, strict=False):
            piece.region, piece.holes = region, holes
    pieces += [Piece(groups[i][1]) for i in typed]
    cells, meshed, messages = mesh_blocks(pieces, meshes, _materials_by_name(groups))
    ring = next((p for i, p in enumerate(pieces) if p.holes and i not in meshed), None)
    if ring is not None:
        raise InputError(
            f"block {ring.name!r} is a ring around the hole or region with a corner at "
            f"({ring.holes[0][0][0, 0]:.6g}, {ring.holes[0][0][0, 1]:.6g}); cut it by a joint, or "
            "mesh it"
        )
    count, removed = len(built.blocks), set(meshed)
    built.meshed = [typed[i - count] for i in meshed if i >= count]
    built.blocks = [item for i, item in enumerate(built.blocks) if i not in removed] + cells
    built.messages += messages


def _materials_by_name(groups) -> dict[str, dict]:
    """Return the variables of each &material by its name, in the order of the input."""
    return {values.get("name", ""): values for kind, values, _ in groups if kind == "material"}


def _names_by_kind(groups) -> dict[str, list[str]]:
    """Return the names of materials, joints and regions, by kind of group."""
    names = {kind: [] for kind in _NAMED}
    for kind, values, _ in groups:
        if kind in _NAMED:
            names[kind].append(values.get("name", getattr(kinds().get(kind), "name", "")))
    return names


def _check_names(names: dict[str, list[str]], values: dict, source: str) -> None:
    """Raise InputError if a group refers to a material, joint or region that does not exist."""
    for variable, name in values.items():
        kind = variable.removeprefix("core_")
        if kind in _NAMED and name and name not in names[kind]:
            hint = nearest(name, names[kind])
            raise InputError(f"{source}: {variable} = {name!r} is not the name of a &{kind}{hint}")


def _make_object(name: str, values: dict):
    """Return the object that a group describes; its class is in `kinds`."""
    try:
        return kinds()[name](**values)
    except TypeError:
        raise InputError("a variable is missing or of the wrong kind") from None


def _block_values(values: dict) -> dict:
    """Return the variables of a &block from the attributes of a stone; omit blank texts."""
    values = dict(values)
    values["vertices"] = values.pop("polygon")
    values["vertices"].flags.writeable = False
    return {name: value for name, value in values.items() if not isinstance(value, str) or value}


def _read_objects(name: str, values: dict, folder) -> list:
    """Return the object of a group, or one object per line of its file."""
    points, values = kinds()[name].from_file, dict(values)
    if not points or "file" not in values:
        for option in ("layer", "scale"):
            if points and option in values:
                raise InputError(f"`{option}` requires `file`")
        return [_make_object(name, values)]
    if points in values:
        raise InputError(f"give either `{points}` or `file`")
    from .importing import read_outlines

    source = Path(folder) / values.pop("file")
    outlines = read_outlines(source, values.pop("layer", None), values.pop("scale", None))
    if name != "joint_line" and len(outlines) != 1:
        raise InputError(f"the file contains {len(outlines)} lines instead of one; set `layer`")
    vertices = [outline.closed_points(name) for outline in outlines]
    return [_make_object(name, values | {points: corners}) for corners in vertices]


def _import_blocks(values: dict, folder) -> list[dict]:
    """Return blocks from the closed polygons of a file."""
    from .cutting.geometry import outline_of
    from .importing import read_outlines

    if "file" not in values:
        raise InputError("`file` is missing")
    stem = values.get("name", "block")
    options = {key: values[key] for key in ("material", "joint") if key in values}
    source = Path(folder) / values["file"]
    outlines = read_outlines(source, values.get("layer"), values.get("scale"), closed=True)
    blocks = []
    for i, outline in enumerate(outlines, 1):
        vertices = outline_of(f"polygon {i}", outline.points)
        blocks.append({"name": outline.name or f"{stem}_{i}", **options, "vertices": vertices})
    return blocks


def _cut_regions(built: Built, parts: dict[str, list], first_joint: str, rings: bool):
    """Cut the regions into blocks, append these to `built`, and return the cut blocks.

    Edges without a joint get the first joint of the input.
    """
    from .cutting import cut

    if len(parts["cutting"]) > 1:
        raise InputError("&cutting may appear only once")
    if not parts["region"]:
        kind = next(name for name, objects in parts.items() if objects)
        raise InputError(f"&{kind} needs a &region")
    blocks = cut(
        parts["region"],
        parts["joint_line"] + parts["joint_set"] + parts["voronoi"],
        parts["surface"],
        parts["hole"] + parts["tunnel"],
        parts["excavation"],
        parts["cutting"][0] if parts["cutting"] else None,
        rings,
    )
    built.messages += blocks.messages
    built.slivers = list(map(str, blocks.slivers))
    rows = zip(
        blocks.names, blocks.materials, blocks.joints, blocks.polygons, blocks.edge_joints,
        strict=True,
    )  # fmt: skip
    for name, material, joint, polygon, edges in rows:
        joint = joint or first_joint
        piece = {"name": name, "material": material, "joint": joint, "polygon": polygon}
        block = _block_values(piece)
        edges = tuple(edge or first_joint for edge in edges)
        if any(edge != joint for edge in edges):
            block["edge_joints"] = edges
        built.blocks.append(block)
    return blocks


def block_writer(
    file, block_file: bool | None = None, reads: Sequence = ()
) -> Callable[[Sequence[dict]], str]:
    """Return a function that writes blocks as namelist text or as block files beside it.

    `file`: the namelist file.  Block files are NAME.blocks.nc, NAME.blocks_2.nc and so on.
    `block_file`: always or never write block files (default: for 10,000 blocks or more).
    `reads`: files from which the blocks may be read; these must not be replaced.
    """
    numbers = count(1)

    def put(blocks: Sequence[dict]) -> str:
        if not (len(blocks) >= LARGE if block_file is None else block_file):
            return blocks_text(blocks)
        number = next(numbers)
        name = Path(file).with_suffix(f".blocks_{number}.nc" if number > 1 else ".blocks.nc")
        return group_text("blocks", {"file": write_block_file(name, blocks, reads).name})

    return put


def built_text(text: str, file, write_blocks: Callable = blocks_text) -> tuple[str, Built]:
    """Convert the groups of joints and masonry of a namelist text into blocks.

    These groups remain as comments; the numbers of all other lines do not change.

    `file`: file of the text, for messages and relative file names; `write_blocks`: converts the
    blocks into text.
    """
    typed = () if _MESH.search(text) else ("block",)  # only a mesh needs the existing blocks
    all_groups = find_groups(text, file, typed)
    if not any(is_made(group.name) for group in all_groups):
        return text, Built()
    relevant = [
        group
        for group in all_groups
        if is_made(group.name) or group.name in _NAMED or (group.name == "block" and not typed)
    ]
    typed_values = [(group.name, read_values(group, file), group.place(file)) for group in relevant]
    built = build_blocks(typed_values, Path(file).parent)
    meshed = {id(relevant[i]) for i in built.meshed}
    replaced = [group for group in all_groups if is_made(group.name) or id(group) in meshed]
    head = f"! {len(built.blocks)} blocks, made from the groups in the comments above.\n"
    body = _comment_out(text, replaced)
    end = "" if body.endswith("\n") else "\n"
    rest_text = "".join(group_text(kind, values) for kind, values in built.groups)
    return f"{body}{end}\n{head}{rest_text}{write_blocks(built.blocks)}", built


def _comment_out(text: str, groups: Sequence[ParsedGroup]) -> str:
    """Replace groups by comments, or by blanks if they share a line with other groups."""
    parts, start = [], 0
    for item in groups:
        line = text.rfind("\n", 0, item.start) + 1
        rest_of_line = text[item.end :].split("\n", 1)[0].strip()
        separate = not text[max(line, start) : item.start].strip() and (
            not rest_of_line or rest_of_line[0] == "!"
        )
        group = text[item.start : item.end]
        parts.append(text[start : item.start])
        comment, blanks = "! " + group.replace("\n", "\n! "), re.sub(r"[^\n]", " ", group)
        parts.append(comment if separate and line >= start else blanks)
        start = item.end
    return "".join(parts) + text[start:]


def build_file(file, output=None, block_file: bool | None = None) -> tuple[Path, Built]:
    """Convert the groups of joints and masonry of an input into blocks and write the result.

    `file`: namelist input; `output`: file to write (NAME_blocks.nml beside the input);
    `block_file`: write the blocks to a netCDF file, NAME_blocks.blocks.nc (default: for 10,000 or
    more).

    The result is the path of the written file, and the blocks.
    """
    file = Path(file)
    output = Path(output) if output else file.with_name(f"{file.stem}_blocks.nml")
    text = read_input(file)
    if is_same(output, file):
        raise InputError(f"{output} is the input itself; name another output file")
    text = _rename_files(text, file, output.parent)
    text, built = built_text(text, file, block_writer(output, block_file, [file]))
    return write(output, text, OWN_INPUT, [file]), built


def _rename_files(text: str, file: Path, target: Path) -> str:
    """Return a text in which paths of record and block files are relative to another folder."""
    folder = file.parent

    def name_from(group: ParsedGroup) -> str:
        name = group.values.get("file", "")
        moves = group.name in ("motion", "blocks") and name and not os.path.isabs(name)
        return os.path.relpath(folder / name, target) if moves else ""

    return text if folder.resolve() == target.resolve() else with_files(text, name_from, file)


def summary(built: Built) -> str:
    """Return the number of blocks with the same name, up to its final number, in one line."""
    stems: Counter = Counter()
    for block in built.blocks:
        stem = re.sub(r"_?\d*$", "", block.get("name", ""))
        stems[f"cells of {block['body']}" if "body" in block else stem] += 1
    corners = sum(len(np.reshape(block["vertices"], (-1, 2))) for block in built.blocks)
    listed = ", ".join(f"{count} {stem}" for stem, count in list(stems.items())[:12])
    return f"{len(built.blocks)} blocks with {corners} corners: {listed}"
