# SPDX-License-Identifier: GPL-3.0-or-later
"""Write outputs for ParaView: blocks, contacts and bolts of frames as .vtp, times as .pvd.

The files are VTK's XML PolyData with appended, deflated raw data, written with numpy alone.
"""

import csv
import io
import zlib
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from ..base.files import make_folder, write, written
from ..output.scene import Scene, principal_stresses

_TYPES = {"f8": "Float64", "i8": "Int64", "i4": "Int32"}
_BLOCK = 1 << 20  # largest number of bytes that are deflated together


class PolyData:
    """The contents of a .vtp file.

    `points`: shape (k, 2); positions, m; z is 0.
    `connectivity`, `offsets`: points of all cells in sequence, and the index at which each cell
    ends.
    """

    def __init__(self, points, kind: str, connectivity, offsets):
        self.points = np.column_stack([points, np.zeros(len(points))])
        self.kind = kind
        self.connectivity = np.asarray(connectivity, dtype="<i8")
        self.offsets = np.asarray(offsets, dtype="<i8")
        self.cells: dict[str, np.ndarray] = {}
        self.point_data: dict[str, np.ndarray] = {}
        self.field: dict[str, list[str]] = {}

    def write(self, file: Path) -> None:
        """Write the file."""
        appended: list[bytes] = []
        body = self._piece_xml(appended)
        head = (
            '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" '
            'byte_order="LittleEndian" header_type="UInt64" '
            f'compressor="vtkZLibDataCompressor">\n<PolyData>\n{body}</PolyData>\n'
            '<AppendedData encoding="raw">\n_'
        )
        with written(file, "a ParaView file", sync=False) as draft, draft.open("wb") as stream:
            stream.write(head.encode("utf-8"))
            stream.writelines(appended)
            stream.write(b"\n</AppendedData>\n</VTKFile>\n")

    def _piece_xml(self, appended: list[bytes]) -> str:
        """Return the elements of fields and geometry; append the numbers of their arrays."""
        counts = {kind: 0 for kind in ("Verts", "Lines", "Strips", "Polys")}
        counts[self.kind] = len(self.offsets)
        numbers = " ".join(f'NumberOf{kind}="{count}"' for kind, count in counts.items())
        cells = "".join(_array_xml(name, v, appended) for name, v in self.cells.items())
        topology = _array_xml("connectivity", self.connectivity, appended)
        topology += _array_xml("offsets", self.offsets, appended)
        at_points = "".join(_array_xml(name, v, appended) for name, v in self.point_data.items())
        points = _array_xml("Points", self.points, appended)
        fields = "".join(_text_xml(name, texts) for name, texts in self.field.items())
        return (
            f"<FieldData>\n{fields}</FieldData>\n"
            f'<Piece NumberOfPoints="{len(self.points)}" {numbers}>\n'
            f"<PointData>\n{at_points}</PointData>\n"
            f"<CellData>\n{cells}</CellData>\n<Points>\n{points}</Points>\n"
            f"<{self.kind}>\n{topology}</{self.kind}>\n</Piece>\n"
        )


def _array_xml(name: str, values, appended: list[bytes]) -> str:
    """Return the XML element of an array, and append its numbers to `appended`."""
    values = np.ascontiguousarray(values)
    kind = values.dtype.newbyteorder("<").str[1:]
    components = 1 if values.ndim == 1 else values.shape[1]
    offset = sum(map(len, appended))
    appended.append(_compress_blocks(values.astype(f"<{kind}").tobytes()))
    return (
        f'<DataArray type="{_TYPES[kind]}" Name={quoteattr(_remove_illegal_characters(name))} '
        f'NumberOfComponents="{components}" format="appended" offset="{offset}"/>\n'
    )


def _compress_blocks(data: bytes) -> bytes:
    """Return data in deflated blocks, after a header with the number and sizes of blocks."""
    blocks = [zlib.compress(data[i : i + _BLOCK], 6) for i in range(0, len(data), _BLOCK)]
    remainder = len(data) % _BLOCK
    head = np.array([len(blocks), _BLOCK, remainder, *map(len, blocks)], dtype="<u8")
    return head.tobytes() + b"".join(blocks)


