# SPDX-License-Identifier: GPL-3.0-or-later
"""Generate from schema.txt tables of the engine, the table of the reader in Python, and a page.

python make_schema.py table|python|page schema.txt OUTPUT
"""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

NEXT = ", &\n      "  # between parts of a list of Fortran
KINDS = {"text": "is_text", "real": "is_real", "real or none": "is_real", "fraction": "is_real"}
ROWS = ("time", "frame", "contact")  # dimensions that values are written along, row by row
PER_METRE = ", per metre of thickness"
FLAG = re.compile(r"(\d+) ([^,:]+)")


@dataclass
class Variable:
    """A variable of the output; the fields are the columns of the schema."""

    name: str
    dimensions: list[str]
    kind: str
    unit: str
    meaning: str
    more: str
    family: str
    needed: bool
    label: bool
    coordinates: str = ""

    @property
    def row(self) -> str:
        """Return the dimension along which it is written in rows; blank: written once."""
        found = "" if self.name == "contact_frame" else self.dimensions[0]
        return found if found in ROWS else ""

    @property
    def number(self) -> str:
        """Return its name in the values of the verdict."""
        return number_of(self.name, self.unit)

    @property
    def flags(self) -> dict[str, str]:
        """Return values and meanings of a flag, as the CF conventions require."""
        if self.kind != "flag":
            return {}
        return {
            value: words.strip().replace(" ", "_") for value, words in FLAG.findall(self.meaning)
        }


@dataclass
class Schema:
    """All dimensions, energies, largest values, families and variables."""

    dimensions: dict[str, tuple[str, str]] = field(default_factory=dict)
    energies: list[tuple[str, str, str]] = field(default_factory=list)
    maxima: list[tuple[str, str, str, str]] = field(default_factory=list)
    families: dict[str, str] = field(default_factory=dict)
    variables: list[Variable] = field(default_factory=list)


def number_of(name: str, unit: str) -> str:
    """Append the unit to a name, as in attributes: acceleration_m_s2."""
    return (
        name if unit in ("1", "") else f"{name}_{unit.lower().replace('/', '_').replace('^', '')}"
    )


def read(file: Path) -> Schema:
    """Read and check a schema."""
    lines: list[str] = []
    for line in file.read_text(encoding="utf-8").splitlines():
        if line.startswith(" "):
            lines[-1] += " " + line.strip()
        elif line and not line.startswith("#"):
            lines.append(line)
    found = Schema()
    for line in lines:
        cells = [cell.strip() for cell in line.split("|")]
        word, _, name = cells[0].partition(" ")
        if word == "dimension":
            found.dimensions[name] = (cells[1], cells[2])
        elif word == "energy":
            found.energies.append((name, *cells[1:]))
        elif word == "maximum" and name:
            found.maxima.append((name, *cells[1:]))
        elif word == "family":
            found.families[name] = cells[1]
            if name == "energies":
                found.variables += [energy(name, one) for one in found.energies]
        else:
            found.variables.append(variable(cells, list(found.families)[-1]))
    for one in found.variables:
        check(one, found)
        one.coordinates = " ".join(
            other.name
            for other in found.variables
            if other.label and has_labels(one, found) and {*other.dimensions} <= {*one.dimensions}
        )
    return found


def energy(family: str, term: tuple[str, str, str]) -> Variable:
    """Return the variable of a term of the energy budget."""
    name, role, meaning = term
    needed = name == "kinetic" or role == "remainder"  # others may be absent
    words = meaning + PER_METRE
    return Variable(f"energy_{name}", ["time"], "real", "J/m", words, "", family, needed, False)


def variable(cells: list[str], family: str) -> Variable:
    """Convert the cells of a row into a variable."""
    name, star, _ = cells[0].partition(" *")
    kind = cells[2].removeprefix("label ")
    more = cells[5] if len(cells) > 5 else ""
    label = kind != cells[2]
    return Variable(name, cells[1].split(), kind, *cells[3:5], more, family, bool(star), label)


def has_labels(one: Variable, schema: Schema) -> bool:
    """Whether a variable has labels and is no coordinate itself."""
    return not one.label and one.name not in schema.dimensions


def check(one: Variable, schema: Schema) -> None:
    """Raise ValueError if a variable is not valid."""
    named = one.kind.removesuffix(" or none")
    known = named in schema.dimensions or one.kind in (*KINDS, "number", "flag")
    good = re.fullmatch(r"[a-z][a-z_0-9]*", one.name) and set(one.dimensions) <= {
        *schema.dimensions
    }
    flags_count = list(one.flags) == [str(i) for i in range(len(one.flags))]
    if not (good and known and one.meaning and flags_count) or (
        one.kind == "flag" and not one.flags
    ):
        raise ValueError(f"{one}: not a variable of an output")


