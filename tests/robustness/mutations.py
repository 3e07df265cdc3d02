# SPDX-License-Identifier: GPL-3.0-or-later
"""Hostile inputs, records and checkpoints: valid ones with changed groups or bytes."""

import random
import re
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "python"))

from model_text import changed, flying_block, namelist, rectangle, tower  # noqa: E402

RECORDS = HERE.parent / "data" / "records"

NUMBERS = """0 -0.0 -1 1 2 0.5 1e400 -1e400 1e308 -1e308 1e-308 5e-324 1e300 1e100 1e30 1e-30 1e15
1e9 1e-9 1e-15 2147483647 2147483648 -2147483649 9223372036854775808 1d5 1.0D-400 1e 1e+ .5 5. . - +
NaN nan(7) Inf -Infinity +Inf 0x10 z'ff' 1_8 1,5 1;5 ١٢""".split()
VALUES = [
    "",
    "\t",
    *"""'' 'x' "y" ' " , ,, ; = / & ! $end ? =?""".split(),
    *(".true.", "T", "(1,2)", "(1", "3*", "3*1.0", "0*1.0", "-3*1.0", "1000000000*1.0", "1 2 3"),
    *("9" * 400, "0." + "1" * 5000, "1 " * 5000, "1e" + "9" * 50),
    *"%s%n%x `id` $(id) ../.. é地".split(),
]
SUBSCRIPTS = "(1) (0) (-5) (99999) (2:1) (1:1000000) (::0) (1,1,1) ( () %x (1)(2:3)".split()
GROUPS = """run control contact material joint block blocks layers drums wall motion fixed_point
load flow flow_boundary measured_point stage amplification output unknown""".split()
SNIPPETS = [b"\0", b"\xff", b"\xef\xbb\xbf", b"\r\n", b"\x1a", b"1e999"]
SNIPPETS += [bytes([one]) for one in b"\r\t'\"/&!"]


def models() -> list[list]:
    """Return valid models with every group and most features of the engine."""
    shaken = [
        *tower(layers=2, steps=5, solver="direct"),
        ("load", {"x": 1.0, "y": 1.5, "time": [0.0, 0.1, 0.2], "force_x": [0.0, 1e5, 0.0]}),
        ("amplification", {"surface": "surface", "base": "base", "lowest": 1.0, "highest": 20.0}),
    ]
    start = flying_block(steps=5)[:4]
    resting_groups = [
        *changed(start, "control", gravity=[0.0, -9.81], time_step_control="adaptive"),
        ("wall", {"brick_length": 1.0, "brick_height": 0.5, "bricks": 2, "courses": 3}),
        ("block", {"name": "floor", "vertices": rectangle(-1.0, -1.0, 5.0, 1.0)}),
        ("fixed_point", {"x": 0.0, "y": -0.5}),
        ("fixed_point", {"x": 3.0, "y": -0.5}),
        ("measured_point", {"name": "top", "x": 1.0, "y": 1.2}),
    ]
    column = [
        *changed(start, "control", gravity=[0.0, -9.81], steps=None, duration=5e-3),
        ("drums", {"width": 1.0, "top_width": 0.8, "height": 0.7, "count": 3}),
        ("fixed_point", {"x": 0.0, "y": 0.1, "direction": "xy"}),
    ]
    original = changed(resting_groups, "contact", contact_rules="original",
                       penetration_tolerance=0.0)  # fmt: skip
    tight_groups = changed(resting_groups, "contact", penetration_tolerance=1e-6, max_iterations=50)
    based = [*changed(column, "control", base_motion_x="m"), tower()[7]]
    based[-1][1]["name"] = "m"
    wet_groups = [
        *resting_groups,
        ("flow", {"aperture": 1e-3, "state": "transient", "saturation": 0.9}),
        ("flow_boundary", {"along": [0, 0, 0, 1.6], "head": [2.0, 3.0], "time": [0.0, 1e-3]}),
        ("traction", {"side": "right", "level": 1.0, "added_mass": True}),
    ]
    return [shaken, resting_groups, column, original, tight_groups, based, wet_groups,
            flying_block(steps=5)]  # fmt: skip


