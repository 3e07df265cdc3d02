# SPDX-License-Identifier: GPL-3.0-or-later
"""Import names of a package on first access, because imports take time."""

import builtins
from _thread import RLock
from importlib import import_module

_LOCK = RLock()  # of the built-in function that imports


class on_access:  # noqa: N801
    """Context in whose body the statements ``from .module import name`` only register names.

    A registered name is imported on its first access. Type checkers read the same statements.
    The package has ``__all__``, and its names are not renamed by ``as``.

    Parameters
    ----------
    members : dict
        ``globals()`` of the package.
    """

    def __init__(self, members: dict):
        self._members = members
        self._places: dict[str, str] = {}  # module of each name

    def __enter__(self) -> None:
        """Replace the function that executes import statements."""
        _LOCK.acquire()
        self._import, builtins.__import__ = builtins.__import__, self._register

    def __exit__(self, *_) -> None:
        """Restore the function, and define access to the names."""
        builtins.__import__ = self._import
        _LOCK.release()
        for name in self._places:
            self._members.pop(name, None)
        self._members.update(__getattr__=self._get, __dir__=self._names)

    def _register(self, module, members=None, local=None, names=(), level=0):
        """Register names and their module; imports of other threads are executed."""
        if members is not self._members:
            return self._import(module, members, local, names, level)
        modules = {name: "." * level + module for name in names}
        self._places |= modules
        return _Names(modules)

    def _get(self, name: str) -> object:
        """Import a name; see `object.__getattr__`."""
        package = self._members["__name__"]
        if name not in self._places:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        target = self._places[name]
        defining_module = import_module(target, package) if target.strip(".") else None
        if defining_module is None or (
            hasattr(defining_module, "__path__") and not hasattr(defining_module, name)
        ):
            value = import_module(f"{target.rstrip('.')}.{name}", package)
        else:
            value = getattr(defining_module, name)
        self._members[name] = value
        return value

    def _names(self) -> list[str]:
        """Return the public names, registered modules and special names."""
        dunder_names = [name for name in self._members if name.startswith("__")]
        return sorted({*self._members["__all__"], *self._places, *dunder_names})


class _Names:
    """Placeholder of a module; an import statement takes names from it."""

    def __init__(self, names: dict):
        vars(self).update(names)
