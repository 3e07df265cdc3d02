# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers as a reader sees them in terminals, reports, pictures; the engine writes them alike."""

import math

# Factors from SI to the units in which values are shown.
SHOWN = {"m": 1.0, "mm": 1e3, "µm": 1e6, "nm": 1e9, "°": 180.0 / math.pi, "%": 100.0,
         "kN/m": 1e-3, "MN/m": 1e-6, "m/s": 1.0, "m/s²": 1.0, "": 1.0}  # fmt: skip

# Sizes and names of the units that values of an SI unit are shown in, as `words.js` of the view.
UNITS = {
    "m": ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm")),
    "m/s": ((1.0, "m/s"), (1e-3, "mm/s"), (1e-6, "µm/s"), (1e-9, "nm/s")),
    "Pa": ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa")),
    "N/m": ((1e9, "GN/m"), (1e6, "MN/m"), (1e3, "kN/m"), (1.0, "N/m")),
    "J/m": ((1e9, "GJ/m"), (1e6, "MJ/m"), (1e3, "kJ/m"), (1.0, "J/m")),
    "°": ((0.01, "°"), (180e-6 / math.pi, "µrad")),
}


def in_unit(largest: float, unit: str) -> tuple[float, str]:
    """The size and name of the unit in which a value reads well: mm for 0.004 m.

    Parameters
    ----------
    largest : float
        In an SI unit, or °.
    unit : str
    """
    for size, name in UNITS.get(unit, ()):
        if abs(largest) >= size:
            return (1.0, unit) if name == unit else (size, name)
    return (1.0, unit) if largest == 0 or unit not in UNITS else UNITS[unit][-1]


def counted(count: int, one: str, many: str) -> str:
    """A count and of what: 1 block is, 1,000 blocks are."""
    return f"{count:,} {one if count == 1 else many}"


def number(value: float, digits: int = 4) -> str:
    """A number in so many significant digits: 0.1235, 12.5, 1.235e-7.

    Parameters
    ----------
    value : float
    digits : int
    """
    if value == 0 or not math.isfinite(value):
        return "0" if value == 0 else str(value)
    if 1e-3 <= abs(value) < 1e6:
        decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
        return _without_zeros(f"{value:.{decimals}f}")
    mantissa, power = f"{value:.{digits - 1}e}".split("e")
    return f"{_without_zeros(mantissa)}e{int(power)}"


def _without_zeros(text: str) -> str:
    return text.rstrip("0").rstrip(".") if "." in text else text


def with_bar(value: float, bar: float) -> str:
    """A number and its bar; the bar has two digits, the number ends where the bar does.

    Parameters
    ----------
    value, bar : float
        In the same unit; without a bar, NaN, the number has four digits.
    """
    if not math.isfinite(bar) or not math.isfinite(value):
        return f"{number(value)} (no bar)"
    if bar == 0:
        return f"{number(value, 6)} ± 0"
    last = math.floor(math.log10(bar)) - 1
    power = math.floor(math.log10(max(abs(value), bar)))
    if -4 <= power < 6:
        digits = max(-last, 0)
        return f"{round(value, -last):.{digits}f} ± {round(bar, -last):.{digits}f}"
    scale, digits = 10.0**power, max(power - last, 0)
    return f"({value / scale:.{digits}f} ± {bar / scale:.{digits}f})e{power}"


def length(value: float) -> str:
    """A length in the unit that suits it.

    Parameters
    ----------
    value : float
        m
    """
    fits = (unit for unit in ("m", "mm", "µm") if abs(value) * SHOWN[unit] >= 1.0)
    unit = "m" if value == 0 else next(fits, "nm")
    return f"{number(value * SHOWN[unit])} {unit}"
