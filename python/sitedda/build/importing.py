# SPDX-License-Identifier: GPL-3.0-or-later
"""Read lines and polygons from untrusted DXF, GeoJSON, WKT and CSV files."""

import csv
import json
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
import shapely

from ..base.errors import InputError, OutputError
from ..base.reading import check_readable

MOST_BYTES = 64 * 2**20  # largest size of a file
MOST_POINTS = 2_000_000  # largest number of points of all lines of a file
MOST_OF_CURVE = 20_000
MOST_LINES = 500_000
DEEPEST = 8  # largest depth of nested blocks or collections
_FARTHEST = 1e9  # largest coordinate, m
_SAGITTA = 1e-3  # largest distance of chords from a curve / size of the curve
_UNITS = {1: 0.0254, 2: 0.3048, 4: 1e-3, 5: 1e-2, 6: 1.0, 7: 1e3, 10: 0.9144, 14: 0.1}


@dataclass
class Outline:
    """A line of a file."""

    points: np.ndarray  # shape (n, 2), m; a closed line does not repeat its first point
    closed: bool
    name: str = ""  # name of the line, or blank
    layer: str = ""

    def closed_points(self, group: str) -> np.ndarray:
        """Return the points for a kind of group; a closed &joint_line repeats its first point."""
        if self.closed and group == "joint_line":
            return np.vstack([self.points, self.points[:1]])
        return self.points


def read_outlines(
    file, layer: str | None = None, scale: float | None = None, closed: bool | None = None
) -> list[Outline]:
    """Read the lines and polygons of a file.

    `file`: ``.dxf``, ``.geojson`` or ``.json``, ``.wkt``, ``.csv`` or ``.txt``.
    `layer`: read only lines of this layer (DXF), or with this property ``layer`` (GeoJSON).
    `scale`: metres per unit of the file (default: from the header of a DXF file, otherwise 1).
    `closed`: read only closed lines, or only open lines.

    Notes
    -----
    A CSV file has one row per point: x, y, or name, x, y, or columns with these headings.  Points
    with the same name must be consecutive and form a line; without names, all points form one line.
    A line is closed if its last point equals the first.
    """
    file = Path(file)
    readers = {".dxf": _read_dxf, ".geojson": _read_geojson, ".json": _read_geojson}
    readers |= {".wkt": _read_wkt, ".csv": _read_csv, ".txt": _read_csv}
    reader = readers.get(file.suffix.lower())
    if reader is None:
        endings = ", ".join(readers)
        raise InputError(f"{file}: the name must end in one of {endings}")
    if scale is not None and not 0 < scale <= 1e6:
        raise InputError(f"scale = {scale:g} must be a positive number")
    if (size := check_readable(file)) > MOST_BYTES:
        raise InputError(f"{file} has {size} bytes, more than {MOST_BYTES}")
    try:
        outlines = list(_check_lines(file, reader(file, scale)))
    except OSError as error:
        raise OutputError(f"{file} cannot be read: {error.strerror}") from error
    except RecursionError:
        raise InputError(f"{file}: nested too deeply") from None
    if layer is not None:
        layers = sorted({outline.layer for outline in outlines})
        outlines = [outline for outline in outlines if outline.layer == layer]
        if not outlines:
            names = ", ".join(map(repr, filter(None, layers[:12]))) or "none"
            raise InputError(f"{file}: layer {layer!r} is empty or missing; the layers: {names}")
    if closed is not None:
        outlines = [outline for outline in outlines if outline.closed == closed]
    if not outlines:
        kind = {None: "lines", True: "closed lines", False: "open lines"}[closed]
        raise InputError(f"{file} contains no {kind}")
    return outlines


