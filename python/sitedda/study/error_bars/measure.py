# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda.accuracy`: error bars from runs with smaller steps and stiffer contacts."""

import math
import signal
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

from ...base.arguments import Range
from ...base.errors import InterruptedRun, SiteddaError
from ...engine.simulation import completed_run
from ...input.changes import merged
from ...output.verdict_lines import Doubt
from .bars import bar_of_steps, penalty_error
from .figures import NOT_CONVERGED, Accuracy, Figure, figure_of, is_count, is_figure
from .horizon import bands_of, with_horizons
from .variants import RUN, STEPS, TWIN, Facts, Variants, facts_of, finer, stiffer, twin
from .variants import ensemble as twins_of

# Causes of missing convergence without and with damping, and in linear runs.
_CAUSES = (
    "vibrations of blocks and contacts change friction and impacts; they have only numerical "
    "damping, which is proportional to Δt; set damping of &joint or rayleigh_beta of &material",
    "the times at which contacts slip, open and close depend on the time step",
)
_UNDAMPED = ("a resonance has only numerical damping, which is proportional to Δt; "
             "set damping_ratio of &material")  # fmt: skip


def accuracy(
    model,
    results="figures",
    *,
    changes: Mapping | None = None,
    ensemble: int = 0,
    folder=None,
    executor=None,
    workers: int | None = None,
    progress: bool | Callable = False,
    output: Path | None = None,
    **variables,
) -> Accuracy:
    """Estimate the error bars of the results of a run.

    The input is run with Δt, Δt/2 and Δt/4, and with four times its penalty stiffness, if any.
    These runs form a study: they run in parallel, and existing runs are not repeated.

    Parameters
    ----------
    model : path or Model
    results : str, callable, sequence or mapping of these
        Results, see `sitedda.study.measure`; default: the results of the verdict.
    changes, **variables
        Variables to change in the input, see `Simulation`.
    ensemble : int
        Number of twins of the run, each with another block displaced by 1e-9 of its size.  They
        yield the 16, 50 and 84 % fractiles of each result and of its history.
    folder : path, optional
        Folder of the runs, from which another call continues; default: a temporary folder.
    executor, workers, progress
        See `sitedda.study.study`.
    output : path, optional
        Complete output of the run itself, written by this build; the run is then not repeated.

    Raises
    ------
    InputError
        If the input is invalid.
    SiteddaError
        If the run with the time step of the input fails.

    Notes
    -----
    The error bar is the sum of `sitedda.error_bars.bars.bar_of_steps` and `penalty_error`.  A twin
    shows how long a result is predictable, see `sitedda.error_bars.horizon`.
    """
    from ..api import study

    changes = merged(changes, variables)
    ensemble = int(Range(0, 10**6, whole=True).check("ensemble", ensemble))
    facts = facts_of(model, changes)
    if results == "figures" and not ensemble and facts.is_bonded:
        if linear_result := _try_linear_run(model, changes, facts):
            return linear_result
    # The longest run starts first, which minimises the total time of parallel runs.
    steps = {times: RUN if times == 1 else f"dt/{times}" for times in STEPS}
    variants = {steps[times]: finer(facts, times) for times in reversed(STEPS)}
    if facts.penalty:
        variants["4 k_n"] = stiffer(facts)
    if facts.is_dynamic:
        variants |= {TWIN: twin(facts.remaining[0])} | twins_of(facts, ensemble)
    table = study(
        model, Variants(variants), _with_histories(results), folder=folder, fixed=changes,
        executor=executor, workers=workers, progress=progress, keep=False,
        outputs={len(STEPS) - 1: output} if output else None,
    )  # fmt: skip
    if str(table.sel(variant=RUN).status.values) != "complete":
        raise SiteddaError(str(table.sel(variant=RUN).message.values))
    names = [*steps.values(), *(name for name in variants if name not in steps.values())]
    messages = {}
    for name in names:
        run = table.sel(variant=name)
        doubts = Doubt.lines(str(run.warning.values))  # warnings of the check are omitted
        text = "\n".join(str(doubt) for doubt in doubts if not doubt.is_from_check)
        messages[name] = str(run.message.values) or text
    figures = _estimate_figures(facts, _numbers_by_run(table.sel(variant=names)))
    end = float(table.look.values[-1]) if "look" in table else math.nan
    figures = with_horizons(figures, table)
    return Accuracy(figures, messages, end, bands_of(table), _nonconvergence_cause(figures, facts))


def _try_linear_run(model, changes: Mapping, facts: Facts) -> Accuracy | None:
    """Run an input; return its results with error bars if the run is linear, otherwise None."""
    from ...output.output_file import load

    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "run.nc"
        try:
            with completed_run(model, output, signals=(signal.SIGINT,), changes=changes):
                pass
        except InterruptedRun:
            raise KeyboardInterrupt from None
        return of_linear_run(model, load(output), changes, facts)


def of_linear_run(model, history, changes: Mapping | None = None, facts=None) -> Accuracy | None:
    """Return the results with error bars if a run is linear, otherwise None; see `linear.py`.

    `history`: histories of the run; `changes`: changes of the input; `facts`: properties of the
    changed input.
    """
    from .linear import is_linear, linear_figures

    facts = facts or facts_of(model, changes or {})
    if not is_linear(history, facts):
        return None
    try:
        figures = linear_figures(model, changes or {}, history, facts)
    except SiteddaError:  # the model has no transfer function
        return None
    cause = _nonconvergence_cause(figures, facts) and (_CAUSES[1] if facts.is_damped else _UNDAMPED)
    return Accuracy(figures, end=float(history.time.values[-1]), cause=cause)


def _nonconvergence_cause(figures: Mapping[str, Figure], facts: Facts) -> str:
    """Return the cause of missing convergence; blank if all results converge."""
    open_ones = any(figure.doubt.startswith(NOT_CONVERGED) for figure in figures.values())
    return _CAUSES[facts.is_damped] if open_ones else ""


def _numbers_by_run(table) -> list[dict[str, float]]:
    """Return the numbers of each run by name; missing counts of complete runs are 0."""
    names = [name for name in table.data_vars
             if table[name].dims == ("variant",) and table[name].dtype.kind == "f"]  # fmt: skip
    rows = ({name: float(table[name].values[i]) for name in names if name != "seconds"}
            for i in range(table.sizes["variant"]))  # fmt: skip
    complete = table.status.values == "complete"  # a failed run has no counts
    return [{name: 0.0 if is_complete and is_count(name) and math.isnan(value) else value
             for name, value in row.items()}
            for row, is_complete in zip(rows, complete, strict=True)]  # fmt: skip


def _estimate_figures(facts: Facts, runs: list[dict[str, float]]) -> dict[str, Figure]:
    """Return results with error bars from runs with Δt, Δt/2, Δt/4 and, with a penalty, 4 k_n."""
    figures = {}
    for name in runs[0]:
        if not any(is_figure(name, run) for run in runs[: len(STEPS)]):
            continue
        coarse, medium, fine = (run[name] for run in runs[: len(STEPS)])
        penalty = penalty_error(runs[0][name], runs[len(STEPS)][name]) if facts.penalty else 0.0
        numbers = (coarse, medium, fine)
        figures[name] = figure_of(name, numbers, bar_of_steps(*numbers, facts.order), penalty)
    return figures


def _with_histories(results) -> dict:
    """Return the requested results by name, and the histories of results."""
    if isinstance(results, Mapping):
        return {**results, "histories": "histories"}
    is_single = isinstance(results, str) or callable(results)
    return {
        getattr(r, "__name__", r): r for r in [*([results] if is_single else results), "histories"]
    }
