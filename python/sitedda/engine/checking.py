# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks before a run: frequencies, modes, damping, transfer functions and advice."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from ..base.arguments import COUNT, POSITIVE, Range, not_negative
from ..base.core import api
from ..base.errors import InputError
from ..base.numbers import number
from ..input.changes import merged
from .scheme import finite_or_inf
from .simulation import Simulation

if TYPE_CHECKING:
    from ..report import Table

_NUMBER_PATTERN = re.compile(r"(?<![\w.'])([-+]?\d+\.?\d*)(?:[eE]([-+]?\d+))?(?![\w.]*')")
_REDUCTION = Range(1e-9, 0.999)  # accuracy of `penalty_for`
_HEAD = re.compile(r"^(ok  |warn|fail)  (.{18})(.*)$", re.IGNORECASE)


@dataclass(frozen=True)
class Line:
    """A finding of a check: verdict ('ok', 'warn' or 'fail'), topic, text and advice."""

    verdict: str
    topic: str
    words: str
    advice: str = ""


@dataclass(frozen=True)
class Report:
    """The check report of a model.

    Attributes
    ----------
    text : str
        One line for each finding, as the command prints it.
    verdict : str
        The worst verdict of all lines: 'ok', 'warn' or 'fail'.
    omega_max : float
        Highest natural frequency, rad/s (ARPACK); 0 if not found; the text states the reason.
    bracket : tuple of float
        Guaranteed bounds of `omega_max`, rad/s.
    residual : float
        Relative residual of the eigenpair of `omega_max`.
    shift : float
        Relative reduction of the first frequency by the joints, compared with rigid joints.
    band : tuple of float
        Frequencies below which 5 and 95 % of the energy of the motions lie, Hz; 0: no motions.
    ringing : float
        Number of steps in which velocities that change sign at each step decay to 1/e, for the
        slowest decay; 0 if there are none, inf if they do not decay.
    memory : float
        Approximate memory of a run, bytes.
    seconds : float
        Estimated time of a run, from the time of its first steps; 0 if these were not timed.
    """

    text: str
    verdict: str
    omega_max: float
    bracket: tuple[float, float]
    residual: float
    shift: float
    band: tuple[float, float]
    ringing: float
    memory: float
    seconds: float

    def __str__(self) -> str:
        return self.text

    @property
    def lines(self) -> list[Line]:
        """Return the findings, with numbers of four digits."""
        rows: list[list[str]] = []
        for row in self.text.splitlines():
            match = _HEAD.match(row)
            if match:
                rows.append([match[1].strip().lower(), match[2].strip(), match[3], ""])
            elif rows:
                column = 3 if row.strip().startswith("->") or rows[-1][3] else 2
                rows[-1][column] += " " + row.strip().removeprefix("->").strip()
        return [Line(verdict, topic, *(_round_numbers(text).strip() for text in texts))
                for verdict, topic, *texts in rows]  # fmt: skip

    @property
    def conclusion(self) -> str:
        """Return the verdict in one line, with the topics that need action."""
        topics = [f"{line.topic} ({line.verdict})" for line in self.lines if line.verdict != "ok"]
        text = f": {', '.join(dict.fromkeys(topics))}" if topics else ": nothing to do"
        return f"verdict: {self.verdict}{text}"

    def to_dict(self) -> dict:
        """Return plain values, for example for JSON."""
        values = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "text"}
        return values | {"lines": [asdict(line) for line in self.lines]}

    def _repr_html_(self) -> str:
        """Return the findings as an HTML table."""
        from ..report.html import fragment

        return fragment(check_table(self))


def check_table(report: Report) -> Table:
    """Return the findings of a check as a table."""
    from ..report import Table

    rows = [
        [line.verdict, line.topic, f"{line.words} → {line.advice}" if line.advice else line.words]
        for line in report.lines
    ]
    return Table(["verdict", "topic", "finding"], rows)


