# SPDX-License-Identifier: GPL-3.0-or-later
"""The short path of each module that callers use, as `sitedda.masonry` for `build.masonry`."""

import sys
from importlib import import_module
from importlib.abc import Loader
from importlib.machinery import ModuleSpec
from types import ModuleType

PACKAGES = {
    "base": "arguments errors files numbers reading stop",
    "build": "building cutting importing masonry meshing",
    "commands": "command",
    "drawing": "boundary_marks movie pictures view vtk",
    "engine": "checking damping maxima records scheme signals spectra",
    "facade": "model plot",
    "input": "block_file changes examples groups input_text schema",
    "output": "response scene verdict",
    "report": "style",
    "site": "column",
    "study": "error_bars",
}
_PLACES = {n: f"{package}.{n}" for package, names in PACKAGES.items() for n in names.split()}
_PLACES |= {"simulation": "facade.run"}


class _Finder(Loader):
    """Finds a module by its short path: it is the same module, read once."""

    def find_spec(self, name: str, path=None, target=None) -> ModuleSpec | None:
        """See `importlib.abc.MetaPathFinder.find_spec`."""
        top, _, inner = name.partition(".")
        if top != __package__ or inner.partition(".")[0] not in _PLACES:
            return None
        return ModuleSpec(name, self)

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """The module itself, whose own specification is kept."""
        _, short, *inner = spec.name.split(".")
        module = import_module(".".join([__package__, _PLACES[short], *inner]))
        spec.loader_state = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Nothing: it has been executed."""
        module.__spec__ = module.__spec__.loader_state


def install() -> None:
    """From here on modules are found by their short paths."""
    sys.meta_path.insert(0, _Finder())
