# SPDX-License-Identifier: GPL-3.0-or-later
"""Generate from schema.txt the table and readers of the engine, methods of `Model`, a page of docs.

python make_schema.py table|values|groups|python|page schema.txt OUTPUT
"""

from __future__ import annotations

import keyword
import re
import sys
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import accumulate, groupby
from pathlib import Path

WIDTH = 128  # bytes of values, as in `dda_input_variable`
USABLE = "usable"  # the largest number of an input
KIND = re.compile(r"(real|integer|logical|name|word|text|points)(?:\((\d+)\))?")
NUMBERS = ("real", "integer", "points")
NEXT, NEW_LINE = ", &\n      ", "\n      "  # between parts of a list, and statements, of Fortran
BLANK = "''"
RANGE = re.compile(r"(\S+) to (\S+)|above (0)|at least (\S+)|any")


@dataclass
class Variable:
    """A variable of a group; the fields are the columns of the schema."""

    name: str
    kind: str
    unit: str
    default: str
    values: str
    meaning: str
    when: str = ""
    needs: str = ""
    excludes: str = ""
    part: str = ""  # its part, if groups share the variable

    def __post_init__(self):
        match = KIND.fullmatch(self.kind)
        if not match or not re.fullmatch(r"[a-z][a-z_0-9]*", self.name) or not self.meaning:
            raise ValueError(f"{self}: not a variable")
        self.base, self.size = match[1], int(match[2] or 0)
        if self.base in NUMBERS and not RANGE.fullmatch(self.values):
            raise ValueError(f"{self.name}: values = {self.values!r}")

    @property
    def limits(self) -> tuple[str, str]:
        """Return the lowest and highest number as Fortran literals."""
        low, high, above, least = RANGE.fullmatch(self.values).groups()
        if above:
            return "above_zero", USABLE
        return real(low or least), real(high)

    @property
    def conditions(self) -> str:
        """Describe the conditions of the variable in words."""
        parts = (("", self.when), ("needs ", self.needs), ("excludes ", self.excludes))
        return "; ".join(word + text for word, text in parts if text)

    def rules(self) -> Iterator[tuple[str, str, bool]]:
        """Yield each condition, the variable that it needs or excludes, and whether it excludes."""
        if self.when:
            yield self.name, self.when, False
        if self.default.startswith("required by its "):
            yield self.when, self.name, False
        for cell, excludes in ((self.needs, False), (self.excludes, True)):
            for clause in filter(None, cell.split("; ")):
                of, items = re.fullmatch(r"(?:((?:'\w+', )*'\w+'): )?(.+)", clause).groups()
                for item in items.split(", "):
                    yield f"{self.name} = {of}" if of else self.name, item, excludes


@dataclass
class Group:
    """A group of the schema."""

    name: str
    meaning: str
    repeats: bool
    built: bool
    example: str = ""
    needs: str = ""
    variables: list[Variable] = field(default_factory=list)

    def rules(self) -> Iterator[tuple[str, str, bool]]:
        """Yield the needs of the group in the form of `Variable.rules`."""
        return (("", item, False) for item in filter(None, self.needs.split("; ")))


def real(number: str | None) -> str:
    """Return a number as a Fortran literal; blank if there is no limit."""
    return f"{float(number)!r}_wp" if number else ""


def read(file: Path) -> list[Group]:
    """Read the groups of a schema."""
    lines: list[str] = []
    for line in file.read_text(encoding="utf-8").splitlines():
        if line.startswith(" "):
            lines[-1] += " " + line.strip()
        elif line and not line.startswith("#"):
            lines.append(line)
    groups, parts, here, part = [], {}, [], ""
    for line in lines:
        word, _, rest = line.partition(" ")
        if "|" in line:
            here.append(Variable(*(cell.strip() for cell in line.split("|")), part=part))
        elif word == "part":
            here, part = parts.setdefault(rest, []), rest
        elif word == "use":
            here += parts[rest]
        elif word == "example":
            groups[-1].example = rest
        elif word == "needs":
            groups[-1].needs = rest
        else:
            name, star, meaning = re.fullmatch(r"(\w+) (\* )?(.+)", rest).groups()
            groups.append(Group(name, meaning, bool(star), word == "built"))
            here, part = groups[-1].variables, ""
    return groups


# --- Fortran -------------------------------------------------------------------------------------


