# SPDX-License-Identifier: GPL-3.0-or-later
"""Format numbers for terminals, reports and pictures, as the engine does."""

import math

# Factors from SI to the units in which values are shown.
SHOWN = {"m": 1.0, "mm": 1e3, "µm": 1e6, "nm": 1e9, "°": 180.0 / math.pi, "%": 100.0,
         "kN/m": 1e-3, "MN/m": 1e-6, "m/s": 1.0, "m/s²": 1.0, "": 1.0}  # fmt: skip

# For each SI unit, size and name of the units in which values are shown, as in `words.js`.
UNITS = {
    "m": ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm")),
    "m/s": ((1.0, "m/s"), (1e-3, "mm/s"), (1e-6, "µm/s"), (1e-9, "nm/s")),
    "Pa": ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa")),
    "N/m": ((1e9, "GN/m"), (1e6, "MN/m"), (1e3, "kN/m"), (1.0, "N/m")),
    "J/m": ((1e9, "GJ/m"), (1e6, "MJ/m"), (1e3, "kJ/m"), (1.0, "J/m")),
    "°": ((0.01, "°"), (180e-6 / math.pi, "µrad")),
}

_ENDINGS = {"_m_s2": "m/s²", "_m_s": "m/s", "_n_m": "N/m", "_j_m": "J/m", "_m": "m", "_rad": "rad",
            "_hz": "Hz", "_s": "s"}  # fmt: skip
_SHORT = {"pga": "PGA", "pgv": "PGV", "sa": "Sa", "arias": "Arias intensity"}


def in_unit(largest: float, unit: str) -> tuple[float, str]:
    """Return the size and name of a suitable unit for a value: mm for 0.004 m.

    `largest`: in an SI unit, or °.
    """
    for size, name in UNITS.get(unit, ()):
        if abs(largest) >= size:
            return (1.0, unit) if name == unit else (size, name)
    return (1.0, unit) if largest == 0 or unit not in UNITS else UNITS[unit][-1]


def shown(value: float, unit: str, digits: int = 3) -> str:
    """Format a value in a suitable unit: −4.12 mm.

    `value`: in `unit`.
    `unit`: SI, or °.
    """
    size, name = in_unit(value, unit)
    return f"{number(value / size, digits)} {name}".replace("-", "−")


def title_and_unit(name: str) -> tuple[str, str]:
    """Split the name of a result into words and unit: 'largest tilt', 'rad' of largest_tilt_rad.

    `name`: as in verdicts and studies, with the point or joint in brackets.
    """
    text, _, bracketed = name.partition("[")
    axis = next((axis_name for axis_name in "xy" if text.endswith(f"_{axis_name}")), "")
    text = text.removesuffix(f"_{axis}") if axis else text
    end = next((axis_name for axis_name in _ENDINGS if text.endswith(axis_name)), "")
    text = text.removesuffix(end).replace("_", " ")
    first_word, space, remainder = text.partition(" ")
    text = _SHORT.get(first_word, first_word) + space + remainder
    return ", ".join(filter(None, (text, bracketed.removesuffix("]"), axis))), _ENDINGS.get(end, "")


def axis_label(name: str, unit: str = "") -> str:
    """Return the axis label of a result with its unit: 'largest tilt (rad)'.

    `name`: see `title_and_unit`.
    `unit`: replaces the unit in the name.
    """
    title, own_unit = title_and_unit(name)
    unit = unit.replace("^2", "²") or own_unit
    return f"{title} ({unit})" if unit not in ("", "1") else title


def counted(count: int, singular: str, plural: str) -> str:
    """Format a count with its noun and verb: 1 block is, 1,000 blocks are."""
    return f"{count:,} {singular if count == 1 else plural}"


def number(value: float, digits: int = 4) -> str:
    """Format a number with the given significant digits: 0.1235, 12.5, 1.235e-7."""
    if value == 0 or not math.isfinite(value):
        return "0" if value == 0 else str(value)
    if 1e-3 <= abs(value) < 1e6:
        decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
        return _strip_trailing_zeros(f"{value:.{decimals}f}")
    mantissa, power = f"{value:.{digits - 1}e}".split("e")
    return f"{_strip_trailing_zeros(mantissa)}e{int(power)}"


def _strip_trailing_zeros(text: str) -> str:
    """Remove the zeros at the end of the decimals of a number."""
    return text.rstrip("0").rstrip(".") if "." in text else text


def with_bar(value: float, bar: float) -> str:
    """Format a number with its error bar of two digits, both to the same decimal place.

    `value`, `bar`: both in the same unit.  If the bar is NaN, the number has four digits.
    """
    if not math.isfinite(bar) or not math.isfinite(value):
        return f"{number(value)} (no error bar)"
    if bar == 0:
        return f"{number(value, 6)} ± 0"
    decimal = math.floor(math.log10(bar)) - 1
    power = math.floor(math.log10(max(abs(value), bar)))
    if -4 <= power < 6:
        digits = max(-decimal, 0)
        return f"{round(value, -decimal):.{digits}f} ± {round(bar, -decimal):.{digits}f}"
    scale, digits = 10.0**power, max(power - decimal, 0)
    return f"({value / scale:.{digits}f} ± {bar / scale:.{digits}f})e{power}"


def length(value: float) -> str:
    """Format a length in a suitable unit.

    `value`: m.
    """
    units = (unit for unit in ("m", "mm", "µm") if abs(value) * SHOWN[unit] >= 1.0)
    unit = "m" if value == 0 else next(units, "nm")
    return f"{number(value * SHOWN[unit])} {unit}"
