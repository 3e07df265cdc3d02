# SPDX-License-Identifier: GPL-3.0-or-later
"""Import names of a package on first access, because imports take time."""

import sys
from collections.abc import Callable, Mapping
from importlib import import_module


def importer(package: str, homes: Mapping[str, str]) -> Callable[[str], object]:
    """Return the function ``__getattr__`` of a package.

    Parameters
    ----------
    package : str
        Name of the package.
    homes : mapping of str to str
        Names of each module, separated by blanks; a module without names is a name itself.
    """
    places = {name: module for module, names in homes.items() for name in names.split()}

    def get(name: str) -> object:
        if name in places:
            value = getattr(import_module(f".{places[name]}", package), name)
        elif homes.get(name) == "":
            value = import_module(f".{name}", package)
        else:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        setattr(sys.modules[package], name, value)
        return value

    return get