@dataclass(frozen=True)
class Modes:
    """The lowest modes of a model.

    Attributes
    ----------
    frequency : ndarray, shape (modes,)
        Hz, undamped.
    damping : ndarray, shape (modes,)
        Damping ratio of free vibration due to time integration and dashpots; 1 if a mode does not
        oscillate. Dashpots count by their fraction of the energy of the undamped mode.
    elongation : ndarray, shape (modes,)
        Relative elongation of the period by the time integration; -1 if a mode does not oscillate.
    participation : ndarray, shape (modes, 2)
        Participation factors for base motion in x and y, sqrt(kg) per metre of thickness.
    effective_mass : ndarray, shape (modes, 2)
        Effective masses as fractions of the total mass.
    shapes : ndarray, shape (modes, blocks, 6)
        Mass-normalised block coordinates; may be set as `Simulation.rates`.
    words : str
        Notes on rigid motions, mechanisms and sliding contacts.
    """

    frequency: np.ndarray
    damping: np.ndarray
    elongation: np.ndarray
    participation: np.ndarray
    effective_mass: np.ndarray
    shapes: np.ndarray
    words: str

    def __repr__(self) -> str:
        """Return frequencies and damping in one line."""
        pairs = zip(self.frequency, self.damping, strict=True)
        return f"<sitedda.Modes {', '.join(f'{f:.4g} Hz ({100 * d:.2g} %)' for f, d in pairs)}>"

    def _repr_html_(self) -> str:
        """Return the modes as a table, for a notebook."""
        from ..report import Paragraph, Table
        from ..report.html import fragment

        heads = ["mode", "frequency (Hz)", "damping (%)", "period elongation (%)", "mass x (%)",
                 "mass y (%)"]  # fmt: skip
        fractions = np.column_stack([self.damping, self.elongation, self.effective_mass])
        rows = [
            [str(i + 1), f"{frequency:.4g}", *(f"{100 * v:.3g}" for v in fractions[i])]
            for i, frequency in enumerate(self.frequency)
        ]
        return fragment(Table(heads, rows), Paragraph(self.words))


@dataclass(frozen=True)
class Penalty:
    """Normal stiffness (N/m per metre), and first frequency (Hz) with it and with rigid joints."""

    normal_stiffness: float
    frequency: float
    limit: float


def _round_numbers(text: str) -> str:
    """Shorten the numbers in a text to four digits, except for numbers in names."""

    def shortened(match: re.Match) -> str:
        mantissa, exponent = match[1], match[2]
        if exponent is None and len(mantissa.strip("+-").replace(".", "").strip("0")) <= 4:
            return match[0]
        if exponent is None and "." not in mantissa:
            return match[0]
        return number(float(match[0]))

    return _NUMBER_PATTERN.sub(shortened, text)


@contextmanager
def _open_model(model, changes: Mapping | None, variables: dict) -> Iterator[Simulation]:
    """Yield an open simulation, or one that is opened with changes and closed afterwards."""
    changes = merged(changes, variables)
    if not isinstance(model, Simulation):
        with Simulation(model, changes=changes) as simulation:
            yield simulation
        return
    if changes:
        raise InputError("changes require an input file; an open simulation cannot be changed here")
    with model._lock:  # all results must belong to the same state
        yield model


def check(model, changes: Mapping | None = None, **variables) -> Report:
    """Check an input file or an open simulation before a long run.

    Parameters
    ----------
    model : path or Simulation
    changes, **variables
        Variables to change in the input, see `Simulation`.
    """
    with _open_model(model, changes, variables) as simulation:
        text, grade, numbers = simulation._call_engine("check_run")
    report, verdict = text.decode("utf-8", "replace").rstrip(), ("ok", "ok", "warn", "fail")[grade]
    highest, low, high, residual, shift, begin, end, ringing_steps, *cost = map(float, numbers)
    ringing_steps = float(finite_or_inf(ringing_steps))
    bounds, band = (low, high), (begin, end)
    return Report(report, verdict, highest, bounds, residual, shift, band, ringing_steps, *cost)


def modes(
    model, count: int = 5, contacts: str = "auto", changes: Mapping | None = None, **variables
) -> Modes:
    """Compute the lowest modes with stiffness.

    Parameters
    ----------
    model : path or Simulation
    count : int
    contacts : {'auto', 'closed', 'present', 'settled'}
        Contacts with stiffness. 'closed': all that touch; 'present': those closed at present;
        'settled': those closed by gravity, which stick if they have friction; 'auto': 'settled'
        with gravity, otherwise 'closed'.
    changes, **variables
        Variables to change in the input, see `Simulation`.
    """
    count = COUNT.check("count", count)
    with _open_model(model, changes, variables) as simulation:
        blocks = len(simulation.coordinates)
        size, values, shapes, note = simulation._call_engine("mode_shapes", contacts, blocks, count)
    values, shapes = values[:, :size].T, shapes[:, :, :size]
    return Modes(
        frequency=values[:, 0].copy(),
        damping=values[:, 1].copy(),
        elongation=values[:, 2].copy(),
        participation=values[:, 3:5].copy(),
        effective_mass=values[:, 5:7].copy(),
        shapes=np.ascontiguousarray(np.transpose(shapes, (2, 1, 0))),
        words=note.decode("utf-8", "replace").strip(),
    )