def _check_lines(file: Path, lines) -> Iterator[Outline]:
    """Yield lines with checked points; omit the repeated last point of closed lines."""
    total = 0
    for count, (points, is_closed, name, layer) in enumerate(lines, 1):
        total += len(points)
        if count > MOST_LINES or total > MOST_POINTS:
            raise InputError(f"{file} has more than {MOST_LINES} lines or {MOST_POINTS} points")
        points = np.array(points, dtype=float).reshape(-1, 2)
        if not (abs(points) <= _FARTHEST).all():
            raise InputError(
                f"{file}: line {count} {name} has a point that lies beyond {_FARTHEST:g} m or is "
                "not a number"
            )
        is_repeated = len(points) > 3 and (points[0] == points[-1]).all()
        points = points[:-1] if is_repeated else points
        if len(points) >= 2:
            yield Outline(points, bool(is_closed or is_repeated), name[:64], layer)


# --- Formats -------------------------------------------------------------------------------------


def _read_text(file: Path) -> str:
    """Return the text of a UTF-8 file."""
    try:
        return file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{file} is not a text file in UTF-8") from None


def _read_csv(file: Path, scale):
    """Yield the lines of a CSV file: one per sequence of points with the same name."""
    try:
        table = csv.reader(_read_text(file).splitlines())
        rows = [row for row in table if row and row[0][:1] != "#"]
    except csv.Error as error:
        raise InputError(f"{file} cannot be read as CSV: {error}") from None
    rows = [[cell.strip() for cell in row] for row in rows]
    if not rows:
        return
    heads = [cell.lower() for cell in rows[0]]
    if "x" in heads and "y" in heads:
        x, y, rows, start = heads.index("x"), heads.index("y"), rows[1:], 2
        name = next((heads.index(key) for key in ("name", "block") if key in heads), None)
    else:
        x, y, start, name = (0, 1, 1, None) if len(rows[0]) < 3 else (1, 2, 1, 0)
    lines: list[tuple[str, list]] = []
    for number, row in enumerate(rows, start):
        try:
            point = (float(row[x]), float(row[y]))
        except (ValueError, IndexError):
            raise InputError(
                f"{file}, row {number}: {','.join(row)[:60]!r} contains no numbers x, y"
            ) from None
        label = row[name] if name is not None and name < len(row) else ""
        if not lines or lines[-1][0] != label:
            lines.append((label, []))
        lines[-1][1].append(point)
    for label, points in lines:
        yield np.array(points) * (scale or 1.0), name is not None, label, ""


def _read_wkt(file: Path, scale):
    """Yield the lines of a WKT file with one geometry per row."""
    for number, line in enumerate(_read_text(file).splitlines(), 1):
        if not line.strip() or line.lstrip()[0] == "#":
            continue
        if _nesting_depth(line, "(") > DEEPEST:
            raise InputError(f"{file}, line {number}: nested too deeply")
        try:
            shape = shapely.from_wkt(line)
        except (shapely.errors.ShapelyError, UnicodeError) as error:
            reason = str(error).splitlines()[0][:100]
            raise InputError(f"{file}, line {number}: {reason}") from None
        yield from _shape_lines(file, shape, scale or 1.0, "", "")


def _nesting_depth(text: str, opening: str) -> int:
    """Return the largest depth of nested brackets in a text."""
    deepest = depth = 0
    for mark in text:
        depth += (mark in opening) - (mark in ")]}")
        deepest = max(deepest, depth)
    return deepest


def _shape_lines(source, shape, scale: float, name: str, layer: str, depth: int = 0):
    """Yield the lines of a shapely geometry, with their closure, name and layer."""
    if depth > DEEPEST:
        raise InputError(f"{source}: nested too deeply")
    if hasattr(shape, "geoms"):
        for part in shape.geoms:
            yield from _shape_lines(source, part, scale, name, layer, depth + 1)
    elif shape.geom_type == "Polygon" and not shape.is_empty:
        if len(shape.interiors):
            raise InputError(f"{source}: polygon {name!r} has holes; give each hole as a polygon")
        yield shapely.get_coordinates(shape.exterior) * scale, True, name, layer
    elif shape.geom_type in ("LineString", "LinearRing"):
        yield shapely.get_coordinates(shape) * scale, False, name, layer