# --- Fortran -------------------------------------------------------------------------------------


def table(schema: Schema) -> str:
    """Generate the module `dda_output_schema`."""
    numbers = [number_of(name, unit) for name, unit, *_ in schema.maxima]
    variables = schema.variables
    widths = {
        "name": longest(v.name for v in variables),
        "units": longest(v.unit for v in variables),
        "meaning": longest(v.meaning for v in variables),
        "coordinates": longest(v.coordinates for v in variables),
        "flags": longest(" ".join(v.flags.values()) for v in variables),
    }
    text = "\n".join(f"      character(len={width}) :: {name}" for name, width in widths.items())
    rows = "".join(
        f"   type(output_variable_type), parameter :: rows_{name}(*) = [ &\n      "
        f"{NEXT.join(entry(v, schema) for v in variables if v.family == name)}]\n"
        for name in schema.families
    )
    maxima = NEXT.join(
        f"maximum_type({literal(name)}, {literal(unit)}, {literal(number)}, {truth(of == 'point')})"
        for (name, unit, of, _), number in zip(schema.maxima, numbers, strict=True)
    )
    terms = NEXT.join(
        f"energy_term_type({literal(name)}, is_{role})" for name, role, _ in schema.energies
    )
    return f"""! Made from schema.txt by make_schema.py.
!> The variables of the output, the terms of the energy budget and the kinds of largest values.
module dda_output_schema
   implicit none
   public

   integer, parameter :: is_text = 1, is_real = 2, is_whole = 3  !< kinds of variables
   integer, parameter :: once = 0, each_time = 1, each_frame = 2, each_contact = 3  !< rows
   integer, parameter :: is_stored = 1, is_gain = 2, is_loss = 3, is_remainder = 4  !< roles

   !> A variable: blank units mean one unit per component; the fastest dimension is first.
   type :: output_variable_type
{text}
      integer :: kind, family, row, dimensions(3)
      character(len={longest(v.number for v in variables)}) :: number  ! as a number of the verdict
   end type output_variable_type

   !> A kind of largest values: name, units, name as a number of the verdict; of measured points.
   type :: maximum_type
      character(len={longest(one[0] for one in schema.maxima)}) :: name
      character(len={longest(one[1] for one in schema.maxima)}) :: units
      character(len={longest(numbers)}) :: number
      logical :: of_points
   end type maximum_type

   !> A term of the energy budget, and how it enters the balance.
   type :: energy_term_type
      character(len={longest(one[0] for one in schema.energies)}) :: name
      integer :: role
   end type energy_term_type

{places("dim_", schema.dimensions)}
   character(len=*), parameter :: dimension_names({len(schema.dimensions)}) = [ &
      character(len={longest(schema.dimensions)}) :: {NEXT.join(map(literal, schema.dimensions))}]

{places("in_", schema.families)}
   integer, parameter :: number_of_families = {len(schema.families)}

{places("energy_", [one[0] for one in schema.energies])}
   type(energy_term_type), parameter :: energy_terms({len(schema.energies)}) = [ &
      {terms}]

{places("of_", [one[0] for one in schema.maxima])}
   integer, parameter :: number_of_maxima = {len(schema.maxima)}
   integer, parameter :: maxima_of_blocks = {sum(of == "block" for *_, of, _ in schema.maxima)}
   type(maximum_type), parameter :: maxima_table(number_of_maxima) = [ &
      {maxima}]

{places("out_", [v.name for v in variables])}
{rows}   type(output_variable_type), parameter :: output_variables({len(variables)}) = [ &
      {NEXT.join(f"rows_{name}" for name in schema.families)}]
{columns(schema)}
end module dda_output_schema
"""


def entry(one: Variable, schema: Schema) -> str:
    """Return a row of the table as Fortran code."""
    names = list(schema.dimensions)
    text = one.kind == "text"
    fastest = ["letter"] * text + one.dimensions[::-1]
    dims = ", ".join(f"{names.index(name) + 1}" for name in fastest)
    dims += ", 0" * (3 - len(fastest))
    kind = KINDS.get(one.kind, "is_whole")
    row = {"": "once", "time": "each_time", "frame": "each_frame", "contact": "each_contact"}[
        one.row
    ]
    words = (one.name, one.unit, one.meaning, one.coordinates, " ".join(one.flags.values()))
    texts = ", &\n      ".join(map(literal, words))
    return (
        f"output_variable_type({texts}, &\n      {kind}, in_{one.family}, {row}, [{dims}], "
        f"{literal(one.number)})"
    )


