# SPDX-License-Identifier: GPL-3.0-or-later
"""Hostile files of lines, polygons and blocks: DXF, GeoJSON, CSV, WKT, netCDF."""

import io
import json
import random
import struct
import tempfile
from functools import cache
from pathlib import Path

import numpy as np
from mutations import mutated_bytes, mutated_lines, mutated_number, rectangle

SQUARES = np.reshape(rectangle(0.0, 0.0, 1.0, 1.0) + rectangle(2.0, 0.0, 1.0, 1.0), (-1, 2))
DEPTHS = [2, 9, 40, 1000, 100_000]
SIZES = [0, 1, 3, 8, 1000, 2_000_000, 1_000_000_000]


def mutated_file(kind: str, seed: int) -> bytes:
    """Return one hostile file of a kind; the same seed gives the same bytes."""
    rng = random.Random(f"{kind} {seed}")
    make = MAKERS[kind]
    if rng.random() < 0.25:
        return make[1](rng)
    data = make[0](rng)
    for _ in range(rng.choice([1, 1, 2, 3])):
        changes = [mutated_bytes] if kind == "nc" else [mutated_bytes, mutated_lines,
                                                        mutated_number]  # fmt: skip
        data = rng.choice(changes)(rng, data)
    return data


def moved_corners(kind: str, seed: int) -> bytes:
    """Return one valid polygon with some changed coordinates."""
    rng = random.Random(f"corners {kind} {seed}")
    coordinates = [0.0, 1.0, 3.0, 4.0, 4.0000001, -4.0, 2.5, 1e3, 1e-9, 1e300]
    fraction = rng.choice([0.0, 0.1, 0.3, 1.0])
    ring = [[rng.choice(coordinates) if rng.random() < fraction else coordinate
             for coordinate in corner]
            for corner in ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))]  # fmt: skip
    closed_ring = [*ring, ring[0]]
    match kind:
        case "csv":
            text = "name, x, y\n" + "".join(f"a, {x}, {y}\n" for x, y in ring)
        case "wkt":
            text = f"POLYGON (({', '.join(f'{x} {y}' for x, y in closed_ring)}))\n"
        case "geojson":
            text = json.dumps({"type": "Polygon", "coordinates": [closed_ring]})
        case "dxf":
            corners = (f"0\nVERTEX\n8\na\n10\n{x}\n20\n{y}\n" for x, y in ring)
            text = (
                "0\nSECTION\n2\nENTITIES\n0\nPOLYLINE\n8\na\n66\n1\n70\n1\n"
                f"{''.join(corners)}0\nSEQEND\n0\nENDSEC\n0\nEOF\n"
            )
    return text.encode()


def good_csv(rng) -> bytes:
    """Return squares with names, or a line without a name."""
    if rng.random() < 0.5:
        return b"x, y\n0, 0\n4, 1\n9, 2\n"
    rows = [f"s{i // 4}, {x}, {y}" for i, (x, y) in enumerate(SQUARES)]
    return "\n".join(["name, x, y", *rows, ""]).encode()


def huge_csv(rng) -> bytes:
    """Return open quotes, very many rows, or many names."""
    return rng.choice([
        b'a, "' + b"x" * 300_000,
        b"1," * 200_000 + b"\n",
        b"".join(b"n%d,%d,0\n" % (i, i) for i in range(20_000)),
        b"x,y\n" + b"0,0\n" * 50_000,
    ])  # fmt: skip


def good_wkt(rng) -> bytes:
    """Return a polygon, lines and a collection."""
    ring = ", ".join(f"{x} {y}" for x, y in [*SQUARES[:4], SQUARES[0]])
    return (
        f"POLYGON (({ring}))\nLINESTRING (0 0, 4 1, 9 2)\n"
        f"GEOMETRYCOLLECTION (POLYGON (({ring})), MULTILINESTRING ((0 0, 1 1), (2 2, 3 3)))\n"
    ).encode()


def nested_wkt(rng) -> bytes:
    """Return nested collections."""
    depth = rng.choice(DEPTHS)
    inner = rng.choice(["POINT (0 0)", "LINESTRING (0 0, 1 1)", "POLYGON EMPTY", ""])
    return ("GEOMETRYCOLLECTION (" * depth + inner + ")" * depth).encode()


def good_geojson(rng) -> bytes:
    """Return features of several types."""
    ring = [*SQUARES[:4].tolist(), SQUARES[0].tolist()]
    shapes = [("Polygon", [ring]), ("LineString", ring[:3]), ("MultiPolygon", [[ring]])]
    features = [
        {"type": "Feature", "properties": {"name": f"f{i}", "layer": "a"},
         "geometry": {"type": kind, "coordinates": values}}
        for i, (kind, values) in enumerate(shapes)
    ]  # fmt: skip
    return json.dumps({"type": "FeatureCollection", "features": features}, indent=1).encode()