def matrices(model, contacts: str = "auto", changes: Mapping | None = None, **variables) -> tuple:
    """Return the stiffness and mass matrices of the linearised model.

    Parameters
    ----------
    model, contacts, changes, **variables
        See `modes`.  Damped materials have the modulus of the input.

    Returns
    -------
    stiffness, mass : scipy.sparse.csr_array, shape (6 blocks, 6 blocks)
        For the block coordinates, per metre of thickness, SI.
    points : scipy.sparse.csr_array, shape (2 points, 6 blocks)
        Matrix that yields the displacements x and y of each measured point in turn.
    names : list of str
        Names of the points.
    """
    from scipy import sparse

    with _open_model(model, changes, variables) as simulation:
        sizes = simulation._call_engine("make_matrices", contacts)
        matrix, row, column, value = api.read_table(simulation._handle, *sizes)
        names = simulation.point_names
        size = 6 * len(simulation.coordinates)
    result = []
    for i, rows in enumerate((size, size, 2 * len(names))):
        indices = (row[matrix == i].astype(int), column[matrix == i].astype(int))
        result.append(sparse.csr_array((value[matrix == i], indices), shape=(rows, size)))
    return (*result, names)


def transfer(
    model,
    frequencies,
    surface: str = "surface",
    base: str | None = "base",
    direction: str = "x",
    damped: bool = True,
    contacts: str = "auto",
    changes: Mapping | None = None,
    **variables,
) -> np.ndarray:
    """Compute the exact transfer function of the time integration between two measured points.

    The model is linearised and integrated with the scheme and time step of ``&control``.

    Parameters
    ----------
    model : path or Simulation
    frequencies : array_like, shape (n,)
        Hz, below the Nyquist frequency of the time step.
    surface : str
        Measured point.
    base : str or None
        Measured point whose motion is the denominator; None: the prescribed motion.
    direction : {'x', 'y'}
    damped : bool
        True: with the damping of time integration (θ, χ), supports and dashpots; False: exact
        in time and undamped.
    contacts : str
        See `modes`.
    changes, **variables
        Variables to change in the input, see `Simulation`.

    Returns
    -------
    ndarray of complex, shape (n,)
    """
    frequencies = np.ascontiguousarray(np.atleast_1d(not_negative("frequencies", frequencies)))
    if direction not in ("x", "y"):
        raise InputError(f"direction = {direction!r} must be 'x' or 'y'")
    axis = ("x", "y").index(direction) + 1
    with _open_model(model, changes, variables) as simulation:
        names = simulation.point_names
        for name in (surface, base):
            if name is not None and name not in names:
                raise InputError(f"{name!r} is not a measured point; the points are {names}")
        points = [0 if name is None else names.index(name) + 1 for name in (surface, base)]
        request = (contacts, points, axis, frequencies, int(damped))
        return simulation._call_engine("transfer_of", *request)


def penalty_for_frequency(
    model, frequency: float, contacts: str = "auto", changes: Mapping | None = None, **variables
) -> Penalty:
    """Find the normal stiffness with which the first mode has a measured frequency (Hz)."""
    frequency = POSITIVE.check("frequency", frequency)
    with _open_model(model, changes, variables) as simulation:
        return _find_penalty(simulation, contacts, "frequency", frequency)


def penalty_for(
    model,
    accuracy: float = 0.01,
    contacts: str = "auto",
    changes: Mapping | None = None,
    **variables,
) -> Penalty:
    """Find the normal stiffness whose joints lower the first frequency by a given fraction.

    The closed contacts are those with the penalty of the model.  Stiffer joints need more
    iterations, see the line "penalty" of `check`.

    Parameters
    ----------
    model : path or Simulation
    accuracy : float
        Reduction as a fraction of the first frequency with rigid joints, from 1e-9 to 0.999.
    contacts : str
        See `modes`.
    changes, **variables
        Variables to change in the input, see `Simulation`.

    Returns
    -------
    Penalty

    Raises
    ------
    SiteddaError
        If the fraction is out of range; if no closed contact has the stiffness
        `normal_stiffness`; if rigid joints would prevent all motion; or if the penalty would exceed
        the largest permitted value.
    """
    accuracy = _REDUCTION.check("accuracy", accuracy)
    with _open_model(model, changes, variables) as simulation:
        return _find_penalty(simulation, contacts, "shift", 100.0 * accuracy)


def _find_penalty(simulation: Simulation, contacts: str, criterion: str, value: float) -> Penalty:
    """Find the normal stiffness by the frequency (Hz) or its shift (%)."""
    return Penalty(*map(float, simulation._call_engine("penalty_for", contacts, criterion, value)))


def penalty_for_shift(
    model, percent: float, contacts: str = "auto", changes: Mapping | None = None, **variables
) -> Penalty:
    """Call `penalty_for` with an accuracy in per cent."""
    accuracy = POSITIVE.check("percent", percent) / 100
    return penalty_for(model, accuracy, contacts, changes, **variables)