def literal(text: str) -> str:
    """Return a Fortran literal of a text, on several lines if it is long."""
    parts = textwrap.wrap(text, 80, drop_whitespace=False)
    return "// &\n         ".join(f'"{part}"' for part in parts) or BLANK


def table(groups: list[Group]) -> str:
    """Generate the module `dda_input_schema`."""
    entries, names, first = [], [], 1
    rows_of = ""
    rules = [
        rule(i, *one)
        for i, group in enumerate(groups, 1)
        for one in [*group.rules(), *(r for v in group.variables for r in v.rules())]
    ]
    for group in groups:
        last = first + len(group.variables) - 1
        flags = f"{truth(group.repeats)}, {truth(group.built)}"
        entries.append(f"group_entry_type('{group.name}', {flags}, {first}, {last})")
        rows = NEXT.join(map(entry, group.variables))
        rows_of += f"   type(variable_type), parameter :: of_{group.name}(*) = [ &\n      {rows}]\n"
        names.append(f"of_{group.name}")
        first = last + 1
    return f"""! Made from schema.txt by make_schema.py.
!> The groups and variables of the input.
module dda_input_schema
   use dda_kinds, only: wp
   use dda_input_variable, only: group_entry_type, rule_type, variable_type, above_zero, usable
   implicit none
   private
   public :: input_groups, input_rules, input_variables

{rows_of}
   type(group_entry_type), protected :: input_groups({len(groups)}) = [ &
      {NEXT.join(entries)}]
   type(variable_type), protected :: input_variables({first - 1}) = [ &
      {NEXT.join(names)}]
   type(rule_type), protected :: input_rules({len(rules)}) = [ &
      {NEXT.join(rules)}]

end module dda_input_schema
"""


def rule(group: int, holder: str, item: str, excludes: bool) -> str:
    """Return a rule as Fortran code."""
    if max(len(holder), len(item)) > WIDTH:
        raise ValueError(f"{holder}, {item}: longer than {WIDTH} bytes")
    return f"rule_type({group}, {literal(holder)}, {literal(item)}, {truth(excludes)})"


def truth(value: bool) -> str:
    """Return a logical value as a Fortran literal."""
    return ".true." if value else ".false."


def preset(one: Variable) -> str:
    """Return the default as Fortran code if it is one value or a list of numbers."""
    if one.base == "logical":
        return one.default
    if one.base in ("name", "word", "text"):
        match = re.match(r"('[^']+')(:|$)", one.default)
    elif re.fullmatch(r"[-+.\de]+(, [-+.\de]+)+", one.default):
        return f"[{', '.join(map(real, one.default.split(', ')))}]"
    else:
        match = re.match(r"([-+.\de]+)([:;]|$)", one.default)
    if not match:
        return ""
    return match[1] if one.base in ("name", "word", "text", "integer") else real(match[1])


def entry(one: Variable) -> str:
    """Return a variable as Fortran code."""
    size = 2 * one.size if one.base == "points" else one.size
    parts = [f"'{one.name}'", f"'{one.base}'", str(size)]
    if one.base in NUMBERS:
        limits = zip(("lowest", "highest"), one.limits, strict=True)
        parts += [f"{name}={limit}" for name, limit in limits if limit and limit != USABLE]
        number = preset(one)
        if number and number[0] != "[":
            parts.append(f"preset={real(number.removesuffix('_wp'))}")
    elif one.base == "word":
        parts.append(f"allowed={literal(one.values)}")
    elif one.default == ".true.":
        parts.append("preset=1.0_wp")
    if one.base in ("name", "word", "text") and (word := preset(one)):
        parts.append(f"usual={word}")
    if one.default == "required":
        parts.append("required=.true.")
    variable, _, values = one.when.partition(" = ")
    if one.when:
        parts.append(f"switch='{variable}', belongs={literal(values)}")
    for text, width in ((one.name, 26), (one.values, WIDTH), (variable, 12), (values, WIDTH)):
        if len(text.encode()) > width:
            raise ValueError(f"{one.name}: {text!r} is longer than the {width} bytes it has")
    return f"variable_type({NEXT.join(parts)})"


