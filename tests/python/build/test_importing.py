# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines and polygons from files of other programs, which are not trusted."""

import json
import os

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from model_text import flying_block, namelist

import sitedda
from sitedda import SiteddaError
from sitedda.importing import DEEPEST, MOST_BYTES, read_outlines

TRIANGLE = [[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]]


def geojson(*geometries, **properties):
    features = [
        {"type": "Feature", "geometry": geometry, "properties": properties}
        for geometry in geometries
    ]
    return json.dumps({"type": "FeatureCollection", "features": features})


POLYGON = {"type": "Polygon", "coordinates": [[*TRIANGLE, TRIANGLE[0]]]}
LINE = {"type": "LineString", "coordinates": [[0, 1, 9.0], [5, 1, 9.0]]}


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.geojson", geojson(POLYGON, LINE)),
        ("a.json", json.dumps({"type": "GeometryCollection", "geometries": [POLYGON, LINE]})),
        ("a.wkt", "# two\nPOLYGON ((0 0, 4 0, 0 3, 0 0))\nLINESTRING Z (0 1 9, 5 1 9)\n"),
        (
            "a.wkt",
            "GEOMETRYCOLLECTION (MULTIPOLYGON (((0 0, 4 0, 0 3, 0 0))), LINESTRING (0 1, 5 1))",
        ),
    ],
)  # fmt: skip
def test_polygons_and_lines_are_read(name, text, tmp_path):
    (tmp_path / name).write_text(text)
    polygon, line = read_outlines(tmp_path / name)
    assert polygon.closed and polygon.points.tolist() == TRIANGLE
    assert not line.closed and line.points.tolist() == [[0, 1], [5, 1]]
    assert len(read_outlines(tmp_path / name, closed=True)) == 1
    assert read_outlines(tmp_path / name, scale=0.5)[1].points[1, 0] == 2.5


@pytest.mark.parametrize(
    ("text", "closed", "names"),
    [
        ("0, 0\n4, 0\n0, 3\n", [False], [""]),
        ("# x and y\nx,y\n0,0\n4,0\n0,3\n0,0\n", [True], [""]),
        ("a,0,0\na,4,0\na,0,3\nb,0,0\nb,4,0\nb,0,3\n", [True, True], ["a", "b"]),
        ("block,depth,x,y\na,1,0,0\na,2,4,0\na,3,0,3\n", [True], ["a"]),
    ],
)
def test_tables_of_points_are_read(text, closed, names, tmp_path):
    (tmp_path / "a.csv").write_text(text)
    outlines = read_outlines(tmp_path / "a.csv")
    assert [outline.closed for outline in outlines] == closed and [
        outline.name for outline in outlines
    ] == names
    assert all(outline.points.tolist() == TRIANGLE for outline in outlines)


def drawing(tmp_path):
    """A DXF file in millimetres with most kinds of entities, one in a block inserted twice."""
    ezdxf = pytest.importorskip("ezdxf")
    document = ezdxf.new(units=4)
    space = document.modelspace()
    at = {"layer": "outline"}
    space.add_lwpolyline(1000 * np.array(TRIANGLE), close=True, dxfattribs=at)
    space.add_line((0, 1000), (5000, 1000), dxfattribs={"layer": "fault"})
    space.add_circle((0, 0), 2000, dxfattribs={"layer": "tunnel"})
    space.add_spline([(0, 0), (1000, 500), (2000, 0)], dxfattribs={"layer": "curve"})
    space.add_text("words")
    part = document.blocks.new("part")
    part.add_line((0, 0), (1000, 0), dxfattribs={"layer": "part"})
    space.add_blockref("part", (0, 0))
    space.add_blockref("part", (0, 500), dxfattribs={"rotation": 90})
    document.saveas(tmp_path / "a.dxf")
    return tmp_path / "a.dxf"