def mutated_input(seed: int) -> bytes:
    """Return one hostile input; the same seed gives the same bytes."""
    rng = random.Random(seed)
    groups = rng.choice(models())
    for _ in range(rng.choice([1, 1, 1, 2, 3])):
        rng.choice(MUTATIONS)(rng, groups)
    data = unquoted(namelist(groups)).encode("utf-8", "surrogateescape")
    if rng.random() < 0.3:
        data = mutated_bytes(rng, data)
    return data


def mutated_record(seed: int) -> bytes:
    """Return one hostile record."""
    rng = random.Random(seed)
    seeds = sorted(file for file in RECORDS.iterdir() if file.suffix != ".md")
    data = rng.choice(seeds).read_bytes()
    for _ in range(rng.choice([1, 1, 2, 3])):
        data = rng.choice([mutated_bytes, mutated_lines, mutated_number])(rng, data)
    if rng.random() < 0.05:
        data = data[: rng.randrange(len(data) + 1)] + rng.choice(seeds).read_bytes()
    return data


def mutated_checkpoint(seed: int, good: bytes) -> bytes:
    """Return one damaged checkpoint; it always differs from the valid one."""
    rng = random.Random(seed)
    data = good
    while data == good:
        for _ in range(rng.choice([1, 1, 2, 5])):
            data = mutated_bytes(rng, data)
        if rng.random() < 0.1:
            at = rng.choice([0, 8, len(data) - 16])  # mark, format, length
            data = data[:at] + rng.randbytes(8) + data[at + 8 :]
    return data


def raw(text: str) -> str:
    """Mark a value that `unquoted` writes into the namelist without quotes."""
    return f"\x01{text}\x02"


def unquoted(text: str) -> str:
    """Return the namelist text with marked values without quotes."""
    return re.sub("(?s)'\x01(.*?)\x02'", lambda match: match[1].replace("''", "'"), text)


def _variable(rng, groups):
    """Return the values of a group, and the name of one of its variables."""
    filled = [values for _, values in groups if values] or [{"title": "a"}]
    values = rng.choice(filled)
    return values, rng.choice(list(values))


def hostile_value(rng, groups):
    """Insert a value of the wrong type or far out of range."""
    values, variable = _variable(rng, groups)
    values[variable] = raw(rng.choice([*NUMBERS, *VALUES]))


def hostile_element(rng, groups):
    """Replace one number of a list."""
    values, variable = _variable(rng, groups)
    if not isinstance(values[variable], list):
        return hostile_value(rng, groups)
    items = [repr(item) for item in values[variable]]
    items[rng.randrange(len(items))] = rng.choice(NUMBERS)
    values[variable] = raw(", ".join(items))
    return None


def other_size(rng, groups):
    """Increase or decrease a number many times, or change its sign."""
    values, variable = _variable(rng, groups)
    factor = rng.choice([-1.0, 10 ** rng.uniform(-14, 14), 10 ** rng.uniform(-1, 1)])
    old_values = values[variable]
    if isinstance(old_values, list):
        index = rng.randrange(len(old_values))
        values[variable] = [x * factor if i == index else x for i, x in enumerate(old_values)]
    elif isinstance(old_values, float):
        values[variable] = old_values * factor
    elif isinstance(old_values, int):
        values[variable] = rng.choice([0, -1, 3 * old_values, 200 * old_values,
                                          int(old_values * factor)])  # fmt: skip


def take_out(rng, groups):
    """Remove a variable or a group."""
    if rng.random() < 0.5 and len(groups) > 1:
        groups.remove(rng.choice(groups))
    else:
        values, variable = _variable(rng, groups)
        del values[variable]