def component(one: Variable) -> tuple[str, str]:
    """Return the declaration of a variable with its default, and its reader."""
    if one.base == "points":
        return f"real(wp), allocatable :: {one.name}(:,:)", "take_points"
    if one.base == "text":
        return f"character(len=:), allocatable :: {one.name}", "take_text"
    if one.base in ("name", "word"):
        if one.size:
            return f"character(len=name_length), allocatable :: {one.name}(:)", "take_names"
        return f"character(len=name_length) :: {one.name} = {preset(one) or BLANK}", "take_name"
    if one.base == "logical":
        return f"logical :: {one.name} = {one.default}", "take_logical"
    if one.base == "integer" and float(one.limits[1].removesuffix("_wp") or 0) < 2**31:
        return f"integer :: {one.name} = {preset(one) or '-huge(1)'}", "take_integer"
    if one.size > 3:
        return f"real(wp), allocatable :: {one.name}(:)", "take_numbers"
    shape, how = (f"({one.size})", "take_tuple") if one.size else ("", "take_real")
    return f"real(wp) :: {one.name}{shape} = {preset(one) or 'unset'}", how


def type_of(name: str, meaning: str, variables: list[Variable]) -> str:
    """Generate a type with the values of a group or part."""
    lines = []
    for part, own in groupby(variables, lambda one: one.part if one.part != name else ""):
        lines += [f"type({part}_values) :: {part}"] if part else [component(v)[0] for v in own]
    return f"""
   !> {meaning}.
   type :: {name}_values
      {NEW_LINE.join(lines)}
   end type {name}_values
"""


def reader_of(group: Group, g: int, first: int) -> str:
    """Generate the reader of group number `g`, whose first variable has number `first`."""
    calls = [
        f"call {component(v)[1]}(group, {i}, values%{v.part and v.part + '%'}{v.name}, error)"
        for i, v in enumerate(group.variables, first)
    ]
    return f"""
   pure subroutine read_{group.name}(group, values, error)
      type(group_type), intent(in) :: group
      type({group.name}_values), intent(out) :: values
      type(error_type), allocatable, intent(inout) :: error

      call check_rules(group, {g}, .false., error)
      {NEW_LINE.join(calls)}
   end subroutine read_{group.name}
"""


def values(every: list[Group]) -> str:
    """Generate the module `dda_group_values`."""
    own = [group for group in every if not group.built]
    parts: dict[str, list[Variable]] = {}
    for variable in (v for group in own for v in group.variables if v.part):
        parts.setdefault(variable.part, [])
        if variable not in parts[variable.part]:
            parts[variable.part].append(variable)
    types = "".join(type_of(name, f"The part {name}", rows) for name, rows in parts.items())
    types += "".join(type_of(one.name, f"&{one.name}: {one.meaning}", one.variables) for one in own)
    return f"""! Made from schema.txt by make_schema.py.
!> The values of each group of the input, with their defaults.
module dda_group_values
   use dda_kinds, only: wp
   implicit none

   real(wp), parameter :: unset = -huge(1.0_wp)  !< value of variables that the input does not give
   integer, parameter :: name_length = 64        !< bytes of a name
{types}
end module dda_group_values
"""


def groups(every: list[Group]) -> str:
    """Generate the module `dda_input_groups`."""
    own = [group for group in every if not group.built]  # they are the first
    parts = dict.fromkeys(v.part for group in own for v in group.variables if v.part)
    firsts = accumulate((len(group.variables) for group in every), initial=1)
    readers = "".join(map(reader_of, own, range(1, len(own) + 1), firsts))
    return f"""! Made from schema.txt by make_schema.py.
!> Readers of the values of each group of the input.
module dda_input_groups
   use dda_errors, only: error_type
   use dda_group_values
   use dda_input_group, only: group_type, take_integer, take_logical, take_name, take_names, &
      take_numbers, take_points, take_real, take_text, take_tuple
   use dda_input_text, only: check_rules
   implicit none
   private
   public :: read_values, &
      {NEXT.join(f"{name}_values" for name in [*parts, *(one.name for one in own)])}

   !> Read and check the values of a group; missing values are the defaults, or `unset`.
   interface read_values
      module procedure {NEXT.join(f"read_{one.name}" for one in own)}
   end interface read_values

contains
{readers}
end module dda_input_groups
"""


# --- Python --------------------------------------------------------------------------------------

TYPES = {"real": "float", "integer": "int", "logical": "bool", "points": "Points"}


