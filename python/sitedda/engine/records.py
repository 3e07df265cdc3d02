# SPDX-License-Identifier: GPL-3.0-or-later
"""Read ground motions, remove their drift and integrate them, with the engine's readers."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..base.core import api, checked
from ..base.errors import InputError, library_required
from ..base.reading import check_readable, file_path

if TYPE_CHECKING:
    import xarray as xr

_QUANTITIES = ("acceleration", "velocity", "displacement")
_UNITS = ("m/s^2", "m/s", "m")


def read_record(
    file,
    format: str = "auto",
    quantity: str = "",
    unit: str = "",
    time_step: float = 0.0,
    drift_order: int = -1,
    taper: float = 0.0,
    scale: float = 1.0,
    channel: int = 1,
) -> xr.Dataset:
    """Read a record; return its acceleration, velocity and displacement.

    Parameters
    ----------
    file : path
    format : str
        'smc' (USGS), 'at2' (PEER NGA), 'knet' (K-NET, KiK-net), 'esm' (ESM, DYNA), 'cosmos' (V2),
        'text', 'auto'; or 'obspy': any format that obspy reads (an optional dependency).
    quantity, unit : str
        Required if the file does not state them; otherwise they must agree with the file.
    time_step : float
        s between samples, for one column of text.
    drift_order : int
        Order of the polynomial subtracted from the velocity; -1: 2 for accelerations, else 0.
    taper : float
        Fraction of the record under a cosine taper.
    scale : float
        Factor on the record.
    channel : int
        Section of a COSMOS file, or trace of an obspy stream, from 1.

    Returns
    -------
    xarray.Dataset
        ``acceleration``, ``velocity``, ``displacement`` over ``time``, SI; attributes state the
        source and the processing.

    Raises
    ------
    InputError
        If the file is damaged, truncated or contradicts the request; the message names the line.
    """
    if format == "obspy":
        return _read_by_obspy(file, quantity, unit, drift_order, taper, scale, channel)
    request = (
        os.fsencode(file_path(file)),
        format.encode(),
        quantity.encode(),
        unit.encode(),
        np.array([time_step, drift_order, taper, scale], dtype=float),
        channel,
    )
    samples, *_ = checked(api.read_ground_motion, *request, 0)
    _, step, motion, metadata = checked(api.read_ground_motion, *request, samples)
    lines = metadata.decode("utf-8", "replace").rstrip().split("\n")
    return _as_dataset(motion, step, file, lines)


def _as_dataset(motion: np.ndarray, step: float, file, texts: list[str]) -> xr.Dataset:
    """Return the samples of a motion, shape (3, samples), as a dataset."""
    import xarray as xr

    time = ("time", step * np.arange(motion.shape[1]), {"units": "s"})
    names = ("station", "description", "format", "unit", "method")
    return xr.Dataset(
        {
            name: ("time", motion[i].copy(), {"units": unit})
            for i, (name, unit) in enumerate(zip(_QUANTITIES, _UNITS, strict=True))
        },
        coords={"time": time},
        attrs={"file": str(file)} | dict(zip(names, map(str.strip, texts), strict=False)),
    )


def _read_by_obspy(file, quantity, unit, drift_order, taper, scale, channel) -> xr.Dataset:
    """Read a trace of an obspy stream and pass it to the engine as plain text."""
    with library_required("format 'obspy' needs this library: pip install obspy"):
        import obspy
    check_readable(file)
    if not quantity or not unit:
        raise InputError("format 'obspy' needs `quantity` and `unit`: the file states neither")
    trace = obspy.read(str(file))[channel - 1]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "trace.txt"
        np.savetxt(path, trace.data.astype(float), fmt="%.17g")
        step = float(trace.stats.delta)
        record = read_record(path, "text", quantity, unit, step, drift_order, taper, scale)
    record.attrs |= {"file": str(file), "station": trace.id, "format": "obspy"}
    return record
