# SPDX-License-Identifier: GPL-3.0-or-later
"""Import names of a package on first access, because imports take time."""

import sys
from collections.abc import Callable, Mapping
from importlib import import_module


def importer(
    package: str, homes: Mapping[str, str]
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """Return the functions ``__getattr__`` and ``__dir__`` of a package that has ``__all__``.

    Parameters
    ----------
    package : str
        Name of the package.
    homes : mapping of str to str
        Names of each module, separated by blanks; a module without names is a name itself.
    """
    module_of = {name: module for module, names in homes.items() for name in names.split()}

    def get(name: str) -> object:
        if name in module_of:
            value = getattr(import_module(f".{module_of[name]}", package), name)
        elif homes.get(name) == "":
            value = import_module(f".{name}", package)
        else:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        setattr(sys.modules[package], name, value)
        return value

    def names() -> list[str]:
        members = vars(sys.modules[package])
        modules = [module for module, its in homes.items() if not its]
        special = [name for name in members if name.startswith("__")]
        return sorted({*members["__all__"], *modules, *special})

    return get, names
