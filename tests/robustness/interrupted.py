# SPDX-License-Identifier: GPL-3.0-or-later
"""Interrupted runs: models, programs, and bit-exact comparison of outputs."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import netCDF4
import numpy as np

INPUTS = Path(__file__).parents[2] / "inputs"

WALL = """&run title = 'A wall of 200 bricks' /
&control time_step = 1.0e-3, {steps}gravity = 0.0, -9.81, solver = '{solver}' /
&contact normal_stiffness = 2.0e10 /
&material name = 'stone', density = 2500.0, young_modulus = 10.0e9, poisson_ratio = 0.25 /
&joint name = 'dry', friction_angle = 35.0 /
&layers name = 'base', left = -0.5, bottom = -0.5, width = 22.0, thickness = 0.5 /
&wall name = 'brick', left = 0.0, bottom = 0.0, brick_length = 1.0, brick_height = 0.5,
   bricks = {bricks}, courses = 10 /
&motion name = 'cycle', quantity = 'displacement', time_step = 0.02,
   values = 0.0, 0.0294, 0.0476, 0.0294, 0.0, -0.0294, -0.0476, -0.0294, 0.0, 0.0 /
&fixed_point x = 0.0, y = -0.25, motion_x = 'cycle' /
&fixed_point x = 20.0, y = -0.25, motion_x = 'cycle' /
&measured_point name = 'top', x = 0.1, y = 4.9 /
&output file = 'wall.nc', block_interval = 20, checkpoint_interval = {interval} /
"""


STAGES = """&joint name = 'worn', friction_angle = 25.0 /
&layers name = 'cap', left = 0.0, bottom = 5.0, width = {bricks}.0, thickness = 0.5 /
&stage name = 'rest', kind = 'static' /
&stage name = 'shake', steps = {steps}, motions = 'cycle' /
&stage name = 'unload', kind = 'static', remove = 'cap*' /
&stage name = 'weaken', steps = {steps}, change_joints = 'dry -> worn',
   zero_displacements = .true. /
&stage name = 'shorter steps', steps = {steps}, time_step = 5.0e-4, integration = 'theta' /
"""


WATER = """&flow aperture = 1.0e-3, state = 'transient' /
&traction along = 0.0, 0.0, 0.0, 5.0, level = 4.0, added_mass = .true. /
"""


def layered_site(steps: int = 60000, interval: int = 500) -> str:
    """The layered site under its earthquake, with checkpoints."""
    text = (INPUTS / "layered_site.nml").read_text()
    text = text.replace("steps = 60000", f"steps = {steps}")
    return text.replace("&output", f"&output checkpoint_interval = {interval}")


def column(duration: float = 5.0, interval: int = 50) -> str:
    """The column of drums, with checkpoints."""
    text = (INPUTS / "column.nml").read_text()
    text = text.replace("duration = 5.0", f"duration = {duration}")
    return text.replace("&output", f"&output checkpoint_interval = {interval},")


def wall(steps: int = 100, interval: int = 5, bricks: int = 20, solver: str = "auto") -> str:
    """A shaken wall of 10 courses."""
    return WALL.format(steps=f"steps = {steps}, ", interval=interval, bricks=bricks, solver=solver)


def staged_wall(steps: int = 40, interval: int = 5, bricks: int = 20) -> str:
    """The wall in five stages, two of them static, that remove loads, bricks and friction."""
    text = WALL.format(steps="", interval=interval, bricks=bricks, solver="auto")
    return text + STAGES.format(steps=steps, bricks=bricks)


def wet_wall(steps: int = 100, interval: int = 5, bricks: int = 20) -> str:
    """The wall at a reservoir, with flow in its joints and added mass at its side."""
    return wall(steps, interval, bricks) + WATER


def binary(name: str | None = None) -> str:
    """Return a named executable, or that of this environment, or that in PATH."""
    native = Path(sys.executable).parent / "sitedda-native"
    path = name or (native if native.exists() else shutil.which("sitedda-native"))
    if not path:
        raise SystemExit("sitedda-native is not installed; name it with --program")
    return str(Path(path).resolve())


def prepare(folder: Path, text: str) -> Path:
    """Write an input into a folder, with the records that it may name."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "records").symlink_to(INPUTS / "records")
    (folder / "model.nml").write_text(text)
    return folder


def start(program: str, command: str, folder: Path, call=subprocess.Popen, **options):
    """Run or resume the input of a folder; return a process, or the result of `call`."""
    return call(
        [program, command, "model.nml", "-q", "-o", "out.nc"],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        errors="replace",
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_WAIT_POLICY": "passive"},
        **options,
    )


def finish(program: str, command: str, folder: Path, **options) -> tuple[int, str, str]:
    """Run or resume the input to its end within `timeout`, s; return status, output, errors."""
    process = start(program, command, folder, subprocess.run, **options)
    return process.returncode, process.stdout, process.stderr


def reference_of(program: str, folder: Path) -> Path:
    """Complete a run, and return its output under another name."""
    status, _, err = finish(program, "run", folder)
    if status:
        raise SystemExit(err)
    return (folder / "out.nc").rename(folder / "reference.nc")


def difference(file: Path, other: Path) -> str:
    """Return the differences in the data of two outputs; empty if all bits are identical."""
    with netCDF4.Dataset(file) as left, netCDF4.Dataset(other) as right:
        if set(left.variables) != set(right.variables):
            return "variables"
        for name in left.variables:
            for dataset in (left, right):
                dataset[name].set_auto_maskandscale(False)
            values, other_values = np.asarray(left[name][...]), np.asarray(right[name][...])
            if values.shape != other_values.shape or values.tobytes() != other_values.tobytes():
                return name
        for name in ("complete", "step_control"):
            if left.getncattr(name) != right.getncattr(name):
                return name
    return ""


def same(kind: str, folder: Path, reference: Path) -> bool:
    """Return whether an output equals another bitwise and has no other files; print otherwise."""
    wrong = difference(folder / "out.nc", reference)
    left = sorted(file.name for file in folder.glob("out.nc?*"))
    if wrong or left:
        print(f"{kind}: {wrong or 'nothing'} differs, left behind: {left}")
    return not wrong and not left
