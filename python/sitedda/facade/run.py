# SPDX-License-Identifier: GPL-3.0-or-later
"""Run an input to its end and return the run with its results."""

import signal
import tempfile
import warnings
from collections.abc import Callable, Mapping
from functools import cached_property
from pathlib import Path

from ..base.errors import AuditWarning, PeakWarning
from ..base.stop import SIGNALS, Stop
from ..drawing.ended_run import EndedRun
from ..engine import simulation
from ..engine.simulation import run_to_end
from ..input.changes import flat_changes, merged
from ..input.input_text import find_groups
from ..input.schema import GROUPS
from ..input.source import InputOfRun, opened_input
from ..output import output_file


class Simulation(simulation.Simulation):  # noqa: D101
    __slots__ = ()
    __doc__ = simulation.Simulation.__doc__

    def _repr_html_(self) -> str:
        """Return blocks, time and a picture for a notebook."""
        from .notebook import simulation_fragment

        return simulation_fragment(self)


class Run(EndedRun):  # noqa: D101
    __doc__ = EndedRun.__doc__

    @cached_property
    def verdict(self):
        """Return the results in words as a `Verdict`, with error bars if the output has them."""
        from ..output.verdict import verdict

        if "accuracy" not in self.history.attrs:
            return verdict(self.history)
        from ..study.error_bars import stored_accuracy

        return verdict(self.history, stored_accuracy(self.history.attrs))

    def accuracy(self, **options):
        """Estimate error bars by runs with other steps and stiffnesses, see `sitedda.accuracy`."""
        from ..study.error_bars import accuracy, of_linear_run

        text = self.history.attrs
        model = InputOfRun(Path(text["input_file"]), text["input_text"])
        is_plain = not options.keys() - {"progress", "workers", "folder", "executor", "output"}
        accuracies = of_linear_run(model, self.history) if is_plain and self.complete else None
        return accuracies or accuracy(model, **options)

    def view(self, file=None, **options):
        """Write the interactive view to a page, with stored error bars; return its path."""
        from ..drawing.view import write_view
        from ..output.scene import Scene
        from .page import bars_of

        scene = Scene.of(self)
        return write_view(scene, file or Path("view.html"), below=bars_of(scene), **options)

    def widget(self, **options):
        """Return the interactive view for a notebook; ``.picked`` of it is the picked block."""
        from ..drawing.view.widget import ViewWidget

        return ViewWidget(self, **options)

    def report(self, file=None) -> Path:
        """Write the report of the run to one HTML file, beside the output by default."""
        from ..report import write_html
        from .page import report_page

        default_file = self.output.with_suffix(".html") if self.output else Path("run.html")
        return write_html(report_page(self), file or default_file)


class _OfDataset(Run):
    """Accessor ``data.sitedda`` of the dataset of an output, with the methods of a run."""

    def __init__(self, data):
        super().__init__(data, data.attrs.get("complete", "yes") == "yes", None, "read again")


def open_output(file):
    """Open an output file as a dataset of xarray; its frames are read on access.

    It has coordinates to select by:
    ``data.block_stress.sel(block="brick_7", component="yy").sel(frame=1.5, method="nearest")``,
    and the methods of a run: ``data.sitedda.verdict``, ``data.sitedda.draw()``, ``view``,
    ``report``.

    Parameters
    ----------
    file : path

    Raises
    ------
    InputError
        If there is no such file.
    OutputError
        If it is not an output of a run, or damaged; the message names the variable.
    """
    data = output_file.open_output(file)
    _register_accessor()
    return data


def _register_accessor() -> None:
    """Add the attribute ``sitedda`` to datasets of xarray as soon as xarray is imported."""
    import xarray as xr

    if not hasattr(xr.Dataset, "sitedda"):
        xr.register_dataset_accessor("sitedda")(_OfDataset)


def run(
    file,
    output=None,
    progress: Callable[[Simulation], None] | None = None,
    changes: Mapping | None = None,
    **variables,
) -> Run:
    """Run an input to its end.

    Parameters
    ----------
    file : path
        Namelist input.
    output : path, True, False or None
        Output file; True: as in the input; False: none, the output remains in memory; None: none,
        unless the input or changes name an ``output.file``.
    progress : callable, optional
        Called at intervals with the `Simulation`.
    changes, **variables
        Variables to change in the input, see `Simulation`.

    Returns
    -------
    Run
        The run; it is incomplete if it was stopped with Ctrl-C.  Its output file is then
        FILE.partial, and `resume` continues it.
    """
    changes = merged(changes, variables)
    if output is None and (
        "output.file" in dict(flat_changes(changes)) or _input_names_output(file)
    ):
        output = True
    return _run_or_resume(file, output or None, progress, changes)


def _input_names_output(source) -> bool:
    """Return whether an input names its output file."""
    if hasattr(source, "output"):
        return source.output.file is not None
    with opened_input(source) as (file, text):
        groups = (
            find_groups(text, file, tuple(GROUPS.keys() - {"output"}))
            if "&output" in text.lower()
            else ()
        )
    return any(group.name == "output" and "file" in group.values for group in groups)


def resume(
    file,
    output=True,
    progress: Callable[[Simulation], None] | None = None,
    changes: Mapping | None = None,
    **variables,
) -> Run:
    """Continue a run that ended early, from the last checkpoint of its output.

    The result is bit-identical to that of an uninterrupted run.  Without a checkpoint, the run
    starts from the beginning; a complete output is only read.

    Parameters
    ----------
    file : path
        Namelist input of the run, unchanged.
    output : path or True
        Output file of the run; True: as in the input.
    progress : callable, optional
        Called at intervals with the `Simulation`.
    changes, **variables
        Changed variables of the input, the same as in the run.

    Raises
    ------
    CheckpointError
        If no checkpoint is usable: each is damaged, or from another input, version or build.
    """
    return _run_or_resume(file, output, progress, merged(changes, variables), resume=True)


def _run_or_resume(
    file, output, progress, changes, resume=False, program=False, light=False
) -> Run:
    """Run or resume an input; with `light`, the history of the run is no xarray dataset."""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "history.nc" if output is None else output
        with (
            Simulation(file, output=target, resume=resume, changes=changes) as simulation,
            Stop(SIGNALS if program else (signal.SIGINT,), program) as stop,
        ):
            complete = run_to_end(simulation, progress, stop)
            file_written = simulation.finish()
            if simulation.warning:
                warnings.warn(simulation.warning, AuditWarning, stacklevel=3)
            for warning in simulation.peak_warnings:
                warnings.warn(warning, PeakWarning, stacklevel=3)
        if not complete:
            file_written = file_written.with_name(file_written.name + ".partial")
        if light:
            history = output_file.read_output(file_written, written=not resume)
        else:
            history = output_file.load(file_written)
    if not light:
        _register_accessor()
    summary = history.attrs["step_control"]
    return Run(history, complete, None if output is None else file_written, summary)
