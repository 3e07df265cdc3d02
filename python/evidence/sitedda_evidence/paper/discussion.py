# SPDX-License-Identifier: GPL-3.0-or-later
"""The discussion of the paper: time step, block size and penalty (section 4)."""

from functools import cache

import numpy as np

from sitedda.engine.scheme import Scheme, scheme_damping
from sitedda.report.style import BLUE, COLORS, RED, small_axes

from ..case import Outcome, picture, study
from ..compared import per_cent, show
from ..runs import Task, input_file
from .discrete import DiscreteModel

_YOUNG, _DENSITY, _POISSON = 17e9, 2250.0, 0.22  # printed values; Pa, kg/m³, –
_SIDE, _DIAMETER = 0.5, 0.6  # printed largest side and mean diameter, m
_SPEED = 3000.0  # printed wave speed, m/s
_PERIOD = 0.004  # printed wave period, s
_PAPER_OMEGA = 6.3  # frequency that the paper uses as ω_max, Hz
_BEST = {"column": 4e8, "layers": 1.5e12}  # printed best penalties (section 4, table I), N/m
_PENALTIES = (1e8, 4e8, 1e9, 1e10)  # N/m
_STEPS = (1e-3, 1e-2)  # s
_RECOMMENDED = {"1/12 [14]": 1 / 12, "1/16 [8]": 1 / 16, "1/20 [10, 19]": 1 / 20}  # η, section 2.2


def tasks(quick: bool = False) -> list[Task]:
    """Return the tasks: frequencies of the column at each penalty, by the discrete theory."""
    return [Task(k, _extreme_frequencies, {"k": k}, 0.3) for k in _PENALTIES]


def _extreme_frequencies(k: float) -> dict:
    """Return first and highest angular frequency of the column, also with soft supports, rad/s."""
    omega = _discrete_column(k).omega
    held = _discrete_column(k, 1.0).omega
    return {"first": float(omega[0]), "highest": float(omega[-1]), "without": float(held[-1])}


@cache
def _discrete_column(k: float, ratio: float = 100.0) -> DiscreteModel:
    """Return the column at a penalty (N/m); `ratio`: stiffness of fixed points over penalty."""
    contact = {"normal_stiffness": k, "fixed_point_ratio": ratio}
    return DiscreteModel.of(input_file("avdat.nml"), contact=contact)


@study("Discussion: ω_max, CFL, η and the penalty (section 4)", tasks)
def discussion(found: dict) -> Outcome:
    """Compose rows, tables and pictures."""
    done = Outcome(text=[
        "The paper checks its time steps with equations 13 and 14 and its blocks with equation 12."
        " The same checks use the true ω_max here: the highest frequency of K x = ω² M x."
    ])  # fmt: skip
    _add_resolution_rows(done, found)
    _add_size_rows(done)
    _add_penalty_rows(done)
    done.pictures = [
        picture("discussion_damping", "Damping ratio by the scheme over frequency, and limit above"
                " which a mode does not oscillate (ωΔt = 4, eq. 13).", _draw_damping),
        picture("discussion_omega", "First and highest frequency of the column over penalty, with"
                " the limits 4/Δt of eq. 13.", _draw_frequencies, found),
    ]  # fmt: skip
    return done


def _add_resolution_rows(done: Outcome, found: dict) -> None:
    """Compare the largest time steps of equations 13 and 14."""
    at_best = found[_BEST["column"]]
    highest = at_best["highest"] / (2 * np.pi)
    shear = np.sqrt(_YOUNG / 2 / (1 + _POISSON) / _DENSITY)
    done.compare("largest Δt of eq. 13 with the first mode for ω_max (s)", "section 4", 0.1,
        4 / (2 * np.pi * _PAPER_OMEGA), 4 / at_best["first"],
        "the paper uses 6.3 Hz, the highest *dominant* frequency, in eq. 13; here the first"
        " mode at k = 4e8 N/m", 3)  # fmt: skip
    done.compare("ω_max/2π of the column, k = 4e8 N/m (Hz)", "section 4", _PAPER_OMEGA, None,
        highest,
        "strain modes of the drums, independent of the penalty (with fixed points of stiffness k"
        f" instead of 100 k: {at_best['without'] / 2 / np.pi:.0f} Hz)", 4)  # fmt: skip
    done.compare("largest Δt of eq. 13 with ω_max (s)", "section 4", 0.1, None,
        4 / at_best["highest"],
        "a limit of accuracy, not of stability: above it a mode is damped without oscillation;"
        " both time steps of the paper are above it", 3)  # fmt: skip
    done.compare("largest Δt of eq. 14, CFL (s)", "section 4", 0.0002, _SIDE / _SPEED,
        _SIDE / shear,
        f"theory: Δx/v with the paper's {_SPEED:g} m/s; sitedda column: with"
        f" √(G/ρ) = {shear:.0f} m/s of Table III", 3)  # fmt: skip
    done.require(
        "Both time steps of the paper exceed the limit 4/ω_max",
        bool(4 / at_best["highest"] < min(_STEPS)),
        f"4/ω_max = {4 / at_best['highest']:.2g} s; the steps of 1 and 10 ms are"
        f" {min(_STEPS) * at_best['highest'] / 4:.0f} and"
        f" {max(_STEPS) * at_best['highest'] / 4:.0f} times that, and stable",
    )
    cells = [
        [f"{k:.0e}", f"{v['first'] / 2 / np.pi:.2f}", f"{v['highest'] / 2 / np.pi:.0f}",
         f"{4 / v['highest']:.1e}",
         *(per_cent(float(_free_damping(v["first"] / 2 / np.pi, s))) for s in _STEPS)]
        for k, v in found.items()
    ]  # fmt: skip
    done.tabulate(
        "Frequencies of the column, and damping of its first mode by the scheme",
        ["k (N/m)", "first (Hz)", "highest (Hz)", "4/ω_max (s)",
         *(f"ζ of the first at Δt = {s:g} s" for s in _STEPS)],
        sorted(cells, key=lambda row: float(row[0])),
    )  # fmt: skip


