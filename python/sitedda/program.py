# SPDX-License-Identifier: GPL-3.0-or-later
"""The program `sitedda`: it ends with one sentence, from the first import on.

This module imports nothing that takes time or memory, so that a signal, a library that is missing
and too little memory are met here, wherever they come.
"""

import gc
import mmap
import os
import sys
import warnings

from .base.errors import InterruptedRun, OutOfMemory, SiteddaError, lacks_memory
from .base.stop import Interruption

_LIGHT = ("check", "example", "-h", "--help", "--version")
# Bytes of addresses that the libraries take, measured (200 and 430 MiB with one thread), with the
# buffer of 129 MiB of the engine's OpenBLAS.
_LIGHT_ROOM, _ROOM = 6 * 2**26, 9 * 2**26
_SCIPY_ROOM = 2**27  # of them, for SciPy, which has an OpenBLAS of its own

# Libraries of arrays that xarray imports, where they are installed, to ask whether an array is one
# of theirs: no array of the program is, and dask alone takes 0.4 s.  Matplotlib imports its axes in
# three dimensions.  A study may run on dask, and whatever its functions import.
_UNUSED = ("cubed", "cupy", "dask", "pint", "sparse", "mpl_toolkits.mplot3d")
_OBJECTS = 20_000  # new ones before a garbage collection: with 700 it costs 6 % of a run

_plain_showwarning = warnings.showwarning


class _Watcher:
    """A finder of modules that finds nothing, and knows what is about to be imported.

    SciPy is asked room for.  The classes of matplotlib write a list of their properties into their
    documentation when they are made, which takes 0.05 s and which no program reads.
    """

    def find_spec(self, name: str, path=None, target=None) -> None:
        """See `importlib.abc.MetaPathFinder.find_spec`."""
        if name == "scipy":
            _require_room(_SCIPY_ROOM)
        if name == "matplotlib.patches" and (artist := sys.modules.get("matplotlib.artist")):
            vars(artist)["kwdoc"] = lambda _: ""


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit status, see `sitedda.command.main`."""
    if arguments is None:
        # Each thread reserves memory; what is large here is the engine's, which has its own.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with Interruption() as interruption:
        status = _status(arguments, interruption)
    if arguments is None:  # this process is the program, and at its end
        interruption.ignore()
        gc.freeze()  # the process ends: a last garbage collection takes 0.25 s
    return status


def _status(arguments: list[str] | None, interruption: Interruption) -> int:
    try:
        if arguments is None:
            _require_room(_LIGHT_ROOM if sys.argv[1:2] and sys.argv[1] in _LIGHT else _ROOM)
            sys.meta_path.insert(0, _Watcher())
            gc.set_threshold(_OBJECTS)
            if sys.argv[1:2] != ["study"]:
                sys.modules |= dict.fromkeys(_UNUSED)  # None: not to be imported
                warnings.filterwarnings("ignore", "Unable to import Axes3D")
            warnings.showwarning = _print_warning
        from .commands.command import main as carry_out

        return carry_out(arguments)
    except SystemExit:
        raise
    except BaseException as trouble:
        interruption.ignore()
        ending = (InterruptedRun.kind, "interrupted") if interruption.heard else _ending(trouble)
        if ending is None:
            raise
        print(f"sitedda: {ending[1]}", file=sys.stderr)
        return ending[0]


def _print_warning(message, category, *place, **more) -> None:
    """Print warnings of this program only; those of libraries are shown on request (python -W).

    What the audit finds is a doubt of the verdict.
    """
    if category.__name__ == "AuditWarning":
        return
    if category.__module__.startswith("sitedda."):
        print(f"sitedda: {message}", file=sys.stderr)
    elif sys.warnoptions:
        _plain_showwarning(message, category, *place, **more)


def _require_room(size: int) -> None:
    """An error if so many bytes of addresses are not available: OpenBLAS would end or hang."""
    try:
        mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, prot=0).close()
    except OSError as trouble:
        words = f"there is not enough memory: the libraries need {size // 2**20} MiB of addresses"
        raise OutOfMemory(words) from trouble


def _ending(trouble: BaseException) -> tuple[int, str] | None:
    """Exit status and sentence of an expected error; None if it is a fault of the program."""
    if isinstance(trouble, KeyboardInterrupt):
        return InterruptedRun.kind, "interrupted"
    if isinstance(trouble, SiteddaError):
        return trouble.kind, str(trouble)
    if lacks_memory(trouble):
        return OutOfMemory.kind, "there is not enough memory"
    name = getattr(trouble, "name", None) or "sitedda"
    if isinstance(trouble, ImportError) and (name := name.partition(".")[0]) != "sitedda":
        return 1, f"the library {name} is missing or broken: pip install {name}"
    return None