def test_drawings_are_read(tmp_path):
    file = drawing(tmp_path)
    outline = read_outlines(file, layer="outline")[0]
    assert outline.closed and outline.points == pytest.approx(np.array(TRIANGLE), abs=1e-12)
    assert read_outlines(file, layer="fault")[0].points.tolist() == [[0, 1], [5, 1]]
    assert read_outlines(file, "fault", scale=1.0)[0].points[1, 0] == 5000
    circle = read_outlines(file, layer="tunnel", closed=True)[0].points
    assert np.hypot(*circle.T) == pytest.approx(2.0, rel=1e-3) and len(circle) > 30
    assert len(read_outlines(file, layer="curve")[0].points) > 5
    ends = [one.points[1] for one in read_outlines(file, layer="part")]
    assert ends == [pytest.approx([1, 0]), pytest.approx([0, 1.5], abs=1e-9)]


def test_groups_read_their_points_from_files(tmp_path):
    file = drawing(tmp_path)
    (tmp_path / "top.csv").write_text("x,y\n0,0.5\n9,0.5\n")
    text = namelist(flying_block()) + (
        "&region name = 'r', file = 'a.dxf', layer = 'outline' /\n"
        "&joint_line file = 'a.dxf', layer = 'fault' /\n"
        "&surface file = 'top.csv' /\n"
        "&polygons file = 'b.geojson', name = 'p' /\n"
    )
    (tmp_path / "b.geojson").write_text(geojson({
        "type": "Polygon", "coordinates": [[[x, y + 20] for x, y in reversed(TRIANGLE)]]
    }))  # fmt: skip
    file.with_name("m.nml").write_text(text)
    with pytest.raises(sitedda.InputError, match="overlaps"):
        sitedda.Simulation(tmp_path / "m.nml")
    changed_text = text.replace(
        "0.0, 0.0, 2.0, 0.0, 2.0, 1.0, 0.0, 1.0", "50.0, 0.0, 52.0, 0.0, 52.0, 1.0, 50.0, 1.0"
    ).replace("x = 2.0", "x = 52.0")
    file.with_name("m.nml").write_text(changed_text)
    with sitedda.Simulation(tmp_path / "m.nml") as simulation:
        assert simulation.block_names == ["brick", "r_1", "r_2", "r_3", "p_1"]