def python(groups: list[Group]) -> str:
    """Generate the module `sitedda.input.schema`."""
    table = ""
    for group in groups:
        rows = "".join(
            f"    Variable({', '.join(map(repr, [group.name, v.name, v.base, v.size, v.unit]))},\n"
            f"        {', '.join(map(repr, [v.default, v.values, v.meaning, v.when]))},\n"
            f"        {v.needs!r}, {v.excludes!r}),\n"
            for v in group.variables
        )
        flags = f"{group.name!r}, {group.meaning!r}, {group.repeats}, {group.built}"
        texts = f"{group.example!r}, {group.needs!r}"
        table += f"    {group.name!r}: Group({flags}, {texts}, (\n{rows}    )),\n"
    methods = "".join(method(group) for group in groups if group.name != "run")
    values = "".join(values_of(group) for group in groups if group.built)
    return f'''# Made from schema.txt by make_schema.py.
"""The groups of the input: their variables, the methods of `Model` that add them, and the values of
those that become blocks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple

from .values import Values

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike as Points
    from numpy.typing import ArrayLike as Numbers

    from ..build.model import Group as Added


class Variable(NamedTuple):
    """A variable of the input."""

    group: str
    name: str
    kind: str
    size: int
    unit: str
    default: str
    values: str
    meaning: str
    when: str
    needs: str
    excludes: str


class Group(NamedTuple):
    """A group of the input."""

    name: str
    meaning: str
    repeats: bool
    built: bool
    example: str
    needs: str
    variables: tuple[Variable, ...]


GROUPS = {{
{table}}}


class Groups:
    """Methods of `Model`, one for each group of the input."""

    __slots__ = ()
{methods}{values}'''


def method(group: Group) -> str:
    """Generate the method of `Model` that adds or returns a group."""
    variables = described_all(group.variables, 8)
    if not group.repeats:
        return f'''
    @property
    def {group.name}(self) -> Added:
        """The group &{group.name}: {group.meaning}.

        Attributes
        ----------
{variables}        """
        return self._once["{group.name}"]
'''
    names = [v.name for v in group.variables]
    if any(map(keyword.iskeyword, names)):
        given, passed = "*arguments, **values", "*arguments, **values"
    else:
        given = ", ".join(f"{v.name}: {hint(v)} | None = None" for v in group.variables)
        given += ", **others"
        passed = ", ".join(f"{name}={name}" for name in names) + ", **others"
    return f'''
    def {group.name}(self, {given}) -> Added:
        """Add a group &{group.name}: {group.meaning}.

        Parameters
        ----------
{variables}        """
        return self.add("{group.name}", {passed})
'''


def described_all(variables: list[Variable], indent: int) -> str:
    """Describe variables for a docstring."""
    blank = " " * (indent + 4)
    return "".join(
        f"{' ' * indent}{v.name} : {', '.join(filter(None, [shown(v), v.unit]))}\n"
        f"{textwrap.fill(described(v), 96, initial_indent=blank, subsequent_indent=blank)}\n"
        for v in variables
    )


def shown(variable: Variable) -> str:
    """Return the type of a variable for a docstring."""
    return f"{{{variable.values}}}" if variable.base == "word" else hint(variable)


def hint(variable: Variable) -> str:
    """Return the type hint of a variable."""
    if variable.base == "word":
        return f"Literal[{variable.values}]"
    one = TYPES.get(variable.base, "str")
    if not variable.size or variable.base == "points":
        return one
    return "Sequence[str]" if one == "str" else "Numbers"


def described(variable: Variable) -> str:
    """Describe meaning, values, conditions and default of a variable."""
    text = variable.meaning
    if variable.values and variable.base != "word" and variable.values != "any":
        text += f"; {variable.values}"
    if variable.conditions:
        text += f"; {'of ' * bool(variable.when)}{variable.conditions}"
    return f"{text} ({variable.default})."


def values_of(group: Group) -> str:
    """Generate the class of the values of a group, without the variables of a points file."""
    own = [v for v in group.variables if v.part != "points_file"]
    points = next((v.name for v in own if v.base == "points"), "")
    from_file = points if len(own) < len(group.variables) else ""
    fields = "".join(
        f"    {v.name}: {'str' if v.base == 'word' else hint(v)} | None = {value(v)}\n" for v in own
    )
    return f'''

class {"".join(map(str.capitalize, group.name.split("_")))}Values(Values):
    """&{group.name}: {group.meaning}.

    Attributes
    ----------
{described_all(own, 4)}    """

    group = {quoted(group.name)}
    from_file = {quoted(from_file)}
    variables, needs = GROUPS[group].variables, GROUPS[group].needs
{fields}'''


