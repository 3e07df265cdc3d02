# SPDX-License-Identifier: GPL-3.0-or-later
"""The discussion of the paper: time step, block size and penalty (section 4)."""

from functools import cache

import numpy as np

from sitedda.engine.scheme import Scheme, scheme_damping
from sitedda.report.style import BLUE, COLORS, RED, small_axes

from ..case import Outcome, picture, study
from ..comparison import per_cent, show
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
    return [Task(k, _extreme_frequencies, {"normal_stiffness": k}, 0.3) for k in _PENALTIES]


def _extreme_frequencies(normal_stiffness: float) -> dict:
    """Return first and highest angular frequency, and the highest with soft supports, rad/s."""
    omega, soft = (_discrete_column(normal_stiffness, ratio).omega for ratio in (100.0, 1.0))
    return {"first": float(omega[0]), "highest": float(omega[-1]), "soft_supports": float(soft[-1])}


@cache
def _discrete_column(normal_stiffness: float, ratio: float = 100.0) -> DiscreteModel:
    """Return the column at a penalty (N/m); `ratio`: stiffness of fixed points / penalty."""
    contact = {"normal_stiffness": normal_stiffness, "fixed_point_ratio": ratio}
    return DiscreteModel.of(input_file("avdat.nml"), contact=contact)


@study("Discussion: ω_max, CFL, η and the penalty (section 4)", tasks)
def discussion(runs: dict) -> Outcome:
    """Compose rows, tables and pictures."""
    outcome = Outcome(text=[
        "The paper checks its time steps by equations 13 and 14 and its blocks by equation 12. This"
        " study repeats the checks with the exact ω_max, the highest frequency of K x = ω² M x."
    ])  # fmt: skip
    _add_resolution_rows(outcome, runs)
    _add_size_rows(outcome)
    _add_penalty_rows(outcome)
    outcome.pictures = [
        picture("discussion_damping", "Damping ratio of the scheme; circles: limits above which a"
                " mode does not oscillate (ωΔt = 4, eq. 13).", _draw_damping),
        picture("discussion_omega", "First and highest frequency of the column, and the limits 4/Δt"
                " of eq. 13.", _draw_frequencies, runs),
    ]  # fmt: skip
    return outcome


def _add_resolution_rows(outcome: Outcome, runs: dict) -> None:
    """Compare the largest time steps of equations 13 and 14."""
    best_run = runs[_BEST["column"]]
    highest = best_run["highest"] / (2 * np.pi)
    shear = np.sqrt(_YOUNG / 2 / (1 + _POISSON) / _DENSITY)
    outcome.compare("largest Δt (s) by eq. 13 with the first frequency as ω_max", "section 4", 0.1,
        4 / (2 * np.pi * _PAPER_OMEGA), 4 / best_run["first"],
        "the paper uses 6.3 Hz, the highest *dominant* frequency; sitedda: first frequency at"
        " k = 4e8 N/m", 3)  # fmt: skip
    outcome.compare("ω_max/2π of the column, k = 4e8 N/m (Hz)", "section 4", _PAPER_OMEGA, None,
        highest,
        "strain modes of the drums, independent of the penalty (with fixed points of stiffness k"
        f" instead of 100 k: {best_run['soft_supports'] / 2 / np.pi:.0f} Hz)", 4)  # fmt: skip
    outcome.compare("largest Δt (s) by eq. 13 with the exact ω_max", "section 4", 0.1, None,
        4 / best_run["highest"],
        "a limit of accuracy, not of stability: above it modes decay without oscillation; both"
        " time steps of the paper are above it", 3)  # fmt: skip
    outcome.compare("largest Δt (s) by eq. 14, CFL", "section 4", 0.0002, _SIDE / _SPEED,
        _SIDE / shear,
        f"theory: Δx/v with {_SPEED:g} m/s of the paper; sitedda: with"
        f" √(G/ρ) = {shear:.0f} m/s of Table III", 3)  # fmt: skip
    outcome.require(
        "Both time steps of the paper exceed 4/ω_max",
        bool(4 / best_run["highest"] < min(_STEPS)),
        f"4/ω_max = {4 / best_run['highest']:.2g} s; 1 and 10 ms are"
        f" {min(_STEPS) * best_run['highest'] / 4:.0f} and"
        f" {max(_STEPS) * best_run['highest'] / 4:.0f} times this limit; both are stable",
    )
    cells = [
        [f"{k:.0e}", f"{v['first'] / 2 / np.pi:.2f}", f"{v['highest'] / 2 / np.pi:.0f}",
         f"{4 / v['highest']:.1e}",
         *(per_cent(float(_free_damping(v["first"] / 2 / np.pi, s))) for s in _STEPS)]
        for k, v in runs.items()
    ]  # fmt: skip
    outcome.tabulate(
        "Frequencies of the column, and numerical damping ratio ζ of its first mode",
        ["k (N/m)", "first frequency (Hz)", "highest frequency (Hz)", "4/ω_max (s)",
         *(f"ζ at Δt = {s:g} s" for s in _STEPS)],
        sorted(cells, key=lambda row: float(row[0])),
    )  # fmt: skip


