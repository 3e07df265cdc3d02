# SPDX-License-Identifier: GPL-3.0-or-later
"""Identify modes and H/V of an ambient record by stochastic subspace identification."""

from __future__ import annotations

import contextlib
import io
import logging
import warnings
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from ..base.arguments import COUNT, positive
from ..base.errors import InputError, library_required
from ..base.reading import read_numbers
from ..engine.signals import smooth_konno_ohmachi

_LARGEST = 2**30  # largest size of a record, bytes
_RATE_RATIO = 3.0  # sampling frequency of the analysis / highest frequency
_PERIODS = 2.0  # periods of the lowest frequency in the correlations
_WIDEST = 160  # largest number of rows of the block Hankel matrix, whose cost grows as their square
_FEWEST = 100  # smallest number of periods of the lowest frequency in a record
_SMALLEST = 0.01  # smallest deviation of a component of a shape of unit length
_AXES = {"X": "x", "E": "x", "N": "x", "1": "x", "2": "x", "Y": "y", "Z": "y"}


def read_ambient(source, channels: Mapping[str, str] | None = None) -> pd.DataFrame:
    """Read an ambient record: a column for each channel, ``POINT.x`` or ``POINT.y``, by time (s).

    Parameters
    ----------
    source : path, xarray.Dataset or DataFrame
        A CSV file with a heading, ``time`` (s) and a column for each channel; a file that obspy
        reads, such as MiniSEED, whose channels are ``STATION.x`` (E, N, 1, 2) and ``STATION.y``
        (Z); the history of a run; or such a table.
    channels : mapping of str, optional
        Name by heading or code of a channel (``'BHE'``, ``'ST01.BHE'``); others are omitted.
    """
    label = source if isinstance(source, str | Path) else "the record"
    if isinstance(source, pd.DataFrame):
        table = source
    elif hasattr(source, "acceleration"):
        motion = source.acceleration.transpose("time", "point", "axis")[1:]
        table = motion.stack(channel=("point", "axis")).to_pandas()
        table.columns = [".".join(names) for names in table.columns]
    elif Path(source).suffix.lower() in (".csv", ".txt", ""):
        names, rows = read_numbers(source, _LARGEST)
        if len(names) < 2 or names[0] != "time" or len(rows) < 2:
            raise InputError(f"{source}: give a heading, such as time,top.x,base.x, and samples")
        table = pd.DataFrame([row for _, row in rows], columns=names).set_index("time")
    else:
        table, channels = _read_obspy(source, channels or {}), None
    if channels:
        if missing := sorted(set(channels) - set(table)):
            raise InputError(f"{label} has no channel {missing[0]!r}: it has {list(table)}")
        table = table[list(channels)].rename(columns=channels)
    try:
        table = table.set_axis(table.index.astype(float)).astype(float)
    except (TypeError, ValueError) as error:
        raise InputError(f"{label} is not a table of numbers by time (s): {error}") from None
    if table.shape[0] < 2 or table.shape[1] < 1:
        raise InputError(f"{label} has {table.shape[0]} samples of {table.shape[1]} channels: give "
                         "at least two samples of a channel")  # fmt: skip
    if not table.columns.is_unique:
        raise InputError(f"{label}: channel {table.columns[table.columns.duplicated()][0]!r} is "
                         "repeated")  # fmt: skip
    if not np.all(np.isfinite(table)):
        k, channel = np.argwhere(~np.isfinite(table.to_numpy()))[0]
        raise InputError(f"{label}: sample {k + 1} of {table.columns[channel]} is not a number")
    _time_step(table, label)
    return table