def quoted(text: str) -> str:
    """Return a Python literal of a text."""
    return f'"{text}"'


def value(variable: Variable) -> str:
    """Return the default as a Python literal."""
    if variable.base in ("name", "word", "text"):
        blank = "None" if variable.base == "word" else '""'
        return quoted(preset(variable).strip("'")) if preset(variable) else blank
    if variable.base == "logical":
        return variable.default.strip(".").capitalize()
    number = preset(variable).replace("_wp", "")
    return number.replace("[", "(").replace("]", ")") or "None"


# --- Page ----------------------------------------------------------------------------------------

PAGE = """# Input reference

<!-- Made from fortran/input/schema.txt by fortran/input/make_schema.py. -->

Groups marked * may occur several times. [Input](input.md) explains files and units. The number in
brackets is the largest length of a list. *names* is a list such as `'one, two, all_*'`. Points are
listed as x, y, x, y … The default *this or steps* means that this variable or `steps` is required.

"""
PARTS = {  # headings of variables that several groups have
    "naming": "Material and joint",
    "rest": "Weight at the start",
    "point": "A point of a block",
    "edges": "Edges of the outline",
    "points_file": "Points from a file",
    "foot": "Lower left corner",
}
HEAD = "| variable | kind | default | meaning |\n|---|---|---|---|\n"


def page(groups: list[Group]) -> str:
    """Generate the page of the handbook."""
    text = PAGE
    for built, title in ((False, "Groups of the engine"), (True, "Groups that become blocks")):
        text += f"## {title}\n\n"
        if built:
            text += "`sitedda build` converts these groups into blocks for the executable.\n\n"
        text += "\n".join(section(group) for group in groups if group.built == built) + "\n"
    text += "## Variables of several groups\n\n"
    every = {(v.part, v.name): v for group in groups for v in group.variables}
    return text + "\n".join(
        f"### {title}\n\n{HEAD}{''.join(row(v) for v in every.values() if v.part == part)}"
        for part, title in PARTS.items()
    )


def section(group: Group) -> str:
    """Generate a section: heading, example, table, and links to shared variables."""
    needs = re.sub(r"\b(?!or\b)\w+", r"`\g<0>`", group.needs).replace("; ", ", and ")
    needs = needs and f" Requires {needs}."
    parts = {
        part: ", ".join(f"`{v.name}`" for v in variables)
        for part, variables in groupby(group.variables, lambda v: v.part)
        if part in PARTS
    }
    links = [
        f"[{names}](#{PARTS[part].lower().replace(' ', '-')})" for part, names in parts.items()
    ]
    return (
        f"### `&{group.name}`{' *' if group.repeats else ''}\n\n"
        f"{group.meaning[0].upper()}{group.meaning[1:]}.{needs}\n\n"
        f"    {group.example}\n\n{HEAD}"
        f"{''.join(row(v) for v in group.variables if v.part not in PARTS)}"
        + (f"\nShared variables: {'; '.join(links)}.\n" if links else "")
    )


def row(one: Variable) -> str:
    """Generate a row of a table."""
    conditions = one.conditions and f" (`{one.conditions}`)"
    meaning = one.meaning.removeprefix("x, y, x, y …: ")
    return f"| `{one.name}` | {ranged(one)} | {one.default} | {meaning}{conditions} |\n"


def ranged(one: Variable) -> str:
    """Describe kind, unit and range of a variable."""
    if one.base == "word":
        return one.values
    named = one.base == "name" and one.values.startswith(("the name", "names"))
    if named or one.values.startswith("names: "):
        return one.values.removeprefix("the ").removesuffix(": 'one, two, all_*'")
    limits = "" if one.values == "any" else one.values.removeprefix("any, ").replace(" to ", "…")
    for words, sign in (("above ", ">"), ("at least ", "≥"), ("at most ", "≤")):
        limits = limits.replace(words, sign)
    return ", ".join(filter(None, (one.kind, one.unit, limits)))


if __name__ == "__main__":
    what, source, target = sys.argv[1:]
    make = {"table": table, "values": values, "groups": groups, "python": python, "page": page}[
        what
    ]
    Path(target).write_text(make(read(Path(source))), encoding="utf-8")