def nested_geojson(rng) -> bytes:
    """Return very many brackets, nested collections, or wrong types."""
    depth = rng.choice(DEPTHS)
    invalid_value = rng.choice(["null", "1e999", "{}", "[[[]]]", '"x"', "[[NaN, 0], [1, 1]]",
                                   "[[1]]"])  # fmt: skip
    return rng.choice([
        "[" * depth + "]" * depth,
        '{"type": "GeometryCollection", "geometries": [' * depth + "]}" * depth,
        '{"type": "LineString", "coordinates": ' + invalid_value + "}",
        '{"features": ' + invalid_value + "}",
        '{"a":' * depth + "1" + "}" * depth,
    ]).encode()  # fmt: skip


@cache
def good_dxf() -> bytes:
    """Return a drawing with a block that inserts itself."""
    import ezdxf

    drawing = ezdxf.new("R2000")
    space = drawing.modelspace()
    space.add_lwpolyline(SQUARES[:4], close=True)
    space.add_line((0, 0), (5, 5))
    space.add_circle((1, 1), 2)
    space.add_spline([(0, 0), (1, 2), (3, 1), (4, 4)])
    block = drawing.blocks.new("PART")
    block.add_line((0, 0), (1, 0))
    block.add_blockref("PART", (1, 1))  # inserts itself
    space.add_blockref("PART", (2, 2), {"row_count": 3, "column_count": 2})
    text = io.StringIO()
    drawing.write(text)
    return text.getvalue().encode()


def repeated_dxf(rng) -> bytes:
    """Return blocks that are inserted many times, or very many entities."""
    count = rng.choice([2, 1000, 32767, 10**9])
    start = b"0\nSECTION\n2\nENTITIES\n"
    line = b"0\nLINE\n8\n0\n10\n0\n20\n0\n11\n1\n21\n1\n"
    insert = b"0\nINSERT\n8\n0\n2\nPART\n10\n0\n20\n0\n70\n%d\n71\n%d\n" % (count, count)
    part = b"0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n8\n0\n2\nPART\n70\n0\n10\n0\n20\n0\n3\nPART\n1\n\n"
    blocks = part + line + b"0\nENDBLK\n8\n0\n0\nENDSEC\n"
    body = rng.choice([line * 5000, insert, insert * 100, line[:-4], b"0\nARC\n40\n1e300\n"])
    return blocks + start + body + b"0\nENDSEC\n0\nEOF\n"


@cache
def good_blocks() -> bytes:
    """Return two squares."""
    from sitedda.block_file import write_block_file

    with tempfile.TemporaryDirectory() as folder:
        blocks = [{"name": f"b{i}", "material": "rock", "joint": "bed", "vertices": corners}
                  for i, corners in enumerate(np.split(SQUARES, 2))]  # fmt: skip
        return write_block_file(Path(folder) / "good.nc", blocks).read_bytes()


def lying_blocks(rng) -> bytes:
    """Return variables with wrong types, dimensions and values."""
    import netCDF4

    valid_values = {"vertices": ("f8", SQUARES), "corners": ("i4", np.array([4, 4])),
                    "material": ("i4", np.array([1, 0])),
                    "edge_joint": ("i4", np.array([1, 0, 0, 0, 0, 0, 0, 1])),
                    "material_name": ("S1", np.array([list("rock")], dtype="S1")),
                    "joint_name": ("S1", np.array([list("bed")], dtype="S1")),
                    "name": ("S1", np.array([list("a"), list("b")], dtype="S1"))}  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "lies.nc"
        form = rng.choice(["NETCDF3_CLASSIC", "NETCDF3_64BIT_OFFSET", "NETCDF3_64BIT_DATA"])
        with netCDF4.Dataset(file, "w", format=form) as data:
            for name, (kind, values) in valid_values.items():
                if rng.random() < 0.05:
                    continue
                if rng.random() < 0.15:
                    _lie(rng, data, name)
                    continue
                values = values.copy()
                if kind != "S1" and rng.random() < 0.3:
                    new = float(rng.choice(["nan", "inf", "-1", "0", "3", "1e30", "1e9", "5"]))
                    if kind == "f8" or np.isfinite(new) and abs(new) < 2**31:
                        values.flat[rng.randrange(values.size)] = new
                _define(data, name, kind, values.shape)[:] = values
        content = bytearray(file.read_bytes())
    if rng.random() < 0.5:  # change a length or an offset in the header
        at = 4 * rng.randrange(1, 60)
        number = rng.choice([*SIZES, -1, 2**31 - 1, 2**30])
        content[at : at + 4] = struct.pack(">i", number)
    return bytes(content)


def _lie(rng, data, name: str) -> None:
    """Add an empty variable of random type and shape."""
    shape = [rng.choice([1, 2, 3, 4, 8, 1000]) for _ in range(rng.choice([0, 1, 1, 2, 2, 3]))]
    _define(data, name, rng.choice(["f8", "f4", "i4", "i2", "i1", "S1"]), shape[-2:])


def _define(data, name: str, kind, shape):
    for i, size in enumerate(shape):
        data.createDimension(f"{name}_{i}", size)
    return data.createVariable(name, kind, [f"{name}_{i}" for i in range(len(shape))])


MAKERS = {
    "csv": (good_csv, huge_csv),
    "wkt": (good_wkt, nested_wkt),
    "geojson": (good_geojson, nested_geojson),
    "dxf": (lambda _: good_dxf(), repeated_dxf),
    "nc": (lambda _: good_blocks(), lying_blocks),
}