def _add_size_rows(outcome: Outcome) -> None:
    """Compare the block size with the wavelength by equation 12."""
    modulus = _YOUNG / 2 / (1 + _POISSON)
    length = _PERIOD * np.sqrt(modulus / _DENSITY)
    eta = _SIDE / length
    satisfied = [name for name, limit in _RECOMMENDED.items() if eta <= limit]
    outcome.compare("shear modulus of the limestone (GPa)", "section 4", 6.97, modulus / 1e9,
        modulus / 1e9, "E/2(1+ν)")  # fmt: skip
    outcome.compare("wavelength of the incident wave (m)", "section 4, eq. 17", 7.0, length, length,
        "T √(G/ρ), T = 0.004 s")  # fmt: skip
    outcome.compare("wavelength / block size, 1/η", "section 4, eq. 12", 14.0, 1 / eta, 1 / eta,
        f"satisfies the quoted recommendations {', '.join(satisfied) or 'none'}; η at the measured"
        f" 6.3 Hz of the column: {_SIDE * 6.3 / np.sqrt(modulus / _DENSITY):.1e}")  # fmt: skip


def _add_penalty_rows(outcome: Outcome) -> None:
    """Compare the best penalties of the paper with Shi's k = E·L."""
    shi = _YOUNG * _DIAMETER
    layers = 4.788e9 * 15.0
    outcome.compare("penalty of the column by Shi, k = E·L (N/m)", "section 4", 1e10, shi, shi,
        "17 GPa × 0.6 m")  # fmt: skip
    outcome.compare("best penalty of the column / E·L", "section 5", 1 / 25, _BEST["column"] / shi,
        _BEST["column"] / shi, "4e8 N/m; 1/25 of the paper is rounded from 0.4/10.2 = 1/25.5",
        3)  # fmt: skip
    outcome.compare("penalty of the layers / E·L", "section 5", 21.0, _BEST["layers"] / layers,
        _BEST["layers"] / layers, "Table I: 1500 GN/m / (4.788 GPa × 15 m); 15 m is the length of"
        " a layer", 3)  # fmt: skip
    outcome.notes += [
        "“k = E·L” compares different quantities, because the ratio of the compliances of joint"
        " and block is decisive. The rotational stiffness of a joint is k·w²/2. In shear, the"
        " stiffness 2k/2.5 of a joint is in series with G·w/Δx of a layer. The layers require"
        " stiff joints, because these joints are artificial; the column requires soft ones,"
        " because its joints are real. The required frequency determines both penalties before any"
        " run.",
        "The numerical damping ratio does not depend on the penalty: at 4.3 Hz it is"
        f" {per_cent(float(scheme_damping(4.3, 1e-2)))} for Δt = 10 ms and"
        f" {per_cent(float(scheme_damping(4.3, 1e-3)))} for 1 ms.",
        "CFL (eq. 14) and 4/ω_max limit the accuracy of waves and contacts, not the stability,"
        " because the scheme is implicit. The columns of Table IV settle at steps far above both"
        f" limits (ωΔt up to {show(max(_STEPS) * _discrete_column(_PENALTIES[-1]).omega[-1], 2)} at"
        " 1e10 N/m and 10 ms).",
    ]


def _free_damping(frequency, time_step: float) -> np.ndarray:
    """Return the damping ratio of the DDA scheme for free vibrations (Hz) at a time step (s)."""
    return Scheme().vibration(frequency, time_step).damping


def _draw_damping(drawing) -> None:
    with small_axes(drawing, size=(6.4, 3.5)) as axis:
        for step, color in zip((1e-5, 1e-4, 1e-3, 1e-2), COLORS, strict=False):
            highest = min(4 / step / 2 / np.pi * 0.999, 1e4)
            frequency = np.geomspace(0.5, highest, 200)
            axis.loglog(frequency, _free_damping(frequency, step), color=color,
                        label=f"Δt = {step:g} s")  # fmt: skip
            if highest < 1e4:
                damping = _free_damping(highest, step)
                axis.plot(highest, damping, "o", color=color, ms=5)
        for frequency_mark, name in ((4.3, "column"), (14.0, "15 layers")):
            axis.axvline(frequency_mark, color="0.6", lw=0.8, ls=":")
            axis.annotate(name, (frequency_mark, 2e-6), rotation=90, ha="right", fontsize=8,
                          color="0.35")  # fmt: skip
        axis.set(xlabel="frequency (Hz)", ylabel="damping ratio, free vibration", ylim=(1e-6, 1.5))
        axis.legend(loc="lower right")


def _draw_frequencies(drawing, runs) -> None:
    penalties = sorted(runs)
    with small_axes(drawing, size=(6.2, 3.4)) as axis:
        for name, color in (("highest", BLUE), ("first", RED)):
            values = [runs[k][name] / 2 / np.pi for k in penalties]
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
