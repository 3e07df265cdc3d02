# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda.study`: run the cases of a study and collect them in a table."""

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from ..base.errors import InputError
from .case import Work, take_output
from .distribute import distribute
from .evaluate import evaluate
from .plan import Plan, folder_or_temporary, make_plan, plan_of_folder
from .store import case_folder
from .table import collect
from .workers import Workers, check_limits


def study(
    model,
    parameters,
    results=None,
    *,
    folder=None,
    fixed: Mapping | None = None,
    task: str | Callable = "run",
    executor=None,
    workers: int | None = None,
    memory: float | None = None,
    time_limit: float = np.inf,
    keep: bool = True,
    retry: bool = False,
    progress: bool | Callable = False,
    table=None,
    outputs: Mapping[int, Path] | None = None,
):
    """Run a model with many values of its parameters and collect the results in a table.

    Parameters
    ----------
    model : path, Model or callable
        Model to run; or a function of the parameters that returns numbers or arrays.
    parameters : mapping, Axis or sequence of these
        Lists of values by the names of the changed variables, such as
        ``{"joint[bed].friction_angle": [25, 30, 35], "motion.scale": [1, 2]}``: all combinations,
        a dimension each; ``{"phi": ("joint[*].friction_angle", [25, 30])}`` names the dimension.
        Also `Records`, `Points`, and what `latin_hypercube`, `sobol`, `saltelli`,
        `one_at_a_time` return.
    results : str, callable, sequence or mapping of these
        Results of each run, see `sitedda.study.measure`; all numbers of its verdict by
        default.  Functions are of a `sitedda.Run`.
    folder : path, optional
        Of the study; finished cases are not run again.  A temporary one by default.
    fixed : mapping, optional
        Changes of all cases.
    task : 'run', 'safety', 'accuracy' or callable
        Instead of a run the factor of safety of the input, see `sitedda.safety`, or what a
        function of its path returns, such as one that calls `sitedda.check`.
    executor : concurrent.futures.Executor or dask.distributed.Client
        Executor of the cases; processes of this machine by default.
    workers : int
        Processes, one thread each (as many as this process may use processors).
    memory : float
        Bytes that a process may allocate (its fraction of the free memory).
    time_limit : float
        s of the clock that a case may take.
    keep : bool
        Keep the outputs of the runs.
    retry : bool
        Try cases again that have failed.
    progress : bool or callable
        Show a bar; or called with the numbers of cases that are done and that have failed.
    table : path
        File of the table, netCDF or zarr.
    outputs : mapping of int to path, optional
        Complete outputs of cases that this build has run, by the number of the case.

    Returns
    -------
    xarray.Dataset
        Over the dimensions of the parameters; see `sitedda.study.collect`.

    Raises
    ------
    InputError
        If a parameter or a quantity is not known.
    InterruptedRun
        If it was stopped; another call with the same folder continues.
    """
    plan = make_plan(model, parameters, results, folder, fixed, task)
    if workers is not None and (int(workers) != workers or workers < 1):
        raise InputError(f"workers = {workers}: give a whole number above 0")
    check_limits(memory, time_limit)
    with shown(progress, plan.count) as show:
        if callable(model) and folder is None:
            with _open_executor(executor, workers, memory, time_limit) as pool:
                return evaluate(plan, pool, show)
        with folder_or_temporary(folder) as plan.folder:
            plan.write()
            for number, output in (outputs or {}).items():
                take_output(case_folder(plan.folder, plan.keys[number]), output)
            run(plan, executor, workers, memory, time_limit, keep, retry, show)
            found = collect(plan.folder, table)
            return found.load() if folder is None and table is None else found


def run(plan: Plan, executor=None, workers=None, memory=None, time_limit=np.inf, keep=True,
        retry=False, show=None) -> None:  # fmt: skip
    """Run the cases of a written plan; see `study`."""
    model = plan.model if callable(plan.model) else None
    work = Work(plan.folder, model, plan.task, plan.quantities, time_limit, keep, retry,
                memory=memory)  # fmt: skip
    with _open_executor(executor, workers, memory, time_limit) as pool:
        distribute(pool, work, plan.keys, show)


def gather(study, workers: int | None = None, show=None, retry: bool = False) -> None:
    """Extract the results from outputs of sitedda-native in the folder of a study.

    Parameters
    ----------
    study : Plan or path
        A plan that has been written, or the folder of one whose quantities are all names.
    workers : int
        Processes.
    show : callable, optional
        Called with the numbers of cases that are done and that have failed.
    retry : bool
        Discard failed cases, so that the next submission repeats them.
    """
    plan = study if isinstance(study, Plan) else plan_of_folder(study)
    work = Work(plan.folder, quantities=plan.quantities, again=retry, start=False)
    with _open_executor(None, workers, None, np.inf) as pool:
        distribute(pool, work, plan.keys, show)


@contextmanager
def _open_executor(executor, workers, memory, time_limit) -> Iterator:
    """Yield the given executor, which stays open, or processes that end with the context."""
    if executor is not None:
        yield executor.get_executor(pure=False) if hasattr(executor, "get_executor") else executor
        return
    count = workers or len(os.sched_getaffinity(0))
    limit = memory or free_memory() / count
    pool = Workers(count, limit, time_limit)
    try:
        yield pool
    except BaseException:
        pool.shutdown(cancel_futures=True)
        raise
    pool.shutdown()


def free_memory() -> float:
    """Return the bytes of memory that are free or can be freed."""
    for line in Path("/proc/meminfo").read_text().splitlines():
        if line.startswith("MemAvailable"):
            return 1024.0 * float(line.split()[1])
    return float("inf")


@contextmanager
def shown(progress, count: int) -> Iterator[Callable | None]:
    """Yield a function that shows the numbers of finished and failed cases."""
    if progress is not True:
        yield progress or None
        return
    from tqdm import tqdm

    with tqdm(total=count, unit=" cases") as bar:

        def show(done: int, failed: int) -> None:
            bar.update(done - bar.n)
            if failed:
                bar.set_postfix_str(f"{failed} failed")

        yield show