def _read_geojson(file: Path, scale):
    """Yield the lines of a GeoJSON file: features, collections of features, or geometries."""
    text = _read_text(file)
    if _nesting_depth(text, "([{") > 4 * DEEPEST:
        raise InputError(f"{file}: nested too deeply")
    try:
        data = json.loads(text)
    except ValueError as error:
        raise InputError(f"{file} is not JSON: {error}") from None
    features = data.get("features", [data]) if isinstance(data, dict) else None
    if not isinstance(features, list):
        raise InputError(f"{file} is not GeoJSON: it contains no features")
    for number, feature in enumerate(features, 1):
        source = f"{file}, feature {number}"
        if not isinstance(feature, dict):
            raise InputError(f"{source} is not an object")
        geometry = feature.get("geometry", feature)
        properties = feature.get("properties")
        properties = properties if isinstance(properties, dict) else {}
        name, layer = (str(properties.get(key) or "") for key in ("name", "layer"))
        if geometry is None:
            continue
        try:
            shape = shapely.geometry.shape(geometry)
        except shapely.errors.GeometryTypeError:
            raise InputError(f"{source}: the type {geometry['type']!r} is not known") from None
        except Exception:  # shapely raises many kinds of exceptions for a broken geometry
            raise InputError(f"{source}: its coordinates are not pairs of numbers") from None
        yield from _shape_lines(source, shape, scale or 1.0, name, layer)


def _read_dxf(file: Path, scale):
    """Yield lines, polylines, arcs, circles, ellipses and splines in the model space of a DXF."""
    try:
        import ezdxf
    except ImportError:
        raise InputError(
            f"{file}: reading DXF needs the package ezdxf (pip install sitedda[dxf])"
        ) from None
    try:
        drawing = ezdxf.readfile(file)
    except OSError as error:
        raise InputError(f"{file} is not a DXF file: {error}") from None
    except Exception as error:  # a third-party parser may raise any exception
        reason = (str(error).splitlines() or [type(error).__name__])[0][:100]
        raise InputError(f"{file} cannot be read as DXF: {reason}") from None
    unit = scale or _UNITS.get(drawing.units, 1.0)
    budget = [MOST_LINES]
    for entity in drawing.modelspace():
        for points, is_closed, layer in _entity_lines(file, entity, budget, 0):
            yield np.asarray(points) * unit, is_closed, "", layer


def _entity_lines(file: Path, entity, budget: list[int], depth: int):
    """Yield the lines of a DXF entity and of the blocks that it inserts; limit the nesting."""
    from ezdxf import path

    budget[0] -= 1
    if depth > DEEPEST or budget[0] < 0:
        raise InputError(f"{file}: blocks are nested too deeply, or inserted too often")
    kind = entity.dxftype()
    try:
        if kind == "INSERT":
            rows = max(1, entity.dxf.row_count) * max(1, entity.dxf.column_count)
            if rows > budget[0]:
                raise InputError(f"{file}: a block is inserted {rows} times, above the limit")
            for instance in entity.multi_insert() if rows > 1 else [entity]:
                for part in instance.virtual_entities():
                    yield from _entity_lines(file, part, budget, depth + 1)
        elif kind in ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE"):
            curve = path.make_path(entity)
            size = path.bbox([curve]).size.magnitude
            if not size <= 1e6 * _FARTHEST:  # in units of the file; also rejects NaN
                raise InputError(f"{file}: an entity {kind} has no finite size")
            sagitta = _SAGITTA * max(size, 1e-9)
            points = [(p.x, p.y) for p in islice(curve.flattening(sagitta), MOST_OF_CURVE + 1)]
            if len(points) > MOST_OF_CURVE:
                raise InputError(f"{file} contains a curve of more than {MOST_OF_CURVE} points")
            yield points, curve.is_closed, entity.dxf.get("layer", "")
    except InputError:
        raise
    except Exception as error:  # a broken entity may raise any exception
        raise InputError(f"{file}: an entity {kind} cannot be read: {error}") from None
