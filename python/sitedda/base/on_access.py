# SPDX-License-Identifier: GPL-3.0-or-later
"""Import names of a package on first access, because imports take time."""

from functools import cache
from importlib import import_module


def import_on_access(members: dict) -> None:
    """Import the names under ``if TYPE_CHECKING:`` of a package on their first access.

    Type checkers read the same import statements, which the package itself does not execute.  The
    package has ``__all__``, and its names are not renamed by ``as``.

    Parameters
    ----------
    members : dict
        ``globals()`` of the package.
    """
    package = members["__name__"]

    @cache
    def modules() -> dict[str, str]:
        return _modules_of_names(members["__spec__"].loader.get_source(package))

    def import_name(name: str) -> object:
        if name not in modules():
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        target = modules()[name]
        home = import_module(target, package) if target.strip(".") else None
        if home is None or (hasattr(home, "__path__") and not hasattr(home, name)):
            value = import_module(f"{target.rstrip('.')}.{name}", package)
        else:
            value = getattr(home, name)
        members[name] = value
        return value

    def public_names() -> list[str]:
        dunder_names = [name for name in members if name.startswith("__")]
        return sorted({*members["__all__"], *modules(), *dunder_names})

    members.update(__getattr__=import_name, __dir__=public_names)


def _modules_of_names(source: str) -> dict[str, str]:
    """Return the relative module of each name under ``if TYPE_CHECKING:`` of a source text."""
    import ast

    blocks = [node for node in ast.parse(source).body if isinstance(node, ast.If)]
    statements = [node for block in blocks for node in block.body]
    return {
        alias.name: "." * statement.level + (statement.module or "")
        for statement in statements
        if isinstance(statement, ast.ImportFrom)
        for alias in statement.names
    }