def _read_obspy(file, channels: Mapping[str, str]) -> pd.DataFrame:
    """Read the traces of a file by obspy, over their common time."""
    with library_required(f"{file} needs the library: pip install obspy"):
        import obspy
    stream = obspy.read(str(file)).merge(fill_value="interpolate")
    start = max(trace.stats.starttime for trace in stream)
    end = min(trace.stats.endtime for trace in stream)
    if not start < end:
        raise InputError(f"{file}: the traces have no time in common: give the file of one period")
    stream.trim(start, end)
    series, steps = {}, set()
    for trace in stream:
        station, code = trace.stats.station, trace.stats.channel
        name = channels.get(f"{station}.{code}", channels.get(code))
        if not channels and code[-1:] in _AXES:
            name = f"{station}.{_AXES[code[-1:]]}"
        if name:
            series[name] = pd.Series(trace.data, trace.times(), float)
            steps.add(trace.stats.delta)
    if len(steps) != 1:
        raise InputError(f"{file}: no channels, or channels of different time steps")
    return pd.DataFrame(series).dropna()


def identify(
    record, band: tuple[float, float], channels: Mapping[str, str] | None = None, order: int = 16,
) -> pd.DataFrame:  # fmt: skip
    """Identify modes of an ambient record: frequency, damping and shape, with deviations.

    Covariance-driven stochastic subspace identification at all orders of the model up to a largest
    one; poles that agree between orders are a mode (hierarchical clustering).  Deviations are the
    covariance of correlations of parts of the record, to first order (Döhler and Mevel 2013).

    Parameters
    ----------
    record : path, xarray.Dataset or DataFrame
        See `read_ambient`.
    band : (float, float)
        Hz, in which modes are sought; the lower one governs the length of the correlations.
    channels : mapping of str, optional
        See `read_ambient`.
    order : int
        Largest order: twice the number of modes, or more.

    Returns
    -------
    DataFrame
        By frequency, with the columns of `measured_modes`.

    Raises
    ------
    InputError
        If the record does not resolve the band, or no mode in the band is stable.
    MissingLibrary
        Without pyOMA2.

    References
    ----------
    Döhler, M. & Mevel, L. (2013). Efficient multi-order uncertainty computation for stochastic
    subspace identification. Mechanical Systems and Signal Processing 38(2), 346-366.
    """
    from scipy.signal import decimate

    table, (low, high) = read_ambient(record, channels), map(float, band)
    (size, count), rate = table.shape, 1 / _time_step(table)
    if not 0 < low < high <= 0.4 * rate:
        raise InputError(f"band = {low:g} to {high:g} Hz: give two frequencies in order, above 0 "
                         f"and below {0.4 * rate:g} Hz (of {rate:g} samples a second)")  # fmt: skip
    if size / rate * low < _FEWEST:
        raise InputError(f"a record of {size / rate:g} s has less than {_FEWEST} periods of "
                         f"{low:g} Hz: give a longer record")  # fmt: skip
    order = int(COUNT.check("order", order))
    _check_alive(table)
    values = (table - table.mean()).to_numpy()
    if (factor := int(rate / (_RATE_RATIO * high))) > 1:
        values, rate = decimate(values, factor, ftype="fir", axis=0), rate / factor
    depth = int(np.clip(_PERIODS * rate / low, -(-order // count) + 1, max(_WIDEST // count, 4)))
    poles = _stable_poles(values, rate, depth, min(order, depth * count), (low, high))
    # The scalars of a single mode are not arrays.
    found = poles.Fn, poles.Fn_std, poles.Xi, poles.Xi_std
    frequency, frequency_deviation, damping, damping_deviation = map(np.atleast_1d, found)
    shapes, scatter = (np.reshape(x, (-1, frequency.size)) for x in (poles.Phi, poles.Phi_std))
    rows = []
    for i in np.argsort(frequency):
        phase = np.exp(-1j * np.angle(np.sum(shapes[:, i] ** 2)) / 2)
        real_shape = (shapes[:, i] * phase).real
        length = np.linalg.norm(real_shape)
        deviation = np.sqrt(np.mean(np.abs(scatter[:, i]) ** 2)) / length
        rows.append({
            "frequency": frequency[i], "deviation": frequency_deviation[i], "damping": damping[i],
            "damping_deviation": damping_deviation[i],
            "shape_deviation": max(deviation, _SMALLEST),
        } | dict(zip(table, real_shape / length, strict=True)))  # fmt: skip
    return pd.DataFrame(rows)


def _stable_poles(values, rate: float, rows: int, order: int, band):
    """Return the stable poles with deviations, a `ClusteringResult` of pyOMA2."""
    with contextlib.redirect_stderr(io.StringIO()), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with library_required("records need the library: pip install pyOMA-2"):
            from pyoma2.algorithms import SSI
            from pyoma2.algorithms.data.run_params import Clustering, SSIRunParams
            from pyoma2.setup import SingleSetup
        logging.getLogger("pyoma2").setLevel(logging.WARNING)
        method = SSI(name="ssi", run_params=SSIRunParams(br=rows, ordmax=order, calc_unc=True))
        setup = SingleSetup(values, fs=rate)
        setup.add_algorithms(method)
        setup.run_by_name("ssi")
        try:
            method.add_clustering(Clustering(name="modes", quick="hier_avg", freqlim=band))
            method.run_clustering("modes")
        except (IndexError, ValueError):  # raised if there is no pole, or one
            raise InputError(f"no mode is stable between {band[0]:g} and {band[1]:g} Hz: give a "
                             "longer record, a wider band or another order") from None  # fmt: skip
    return method.result.clustering_results["modes"]


def horizontal_over_vertical(
    record, frequency: ArrayLike, point: str, window: float = 30.0, bandwidth: float = 40.0,
    channels: Mapping[str, str] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:  # fmt: skip
    """Compute H/V of a point: median and σ of its logarithm over windows.

    Parameters
    ----------
    record, channels
        See `read_ambient`.
    frequency : array_like, shape (n,)
        Hz.
    point : str
        With ``POINT.x`` and ``POINT.y``.
    window : float
        s; windows overlap by half, under Hann's window.
    bandwidth : float
        Of the window of Konno and Ohmachi.

    Returns
    -------
    median, sigma_ln : ndarray, shape (n,)
    """
    from scipy.signal import ShortTimeFFT, get_window

    table = read_ambient(record, channels)
    at_hz = np.atleast_1d(positive("frequency", frequency))
    if not at_hz.size:
        raise InputError("frequency: give one or more")
    window = float(positive("window", window))
    step = _time_step(table)
    size = round(window / step)
    if not 10 / window <= at_hz.min() <= at_hz.max() <= 0.5 / step or 3 * size > 2 * len(table):
        raise InputError(f"window = {window:g} s: each window needs 10 periods of the lowest "
                         "frequency, and the record needs two windows")  # fmt: skip
    if missing := [n for n in (f"{point}.x", f"{point}.y") if n not in table]:
        raise InputError(f"the record has no channel {missing[0]}: it has {list(table)}")
    _check_alive(table[[f"{point}.x", f"{point}.y"]])
    transform = ShortTimeFFT(get_window("hann", size), size // 2, 1 / step)
    parts = []
    for axis in "xy":
        values = table[f"{point}.{axis}"].to_numpy()
        spectra = transform.spectrogram(values - values.mean(), p0=1,
                                        p1=len(values) // (size // 2) - 1)  # fmt: skip
        parts.append([smooth_konno_ohmachi(transform.f, np.sqrt(row), bandwidth, at_hz)
                      for row in spectra.T])  # fmt: skip
    logs = np.log(np.array(parts[0]) / parts[1])
    return np.exp(np.median(logs, axis=0)), logs.std(axis=0)


def _check_alive(table: pd.DataFrame) -> None:
    """Reject channels whose samples are all equal."""
    for name, values in table.items():
        if np.ptp(values) == 0:
            raise InputError(f"channel {name} of the record is dead: all its samples are "
                             f"{values.iloc[0] + 0.0:g}; omit it")  # fmt: skip


def _time_step(record: pd.DataFrame, label="the record") -> float:
    """Return the step of equidistant times, s."""
    time = record.index.to_numpy()
    steps = np.diff(time)
    step = float(np.median(steps))
    if not step > 0 or np.any(differs_from_step := abs(steps - step) > 1e-3 * step):
        k = int(np.argmax(differs_from_step)) + 1 if step > 0 else 0
        raise InputError(f"{label}: samples are not at equal time steps: see sample {k + 1}, time "
                         f"= {time[k]:g} s")  # fmt: skip
    return float((time[-1] - time[0]) / len(steps))
