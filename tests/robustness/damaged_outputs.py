# SPDX-License-Identifier: GPL-3.0-or-later
"""Randomly damaged outputs of runs, for `attack.py --kinds output`."""

from pathlib import Path

import netCDF4
import numpy as np

NUMBERS = (-1, 0, 1, 7, 2**31 - 1, -(2**31))
REALS = (float("nan"), float("inf"), -1.0, 0.0, 1e300, 1e36, -1e12)


def rewrite(source: Path, target: Path, change) -> None:
    """Copy an output; `change` edits its variables and attributes."""
    with netCDF4.Dataset(source) as source_data, netCDF4.Dataset(target, "w") as target_data:
        source_data.set_auto_maskandscale(False)
        source_data.set_auto_chartostring(False)
        variables = {name: [v.dtype, v.dimensions, v[...], v.__dict__] for name, v in
                     source_data.variables.items()}  # fmt: skip
        attributes = dict(source_data.__dict__)
        change(variables, attributes)
        target_data.setncatts(attributes)
        for name, (kind, dimensions, values, its) in variables.items():
            for dimension, length in zip(dimensions, np.shape(values), strict=True):
                if dimension not in target_data.dimensions:
                    target_data.createDimension(dimension, length)
            variable = target_data.createVariable(name, kind, dimensions)
            its = {k: v for k, v in its.items() if kind == "S1" or k != "_Encoding"}
            variable.setncatts({k: v for k, v in its.items() if k != "_FillValue"})
            variable.set_auto_maskandscale(False)
            variable[...] = values


def drop(rng, variables, attributes) -> str:
    """Remove a variable."""
    name = rng.choice(sorted(variables))
    del variables[name]
    return f"without {name}"


def rename(rng, variables, attributes) -> str:
    """Exchange the names of two variables."""
    first, second = rng.sample(sorted(variables), 2)
    variables[first], variables[second] = variables[second], variables[first]
    return f"{first} as {second}"


def retype(rng, variables, attributes) -> str:
    """Give a variable another type of numbers, or letters."""
    name = rng.choice(sorted(variables))
    kind, dimensions, values, own_attributes = variables[name]
    new_type = rng.choice(["i1", "i4", "f4", "f8", "S1"])
    new_values = np.zeros(values.shape, new_type)
    if new_type == "S1":
        new_values = np.full(values.shape, b"x")
    variables[name] = [new_type, dimensions, new_values, own_attributes]
    return f"{name} of {new_type}"


def reshape(rng, variables, attributes) -> str:
    """Remove or add a dimension of a variable, or change its length."""
    name = rng.choice(sorted(variables))
    kind, dimensions, values, own_attributes = variables[name]
    how = rng.choice(["lose", "gain", "turn", "own"])
    if how == "lose" and values.ndim:
        dimensions, values = dimensions[1:], values[0] if len(values) else values.sum(axis=0)
    elif how == "gain":
        dimensions, values = ("more", *dimensions), values[None]
    elif how == "turn":
        dimensions, values = dimensions[::-1], values.T
    else:
        dimensions = tuple(f"{name}_{i}" for i in range(values.ndim))
    variables[name] = [kind, dimensions, values, own_attributes]
    return f"{name}: {how}"


def replace(rng, variables, attributes) -> str:
    """Replace some values."""
    name = rng.choice(sorted(variables))
    kind, dimensions, values, own_attributes = variables[name]
    if not values.size:
        return "nothing"
    values = values.copy()
    number = rng.choice(REALS if np.issubdtype(values.dtype, np.floating) else NUMBERS)
    for _ in range(rng.choice([1, 1, 5])):
        at = rng.randrange(values.size)
        if values.dtype.kind == "S":
            values.flat[at] = bytes([rng.randrange(256)])
        else:
            values.flat[at] = number
    variables[name] = [kind, dimensions, values, own_attributes]
    return f"{name} has {number}"


def shorten(rng, variables, attributes) -> str:
    """Shorten a dimension, possibly to zero."""
    name = rng.choice(sorted({d for v in variables.values() for d in v[1]}))
    length = rng.choice([0, 1, 2])
    for variable in variables.values():
        for axis, dimension in enumerate(variable[1]):
            if dimension == name:
                positions = range(min(length, variable[2].shape[axis]))
                variable[2] = np.take(variable[2], positions, axis)
    return f"{name} of {length}"


def describe(rng, variables, attributes) -> str:
    """Remove an attribute, or replace it with a number or another text."""
    name = rng.choice(sorted(attributes))
    how = rng.choice(["without", "number", "letters", "numbers", "nothing"])
    if how == "without":
        del attributes[name]
    elif how == "letters" and isinstance(attributes[name], str) and attributes[name]:
        text = list(attributes[name])
        for _ in range(rng.choice([1, 3, 20])):
            text[rng.randrange(len(text))] = rng.choice("0&/'=\n,x.-")
        attributes[name] = "".join(text)
    else:
        attributes[name] = {"number": 3.0, "numbers": np.arange(3.0)}.get(how, "")
    return f"attribute {name}: {how}"


def flip(rng, source: Path, target: Path) -> str:
    """Replace bytes of the file, or cut off its end."""
    data = bytearray(source.read_bytes())
    if rng.random() < 0.2:
        target.write_bytes(data[: rng.randrange(len(data))])
        return "cut"
    for _ in range(rng.choice([1, 8, 200])):
        data[rng.randrange(len(data))] = rng.randrange(256)
    target.write_bytes(data)
    return "bytes"


CHANGES = (drop, drop, rename, retype, reshape, replace, replace, replace, shorten, describe)


def damaged(rng, source: Path, target: Path) -> str:
    """Damage an output; return a description of the damage."""
    if rng.random() < 0.25:
        return flip(rng, source, target)
    change, descriptions = rng.choice(CHANGES), []
    try:
        rewrite(source, target, lambda *parts: descriptions.append(change(rng, *parts)))
    except RuntimeError:  # netCDF cannot write such a file
        return flip(rng, source, target)
    return descriptions[0]
