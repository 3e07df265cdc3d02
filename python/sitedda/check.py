"""What can be known before a run: highest frequency, modes, damping, transfer functions, advice."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from .simulation import Simulation


@dataclass(frozen=True)
class Report:
    """The check report of a model.

    Attributes
    ----------
    text : str
        One line for each finding, as the command prints it.
    verdict : str
        The worst of all lines: 'ok', 'warn' or 'fail'.
    omega_max : float
        Highest frequency, rad/s (ARPACK); 0 where it was not found, and the text says why.
    bracket : tuple of float
        Its guaranteed bounds, rad/s.
    residual : float
        Of the eigenpair, relative.
    shift : float
        By how much the joints lower the first frequency, as a share of the stiff limit.
    band : tuple of float
        Hz, from 5 to 95 % of the energy of the motions; zeros without motions.
    """

    text: str
    verdict: str
    omega_max: float
    bracket: tuple[float, float]
    residual: float
    shift: float
    band: tuple[float, float]

    def __str__(self) -> str:
        """The report for a screen."""
        return self.text


@dataclass(frozen=True)
class Modes:
    """Lowest modes of a model.

    Attributes
    ----------
    frequency : ndarray, shape (modes,)
        Hz, undamped.
    damping, elongation : ndarray, shape (modes,)
        Damping ratio and period elongation in free vibration, by the scheme at the model's step.
    participation : ndarray, shape (modes, 2)
        For base motion in x and y, sqrt(kg) per metre of thickness.
    effective_mass : ndarray, shape (modes, 2)
        Shares of the total mass.
    shapes : ndarray, shape (modes, blocks, 6)
        Of the block coordinates, mass-normalised; may be set as `Simulation.rates`.
    words : str
        On rigid motions, mechanisms and sliding contacts.
    """

    frequency: np.ndarray
    damping: np.ndarray
    elongation: np.ndarray
    participation: np.ndarray
    effective_mass: np.ndarray
    shapes: np.ndarray
    words: str


@dataclass(frozen=True)
class Penalty:
    """A normal stiffness (N/m per metre), its first frequency and the stiff limit (Hz)."""

    normal_stiffness: float
    frequency: float
    limit: float


@contextmanager
def _opened(model, changes: Mapping | None, more: Mapping) -> Iterator[Simulation]:
    """The simulation of an input with changes, closed in the end, or one that is open already."""
    changes = dict(changes or {}) | more
    if not isinstance(model, Simulation):
        with Simulation(model, changes=changes) as simulation:
            yield simulation
        return
    if changes:
        raise ValueError("changes need an input file, not a simulation that is open")
    with model._one:  # what is asked must be of one state
        yield model


def check(model, changes: Mapping | None = None, **more) -> Report:
    """Check an input file or an open simulation before a long run.

    Parameters
    ----------
    model : path or Simulation
    changes, **more
        Variables to change in the input, see `Simulation`.
    """
    with _opened(model, changes, more) as simulation:
        text, worst, numbers = simulation._ask("check_run")
    return Report(
        text.decode("utf-8", "replace").rstrip(),
        ("ok", "ok", "warn", "fail")[int(worst)],
        float(numbers[0]),
        (float(numbers[1]), float(numbers[2])),
        float(numbers[3]),
        float(numbers[4]),
        (float(numbers[5]), float(numbers[6])),
    )


def modes(
    model, count: int = 5, contacts: str = "auto", changes: Mapping | None = None, **more
) -> Modes:
    """Lowest modes with stiffness.

    Parameters
    ----------
    model : path or Simulation
    count : int
    contacts : {'auto', 'closed', 'present', 'settled'}
        Which contacts hold: all in touch, as they are now, or as gravity closes them; 'auto' is
        'settled' with gravity, else 'closed'.
    changes, **more
        Variables to change in the input, see `Simulation`.
    """
    with _opened(model, changes, more) as simulation:
        blocks = len(simulation.coordinates)
        found, values, shapes, words = simulation._ask("mode_shapes", contacts, blocks, count)
    values, shapes = values[:, :found].T, shapes[:, :, :found]
    return Modes(
        frequency=values[:, 0].copy(),
        damping=values[:, 1].copy(),
        elongation=values[:, 2].copy(),
        participation=values[:, 3:5].copy(),
        effective_mass=values[:, 5:7].copy(),
        shapes=np.ascontiguousarray(np.transpose(shapes, (2, 1, 0))),
        words=words.decode("utf-8", "replace").strip(),
    )


def transfer(
    model,
    frequencies,
    surface: str = "surface",
    base: str = "base",
    direction: str = "x",
    damped: bool = True,
    contacts: str = "auto",
    changes: Mapping | None = None,
    **more,
) -> np.ndarray:
    """Exact discrete transfer function between two measured points, for base motion.

    Parameters
    ----------
    model : path or Simulation
    frequencies : array_like, shape (n,)
        Hz, below the Nyquist frequency of the time step.
    surface, base : str
        Measured points.
    direction : {'x', 'y'}
    damped : bool
        With the damping of the scheme, or in continuous time without any.
    contacts : str
        See `modes`.
    changes, **more
        Variables to change in the input, see `Simulation`.

    Returns
    -------
    ndarray of complex, shape (n,)
    """
    frequencies = np.ascontiguousarray(np.atleast_1d(frequencies), dtype=float)
    axis = ("x", "y").index(direction) + 1
    with _opened(model, changes, more) as simulation:
        names = simulation.point_names
        for name in (surface, base):
            if name not in names:
                raise ValueError(f"{name!r} is not a measured point; there are {names}")
        points = [names.index(surface) + 1, names.index(base) + 1]
        return simulation._ask("transfer_of", contacts, points, axis, frequencies, int(damped))


def penalty_for_frequency(
    model, frequency: float, contacts: str = "auto", changes: Mapping | None = None, **more
) -> Penalty:
    """The normal stiffness that gives the first mode a measured frequency (Hz)."""
    with _opened(model, changes, more) as simulation:
        return Penalty(*map(float, simulation._ask("first_mode_penalty", contacts, frequency)))


def penalty_for_shift(
    model, percent: float, contacts: str = "auto", changes: Mapping | None = None, **more
) -> Penalty:
    """The normal stiffness that keeps the first frequency within so many % of the limit."""
    with _opened(model, changes, more) as simulation:
        return Penalty(*map(float, simulation._ask("shift_penalty", contacts, percent)))
