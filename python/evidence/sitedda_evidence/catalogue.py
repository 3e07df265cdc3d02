# SPDX-License-Identifier: GPL-3.0-or-later
"""The catalogue of all cases; the import of their modules registers them."""

from importlib import import_module
from pkgutil import iter_modules

from . import paper, validation
from .case import PAPER, VALIDATION, Result

__all__ = ["PAPER", "VALIDATION", "run_case"]

for _name in ("cantilever", "shear_wave", "layers", "avdat", "discussion", "remarks"):  # in order
    import_module(f"{paper.__name__}.{_name}")
for _module in iter_modules(validation.__path__):
    import_module(f"{validation.__name__}.{_module.name}")


def run_case(name: str, short: bool = False) -> Result:
    """Run an analytic case by its name, see `Collection.run`."""
    return next(VALIDATION.run([name], short))
