# SPDX-License-Identifier: GPL-3.0-or-later
"""Short paths of public modules, such as `sitedda.masonry` for `sitedda.build.masonry`."""

import sys
from importlib import import_module
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
_NEW_PATHS = {n: f"{package}.{n}" for package, names in PACKAGES.items() for n in names.split()}
_NEW_PATHS |= {"simulation": "facade.run"}


class _Finder:
    """Finder and loader of modules by their short paths; a module is loaded only once.

    It is no `importlib.abc.Loader`, whose import takes 10 ms.
    """

    def find_spec(self, name: str, path=None, target=None) -> ModuleSpec | None:
        """See `importlib.abc.MetaPathFinder.find_spec`."""
        top_package, _, inner = name.partition(".")
        if top_package != __package__ or inner.partition(".")[0] not in _NEW_PATHS:
            return None
        return ModuleSpec(name, self)  # type: ignore[arg-type]  # it is no subclass of Loader

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """Return the module with its original specification."""
        _, module_name, *inner = spec.name.split(".")
        module = import_module(".".join([__package__, _NEW_PATHS[module_name], *inner]))
        spec.loader_state = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Do nothing, because the module has been executed already."""
        module.__spec__ = module.__spec__.loader_state


def install() -> None:
    """Install the finder of modules by their short paths."""
    sys.meta_path.insert(0, _Finder())
