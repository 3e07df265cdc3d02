# SPDX-License-Identifier: GPL-3.0-or-later
"""Comparison of published values with theory and run."""

from dataclasses import dataclass

Value = float | tuple[float, float] | str | None


@dataclass(frozen=True)
class Comparison:
    """A result of the paper, of theory and of the run."""

    quantity: str  # quantity with its unit
    source: str  # figure, table or section of the paper
    paper: Value  # printed value, range of values, or statement; None if the paper prints none
    theory: Value  # value of a closed form or of the exact discrete theory
    sitedda: Value  # result of the run
    cause: str = ""  # cause of the difference
    digits: int = 4  # number of significant digits shown

    @property
    def from_paper(self) -> float | None:
        """Return the relative difference of the run from the paper; 0 within a printed range."""
        return deviation(self.sitedda, self.paper)

    @property
    def from_theory(self) -> float | None:
        """Return the relative difference of the run from the theory."""
        return deviation(self.sitedda, self.theory)


def deviation(value: Value, reference: Value) -> float | None:
    """Return the relative difference of a value from a number or from the nearer end of a range."""
    if isinstance(value, str | tuple) or value is None or isinstance(reference, str | None):
        return None
    low, high = reference if isinstance(reference, tuple) else (reference, reference)
    nearest = min(max(value, low), high)
    return (value - nearest) / abs(nearest) if nearest else None


def per_cent(fraction: float | None, sign: bool = False) -> str:
    """Format a fraction in per cent, or as a factor if ≥ 10; `sign` adds + to positive values."""
    if fraction is None:
        return "–"
    if abs(fraction) < 5e-7:
        return "0 %"
    if abs(fraction) >= 10:
        return f"× {1 + fraction:.3g}"
    digits = 3 if abs(fraction) >= 0.0995 else 2
    return _format_exponent(f"{100 * fraction:{'+' if sign else ''}.{digits}g}") + " %"


def show(value: Value, digits: int = 4) -> str:
    """Format a value of a comparison."""
    if value is None:
        return "–"
    if isinstance(value, str):
        return value
    if isinstance(value, tuple):
        return " – ".join(show(v, digits) for v in value)
    return _format_exponent(f"{value:.{digits}g}")


def _format_exponent(text: str) -> str:
    """Replace the exponent of a number, as in 1e-05, by a power of ten."""
    mantissa, e, exponent = text.partition("e")
    return f"{mantissa}·10^{int(exponent)}" if e else mantissa
