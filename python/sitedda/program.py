# SPDX-License-Identifier: GPL-3.0-or-later
"""The program `sitedda`; it reports any error in one sentence, also during imports.

This module imports only small modules, so that it can report signals, missing libraries and lack of
memory that occur in any later import.
"""

import gc
import mmap
import os
import sys
import warnings
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import LazyLoader

from .base.errors import InterruptedRun, OutOfMemory, SiteddaError, lacks_memory
from .base.stop import Interruption

_LIGHT = ("check", "example", "-h", "--help", "--version")
# Bytes of address space that the libraries reserve: measured (200 MiB for a light command, 430 MiB
# for others, with one thread), plus the buffer of 129 MiB of the engine's OpenBLAS.
_LIGHT_ROOM, _ROOM = 6 * 2**26, 9 * 2**26
_SCIPY_ROOM = 2**27  # part of the reserved bytes that SciPy needs for its own OpenBLAS

# xarray imports these array libraries, if installed, only to test the type of arrays.  The program
# does not use them, and the import of dask takes 0.4 s.  Matplotlib imports its 3-D axes.
# Studies import these libraries, because a study may run on dask and call any function.
_UNUSED = ("cubed", "cupy", "dask", "pint", "sparse", "mpl_toolkits.mplot3d")
# Modules that matplotlib imports, but that the program hardly uses; they are loaded on first use.
_LATER = ("fontTools.agl", "matplotlib.widgets")
# New objects before a garbage collection; with 700, collection takes 10 % of a run.
_OBJECTS = 200_000

_plain_showwarning = warnings.showwarning


class _ImportWatcher:
    """Finder that is called before each import; it finds only the modules `_LATER`.

    Before SciPy is imported, the finder checks the available memory. It also disables the generated
    documentation of matplotlib's classes, which takes 0.05 s.
    """

    def find_spec(self, name: str, path=None, target=None) -> ModuleSpec | None:
        """See `importlib.abc.MetaPathFinder.find_spec`."""
        if name in _LATER and (spec := PathFinder.find_spec(name, path)) and spec.loader:
            spec.loader = LazyLoader(spec.loader)
            return spec
        if name == "scipy":
            _require_address_space(_SCIPY_ROOM)
        if name == "matplotlib.patches" and (artist := sys.modules.get("matplotlib.artist")):
            vars(artist)["kwdoc"] = lambda _: ""
        return None


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit status, see `sitedda.command.main`."""
    if arguments is None:
        # Each thread of OpenBLAS reserves memory; only the engine needs threads, which are its own.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with Interruption() as interruption:
        status = _exit_status(arguments, interruption)
    if arguments is None:  # the process is about to end
        interruption.ignore()
        gc.freeze()  # skip the last garbage collection, which takes 0.25 s
    return status


def _exit_status(arguments: list[str] | None, interruption: Interruption) -> int:
    """Run the command line, print an expected error, and return the exit status."""
    try:
        if arguments is None:
            _require_address_space(
                _LIGHT_ROOM if sys.argv[1:2] and sys.argv[1] in _LIGHT else _ROOM
            )
            sys.meta_path.insert(0, _ImportWatcher())
            gc.set_threshold(_OBJECTS)
            if sys.argv[1:2] != ["study"]:
                sys.modules |= dict.fromkeys(_UNUSED)  # None prevents the import
                warnings.filterwarnings("ignore", "Unable to import Axes3D")
            warnings.showwarning = _print_warning
        from .commands.command import main as carry_out

        return carry_out(arguments)
    except SystemExit:
        raise
    except BaseException as error:
        interruption.ignore()
        ending = (
            (InterruptedRun.kind, "interrupted") if interruption.heard else _expected_error(error)
        )
        if ending is None:
            raise
        print(f"sitedda: {ending[1]}", file=sys.stderr)
        return ending[0]


def _print_warning(message, category, *place, **more) -> None:
    """Print warnings of this program; print warnings of libraries only on request (python -W).

    The verdict reports the warnings of the energy audit.
    """
    if category.__name__ == "AuditWarning":
        return
    if category.__module__.startswith("sitedda."):
        print(f"sitedda: {message}", file=sys.stderr)
    elif sys.warnoptions:
        _plain_showwarning(message, category, *place, **more)


def _require_address_space(size: int) -> None:
    """Raise OutOfMemory if fewer bytes of address space are free: OpenBLAS would abort or hang."""
    try:
        mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, prot=0).close()
    except OSError as error:
        need = f"the libraries need {size // 2**20} MiB of address space"
        raise OutOfMemory(f"there is not enough memory: {need}") from error


def _expected_error(error: BaseException) -> tuple[int, str] | None:
    """Return exit status and message of an expected error; None for a defect of the program."""
    if isinstance(error, KeyboardInterrupt):
        return InterruptedRun.kind, "interrupted"
    if isinstance(error, SiteddaError):
        return error.kind, str(error)
    if lacks_memory(error):
        return OutOfMemory.kind, "there is not enough memory"
    name = getattr(error, "name", None) or "sitedda"
    if isinstance(error, ImportError) and (name := name.partition(".")[0]) != "sitedda":
        return 1, f"the library {name} is missing or broken: pip install {name}"
    return None
