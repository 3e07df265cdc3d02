# SPDX-License-Identifier: GPL-3.0-or-later
"""A model as a Python object, with the groups of the namelist input."""

import os
import re
import tempfile
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import groupby
from pathlib import Path

import numpy as np

from ..base.errors import InputError, located
from ..base.files import OWN_INPUT, OWN_RECORD, check_target, write
from ..base.reading import file_path
from ..input.groups import (
    checked,
    group_text,
    is_made,
    known_group,
    known_variable,
    nearest,
    read_values,
    single_groups,
    variable_kinds,
)
from ..input.input_text import cited, find_groups
from ..input.schema import Groups
from ..input.source import blocks_text, read_input
from .building import block_writer, build_blocks

_UNIQUE = ("material", "joint", "motion", "measured_point")
_LONGEST = 4096  # largest number of values of a motion in an input; more are written to a file


class Group:
    """A group of a model; its variables are attributes.

    A variable that is not set is None; setting it to None removes it.  Only variables of the group
    can be set.

    Examples
    --------
    >>> rock = model.material("rock", density=2600.0, young_modulus=40e9, poisson_ratio=0.2)
    >>> rock.density = 2700.0
    """

    __slots__ = ("_name", "_values", "_source")

    def __init__(self, name: str, values: dict | None = None, source: str = ""):
        object.__setattr__(self, "_name", known_group(name))
        object.__setattr__(self, "_values", {})
        object.__setattr__(self, "_source", source)
        self(**(values or {}))

    @classmethod
    def _of_checked_values(cls, name: str, values: dict, source: str = "") -> "Group":
        """Return a group with values that have been checked before."""
        group = cls(name, None, source)
        group._values.update(values)
        return group

    def _copy(self) -> "Group":
        """Return an independent group with the same values."""
        return Group._of_checked_values(self._name, self._values, self._source)

    def __call__(self, **values) -> "Group":
        """Set several variables; return the group."""
        if self._name == "control" and None not in map(values.get, ("duration", "steps")):
            raise InputError("give either `duration` or `steps`")
        changes = {
            name: None if value is None else checked(self._name, name, value)
            for name, value in values.items()
        }
        for name, value in changes.items():
            known_variable(self._name, name)
            if name in ("duration", "steps") and value is not None:
                self._values.pop("steps" if name == "duration" else "duration", None)
            if value is None:
                self._values.pop(name, None)
            else:
                self._values[name] = value
        return self

    def __getattr__(self, name: str):
        if name.startswith("_") or name not in variable_kinds()[self._name]:
            hint = nearest(name, variable_kinds()[self._name])
            raise AttributeError(f"group &{self._name} has no variable {name!r}{hint}")
        return self._values.get(name)

    def __setattr__(self, name: str, value) -> None:
        if name not in variable_kinds()[self._name]:
            hint = nearest(name, variable_kinds()[self._name])
            raise AttributeError(f"group &{self._name} has no variable {name!r}{hint}")
        self(**{name: value})

    def __reduce__(self):
        """Return the values that `copy` and `pickle` restore."""
        return Group._of_checked_values, (self._name, self._values, self._source)

    def __dir__(self):
        """Return the names of attributes and variables."""
        return [*super().__dir__(), *variable_kinds()[self._name]]

    def __eq__(self, other) -> bool:
        """Return whether another group has the same name and values."""
        if not isinstance(other, Group):
            return NotImplemented
        values, other_values = self._values, other._values
        is_equal = self._name == other._name and values.keys() == other_values.keys()
        return is_equal and all(np.array_equal(values[name], other_values[name]) for name in values)

    __hash__ = None

    def __repr__(self) -> str:
        """Return the namelist text of the group, shortened."""
        text = group_text(self._name, self._values).strip()
        return text if len(text) < 120 else text[:116] + " …"

    def as_dict(self) -> dict:
        """Return the variables that are set, and their values."""
        return dict(self._values)


def _restored_model(kind: type["Model"], folder: Path, singles: dict, groups: list) -> "Model":
    """Return the model that `Model.__reduce__` took apart."""
    model = kind()
    model.folder = folder
    model._once.update(singles)
    model.groups.extend(groups)
    return model


