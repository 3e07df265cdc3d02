# SPDX-License-Identifier: GPL-3.0-or-later
"""Serve a model to programs for uncertainty quantification, by the protocol UM-Bridge."""

import json
import os
from collections.abc import Mapping, Sequence

import numpy as np

from ..base.errors import InputError, SiteddaError
from .api import study
from .workers import Workers


def serve_umbridge(
    model,
    parameters: Sequence[str],
    results: Sequence[str],
    *,
    fixed: Mapping | None = None,
    task="run",
    workers: int | None = None,
    port: int = 4242,
) -> None:
    """Serve a model as ``forward`` by UM-Bridge, until interrupted.

    Its input is one vector, the values of the parameters; its output is one vector, the results.
    A client receives the message of a failed run as an exception.

    Parameters
    ----------
    model : path or Model
    parameters : sequence of str
        Names of the changed variables, such as ``joint[bed].friction_angle``.
    results : sequence of str
        Names of numbers, see `sitedda.study.measure`.
    fixed : mapping, optional
        Changes of all runs.
    task : 'run', 'safety' or callable
        See `study`.
    workers : int, optional
        Number of processes for simultaneous requests; default: number of available processors.
    port : int
        Port on which the server listens.
    """
    try:
        import umbridge
        from aiohttp import web
    except ImportError:
        raise InputError("UM-Bridge is missing: pip install 'sitedda[umbridge]'") from None
    count = workers or len(os.sched_getaffinity(0))

    def evaluate(values) -> list[float]:
        cases = {name: [value] for name, value in zip(parameters, values, strict=True)}
        table = study(model, cases, results, fixed=fixed, task=task, executor=pool, keep=False)
        if table.status.item() != "complete":
            raise SiteddaError(table.message.item())
        if missing := [name for name in results if not np.isfinite(table[name])]:
            raise SiteddaError(f"the run has no number {', '.join(missing)}")  # NaN is not JSON
        return [table[name].item() for name in results]

    class Forward(umbridge.Model):
        """The model, without derivatives."""

        def get_input_sizes(self, config):
            """Return the number of parameters."""
            return [len(parameters)]

        def get_output_sizes(self, config):
            """Return the number of results."""
            return [len(results)]

        def supports_evaluate(self):
            """Return that the model can be evaluated."""
            return True

        def __call__(self, inputs, config):
            """Return the results, or raise the response with the message."""
            try:
                return [evaluate(inputs[0])]
            except SiteddaError as error:
                body = {"error": {"type": type(error).__name__, "message": str(error)}}
                raise web.HTTPBadRequest(text=json.dumps(body)) from error

    with Workers(count) as pool:
        umbridge.serve_models([Forward("forward")], port, max_workers=count)