def columns(schema: Schema) -> str:
    """Generate the number of row variables per family, and the list of contact variables."""
    counts = [sum(v.family == name and v.row != "" for v in schema.variables)
              for name in schema.families]  # fmt: skip
    listed = ", ".join(map(str, counts))
    contacts = NEXT.join(f"out_{v.name}" for v in schema.variables if v.row == "contact")
    return f"""   integer, parameter :: columns_of({len(counts)}) = [{listed}]  !< in rows
   integer, parameter :: contact_columns(*) = [ &
      {contacts}]
"""


def places(prefix: str, names) -> str:
    """Generate constants that number the names from 1."""
    rows = "\n".join(
        f"   integer, parameter :: {prefix}{name} = {i}" for i, name in enumerate(names, 1)
    )
    return rows


def literal(text: str) -> str:
    """Return a Fortran literal of a text."""
    return "'" + text.replace("'", "''") + "'"


def truth(value: bool) -> str:
    """Return a logical value as a Fortran literal."""
    return ".true." if value else ".false."


def longest(texts) -> int:
    """Return the number of bytes of the longest text."""
    return max(len(text.encode()) for text in texts)


# --- Python --------------------------------------------------------------------------------------


def python(schema: Schema) -> str:
    """Generate the module `sitedda.output.variables`."""
    rows = "".join(
        f"    {v.name!r}: Variable({v.name!r}, {tuple(v.dimensions)!r}, {v.kind!r}, {v.unit!r},\n"
        f"        {v.family!r}, {v.needed}, {v.number!r}),\n"
        for v in schema.variables
    )
    always = {name: when.startswith("always") for name, when in schema.families.items()}
    lengths = {name: int(n) for name, (n, _) in schema.dimensions.items() if n.isdigit()}
    return f'''# Made from schema.txt by make_schema.py.
"""The variables of an output, with dimensions, kinds, units and families."""

from typing import NamedTuple


class Variable(NamedTuple):
    """A variable of the output, in the words of the schema."""

    name: str
    dimensions: tuple[str, ...]
    kind: str
    unit: str
    family: str
    needed: bool  # if any variable of its family is present
    number: str  # its name in the values of the verdict


VARIABLES = {{
{rows}}}
FAMILIES = {always}  # True: written for all models
LENGTHS = {lengths}  # of dimensions that have one length
'''


# --- Page ----------------------------------------------------------------------------------------

PAGE = """# Variables of the output

<!-- Made from fortran/output/schema.txt by fortran/output/make_schema.py. -->

[Output](output.md) explains how to read outputs, and lists the attributes. Every variable has a
`long_name`, and a unit that pint and UDUNITS read unless its components have different units.

"""


RELATIVE = "Displacements, velocities and accelerations are relative to the base."


def page(schema: Schema) -> str:
    """Generate the page of the handbook."""
    text = PAGE + "## Dimensions\n\n| dimension | content |\n|---|---|\n"
    for name, (length, words) in schema.dimensions.items():
        text += f"| `{name}` | {f'{length}: ' if length.isdigit() else ''}{words} |\n"
    text += "\n## Variables\n"
    for family, when in schema.families.items():
        own = [one for one in schema.variables if one.family == family]
        text += f"\n### {family.replace('_', ' ').capitalize()}\n\n{written(when)}.\n\n"
        text += "| variable | dimensions | kind | meaning |\n|---|---|---|---|\n"
        text += "".join(map(line, own))
    text += f"\n## Largest values\n\n{RELATIVE}\n\n| `maximum` | unit | meaning |\n|---|---|---|\n"
    return text + "".join(f"| `{n}` | {unit} | {words} |\n" for n, unit, _, words in schema.maxima)


def written(when: str) -> str:
    """Describe in a sentence when a family is written."""
    first, _, rest = when.partition("always")
    return f"{when[0].upper()}{when[1:]}" if first else f"Always written{rest}"


def line(one: Variable) -> str:
    """Generate the table row of a variable."""
    kind = ", ".join(
        filter(None, [one.kind, one.unit if one.kind != "text" and one.unit != "1" else ""])
    )
    meaning = one.meaning.removesuffix(PER_METRE) if one.family == "energies" else one.meaning
    words = f"{meaning}{one.more and '; '}{one.more}"
    return f"| `{one.name}` | {', '.join(one.dimensions)} | {kind} | {words} |\n"


if __name__ == "__main__":
    what, source, target = sys.argv[1:]
    make = {"table": table, "python": python, "page": page}[what]
    Path(target).write_text(make(read(Path(source))), encoding="utf-8")