class Model(Groups):
    """A model: blocks, materials, joints, motions, supports, loads, measured points.

    A method for each group of the namelist input adds such a group; the variables are keyword
    arguments.  ``control``, ``contact``, ``output``, ``cutting`` and ``stop`` occur only once and
    are attributes.

    Parameters
    ----------
    title : str, optional
    **control
        Variables of &control.

    Examples
    --------
    >>> slope = Model("Slope", time_step=5e-4, duration=3.0, gravity=(0, -9.81))
    >>> slope.material("rock", density=2600.0, young_modulus=5e9, poisson_ratio=0.25)
    >>> slope.joint("bedding", friction_angle=38.0)
    >>> slope.region("rock", outline)
    >>> slope.joint_set("bedding", angle=35.0, spacing=4.0)
    >>> slope.fixed_point(0.0, 0.0)
    >>> slope.run()

    Notes
    -----
    ``model["material"]`` is the list of groups of a kind, ``model["material.rock"]`` is the group
    with this name.  Points may be lists x, y, x, y …, arrays of shape (n, 2), or shapely polygons.
    """

    __slots__ = ("groups", "folder", "_once", "__weakref__")
    groups: list[Group]
    folder: Path  # folder to which relative file names refer

    def __init__(self, title: str | None = None, **control):
        groups = {name: Group(name) for name in single_groups()}
        object.__setattr__(self, "groups", [])
        object.__setattr__(self, "folder", Path())
        object.__setattr__(self, "_once", groups)
        if title is not None:
            self.title = title
        groups["control"](**control)

    @property
    def title(self) -> str:
        """Title of the run."""
        return self._once["run"].title or ""

    @title.setter
    def title(self, text: str) -> None:
        self._once["run"].title = text

    # --- Groups ----------------------------------------------------------------------------------

    def add(self, kind: str, /, *arguments, **values) -> Group:
        """Add a group, and return it.

        Parameters
        ----------
        kind : str
            Kind of group, without the ``&``.
        *arguments
            First variables of the group, in the order of the input reference.
        **values
            Variables of the group.
        """
        names = list(variable_kinds()[known_group(kind)])
        if len(arguments) > len(names):
            raise TypeError(f"{kind} accepts at most {len(names)} values")
        for name, value in zip(names, arguments, strict=False):
            if name in values:
                raise TypeError(f"{kind}: {name} is given twice")
            values[name] = value
        return self._add_group(Group(kind, values))

    def _add_group(self, group: Group) -> Group:
        """Append and return a group; reject a repeated name, or a group that occurs only once."""
        kind, name = group._name, group._values.get("name")
        if kind in single_groups():
            raise InputError(f"&{kind} occurs only once; set its variables by model.{kind}(…)")
        if kind in _UNIQUE and name in [item._values.get("name") for item in self.of_kind(kind)]:
            source = f"{group._source}: " if group._source else f"&{kind}: "
            raise InputError(f"{source}name = {name!r} is used twice")
        self.groups.append(group)
        return group

    def __getattr__(self, name: str):
        hint = "" if name.startswith("_") else nearest(name, dir(self))
        raise AttributeError(f"a model has no {name!r}{hint}")

    def __setattr__(self, name: str, value) -> None:
        if name in ("folder", "title"):
            super().__setattr__(name, value)
            return
        names = [variable for group in single_groups() for variable in variable_kinds()[group]]
        hint = f"; set it in a group, as model.control.{name}" if name in names else ""
        raise AttributeError(f"a model has no attribute {name!r} to set{hint}")

    def of_kind(self, kind: str) -> list[Group]:
        """Return the groups of a repeatable kind."""
        return [group for group in self.groups if group._name == kind]

    def __getitem__(self, path: str) -> list[Group] | Group:
        """Return the groups of a kind, or the group ``kind.name``."""
        kind, dot, name = path.partition(".")
        known_group(kind)
        if kind in single_groups():
            return self._once[kind]
        groups = self.of_kind(kind)
        if not dot:
            return groups
        by_name = {group._values.get("name"): group for group in reversed(groups)}
        if name not in by_name:
            hint = nearest(name, filter(None, by_name))
            raise InputError(f"there is no &{kind} named {name!r}{hint}")
        return by_name[name]

    def remove(self, group: Group) -> None:
        """Remove a group."""
        indices = [i for i, item in enumerate(self.groups) if item is group]
        if not indices:
            raise InputError("this group is not in the model")
        del self.groups[indices[0]]

    def clear(self, kind: str) -> None:
        """Remove all groups of a kind; a group that occurs once loses its variables."""
        if known_group(kind) in single_groups():
            self._once[kind] = Group(kind)
        self.groups[:] = [group for group in self.groups if group._name != kind]

    def copy(self) -> "Model":
        """Return an independent model with the same groups."""
        model = type(self)()
        model.folder = self.folder
        for name, group in self._once.items():
            model._once[name](**group._values)
        model.groups.extend(group._copy() for group in self.groups)
        return model

    @property
    def counts(self) -> dict[str, int]:
        """Return the number of groups of each repeatable kind."""
        return Counter(group._name for group in self.groups)

    def add_blocks(self, polygons, names=None, **values) -> list[Group]:
        """Add blocks from polygons.

        Parameters
        ----------
        polygons : sequence
            Lists x, y …, arrays of shape (n, 2), m, or shapely polygons, of either orientation.
        names : sequence of str, optional
        **values
            ``material`` and ``joint`` of all blocks.
        """
        from .cutting.geometry import outline_of

        polygons = list(polygons)
        names = [None] * len(polygons) if names is None else list(names)
        return [
            self.add("block", outline_of(f"polygon {i}", polygon), name=name, **values)
            for i, (polygon, name) in enumerate(zip(polygons, names, strict=True), 1)
        ]

    def __reduce__(self):
        """Return the values that `copy` and `pickle` restore."""
        return _restored_model, (type(self), self.folder, self._once, self.groups)

    def __repr__(self) -> str:
        """Return title and numbers of groups in one line."""
        counts = ", ".join(f"{count} {kind}" for kind, count in self.counts.items())
        return f"<sitedda.Model {self.title!r}: {counts or 'empty'}>"

    def __eq__(self, other) -> bool:
        """Return whether another model has the same groups in the same order."""
        if not isinstance(other, Model):
            return NotImplemented
        return self._once == other._once and self.groups == other.groups

    __hash__ = None

    # --- Text ------------------------------------------------------------------------------------

    @classmethod
    def read(cls, file) -> "Model":
        """Return the model of a namelist file."""
        return cls.from_namelist(read_input(file_path(file)), file)

    @classmethod
    def from_namelist(cls, text: str, file="model.nml") -> "Model":
        """Return the model of a namelist text; relative file names refer to the folder of `file`.

        Raises
        ------
        InputError
            If a group or variable is unknown, or a value cannot be read; the message names the
            line.  The engine checks the values in `check` and `run`.
        """
        model = cls()
        model.folder = Path(file).parent
        names = set()
        for group in find_groups(text, file):
            values, source = read_values(group, file), group.place(file)
            if group.name not in single_groups():
                model._add_group(Group._of_checked_values(group.name, values, source))
            elif group.name in names:
                raise InputError(f"{source}: this group may appear only once")
            else:
                with located(source):
                    model._once[group.name](**values)
            names.add(group.name)
        return model

    def to_namelist(self) -> str:
        """Return the model as a namelist text."""
        for group in self.of_kind("motion"):
            if (count := len(group._values.get("values", ()))) > _LONGEST:
                raise InputError(
                    f"motion {group.name!r} has {count} values, more than the limit of {_LONGEST} "
                    "in an input; use write(file), which writes the values to a separate file"
                )
        return self._to_text()

    def _to_text(self, changed: dict | None = None, write=blocks_text) -> str:
        """Return groups as text; `changed` replaces variables by group, `write` writes blocks."""
        groups = [single for single in self._once.values() if single._values] + self.groups
        changed, parts = changed or {}, []
        for kind, members in groupby(groups, key=lambda group: group._name):
            values = [changed.get(id(group), group._values) for group in members]
            parts += [write(values)] if kind == "block" else [group_text(kind, v) for v in values]
        return "".join(parts)

    def write(self, file, block_file: bool | None = None) -> Path:
        """Write the model to a namelist file.

        An existing file is replaced only if this method has written it.
        Motions of more than 4096 values are written to text files ``FILE.MOTION.txt``.  Paths of
        other files are changed to be relative to the folder of the file.

        Parameters
        ----------
        file : path
        block_file : bool, optional
            Write the blocks to a netCDF file, ``FILE.blocks.nc`` (default: for 10,000 consecutive
            blocks or more).
        """
        file = check_target(file, OWN_INPUT)
        changed = self._renamed_files(file.parent, f"{file.stem}.")
        text = self._to_text(changed, block_writer(file, block_file, self._named_files()))
        return write(file, f"! written by sitedda\n{text}", OWN_INPUT)

    def _named_files(self) -> list[Path]:
        """Return the paths of the files that groups name."""
        groups = [*self["motion"], *self["blocks"]]
        return [self.folder / group.file for group in groups if group.file]

    def _renamed_files(self, folder: Path, prefix: str) -> dict[int, dict]:
        """Return the variables of groups whose file path differs if written to `folder`.

        The keys are identities of groups.  Long motions are written to files, with this prefix.
        """
        result = {}
        for group in [*self["motion"], *self["blocks"]]:
            values = dict(group._values)
            if len(values.get("values", ())) > _LONGEST:
                record = folder / f"{prefix}{group.name}.txt"
                numbers = "\n".join(map(repr, values.pop("values").tolist()))
                write(record, f"# written by sitedda\n{numbers}\n", OWN_RECORD)
                units = {"acceleration": "m/s2", "velocity": "m/s", "displacement": "m"}
                values |= {"file": record.name, "format": "text"}
                values.setdefault("unit", units.get(group.quantity, ""))
            elif "file" in values and not os.path.isabs(values["file"]):
                values["file"] = os.path.relpath(self.folder / values["file"], folder)
            else:
                continue
            result[id(group)] = values
        return result

    # --- Use -------------------------------------------------------------------------------------

    def build(self) -> "Model":
        """Return a model with blocks in place of joints, regions and masonry."""
        source = [group for group in (*self.groups, self._once["cutting"]) if group._values]
        parts = [(item._name, item._values, item._source or f"&{item._name}") for item in source]
        built = build_blocks(parts, self.folder)
        model = self.copy()
        model.clear("cutting")
        meshed = {id(source[i]) for i in built.meshed}
        model.groups[:] = [
            group._copy()
            for group in self.groups
            if not is_made(group._name) and id(group) not in meshed
        ]
        generated = [*built.groups, *(("block", block) for block in built.blocks)]
        model.groups.extend(Group._of_checked_values(kind, values) for kind, values in generated)
        return model

    @contextmanager
    def opened(self) -> Iterator[tuple[Path, str]]:
        """Yield a file name and a text that can be run within the context."""
        with tempfile.TemporaryDirectory() as folder:
            changed = self._renamed_files(Path(folder), "motion.")
            for values in changed.values():
                values["file"] = str((Path(folder) / values["file"]).resolve())
            file = self.folder / "model.nml"
            try:
                yield file, self._to_text(changed)
            except InputError as error:
                error.args = (self._cite_source(str(error), file),)
                raise

    def _cite_source(self, message: str, file: Path) -> str:
        """Return a message that names the call or line of the user instead of generated text."""
        groups = [member for member in self._once.values() if member._values] + self.groups

        def place(kind: str, line: int) -> str:
            if line > len(groups):  # each group is one line; generated groups follow
                return f"a &{kind} generated from another group"
            group = groups[line - 1]
            peers = [item for item in groups if item._name == group._name]
            number = next(i for i, item in enumerate(peers, 1) if item is group)
            name = repr(group.name) if group._values.get("name") else f"number {number}"
            label = "" if group._name in single_groups() else f"(…), {name}"
            return group._source or f"Model.{group._name}{label}"

        message = cited(message, file, place)
        return re.sub(rf"^{re.escape(str(file))}(?=[:,])", "Model", message)