def _text_xml(name: str, texts: list[str]) -> str:
    """Return the XML element of texts: ASCII array of character codes, 0 after each text."""
    codes = b"".join(text.encode("utf-8", "replace") + b"\0" for text in texts)
    return (
        f'<Array type="String" Name={quoteattr(name)} NumberOfTuples="{len(texts)}" '
        f'format="ascii">{" ".join(map(str, codes))}</Array>\n'
    )


def _remove_illegal_characters(text: str) -> str:
    """Return a text without the characters that XML 1.0 forbids."""
    return "".join(c for c in text if c in "\t\n\r" or ord(c) >= 32)


def blocks_of(scene: Scene, frame: int) -> PolyData:
    """Return the blocks of a frame as polygons with their data."""
    count = len(scene.owner)
    data = PolyData(scene.vertices(frame), "Polys", np.arange(count), scene.first[1:])
    stress, coordinates = scene.stress(frame), scene.coordinates(frame)
    displacement = scene.displacement(frame)
    largest, smallest = principal_stresses(stress)
    moved_vertices = scene.vertices(frame) - scene.vertices(0)
    data.point_data = {"displacement (m)": _to_3d(moved_vertices)}
    data.cells = {
        "block": np.arange(scene.blocks, dtype="<i4"),
        "material": scene.material.astype("<i4"),
        "removed": scene.removed(frame).astype("<i4"),
        "displacement of the centroid (m)": _to_3d(displacement),
        "rotation (degree)": np.degrees(coordinates[:, 2] - scene.coordinates(0)[:, 2]),
        "velocity (m/s)": _to_3d(scene.rates(frame)[:, :2]),
        "largest principal stress (Pa)": largest,
        "smallest principal stress (Pa)": smallest,
    }
    for k, axes in enumerate(("xx", "yy", "xy")):  # scalars: ParaView shows vectors by magnitude
        data.cells[f"stress {axes} (Pa)"] = stress[:, k]
        data.cells[f"strain {'gamma ' * (k == 2)}{axes}"] = coordinates[:, 3 + k]
    labels = {
        "stress_error": "error of stress (Pa)",
        "plastic_strain": "largest plastic strain",
        "damage": "largest damage of faces and joints",
    }
    for name in scene.own_quantities:
        data.cells[labels[name]] = scene.own_quantity(name, frame)
    data.field = {"block names": scene.names, "material names": scene.material_names}
    return data


def contacts_of(scene: Scene, frame: int) -> PolyData:
    """Return the contacts of a frame as lines along their forces; open contacts are points."""
    contacts = scene.contacts(frame)
    positions, normal = scene.contact_points(frame, contacts)
    force = scene.contact_forces(contacts, normal)
    size = np.linalg.norm(force, axis=1).max(initial=0.0) or 1.0
    length = float(np.sqrt(np.median(scene.areas())))
    half = 0.5 * length * force / size
    k = len(positions)
    points = np.empty((2 * k, 2))
    points[0::2], points[1::2] = positions - half, positions + half
    data = PolyData(points, "Lines", np.arange(2 * k), 2 * np.arange(1, k + 1))
    data.cells = {
        "force (N/m)": _to_3d(force),
        "normal force (N/m)": contacts["normal_force"].astype("<f8"),
        "shear force (N/m)": contacts["shear_force"].astype("<f8"),
        "first block": scene.owner[contacts["vertex"]].astype("<i4"),
        "second block": scene.owner[contacts["edge"]].astype("<i4"),
        "gap (m)": contacts["gap"].astype("<f8"),
        "state": contacts["state"].astype("<i4"),
        "bonded": contacts["bonded"].astype("<i4"),
    }
    if "damage" in contacts:
        data.cells["damage"] = contacts["damage"].astype("<f8")
    return data


