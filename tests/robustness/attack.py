#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run every command with hostile files, options and names, and check its effects on the disk.

usage: python tests/robustness/attack.py [--cases N] [--seed S] [--kinds KIND,…] [--keep FOLDER]
       python tests/robustness/attack.py --replay FOLDER/KIND_SEED

Each case is a folder of valid files and a command line; one file is damaged, or one name is a trap:
a link, a pipe, a device node, a folder, or a file of the user.  A case fails if the command ends
with a traceback, a signal or an undefined status, uses 30 s of processor time, writes values that
are not finite without a message, leaves an incomplete file, changes a file that is not its own, or
creates a file outside its folder.  Failed cases are kept in a folder, from which they can be
replayed.  To attack as another user: setpriv --reuid=65534 --regid=65534 --clear-groups python ….
"""

import contextlib
import hashlib
import importlib
import json
import os
import pkgutil
import random
import re
import resource
import selectors
import shutil
import signal
import stat
import subprocess
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "python")]

from damaged_outputs import damaged  # noqa: E402
from fuzz import Probe  # noqa: E402
from interrupted import binary  # noqa: E402
from model_text import changed, namelist, tower  # noqa: E402
from mutated_files import good_blocks, moved_corners, mutated_file  # noqa: E402
from mutations import (  # noqa: E402
    NUMBERS,
    RECORDS,
    mutated_bytes,
    mutated_checkpoint,
    mutated_input,
    mutated_record,
)
from options import parse_options  # noqa: E402

import sitedda  # noqa: E402
from sitedda import program  # noqa: E402

TIME_LIMIT = 30.0  # processor time of one case, s
PATIENCE = 20 * TIME_LIMIT  # wall-clock time of one case, s
NATIVE = "sitedda-native"
LIBRARIES = [
    "ctypes.util", "matplotlib.backends.backend_agg", "matplotlib.pyplot", "netCDF4", "scipy.fft",
    "scipy.interpolate", "scipy.optimize", "scipy.signal", "scipy.spatial", "scipy.stats", "tqdm",
    "xarray",
]  # fmt: skip
PRECIOUS = b"somebody's own file\n"
INPUTS = HERE.parents[1] / "inputs"
OUTPUTS = "outputs/"  # prefix of names in `good_files` that are not copied to each case
SIDE_FILES = ("journal", "writing", "partial", "checkpoint", "checkpoint.previous",
              "checkpoint.coming")  # fmt: skip
STATUSES = range(8)
PAYLOAD = "touch PWNED"
HOSTILE_TEXTS = [
    "", " ", "..", "../x", "../../x.nc", "x/../../y", "~", "-x", "--help", "a b", "a'b", 'a"b',
    f"a\n{PAYLOAD} #", f"a\r{PAYLOAD}", f"$({PAYLOAD})", f"`{PAYLOAD}`", f"a; {PAYLOAD}", "a\0b",
    "x" * 300, "x" * 5000, "é地", "%s%n", "%A%j", "\x1b[2J", "\u2028", "nan", "1e999",
]  # fmt: skip
HOSTILE_NUMBERS = [*"0 -1 -0.0 nan inf -inf 1e308 1e-308 1e9 7.5 x".split(), ""]

STUDY = """model = "m.nml"
folder = "st"
table = "t.nc"
results = ["displacement[surface].x.largest", "largest_tilt_rad"]
time_limit = 60.0
memory = 2000
[fixed]
"run.title" = "studied"
[parameters]
"motion.scale" = [1.0, 2.0]
density = {changes = "material.rock.density", from = 2000, to = 3000, count = 2}
[slurm]
each = 1
time = "1:00:00"
memory = 500
options = ["--partition=long", "--exclusive"]
[[figures]]
title = "Map"
kind = "map"
quantity = "largest_tilt_rad"
x = "scale"
y = "density"
[[figures]]
kind = "fragility"
quantity = "largest_tilt_rad"
intensity = "scale"
threshold = 0.1
select = {density = 2000.0}
"""
JOINTED = """&control time_step = 1e-3, steps = 3 /
&material name = 'rock', density = 2e3, young_modulus = 1e9, poisson_ratio = 0.2 /
&joint name = 'bed', friction_angle = 30.0 /
&region name = 'part', {region} /
&joint_set joint = 'bed', angle = 10.0, spacing = 1.0 /
"""
OUTLINE = "&region name = 'part', outline = 0, 0, 4, 0, 4, 3, 0, 3 /\n"
FROM_FILES = [
    "&region {} /",
    "&polygons {} /",
    *(f"{OUTLINE}&{name} {{}} /" for name in ("joint_line", "surface", "hole", "excavation")),
]


@dataclass
class Case:
    """A command line and the files of its folder."""

    kind: str
    seed: str
    words: list[str] = field(default_factory=list)
    files: dict[str, bytes] = field(default_factory=dict)  # replace or supplement the valid files
    traps: list[tuple[str, str]] = field(default_factory=list)  # name and kind of trap
    target: str = ""  # a path outside the folder that the command may write


def good_files(folder: Path) -> dict[str, bytes]:
    """Return small valid files of each kind that a command reads."""
    shaken_input = changed(tower(layers=2, steps=12), "output", file="o.nc", block_interval=4)
    shaken_input.append(
        ("amplification", {"surface": "surface", "base": "base", "lowest": 1.0, "highest": 20.0})
    )
    (folder / "m.nml").write_text(namelist(shaken_input))
    sitedda.run(folder / "m.nml", folder / "good.nc")
    with sitedda.Simulation(folder / "m.nml", folder / "stopped.nc") as run:
        run.advance(5)
    contents = {file.name: file.read_bytes() for file in folder.iterdir()}
    region = "outline = 0, 0, 4, 0, 4, 3, 0, 3"
    contents["jointed.nml"] = JOINTED.format(region=region).encode()
    contents["imported.nml"] = JOINTED.format(region="file = 'part.csv'").encode()
    contents["part.csv"] = b"name, x, y\na, 0, 0\na, 4, 0\na, 4, 3\na, 0, 3\n"
    contents["blocks.nc"] = good_blocks()
    contents["blocks.nml"] = (
        JOINTED.format(region=region).split("&region")[0] + "&blocks file = 'blocks.nc' /\n"
    ).encode()
    contents["record.smc"] = next(RECORDS.glob("*.smc")).read_bytes()
    contents["s.toml"] = STUDY.encode()
    contents |= good_store(folder)
    contents["mine.txt"] = PRECIOUS
    return contents | good_outputs(folder)


def good_outputs(folder: Path) -> dict[str, bytes]:
    """Return outputs below OUTPUTS: bolts and stages, joints and a motion, boundaries."""
    roof = sitedda.Model.read(INPUTS / "tunnel_roof_bolted.nml")
    roof["stage"][1](steps=20)
    roof.output(block_interval=10)
    roof.run(output=folder / "roof.nc")
    wall = {"duration": 0.1, "output.block_interval": 20}
    sitedda.run(INPUTS / "wall.nml", output=folder / "wall.nc", changes=wall)
    sitedda.run(INPUTS / "ridge.nml", output=folder / "ridge.nc", duration=0.2)
    return {f"{OUTPUTS}{name}": (folder / f"{name}.nc").read_bytes()
            for name in ("good", "roof", "wall", "ridge")}  # fmt: skip


def good_store(folder: Path) -> dict[str, bytes]:
    """Return the folder of a completed study."""
    from sitedda.command import main

    (folder / "s.toml").write_text(STUDY)
    arguments = ["run", str(folder / "s.toml"), "--folder", str(folder / "done"), "-q", "-w", "1"]
    with contextlib.redirect_stdout(None):
        if main(["study", *arguments]):
            raise SystemExit("the valid study cannot be run")
    files = [file for file in (folder / "done").rglob("*") if file.is_file()]
    return {str(file.relative_to(folder)): file.read_bytes() for file in files}


def hostile_input(case: Case, rng: random.Random, good: dict) -> None:
    """Give a damaged input to each command that reads one."""
    case.files["m.nml"] = mutated_input(rng.randrange(2**31))
    case.words = rng.choices(
        [
            ["run", "m.nml", "-q", "--no-plot"],
            ["check", "m.nml"],
            ["build", "m.nml"],
            ["draw", "m.nml", "-o", "d.png"],
            ["view", "m.nml", "--no-open", "-o", "v.html"],
            ["report", "m.nml", "-o", "r.html"],
            ["safety", "m.nml", "--factor", "1"],
        ],
        [12, 6, 6, 1, 2, 1, 1],
    )[0]


def hostile_name(case: Case, rng: random.Random, good: dict) -> None:
    """Let an input name another place of its output, or set a trap at a file to be written."""
    trap_kind = rng.choice(["link", "dangling", "pipe", "device", "folder", "mine", "hard link"])
    if rng.random() < 0.3:
        targets = ["../victim", "{above}/victim", "{above}/new.nc", "m.nml"]
        name = rng.choice([*HOSTILE_TEXTS, *targets])
        quoted = name.replace("'", "''")
        case.files["m.nml"] = re.sub(rb"'o\.nc'", lambda _: f"'{quoted}'".encode(), good["m.nml"])
        case.words = ["run", "m.nml", "-q", "--no-plot"]
        return
    command = rng.choice(["run", "resume", "draw", "view", "report", "movie", "export", "build",
                             "record", "site", "surface", "safety", "study"])  # fmt: skip
    name = {"draw": "x.png", "view": "x.html", "report": "x.html", "movie": "x.gif",
            "build": "x.nml", "study": "t.nc"}.get(command, "x.png")  # fmt: skip
    source = {"build": "jointed.nml", "record": "record.smc", "safety": "jointed.nml"}
    case.words = [command, source.get(command, "good.nc"), "-o", name]
    if command in ("run", "resume"):
        case.words = [command, "m.nml", "-q", "--no-plot"]
        name = "o.nc" + rng.choice(["", *(f".{ending}" for ending in SIDE_FILES)])
    elif command == "export":
        case.words = ["export", "good.nc", "--vtk", "vtk"]
        name = rng.choice(["vtk", "vtk/blocks_0000.vtp", "vtk/blocks.pvd"])
    elif command == "study":
        case.words = ["study", "plan", "s.toml"]
        name = rng.choice(["st/study.json", "st/submit.sh", "st/tasks.txt", "st/cases", "st"])
    elif command == "view":
        case.words.append("--no-open")
    elif rng.random() < 0.1:
        name = case.words[1]  # the input file itself
        case.words[3] = name
        return
    case.traps.append((name, trap_kind))


def hostile_record(case: Case, rng: random.Random, good: dict) -> None:
    """Give a damaged record."""
    case.files["record.smc"] = mutated_record(rng.randrange(2**31))
    case.words = ["record", "record.smc", "-o", "x.png"]


def hostile_lines(case: Case, rng: random.Random, good: dict) -> None:
    """Give damaged files of lines and polygons."""
    kind = rng.choice(["csv", "wkt", "geojson", "dxf"])
    mutation = rng.choice([mutated_file, moved_corners])
    case.files[f"part.{kind}"] = mutation(kind, rng.randrange(2**31))
    option = rng.choice(["", "", "", "", ", layer = 'a'", ", layer = '0'", ", scale = 1e-3"])
    group = rng.choice(FROM_FILES).format(f"file = 'part.{kind}'{option}")
    case.files["imported.nml"] = re.sub(r"&region.*", lambda _: group, JOINTED).encode()
    case.words = ["build", "imported.nml"]


def hostile_blocks(case: Case, rng: random.Random, good: dict) -> None:
    """Give a damaged block file."""
    case.files["blocks.nc"] = mutated_file("nc", rng.randrange(2**31))
    case.words = rng.choice([["run", "blocks.nml", "-q", "--no-plot"], ["check", "blocks.nml"]])


def hostile_output(case: Case, rng: random.Random, good: dict) -> None:
    """Give a damaged or inconsistent output to each command that shows one."""
    with tempfile.TemporaryDirectory() as folder:
        file, damaged_file = Path(folder) / "o.nc", Path(folder) / "n.nc"
        file.write_bytes(good[rng.choice([name for name in good if name.startswith(OUTPUTS)])])
        damaged(rng, file, damaged_file)
        case.files["good.nc"] = damaged_file.read_bytes()
    case.words = rng.choices(
        [
            ["draw", "good.nc", "-o", "x.png"],
            ["draw", "good.nc", "-o", "x.png", "--contacts", "force", "--color", "stress"],
            ["draw", "good.nc", "-o", "x.png", "--contacts", "slip"],
            ["view", "good.nc", "--no-open", "-o", "x.html"],
            ["report", "good.nc", "-o", "x.html"],
            ["movie", "good.nc", "-q", "-o", "x.gif", "--seconds", "0.1"],
            ["export", "good.nc", "--vtk", "vtk"],
            ["site", "good.nc", "-o", "x.png"],
            ["surface", "good.nc", "-o", "x.png"],
        ],
        [3, 3, 3, 6, 1, 1, 3, 1, 2],
    )[0]


def hostile_checkpoint(case: Case, rng: random.Random, good: dict) -> None:
    """Damage files that an interrupted run has left beside its output."""
    ending = rng.choice(["checkpoint", "checkpoint", "journal", "partial"])
    name = f"stopped.nc.{ending}"
    case.files[name] = mutated_checkpoint(rng.randrange(2**31), good[name])
    command = rng.choice(["resume", "resume", "resume", "run"])
    case.words = [command, "m.nml", "-q", "--no-plot", "-o", "stopped.nc"]


def hostile_study(case: Case, rng: random.Random, good: dict) -> None:
    """Damage the file of a study."""
    text = STUDY
    for _ in range(rng.choice([1, 1, 2])):
        lines = text.splitlines()
        at = rng.randrange(len(lines))
        name, separator, _ = lines[at].partition(" = ")
        literals = [
            *(json.dumps(value) for value in HOSTILE_TEXTS),
            *("nan", "inf", "-1", "0", "true", "[]", "{}", "[[1]]", "1e400", "9" * 30, "[1, 'a']"),
            *("{from = 1, to = 2, count = 1e9}", "1979-05-27", '["--x=a\\nb"]', '{x = "\\n"}'),
        ]
        literal = rng.choice(literals)
        match rng.randrange(5):
            case 0 | 1 | 2 if separator:
                lines[at] = f"{name} = {literal}"
            case 3 if separator:
                lines[at] = f"{json.dumps(rng.choice(HOSTILE_TEXTS))} = {literal}"
            case _:
                lines.pop(at)
        text = "\n".join(lines)
    data = text.encode("utf-8", "replace")
    case.files["s.toml"] = mutated_bytes(rng, data) if rng.random() < 0.15 else data
    case.words = ["study", "plan", "s.toml"]


def hostile_store(case: Case, rng: random.Random, good: dict) -> None:
    """Damage a file in the folder of a study."""
    name = rng.choice(sorted(name for name in good if name.startswith("done/")))
    data = good[name]
    if data and rng.random() < 0.5 and name.endswith((".json", ".nml", ".txt")):
        tokens = re.findall(rb"[\w.]+|\W", data)
        tokens[rng.randrange(len(tokens))] = rng.choice(
            [*HOSTILE_TEXTS, *HOSTILE_NUMBERS, "null", "[]", "{}", '"x"', "true"]
        ).encode("utf-8", "replace")
        case.files[name] = b"".join(tokens)
    else:
        case.files[name] = mutated_bytes(rng, data)
    run = ["study", "run", "s.toml", "--folder", "done", "-q", "-w", "1"]
    collect = ["study", "collect", "done", "-q", "-o", "t.nc"]
    case.words = rng.choices([collect, [*collect, "--report"], run], [8, 2, 1])[0]


OPTIONS = {
    "draw": ["--dpi", "--deformation", "--time", "--stage", "--color", "--contacts", "-o"],
    "movie": ["--fps", "--seconds", "--deformation", "--color", "-o"],
    "view": ["--color", "-o"],
    "report": ["-o"],
    "export": ["--vtk"],
    "site": ["--surface", "--base", "--damping", "-o"],
    "surface": ["--axis", "--lowest", "--highest", "-o"],
    "record": ["--format", "--quantity", "--unit", "--time-step", "-o"],
    "run": ["--set", "-o"],
    "resume": ["--set", "-o"],
    "check": ["--set"],
    "safety": ["--factor", "--tolerance", "--displacement", "--set", "-o"],
    "build": ["-o"],
    "example": [],
    "study": ["-o", "--folder", "--workers"],
    "validate": ["--report"],
    "paper": ["--folder"],
}


def hostile_options(case: Case, rng: random.Random, good: dict) -> None:
    """Give invalid options with valid files to each command."""
    command = rng.choice(list(OPTIONS))
    source = {"record": "record.smc", "run": "m.nml", "resume": "m.nml", "check": "m.nml",
              "safety": "jointed.nml", "build": "jointed.nml"}.get(command, "good.nc")  # fmt: skip
    case.words = [command, source]
    if command == "study":
        case.words = ["study", "plan", "s.toml"]
    elif command in ("example", "validate", "paper"):  # no complete case of validate and paper
        argument = {"example": "column", "validate": "--list"}.get(command, "--help")
        case.words = [command, rng.choice([argument, *HOSTILE_TEXTS])]
    for option in rng.sample(OPTIONS[command], min(len(OPTIONS[command]), rng.choice([1, 2]))):
        value = rng.choice([*HOSTILE_NUMBERS, *HOSTILE_NUMBERS, *HOSTILE_TEXTS])
        if option == "--set":
            name = rng.choice(
                ["time_step", "output.file", "joint[*].cohesion", "block_interval", "x", ""]
            )  # not steps: large numbers of steps are valid
            value = f"{name}={rng.choice([*NUMBERS, value])}"
        if option in ("-o", "--vtk", "--folder"):
            value = rng.choice([*HOSTILE_TEXTS, "mine.txt", "m.nml", "../victim", ".", "no/x.png"])
            case.target = value
        case.words += [option, value]
    if command == "view":
        case.words.append("--no-open")
    if command in ("run", "resume"):
        case.words += ["-q", "--no-plot"]
        case.target = case.target or next(
            (
                argument_text.partition("=")[2]
                for argument_text in case.words
                if argument_text.startswith("output.file=")
            ),
            "",
        )
    case.words = [argument_text.replace("\0", "") for argument_text in case.words]
    case.target = case.target.replace("\0", "")


KINDS: dict[str, tuple[Callable, int]] = {
    "input": (hostile_input, 6),
    "name": (hostile_name, 5),
    "record": (hostile_record, 1),
    "lines": (hostile_lines, 2),
    "blocks": (hostile_blocks, 2),
    "output": (hostile_output, 4),
    "checkpoint": (hostile_checkpoint, 2),
    "study": (hostile_study, 3),
    "store": (hostile_store, 1),
    "options": (hostile_options, 4),
}


def make_case(kind: str, seed: int, good: dict) -> Case:
    """Return the case of a kind and seed; it is always the same."""
    case, rng = Case(kind, str(seed)), random.Random(f"{kind} {seed}")
    KINDS[kind][0](case, rng, good)
    if case.words[0] in ("run", "resume", "check") and rng.random() < 0.4:
        case.words = [NATIVE, *(argument for argument in case.words if argument != "--no-plot")]
    return case


class Yard:
    """A folder that is watched for changes, and a folder in it in which the command runs."""

    def __init__(self, folder: Path, good: dict[str, bytes]):
        self.above, self.good = folder, good
        self.here = folder / "here"

    def lay_out(self, case: Case) -> None:
        """Write fresh valid files, the files of the case, and its traps."""
        for entry in self.above.iterdir():
            if entry.is_dir() and not entry.is_symlink():
                shutil.rmtree(entry)
            else:
                entry.unlink()
        self.here.mkdir()
        (self.above / "victim").write_bytes(PRECIOUS)
        (self.above / "folder").mkdir()
        (self.above / "folder" / "inside").write_bytes(PRECIOUS)
        inputs = {n: data for n, data in self.good.items() if not n.startswith(OUTPUTS)}
        for name, data in (inputs | case.files).items():
            outside = str(self.above).encode()
            data = data.replace(b"{above}", outside) if name == "m.nml" else data
            (self.here / name).parent.mkdir(parents=True, exist_ok=True)
            (self.here / name).write_bytes(data)
        for name, kind in case.traps:
            self.set_trap(self.here / name, kind)

    def set_trap(self, path: Path, kind: str) -> None:
        """Create something that the command must not overwrite."""
        path.parent.mkdir(parents=True, exist_ok=True)
        victim = self.above / "victim"
        if kind == "link":
            path.symlink_to(victim)
        elif kind == "dangling":
            path.symlink_to(self.above / "nothing")
        elif kind == "hard link":
            os.link(victim, path)
        elif kind == "pipe" or (kind == "device" and os.geteuid()):
            os.mkfifo(path)
        elif kind == "device":
            os.mknod(path, stat.S_IFCHR | 0o666, os.makedev(1, 3))
        elif kind == "folder":
            path.mkdir()
        else:
            path.write_bytes(PRECIOUS)

    def watch(self) -> dict[str, tuple]:
        """Return kind and content of each file, by name."""
        states = {}
        for folder, folders, files in os.walk(self.above):
            for name in [*folders, *files]:
                path = Path(folder) / name
                status = os.lstat(path)
                content = os.readlink(path) if stat.S_ISLNK(status.st_mode) else b""
                if stat.S_ISREG(status.st_mode):
                    content = hashlib.sha256(path.read_bytes()).digest()
                state = (status.st_mode, status.st_rdev, content)
                states[str(path.relative_to(self.above))] = state
        return states


def own_names(case: Case) -> tuple[str, ...]:
    """Return the beginnings of names of files that the command may replace or remove."""
    if case.kind == "store":
        return ("here/done/",)
    running = {"run", "resume"} & set(case.words[:2])
    return ("here/stopped.nc",) if running and "stopped.nc" in case.words else ()


def harm(case: Case, yard: Yard, before: dict, after: dict) -> str:
    """Return a forbidden change of the disk in words; empty if there is none."""
    target = case.target and os.path.normpath(os.path.join(yard.here, case.target))
    replaceable = own_names(case)
    for name, state in before.items():
        if (
            after.get(name) != state
            and not name.startswith(replaceable)
            and not stat.S_ISDIR(state[0])
        ):
            return f"{name} has been {'changed' if name in after else 'removed'}"
        if stat.S_ISDIR(state[0]) and name not in after:
            return f"the folder {name} has been removed"
    for name in after.keys() - before.keys():
        path = str(yard.above / name)
        if os.path.basename(name) == "PWNED":
            return "a command was executed"
        if os.path.basename(name).startswith(".new-") or name.endswith((".writing", ".coming")):
            return f"{name} is left over"
        if not name.startswith("here/") and not (target and path.startswith(target)):
            return f"{name} was made outside of the folder"
        if not name.startswith(replaceable) and (complaint := half_written(yard.above / name)):
            return f"{name} {complaint}"
    return ""


def half_written(file: Path) -> str:
    """Return a fault of a file with a final name in words; empty if there is none."""
    if not file.is_file() or file.is_symlink():
        return ""
    data = file.read_bytes()
    ends = {".png": b"IEND\xaeB`\x82", ".html": b"</html>\n", ".gif": b";", ".vtp": b"</VTKFile>\n",
            ".pvd": b"</VTKFile>\n", ".toml": b"\n", ".sh": b"exit $worst\n"}  # fmt: skip
    if file.suffix in ends and not data.endswith(ends[file.suffix]):
        return "is half written"
    if file.suffix == ".nc" and data[:4] in (b"\x89HDF", b"CDF\1", b"CDF\2", b"CDF\5"):
        return not_finite(file)
    return ""


def not_finite(file: Path) -> str:
    """Return a variable of an output with values that are not finite, in words."""
    import netCDF4
    import numpy as np

    try:
        with netCDF4.Dataset(file) as data:
            data.set_auto_maskandscale(False)
            for name, variable in data.variables.items():
                if np.dtype(variable.dtype).kind != "f" or "case" in data.variables:
                    continue  # in a table, NaN marks cases without a value
                values = variable[...]
                if "maximum" in variable.dimensions:  # NaN marks a maximum without data
                    axis = variable.dimensions.index("maximum")
                    is_given = ~np.isnan(data["largest"][...])
                    values = np.compress(is_given, values, axis)
                if not np.all(np.isfinite(values)):
                    return f"contains values that are not finite in {name}"
    except OSError as trouble:
        return f"cannot be read: {trouble}"
    return ""


def serve() -> None:
    """Run command lines from standard input, one per line as JSON; answer in JSON.

    This process has imported the libraries and forks, which takes hundredths of a second.
    """
    read_libraries()
    for request in sys.stdin:
        folder, arguments = json.loads(request)
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            child = os.fork()
            if child == 0:
                os.dup2(out.fileno(), 1)
                os.dup2(err.fileno(), 2)
                become(folder, arguments)
            status = ending(child)
            texts = []
            for stream in (out, err):
                stream.seek(0)
                texts.append(stream.read(20_000).decode("utf-8", "replace"))
        print(json.dumps([status, *texts]), flush=True)


def read_libraries() -> None:
    """Import the modules of all commands; they start no threads."""
    parts = [part.name for part in pkgutil.walk_packages(sitedda.__path__, "sitedda.")]
    for name in [*LIBRARIES, *parts]:
        with contextlib.suppress(ImportError):  # of optional packages
            importlib.import_module(name)


def become(folder: str, arguments: list[str]) -> NoReturn:
    """Run a command in this process, and exit with its status."""
    status = 99
    try:
        seconds = int(TIME_LIMIT)
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        os.chdir(folder)
        if arguments[0] == NATIVE:
            os.execv(binary(), [os.fsencode(argument) for argument in arguments])
        status = program.main([argument.encode("utf-8", "surrogatepass").decode("utf-8", "replace")
                               for argument in arguments])  # fmt: skip
    except SystemExit as end:
        status = end.code
    except BaseException:
        traceback.print_exc()
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(ValueError, OSError):
            stream.flush()
    os._exit(status if isinstance(status, int) else 98)


def ending(child: int) -> int:
    """Return the status of a process, negative for a signal; kill it after the time limit."""
    handle = os.pidfd_open(child)
    with selectors.DefaultSelector() as selector:
        selector.register(handle, selectors.EVENT_READ)
        if not selector.select(PATIENCE):
            os.kill(child, signal.SIGKILL)
    os.close(handle)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def judge(answer: str) -> tuple[str, str]:
    """Return the outcome of a command, and what is wrong with its end."""
    if not answer.startswith("["):
        return "failed", answer
    status, printed, errors = json.loads(answer)
    if status in (-signal.SIGXCPU, -signal.SIGKILL):
        return "failed", f"hang: {errors[-300:]}"
    if status < 0:
        return "failed", f"{signal.Signals(-status).name}: {errors[-300:]}"
    if "Traceback" in errors:
        lines = [line for line in errors.strip().splitlines() if line.strip()]
        source_line = next((x.strip() for x in reversed(lines) if x.strip().startswith("File ")),
                           "")  # fmt: skip
        return "failed", f"traceback: {lines[-1][:300]} {source_line}"
    if status not in STATUSES:
        return "failed", f"status {status}"
    if status and not errors.strip():
        return "failed", f"status {status} without a message"
    return ("done" if status == 0 else f"status {status}"), ""


def run_script(yard: Yard) -> str:
    """Run the Slurm script of a study as its first task; return what is wrong."""
    for script in yard.above.rglob("submit.sh"):
        if script.is_file() and not script.is_symlink() and b"#SBATCH" in script.read_bytes():
            numbers = {"SLURM_ARRAY_TASK_ID": "0", "SLURM_ARRAY_JOB_ID": "1"}
            process = subprocess.run(["bash", str(script)], cwd=yard.here, env=os.environ | numbers,
                                  capture_output=True, text=True, check=False)  # fmt: skip
            if "command not found" in process.stderr or "syntax error" in process.stderr:
                return process.stderr.strip().splitlines()[0]
    return ""


def carry_out(case: Case, yard: Yard, probe: Probe) -> tuple[str, str]:
    """Run one case; return its outcome, and what is wrong."""
    yard.lay_out(case)
    before = yard.watch()
    answer = probe.ask(json.dumps([str(yard.here), case.words]), TIME_LIMIT)
    outcome, wrong = judge(answer)
    if not wrong and case.words[0] == "study" and outcome == "done":
        wrong = run_script(yard)
    wrong = wrong or harm(case, yard, before, yard.watch())
    return ("failed" if wrong else outcome), wrong


def keep_case(case: Case, wrong: str, folder: Path) -> None:
    """Keep the files of a failed case, so that it can be replayed."""
    target = folder / f"{case.kind}_{case.seed}"
    target.mkdir(parents=True, exist_ok=True)
    for name, data in case.files.items():
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        (target / name).write_bytes(data)
    facts = {"kind": case.kind, "words": case.words, "traps": case.traps, "asked": case.target,
             "files": sorted(case.files), "wrong": wrong}  # fmt: skip
    (target / "case.json").write_text(json.dumps(facts, indent=1) + "\n")


def kept_case(folder: Path) -> Case:
    """Read a case that was kept."""
    facts = json.loads((folder / "case.json").read_text())
    files = {name: (folder / name).read_bytes() for name in facts["files"]}
    return Case(facts["kind"], folder.name, facts["words"], files,
                [tuple(trap_values) for trap_values in facts["traps"]], facts["asked"])  # fmt: skip


def attack(cases: Callable, keep: Path | None = None, say: bool = False):
    """Run the cases that a function makes from valid files; return counts and failures."""
    counts: dict[str, Counter] = {}
    failures = []
    command = [sys.executable, str(Path(__file__).resolve()), "--serve"]
    with tempfile.TemporaryDirectory() as good, tempfile.TemporaryDirectory() as outside:
        files = good_files(Path(good))
        yard = Yard(Path(outside).resolve(), files)
        with Probe(command) as probe:
            for case in cases(files):
                outcome, wrong = carry_out(case, yard, probe)
                counts.setdefault(case.kind, Counter())[outcome] += 1
                total = sum(map(Counter.total, counts.values()))
                if say and total % 500 == 0:
                    print(f"… {total} cases, {len(failures)} failed", flush=True)
                if wrong:
                    failures.append(f"{case.kind} {case.seed}: {' '.join(case.words)}: {wrong}")
                    if say:
                        print(failures[-1][:600], flush=True)
                    if keep:
                        keep_case(case, wrong, keep)
    return counts, failures


def spread(count: int, first: int, kinds: list[str]) -> Callable:
    """Return a function that makes `count` cases from seed `first` on, by the weights of kinds."""

    def cases(good):
        total_weight = sum(KINDS[kind][1] for kind in kinds)
        for number in range(count):
            at = number * 7919 % total_weight
            for kind in kinds:
                at -= KINDS[kind][1]
                if at < 0:
                    yield make_case(kind, first * 1_000_000 + number, good)
                    break

    return cases


def main() -> int:
    """Run the cases and print counts."""
    options = parse_options(__doc__, cases=20_000, seed=1, kinds=",".join(KINDS),
                   keep=Path("attack_failures"), replay=Path, serve=False)  # fmt: skip
    if options.serve:
        serve()
        return 0
    cases = spread(options.cases, options.seed, options.kinds.split(","))
    if options.replay:
        cases = lambda good: [kept_case(options.replay)]  # noqa: E731
    counts, failures = attack(cases, None if options.replay else options.keep.resolve(), say=True)
    for kind, outcomes in counts.items():
        summary = ", ".join(f"{number} {outcome}" for outcome, number in sorted(outcomes.items()))
        print(f"{kind:11s} {sum(outcomes.values()):6d}: {summary}")
    print(f"{sum(map(Counter.total, counts.values()))} cases, seed {options.seed}, "
          f"{len(failures)} failed")  # fmt: skip
    return min(len(failures), 1)


if __name__ == "__main__":
    sys.exit(main())
