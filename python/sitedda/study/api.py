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
        Model to run, or a function of the parameters that returns numbers or arrays.
    parameters : mapping, Axis or sequence of these
        Values of each variable, such as ``{"joint[bed].friction_angle": [25, 30, 35],
        "motion.scale": [1, 2]}``.  Each variable becomes a dimension; all combinations are run.
        ``{"phi": ("joint[*].friction_angle", [25, 30])}`` names the dimension.  Alternatives are
        `Records`, `Points`, and the samples of `latin_hypercube`, `sobol`, `saltelli` and
        `one_at_a_time`.
    results : str, callable, sequence or mapping of these
        Results of each run, see `sitedda.study.measure`; default: all numbers of the verdict.
        The argument of a function is a `sitedda.Run`.
    folder : path, optional
        Folder of the study, whose finished cases are not run again; default: a temporary folder.
    fixed : mapping, optional
        Changes of the input in all cases.
    task : 'run', 'safety', 'accuracy' or callable
        What each case computes: 'run'; 'safety', the factor of safety (see `sitedda.safety`);
        'accuracy', error bars; or a function of the path of the input.
    executor : concurrent.futures.Executor or dask.distributed.Client
        Executor of the cases; default: processes on this machine.
    workers : int
        Number of processes with one thread each; default: number of available processors.
    memory : float
        Bytes that a process may allocate; default: the free memory over the number of processes.
    time_limit : float
        Largest duration of a case, s (wall clock).
    keep : bool
        Whether to keep the outputs of the runs.
    retry : bool
        Whether to repeat failed cases.
    progress : bool or callable
        Whether to show a progress bar; or a function of the numbers of ended and failed cases.
    table : path
        File of the table, netCDF or zarr.
    outputs : mapping of int to path, optional
        Complete outputs that this build has written, by the number of their case.

    Returns
    -------
    xarray.Dataset
        Results over the dimensions of the parameters; see `sitedda.study.collect`.

    Raises
    ------
    InterruptedRun
        If a signal stops the study; another call with the same folder continues it.
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
            dataset = collect(plan.folder, table)
            return dataset.load() if folder is None and table is None else dataset


def run(plan: Plan, executor=None, workers=None, memory=None, time_limit=np.inf, keep=True,
        retry=False, show=None) -> None:  # fmt: skip
    """Run the cases of a written plan; see `study`."""
    model = plan.model if callable(plan.model) else None
    work = Work(plan.folder, model, plan.task, plan.quantities, time_limit, keep, retry,
                memory=memory)  # fmt: skip
    with _open_executor(executor, workers, memory, time_limit) as pool:
        distribute(pool, work, plan.keys, show)


def gather(study, workers: int | None = None, show=None, retry: bool = False) -> None:
    """Extract the results of a study from the outputs that sitedda-native has written.

    Parameters
    ----------
    study : Plan or path
        A written plan, or the folder of a plan without functions as quantities.
    workers : int
        Number of processes.
    show : callable, optional
        Called with the numbers of ended and failed cases.
    retry : bool
        Whether to discard failed cases, so that the next submission repeats them.
    """
    plan = study if isinstance(study, Plan) else plan_of_folder(study)
    work = Work(plan.folder, quantities=plan.quantities, again=retry, start=False)
    with _open_executor(None, workers, None, np.inf) as pool:
        distribute(pool, work, plan.keys, show)


@contextmanager
def _open_executor(executor, workers, memory, time_limit) -> Iterator:
    """Yield the given executor, which remains open, or a pool of processes, which is closed."""
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
    """Return the available memory of this machine, bytes."""
    for line in Path("/proc/meminfo").read_text().splitlines():
        if line.startswith("MemAvailable"):
            return 1024.0 * float(line.split()[1])
    return float("inf")


@contextmanager
def shown(progress, count: int) -> Iterator[Callable | None]:
    """Yield a function that shows the numbers of ended and failed cases."""
    if progress is not True:
        yield progress or None
        return
    from tqdm import tqdm

    with tqdm(total=count, unit=" cases") as bar:

        def show(ended: int, failed: int) -> None:
            bar.update(ended - bar.n)
            if failed:
                bar.set_postfix_str(f"{failed} failed")

        yield show