def joints_of(scene: Scene, frame: int) -> PolyData:
    """Return the interfaces between blocks as lines that move with the first block, with data."""
    faces = scene.interfaces
    slip, opening = scene.joint_movement(frame)
    ends = [scene.carried(faces.first, positions, frame) for positions in (faces.start, faces.end)]
    k = len(faces)
    points = np.stack(ends, axis=1).reshape(-1, 2)
    data = PolyData(points, "Lines", np.arange(2 * k), 2 * np.arange(1, k + 1))
    data.cells = {
        "slip (m)": slip,
        "sense of slip": scene.joint_sense(frame).astype("<i4"),
        "opening (m)": opening,
        "joint": scene.interface_joints.astype("<i4"),
        "first block": faces.first.astype("<i4"),
        "second block": faces.second.astype("<i4"),
    }
    data.field = {"joint names": scene.joint_names}
    return data


def _to_3d(vectors: np.ndarray) -> np.ndarray:
    """Add a third component of 0 to vectors of the plane."""
    return np.column_stack([vectors, np.zeros(len(vectors))])


def bolts_of(scene: Scene, frame: int) -> PolyData:
    """Return the bolts of a frame as lines through their points, with data."""
    bolts = scene.bolts(frame)
    points = np.vstack([np.empty((0, 2)), *(bolt["places"] for bolt in bolts)])
    ends = np.cumsum([len(bolt["places"]) for bolt in bolts], dtype=int)
    data = PolyData(points, "Lines", np.arange(len(points)), ends)
    data.cells = {
        "force (N/m)": np.array([bolt["force"] for bolt in bolts], dtype="<f8"),
        "state": np.array([bolt["state"] for bolt in bolts], dtype="<i4"),
    }
    data.field = {"bolt names": [bolt["name"] for bolt in bolts]}
    return data


def write_vtk(source, folder) -> Path:
    """Write all frames for ParaView.

    `folder`: created if missing; receives ``blocks.pvd``, ``contacts.pvd``, ``joints.pvd``,
    ``bolts.pvd`` if there are bolts, their frames, and ``points.csv`` for measured points.

    The result is the path of ``blocks.pvd``.
    """
    scene = Scene.of(source, absolute=True)
    folder = make_folder(folder)
    digits = max(4, len(str(scene.frames - 1)))
    kinds = {"blocks": blocks_of, "contacts": contacts_of, "joints": joints_of}
    if scene.bolt_routes():
        kinds["bolts"] = bolts_of
    for name, convert in kinds.items():
        entries = []
        for frame in range(scene.frames):
            file = f"{name}_{frame:0{digits}d}.vtp"
            convert(scene, frame).write(folder / file)
            time = float(scene.time[frame])
            entries.append(f'<DataSet timestep="{time!r}" part="0" file={quoteattr(file)}/>\n')
        _write_collection(folder / f"{name}.pvd", scene.title, entries)
    if "point" in scene.data.coords:
        write(folder / "points.csv", _history_table(scene), "a ParaView file")
    return folder / "blocks.pvd"


def _history_table(scene: Scene) -> str:
    """Return the histories of the measured points as CSV, one line per sample."""
    columns = {"time (s)": scene.data["time"].values}
    for name, unit in (("displacement", "m"), ("velocity", "m/s"), ("acceleration", "m/s²")):
        for i, point in enumerate(map(str, scene.data["point"].values)):
            for axis, letter in enumerate("xy"):
                head = f"{point} {name} {letter} ({unit})"
                columns[head] = scene.data[name].values[:, i, axis]
    text = io.StringIO(newline="")
    lines = csv.writer(text)
    lines.writerow(columns)
    lines.writerows(np.column_stack(list(columns.values())).tolist())
    return text.getvalue()


def _write_collection(file: Path, title: str, entries: list[str]) -> None:
    """Write a .pvd file, whose entries name the files of the frames with their times."""
    comment = escape(_remove_illegal_characters(title)).replace("--", "- -")
    text = (
        f'<?xml version="1.0"?>\n<!-- {comment} -->\n<VTKFile type="Collection" version="0.1" '
        f'byte_order="LittleEndian">\n<Collection>\n{"".join(entries)}</Collection>\n</VTKFile>\n'
    )
    write(file, text, "a ParaView file")