def _add_size_rows(done: Outcome) -> None:
    """Compare the block size with the wavelength by equation 12."""
    modulus = _YOUNG / 2 / (1 + _POISSON)
    length = _PERIOD * np.sqrt(modulus / _DENSITY)
    eta = _SIDE / length
    met = [name for name, limit in _RECOMMENDED.items() if eta <= limit]
    done.compare("shear modulus (GPa)", "section 4", 6.97, modulus / 1e9, modulus / 1e9,
        "E/2(1+ν)")  # fmt: skip
    done.compare("wavelength of the incident wave (m)", "section 4, eq. 17", 7.0, length, length,
        "T √(G/ρ), T = 0.004 s")  # fmt: skip
    done.compare("1/η", "section 4, eq. 12", 14.0, 1 / eta, 1 / eta,
        f"of the recommendations quoted, {', '.join(met) or 'none'} is met; at the measured"
        f" 3–6 Hz of the column η is {_SIDE * 6.3 / np.sqrt(modulus / _DENSITY):.1e}")  # fmt: skip


def _add_penalty_rows(done: Outcome) -> None:
    """Compare the best penalties of the paper with Shi's k = E·L."""
    shi = _YOUNG * _DIAMETER
    layers = 4.788e9 * 15.0
    done.compare("Shi's k = E·L of the column (N/m)", "section 4", 1e10, shi, shi,
        "17 GPa × 0.6 m")  # fmt: skip
    done.compare("best fit of the column over E·L", "section 5", 1 / 25, _BEST["column"] / shi,
        _BEST["column"] / shi, "4e8 N/m; the paper's 1/25 rounds 10.2/0.4 = 25.5", 3)  # fmt: skip
    done.compare("penalty of the layers over E·L", "section 5", 21.0, _BEST["layers"] / layers,
        _BEST["layers"] / layers, "table I: 1500 GN/m over 4.788 GPa × 15 m, the length of a"
        " layer", 3)  # fmt: skip
    done.notes += [
        "“k = E·L” compares different quantities: the ratio of the compliances of joint and block"
        " is decisive. The rotational stiffness of a joint is k·w²/2; the joint of a layer has"
        " 2k/2.5 in series with G·w/Δx of the layer. The layers need stiff joints because their"
        " joints are artificial, the column soft ones because its joints are real: the wanted"
        " frequency determines both penalties before any run.",
        f"The damping of the scheme does not depend on the penalty: at 4.3 Hz it is"
        f" {per_cent(float(scheme_damping(4.3, 1e-2)))} at 10 ms and"
        f" {per_cent(float(scheme_damping(4.3, 1e-3)))} at 1 ms.",
        "CFL (eq. 14) and 4/ω_max are limits of accuracy for waves and contacts, not of stability:"
        " the scheme is implicit, and Table IV settles at steps far beyond both (ωΔt up to"
        f" {show(max(_STEPS) * _discrete_column(_PENALTIES[-1]).omega[-1], 2)} at 1e10 N/m and"
        " 10 ms).",
    ]


def _free_damping(frequency, time_step: float) -> np.ndarray:
    """Return the damping ratio of the DDA scheme for free vibrations (Hz) at a time step (s)."""
    return Scheme().vibration(frequency, time_step).damping


def _draw_damping(drawing) -> None:
    with small_axes(drawing, size=(6.4, 3.5)) as axis:
        for step, color in zip((1e-5, 1e-4, 1e-3, 1e-2), COLORS, strict=False):
            top = min(4 / step / 2 / np.pi * 0.999, 1e4)
            frequency = np.geomspace(0.5, top, 200)
            axis.loglog(frequency, _free_damping(frequency, step), color=color,
                        label=f"Δt = {step:g} s")  # fmt: skip
            if top < 1e4:
                end = _free_damping(top, step)
                axis.plot(top, end, "o", color=color, ms=5)
        for place, name in ((4.3, "column"), (14.0, "15 layers")):
            axis.axvline(place, color="0.6", lw=0.8, ls=":")
            axis.annotate(name, (place, 2e-6), rotation=90, ha="right", fontsize=8, color="0.35")
        axis.set(xlabel="frequency (Hz)", ylabel="damping ratio, free vibration", ylim=(1e-6, 1.5))
        axis.legend(loc="lower right")


def _draw_frequencies(drawing, found) -> None:
    penalties = sorted(found)
    with small_axes(drawing, size=(6.2, 3.4)) as axis:
        for name, color in (("highest", BLUE), ("first", RED)):
            values = [found[k][name] / 2 / np.pi for k in penalties]
            axis.loglog(penalties, values, "o-", color=color, lw=1, label=f"{name} frequency")
        for step in _STEPS:
            axis.axhline(4 / step / 2 / np.pi, color="0.5", lw=0.9, ls="--")
            axis.annotate(f"4/Δt, Δt = {step:g} s", (1.02e8, 4 / step / 2 / np.pi), fontsize=8,
                          va="bottom", color="0.35")  # fmt: skip
        axis.axhline(_PAPER_OMEGA, color="0.5", lw=0.9, ls=":")
        axis.annotate("the paper's 6.3 Hz", (1e10, _PAPER_OMEGA), fontsize=8, ha="right",
                      va="bottom", color="0.35")  # fmt: skip
        axis.set(xlabel="k (N/m)", ylabel="frequency (Hz)")
        axis.legend(loc="center right")