BAD = {
    "unknown kind": ("a.xyz", "0 0", "must end in"),
    "no lines": ("a.csv", "", "contains no lines"),
    "no number": ("a.csv", "x,y\n0,0\n1,b\n", "row 3: '1,b'"),
    "one column": ("a.csv", "0\n1\n", "row 1"),
    "nan": ("a.csv", "0,0\n1,nan\n2,2\n", "not a number"),
    "infinite": ("a.csv", "0,0\n1,1e400\n2,2\n", "not a number"),
    "far": ("a.csv", "0,0\n1,1e12\n", "beyond"),
    "not text": ("a.csv", b"\xff\xfe\x00\x01", "not a text file"),
    "broken json": ("a.json", "{", "not JSON"),
    "list": ("a.json", "[1, 2]", "not GeoJSON"),
    "no features": ("a.json", '{"features": 3}', "not GeoJSON"),
    "feature of text": ("a.json", '{"features": ["x"]}', "feature 1 is not an object"),
    "type": ("a.json", '{"type": "Ball"}', "'Ball' is not known"),
    "flat": ("a.json", '{"type": "Polygon", "coordinates": [[1, 2]]}', "not pairs"),
    "text": ("a.json", '{"type": "LineString", "coordinates": [["a", "b"], [1, 2]]}', "not pairs"),
    "null": ("a.json", '{"type": "LineString", "coordinates": null}', "contains no lines"),
    "huge": ("a.json", '{"type": "LineString", "coordinates": [[1e999, 0], [1, 2]]}', "number"),
    "hole": (
        "a.json", json.dumps({"type": "Polygon", "coordinates": [TRIANGLE, TRIANGLE]}), "holes",
    ),
    "deep json": ("a.json", "[" * 100_000, "nested too deeply"),
    "deep wkt": ("a.wkt", "GEOMETRYCOLLECTION (" * 5000, "nested too deeply"),
    "broken wkt": ("a.wkt", "POLYGON ((0 0, 1", "line 1"),
    "no dxf": ("a.dxf", "hello", "not a DXF file"),
    "binary dxf": ("a.dxf", b"AutoCAD Binary DXF\r\n\x1a\x00\xff\xff", "cannot be read as DXF"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_files_are_refused_with_a_reason(name, tmp_path):
    file, content, message = BAD[name]
    if file.endswith("dxf"):
        pytest.importorskip("ezdxf")
    (tmp_path / file).write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(SiteddaError) as error:
        read_outlines(tmp_path / file)
    assert message in str(error.value) and (file in str(error.value))


def test_size_and_kind_of_a_file_are_checked_first(tmp_path):
    large = tmp_path / "large.csv"
    with large.open("wb") as file:
        os.truncate(file.fileno(), MOST_BYTES + 1)
    (tmp_path / "folder.csv").mkdir()
    for name, message in (
        ("large", "more than"),
        ("folder", "not a regular file"),
        ("gone", "no such file"),
    ):
        with pytest.raises(SiteddaError, match=message):
            read_outlines(tmp_path / f"{name}.csv")
    with pytest.raises(SiteddaError, match="layer 'x' is empty or missing"):
        read_outlines(drawing(tmp_path), layer="x")
    (tmp_path / "plain.wkt").write_text("LINESTRING (0 0, 1 1)\n")
    with pytest.raises(SiteddaError, match=r"layer 'x' is empty or missing; the layers: none$"):
        read_outlines(tmp_path / "plain.wkt", layer="x")


def test_nesting_of_inserted_blocks_is_limited(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    document = ezdxf.new()
    document.blocks.new("b0").add_line((0, 0), (1, 0))
    for level in range(1, DEEPEST + 2):
        document.blocks.new(f"b{level}").add_blockref(f"b{level - 1}", (0, 0))
    document.modelspace().add_blockref(f"b{DEEPEST + 1}", (0, 0))
    document.saveas(tmp_path / "deep.dxf")
    with pytest.raises(SiteddaError, match="nested too deeply"):
        read_outlines(tmp_path / "deep.dxf")
    document = ezdxf.new()
    document.blocks.new("b").add_line((0, 0), (1, 0))
    many = {"row_count": 30_000, "column_count": 30_000, "row_spacing": 1, "column_spacing": 1}
    document.modelspace().add_blockref("b", (0, 0), dxfattribs=many)
    document.saveas(tmp_path / "many.dxf")
    with pytest.raises(SiteddaError, match="inserted 900000000 times"):
        read_outlines(tmp_path / "many.dxf")


@settings(
    max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data(), kind=st.sampled_from(["dxf", "geojson", "wkt", "csv"]))
def test_damaged_files_are_read_or_refused(data, kind, tmp_path):
    intact = tmp_path / f"whole.{kind}"
    if not intact.exists():
        texts = {"geojson": geojson(POLYGON, LINE, name="a", layer="b")}
        texts["csv"] = "x,y\n0,0\n1,2\n3,4\n"
        texts["wkt"] = "POLYGON ((0 0, 4 0, 0 3, 0 0))\n"
        if kind == "dxf":
            drawing(tmp_path).rename(intact)
        else:
            intact.write_text(texts[kind])
    content = bytearray(intact.read_bytes())
    for _ in range(data.draw(st.integers(1, 6))):
        at = data.draw(st.integers(0, len(content) - 1))
        content[at] = data.draw(st.sampled_from(b'019-e.,()[]{}" \nxAN\x00\xff'))
    cut = data.draw(st.integers(0, len(content)))
    damaged = tmp_path / f"damaged.{kind}"
    damaged.write_bytes(bytes(content[:cut] if data.draw(st.booleans()) else content))
    try:
        outlines = read_outlines(damaged)
    except SiteddaError:
        return
    points = [outline.points for outline in outlines]
    assert all(np.isfinite(p).all() and len(p) >= 2 for p in points)
