#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Damage outputs of runs in many ways and give them to every command that reads one.

usage: python tests/robustness/damaged_outputs.py [--cases N] [--seed S] [--first I]

The rest of an output is shown, or refused in one sentence that names the file; an exception of
another kind, a crash or a hang ends the study with status 1.
"""

import contextlib
import os
import random
import shutil
import signal
import sys
import tempfile
import traceback
import warnings
from pathlib import Path

import netCDF4
import numpy as np
from options import asked

INPUTS = Path(__file__).parents[2] / "inputs"
LONGEST = 60  # s for one case
NUMBERS = (-1, 0, 1, 7, 2**31 - 1, -(2**31))
REALS = (float("nan"), float("inf"), -1.0, 0.0, 1e300, 1e36, -1e12)


def outputs(folder: Path) -> list[Path]:
    """Outputs with bolts and stages, with joints and a motion, with boundaries."""
    import sitedda
    import sitedda.facade.page
    import sitedda.movie
    import sitedda.site.picture
    import sitedda.view
    import sitedda.vtk  # noqa: F401 - once, for all cases
    from sitedda.model import Model

    roof = Model.read(INPUTS / "tunnel_roof_bolted.nml")
    roof["stage"][1](steps=20)
    roof.output(block_interval=10)
    roof.run(output=folder / "roof.nc")
    wall = {"duration": 0.1, "output.block_interval": 20}
    sitedda.run(INPUTS / "wall.nml", output=folder / "wall.nc", changes=wall)
    ridge = Model.read(INPUTS / "ridge.nml")
    ridge.control(duration=0.2)
    ridge.run(output=folder / "ridge.nc")
    return [folder / f"{name}.nc" for name in ("roof", "wall", "ridge")]


def rewrite(source: Path, target: Path, change) -> None:
    """A copy of an output, variable by variable, as `change` has them."""
    with netCDF4.Dataset(source) as old, netCDF4.Dataset(target, "w") as new:
        old.set_auto_maskandscale(False)
        old.set_auto_chartostring(False)
        variables = {name: [v.dtype, v.dimensions, v[...], v.__dict__] for name, v in
                     old.variables.items()}  # fmt: skip
        attributes = dict(old.__dict__)
        change(variables, attributes)
        new.setncatts(attributes)
        for name, (kind, dimensions, values, its) in variables.items():
            for dimension, length in zip(dimensions, np.shape(values), strict=True):
                if dimension not in new.dimensions:
                    new.createDimension(dimension, length)
            made = new.createVariable(name, kind, dimensions)
            its = {k: v for k, v in its.items() if kind == "S1" or k != "_Encoding"}
            made.setncatts({k: v for k, v in its.items() if k != "_FillValue"})
            made.set_auto_maskandscale(False)
            made[...] = values


def drop(chance, variables, attributes) -> str:
    """A variable is missing."""
    return drop_named(variables, chance.choice(sorted(variables)))


def drop_named(variables, name: str) -> str:
    """The variable of a name is missing."""
    del variables[name]
    return f"without {name}"


def rename(chance, variables, attributes) -> str:
    """Two variables have changed names."""
    one, two = chance.sample(sorted(variables), 2)
    variables[one], variables[two] = variables[two], variables[one]
    return f"{one} as {two}"


def retype(chance, variables, attributes) -> str:
    """A variable holds numbers of another kind, or letters."""
    name = chance.choice(sorted(variables))
    kind, dimensions, values, its = variables[name]
    new = chance.choice(["i1", "i4", "f4", "f8", "S1"])
    made = np.full(values.shape, b"x") if new == "S1" else np.zeros(values.shape, new)
    variables[name] = [new, dimensions, made, its]
    return f"{name} of {new}"


def reshape(chance, variables, attributes) -> str:
    """A variable has lost a dimension, gained one or has another of its length."""
    name = chance.choice(sorted(variables))
    kind, dimensions, values, its = variables[name]
    how = chance.choice(["lose", "gain", "turn", "own"])
    if how == "lose" and values.ndim:
        dimensions, values = dimensions[1:], values[0] if len(values) else values.sum(axis=0)
    elif how == "gain":
        dimensions, values = ("more", *dimensions), values[None]
    elif how == "turn":
        dimensions, values = dimensions[::-1], values.T
    else:
        dimensions = tuple(f"{name}_{i}" for i in range(values.ndim))
    variables[name] = [kind, dimensions, values, its]
    return f"{name}: {how}"


def replace(chance, variables, attributes) -> str:
    """Some values are others."""
    name = chance.choice(sorted(variables))
    kind, dimensions, values, its = variables[name]
    if not values.size:
        return "nothing"
    values = values.copy()
    new = chance.choice(REALS if np.issubdtype(values.dtype, np.floating) else NUMBERS)
    for _ in range(chance.choice([1, 1, 5])):
        at = chance.randrange(values.size)
        if values.dtype.kind == "S":
            values.flat[at] = bytes([chance.randrange(256)])
        else:
            values.flat[at] = new
    variables[name] = [kind, dimensions, values, its]
    return f"{name} has {new}"


def shorten(chance, variables, attributes) -> str:
    """A dimension is shorter, down to nothing."""
    name = chance.choice(sorted({d for v in variables.values() for d in v[1]}))
    length = chance.choice([0, 1, 2])
    for one in variables.values():
        for axis, dimension in enumerate(one[1]):
            if dimension == name:
                one[2] = np.take(one[2], range(min(length, one[2].shape[axis])), axis)
    return f"{name} of {length}"


def describe(chance, variables, attributes) -> str:
    """An attribute is missing, a number, or another text."""
    name = chance.choice(sorted(attributes))
    how = chance.choice(["without", "number", "letters", "numbers", "nothing"])
    if how == "without":
        del attributes[name]
    elif how == "letters" and isinstance(attributes[name], str) and attributes[name]:
        text = list(attributes[name])
        for _ in range(chance.choice([1, 3, 20])):
            text[chance.randrange(len(text))] = chance.choice("0&/'=\n,x.-")
        attributes[name] = "".join(text)
    else:
        attributes[name] = {"number": 3.0, "numbers": np.arange(3.0)}.get(how, "")
    return f"attribute {name}: {how}"


def flip(chance, source: Path, target: Path) -> str:
    """Bytes of the file are others, or its end is missing."""
    data = bytearray(source.read_bytes())
    if chance.random() < 0.2:
        target.write_bytes(data[: chance.randrange(len(data))])
        return "cut"
    for _ in range(chance.choice([1, 8, 200])):
        data[chance.randrange(len(data))] = chance.randrange(256)
    target.write_bytes(data)
    return "bytes"


CHANGES = (drop, drop, rename, retype, reshape, replace, replace, replace, shorten, describe)


def damaged(chance, source: Path, target: Path) -> str:
    """Damage an output; what was done."""
    if chance.random() < 0.25:
        return flip(chance, source, target)
    change, words = chance.choice(CHANGES), []
    try:
        rewrite(source, target, lambda *parts: words.append(change(chance, *parts)))
    except RuntimeError:  # netCDF cannot write that
        return flip(chance, source, target)
    return words[0]


def show(file: Path) -> None:
    """Everything that reads an output, each as far as it comes."""
    from sitedda.program import main

    out = file.with_suffix("")
    commands = (
        ["draw", file, "-o", f"{out}.png", "--dpi", "30", "--contacts", "force"],
        ["draw", file, "-o", f"{out}.slip.png", "--dpi", "30", "--contacts", "slip"],
        ["view", file, "-o", f"{out}.html", "--no-open"],
        ["report", file, "-o", f"{out}.report.html"],
        ["export", file, "--vtk", f"{out}_vtk"],
        ["movie", file, "-q", "-o", f"{out}.gif", "--seconds", "0.1"],
        ["surface", file, "-o", f"{out}.surface.png", "--lowest", "6"],
        ["site", file, "-o", f"{out}.site.png"],
    )
    for words in commands:
        print(words[0], end=": ", flush=True)
        status = main([str(word) for word in words])
        print("" if status in (0, 1, 5) else f"status {status}")


def outcome(file: Path, log: Path) -> str:
    """What is wrong with how a damaged file is met; blank if nothing is."""
    child = os.fork()
    if child == 0:
        signal.alarm(LONGEST)
        code = 0
        with log.open("w") as stream:
            os.dup2(stream.fileno(), 1)
            os.dup2(stream.fileno(), 2)
            try:
                warnings.simplefilter("ignore")
                show(file)
            except BaseException:
                traceback.print_exc()
                code = 1
            with contextlib.suppress(Exception):
                sys.stdout.flush()
        os._exit(code)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        return f"signal {os.WTERMSIG(status)}"
    said = log.read_text(errors="replace")
    if os.WEXITSTATUS(status) or "Traceback" in said:
        return said[-1500:]
    return next((line for line in said.splitlines() if ": status" in line), "")


def main() -> int:
    """Run the cases and count what came of them."""
    options = asked(__doc__, cases=1000, seed=1, first=0)
    failures = 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        good = outputs(folder)
        for source in good:
            if words := outcome(source, folder / "log"):
                raise SystemExit(f"{source.name} is whole, and yet: {words}")
        for i in range(options.first, options.first + options.cases):
            chance = random.Random(f"{options.seed} {i}")
            case = folder / "case"
            case.mkdir()
            source = chance.choice(good)
            what = damaged(chance, source, case / source.name)
            wrong = outcome(case / source.name, folder / "log")
            if sys.stderr.isatty():
                done = i - options.first + 1
                print(f"\r{done} of {options.cases}", end="\r", file=sys.stderr, flush=True)
            if wrong:
                failures += 1
                print(f"case {i}: {source.name}, {what}: {wrong}", flush=True)
            shutil.rmtree(case)
    print(f"seed {options.seed}: {options.cases - failures} of {options.cases} as they should be")
    return int(failures > 0)


if __name__ == "__main__":
    sys.exit(main())