def say_twice(rng, groups):
    """Repeat a group, in place or at the end."""
    name, values = rng.choice(groups)
    copies = rng.choice([1, 1, 2, 50])
    groups += [(name, dict(values)) for _ in range(copies)]


def other_name(rng, groups):
    """Rename a variable or a group, or add a subscript."""
    if rng.random() < 0.3:
        index = rng.randrange(len(groups))
        groups[index] = (rng.choice(GROUPS), groups[index][1])
        return
    values, variable = _variable(rng, groups)
    _, other = _variable(rng, groups)
    new_name = rng.choice([variable + rng.choice(SUBSCRIPTS), other, variable[:-1],
                              variable * 50])  # fmt: skip
    values[new_name] = values.pop(variable)


def another_variable(rng, groups):
    """Insert a variable of another group."""
    source, variable = _variable(rng, groups)
    rng.choice(groups)[1][variable] = source[variable]


def reorder(rng, groups):
    """Change the order of the groups."""
    rng.shuffle(groups)


def very_long(rng, groups):
    """Insert a very long value or name."""
    values, variable = _variable(rng, groups)
    length = rng.choice([65, 300, 1100, 70_000])
    filling = rng.choice(["x", "1", " ", "é", "'", "1,"])
    values[variable] = rng.choice([filling * length, raw(filling * length)])


def many_copies(rng, groups):
    """Let a generator make many blocks, or many vertices of one block."""
    for name, values in groups:
        for variable in ("count", "bricks", "courses"):
            if variable in values or (name == "layers" and variable == "count"):
                values[variable] = rng.choice([7, 60, 1000, 8000, 3_000_000])
                return
        if name == "block":
            n = rng.choice([7, 60, 511, 512, 513, 3000])
            edge = [x for i in range(n) for x in (1.0, (i + 1) / n)]
            values["vertices"] = [0.0, 0.0, 1.0, 0.0, *edge]
            return


MUTATIONS = [
    *3 * [hostile_value],
    *2 * [hostile_element],
    *4 * [other_size],
    *(take_out, say_twice, other_name, another_variable, reorder, very_long, many_copies),
]


def mutated_bytes(rng, data: bytes) -> bytes:
    """Flip, cut, repeat, insert, set to zero, or truncate."""
    data = bytearray(data or b" ")
    at = rng.randrange(len(data))
    length = rng.choice([1, 2, 8, 64, 500])
    match rng.randrange(7):
        case 0:
            data[at] ^= 1 << rng.randrange(8)
        case 1:
            data[at] = rng.randrange(256)
        case 2:
            del data[at : at + length]
        case 3:
            data[at:at] = data[at : at + length] * rng.choice([1, 1, 3, 100])
        case 4:
            data[at:at] = rng.choice(SNIPPETS) * rng.choice([1, 1, 1, 1000])
        case 5:
            del data[at:]
        case 6:  # a disk block that was not written
            data[at : at + length] = bytes(len(data[at : at + length]))
    return bytes(data)


def mutated_lines(rng, data: bytes) -> bytes:
    """Remove, repeat or move a line."""
    lines = data.splitlines(keepends=True) or [b"\n"]
    at = rng.randrange(len(lines))
    line = lines.pop(at)
    for _ in range(rng.choice([0, 1, 2])):
        lines.insert(rng.choice([at, rng.randrange(len(lines) + 1)]), line)
    return b"".join(lines)


def mutated_number(rng, data: bytes) -> bytes:
    """Replace a number by a hostile one, mostly in the header."""
    tokens = data[: 3000 if rng.random() < 0.6 else len(data)].split()
    old_token = rng.choice([token for token in tokens if re.search(rb"\d", token)] or [b"1"])
    new_token = rng.choice([*NUMBERS, *VALUES[:26]]).encode()
    at = data.find(old_token)
    return data[:at] + new_token + data[at + len(old_token) :]
