# SPDX-License-Identifier: GPL-3.0-or-later
"""Read a site from a CSV file: layers with velocities, density, damping and curves over depth."""

import csv
import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..base.errors import InputError, located
from ..base.reading import read_bounded

GRAVITY = 9.80665  # m/s², for unit weights and stresses
_LARGEST = 2**24  # largest size of a file, bytes
_MOST = 10_000  # largest number of rows
_FOOT = 0.3048  # m
_COMMENT = "#"
_LENGTH = {"m": 1.0, "ft": _FOOT, "km": 1e3}
_SPEED = {"m/s": 1.0, "ft/s": _FOOT, "km/s": 1e3}
_DENSITY = {"kg/m3": 1.0, "g/cm3": 1e3, "t/m3": 1e3, "kn/m3": 1e3 / GRAVITY,
            "pcf": 0.45359237 / _FOOT**3, "lb/ft3": 0.45359237 / _FOOT**3}  # fmt: skip
_SHARE = {"%": 0.01, "1": 1.0, "-": 1.0}
_STRESS = {"pa": 1.0, "kpa": 1e3, "mpa": 1e6, "psf": 47.88025898}
_ANGLE = {"deg": 1.0, "°": 1.0}
_NONE = {"": 1.0, "1": 1.0, "-": 1.0}
# Columns of a file: factors from their units to SI, and synonyms of their names.
_COLUMNS: dict[str, tuple[dict[str, float] | None, tuple[str, ...]]] = {
    "depth": (_LENGTH, ("z",)),
    "top": (_LENGTH, ("top depth", "depth to top", "from")),
    "bottom": (_LENGTH, ("bottom depth", "depth to bottom", "to")),
    "thickness": (_LENGTH, ("h", "dz")),
    "shear_velocity": (_SPEED, ("vs", "v_s", "shear velocity")),
    "pressure_velocity": (_SPEED, ("vp", "v_p", "pressure velocity")),
    "poisson_ratio": (_NONE, ("nu", "ν", "poisson", "poisson ratio")),
    "density": (_DENSITY, ("rho", "ρ", "unit weight", "gamma", "γ")),
    "damping": (_SHARE, ("damping ratio", "d", "d_min", "ξ", "xi")),
    "shear_strength": (_STRESS, ("strength", "su", "s_u", "cu", "shear strength")),
    "friction_angle": (_ANGLE, ("phi", "φ", "friction angle")),
    "curve": (None, ("curves",)),
    "name": (None, ("layer", "soil", "unit")),
}
_WORDS = {word: name for name, (_, more) in _COLUMNS.items() for word in (name, *more)}
_HEAD = re.compile(r"\s*([^\[(]*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?\s*")
_CURVE = re.compile(r"(\w+)\s*[( ]?\s*([-+.\deE,; ]*)\)?")
_FILLS = ("", "above", "interpolate")
_FILLED = ("shear_velocity", "pressure_velocity", "poisson_ratio", "density", "damping")
_FORMULAS = ("darendeli", "hyperbolic", "mkz", "gqh", "linear")


@dataclass(frozen=True)
class Ground:
    """A row of a file."""

    thickness: float  # m; inf for the half-space
    shear_velocity: float  # m/s
    pressure_velocity: float  # m/s; NaN without this velocity and Poisson's ratio in the file
    density: float  # kg/m³
    damping: float  # damping ratio, a fraction
    curve: str  # curve as in the file; blank: linear
    name: str
    row: int  # row of the file, from 1
    # Undrained strength, or cohesion in addition to friction, Pa; NaN: not given
    shear_strength: float = math.nan
    friction_angle: float = math.nan  # effective angle of friction, degrees; NaN: not given

    def values(self) -> dict[str, float]:
        """Return the arguments for `Layer` and `HalfSpace`."""
        return {"density": self.density, "shear_velocity": self.shear_velocity,
                "damping": self.damping}  # fmt: skip


@dataclass(frozen=True)
class SoilProfile:
    """Layers of ground, from the surface downwards."""

    layers: tuple[Ground, ...]
    half_space: Ground | None  # ground below the layers; None: the file ends with its last layer
    file: Path

    @property
    def depth(self) -> float:
        """Return the depth of the bottom of the lowest layer, m."""
        return float(sum(layer.thickness for layer in self.layers))

    @property
    def tops(self) -> np.ndarray:
        """Return the depths of the layer tops and of the bottom, shape (layers + 1,), m."""
        return np.cumsum([0.0, *(layer.thickness for layer in self.layers)])

    def mean_velocity(self, depth: float = 30.0) -> float:
        """Return the mean velocity of S waves down to a depth (m), m/s: V_s30 for 30 m.

        The half-space, or else the last layer, continues below the file.
        """
        remainder, time = float(depth), 0.0
        for layer in self.layers:
            thickness = min(layer.thickness, remainder)
            time, remainder = time + thickness / layer.shear_velocity, remainder - thickness
        return depth / (time + remainder / (self.half_space or self.layers[-1]).shear_velocity)

    def mean_stresses(
        self, water_table: float = math.inf, pressure_at_rest: float = 0.5
    ) -> list[float]:
        """Return the mean effective stress in the middle of each layer, Pa.

        `water_table`: depth of the water table, m; `pressure_at_rest`: coefficient K₀.
        """
        stresses, overburden = [], 0.0
        for layer, top in zip(self.layers, self.tops, strict=False):
            half, weight = 0.5 * layer.thickness, layer.density * GRAVITY
            water = 1e3 * GRAVITY * max(0.0, float(top) + half - water_table)
            stresses.append((overburden + half * weight - water) * (1 + 2 * pressure_at_rest) / 3)
            overburden += layer.thickness * weight
        return stresses

    def strengths(
        self, water_table: float = math.inf, pressure_at_rest: float = 0.5
    ) -> list[float]:
        """Return the shear strength of each layer, s_u + σ'_v tan φ', Pa; NaN if not in the file.

        `water_table`, `pressure_at_rest`: see `mean_stresses`.
        """
        means = self.mean_stresses(water_table, pressure_at_rest)
        values = []
        for layer, mean in zip(self.layers, means, strict=True):
            vertical = mean * 3 / (1 + 2 * pressure_at_rest)
            parts = [layer.shear_strength, vertical * math.tan(math.radians(layer.friction_angle))]
            values.append(math.nan if all(map(math.isnan, parts)) else float(np.nansum(parts)))
        return values

    def __str__(self) -> str:
        """Return the layers as a table, and V_s30."""
        head = f"{'depth (m)':>15}{'V_s (m/s)':>11}{'V_p (m/s)':>11}{'ρ (kg/m³)':>11}{'D (%)':>8}"
        rows = [head + "  curve"]
        tops = self.tops
        for i, layer in enumerate((*self.layers, *filter(None, [self.half_space]))):
            bottom = f"{tops[i + 1]:.4g}" if i < len(self.layers) else "∞"
            fast = "" if math.isnan(layer.pressure_velocity) else f"{layer.pressure_velocity:.5g}"
            numbers = f"{layer.shear_velocity:11.5g}{fast:>11}{layer.density:11.5g}"
            depths = f"{tops[i]:.4g} – {bottom}"
            rows.append(f"{depths:>15}{numbers}{100 * layer.damping:8.3g}  {layer.curve}".rstrip())
        deep = ""
        if self.depth < 30:
            base_name = "the half-space" if self.half_space else "the last layer"
            deep = f", if {base_name} continues below {self.depth:g} m"
        return "\n".join([*rows, f"V_s30 = {self.mean_velocity():.4g} m/s{deep}"])


def read_soil_profile(file, fill: str = "") -> SoilProfile:
    """Read a site from a CSV file.

    `file`: columns with headings and units in brackets, separated by commas, semicolons or tabs:
    ``depth (m)`` or ``thickness (m)``, ``Vs (m/s)``, ``Vp (m/s)`` or ``nu``, ``density (kg/m3)`` or
    ``unit weight (kN/m3)``, ``damping (%)``, ``curve``, ``name``. Lines that begin with # are
    comments.
    `fill`: value for gaps of velocities, density and damping: none (a gap of a required value is an
    error), the value of the row above, or linear interpolation over the depths of the middles of
    layers.

    Notes
    -----
    ``depth`` means the top of each layer if its first value is 0, otherwise the bottom.  With tops,
    the last row is the half-space; otherwise a last row without thickness or depth is the
    half-space.  Curves: ``darendeli 15`` (plasticity index, %), ``hyperbolic 5e-4`` (reference
    strain), ``mkz 5e-4 1 0.9``, ``linear``, or a CSV file in the same folder with strain, G/G_max
    and damping ratio.
    """
    file = Path(file)
    rows = read_rows(file)
    number, heads = rows[0]
    columns = [_column_unit(head, file, number) for head in heads]
    names = [name for name, _ in columns]
    for name in set(names):
        if names.count(name) > 1:
            raise InputError(f"{file}, row {number}: there are two columns {name}")
    table = [
        {"row": line, **{n: _read_cell(file, line, n, unit, cell)
                       for (n, unit), cell in zip(columns, cells, strict=False)}}
        for line, cells in rows[1:]
    ]  # fmt: skip
    if not table:
        raise InputError(f"{file} has a header but no layers")
    thickness = _thicknesses(file, names, table)
    heads_by_name = {name: head for (name, _), head in zip(columns, heads, strict=True)}
    _fill_gaps(file, table, thickness, heads_by_name, fill)
    ground = [_make_ground(file, values, thick, heads_by_name)
              for values, thick in zip(table, thickness, strict=True)]  # fmt: skip
    half_space = ground.pop() if math.isinf(ground[-1].thickness) else None
    if not ground:
        raise InputError(f"{file} has no layer above its half-space")
    return SoilProfile(tuple(ground), half_space, file)


def read_rows(file: Path) -> list[tuple[int, list[str]]]:
    """Return line number and cells of each row of a CSV file; omit blank rows and comments."""
    try:
        text = read_bounded(file, _LARGEST).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{file} is not a text file in UTF-8") from None
    lines = [(number, line) for number, line in enumerate(text.splitlines(), 1)
             if line.strip() and line.lstrip()[0] != _COMMENT]  # fmt: skip
    if not lines:
        raise InputError(f"{file} is empty")
    if len(lines) > _MOST:
        raise InputError(f"{file} has more than {_MOST} rows")
    mark, result = max(",;\t", key=lines[0][1].count), []
    for number, line in lines:
        try:
            cells = next(csv.reader([line], delimiter=mark, skipinitialspace=True))
        except csv.Error as error:
            raise InputError(f"{file}, row {number}: {error}") from None
        result.append((number, [cell.strip() for cell in cells]))
        surplus = next(filter(None, result[-1][1][len(result[0][1]) :]), "")
        if surplus:
            raise InputError(f"{file}, row {number}: the cell {surplus!r} has no heading; if a "
                             f"cell contains {mark!r}, quote it, or separate cells by ';'; write "
                             "decimal points, not commas")  # fmt: skip
    return result


def _column_unit(head: str, file: Path, row: int) -> tuple[str, float | None]:
    """Return name and factor to SI of a column from its heading; None for texts."""
    heading, unit = _HEAD.fullmatch(head).groups() if _HEAD.fullmatch(head) else (head, None)
    column = " ".join(heading.lower().replace("_", " ").split())
    names = {name.replace("_", " "): column_name for name, column_name in _WORDS.items()}
    if column not in names:
        raise InputError(f"{file}, row {row}: column {heading!r} is unknown; the columns are "
                         f"{', '.join(_COLUMNS)}")  # fmt: skip
    units = _COLUMNS[names[column]][0]
    if units is None:
        return names[column], None
    written_unit = (unit or "").lower().replace("³", "3").replace("^", "").replace(" ", "")
    if written_unit not in units:
        listed = ", ".join(accepted for accepted in units if accepted)
        fault = f"the unit {unit!r} is not known" if unit else "the unit is missing"
        raise InputError(f"{file}, row {row}: {heading}: {fault}; use {heading} ({listed})")
    return names[column], units[written_unit]


def _read_cell(file: Path, row: int, name: str, unit: float | None, cell: str):
    """Return the value of a cell of the file in SI units; NaN if the cell is blank."""
    if unit is None:
        return cell
    if not cell:
        return math.nan
    try:
        number = float(cell)
    except ValueError:
        raise InputError(f"{file}, row {row}: {name} = {cell!r} is not a number") from None
    if name == "thickness" and math.isinf(number):
        return math.nan
    if not math.isfinite(number):
        raise InputError(f"{file}, row {row}: {name} = {cell} is not a usable number")
    return number * unit


def _thicknesses(file: Path, names: list[str], table: list[dict]) -> list[float]:
    """Return the thickness of each row, m; infinite for a half-space."""
    variables = [name for name in ("thickness", "top", "bottom", "depth") if name in names]
    if len(variables) != 1:
        raise InputError(f"{file}: give one column of depth, top, bottom or thickness, not "
                         f"{' and '.join(variables) or 'none'}")  # fmt: skip
    name, values = variables[0], [row.get(variables[0], math.nan) for row in table]
    tops = name == "top" or (name == "depth" and values[0] == 0)
    gaps = [i for i, value in enumerate(values) if math.isnan(value)]
    if gaps and (tops or gaps != [len(values) - 1]):
        raise InputError(f"{file}, row {table[gaps[0]]['row']}: {name} is missing")
    if name == "thickness":
        if not gaps and values[-1] == 0:
            gaps, values[-1] = [len(values) - 1], math.nan
        result = values
    elif tops:
        if values[0] != 0:
            raise InputError(f"{file}, row {table[0]['row']}: the first top must be 0")
        result = [*np.diff(values), math.nan]
    else:
        result = np.diff([0.0, *values]).tolist()
    for row, value in zip(table, result, strict=True):
        if not math.isnan(value) and not 0 < value <= 1e5:
            raise InputError(f"{file}, row {row['row']}: the layer would be {value:g} m thick; "
                             "depths must increase, and thicknesses must be positive")  # fmt: skip
    return [math.inf if math.isnan(value) else float(value) for value in result]


def _fill_gaps(file: Path, table: list[dict], thickness, heads: dict[str, str], fill: str) -> None:
    """Fill the gaps of a table by the rule `fill`, see `read_soil_profile`."""
    if fill not in _FILLS:
        raise InputError(f"fill = {fill!r}: use {', '.join(map(repr, _FILLS))}")
    thick = np.where(np.isinf(thickness), 0.0, thickness)
    middle = np.cumsum(thick) - thick / 2
    for name in _FILLED if fill else ():
        values = np.array([row.get(name, math.nan) for row in table])
        defined = np.flatnonzero(~np.isnan(values))
        if not defined.size:
            continue
        for i in np.flatnonzero(np.isnan(values)):
            upper, lower = defined[defined < i], defined[defined > i]
            if not upper.size or (fill == "interpolate" and not lower.size):
                side = "below" if upper.size else "above"
                raise InputError(f"{file}, row {table[i]['row']}: the gap of {heads[name]} cannot "
                                 f"be filled, because no row {side} has a value")  # fmt: skip
            interpolated = float(np.interp(middle[i], middle[defined], values[defined]))
            table[i][name] = interpolated if fill == "interpolate" else float(values[upper[-1]])


def _make_ground(file: Path, values: dict, thickness: float, heads: dict[str, str]) -> Ground:
    """Return the layer in a row of a file; `heads` contains the headings of the columns."""
    source = f"{file}, row {values['row']}"
    for name, limit in (("shear_velocity", 1e5), ("density", 1e5)):
        if not 0 < values.get(name, math.nan) <= limit:
            number, head = values.get(name, math.nan), heads.get(name, name)
            if math.isnan(number) and name in heads:
                raise InputError(f"{source}: {head} has a gap; give a number, or fill = 'above' or "
                                 "'interpolate'")  # fmt: skip
            fault = "missing" if math.isnan(number) else f"{number:g}"
            raise InputError(f"{source}: {head} is {fault}; it must be positive")
    damping = values.get("damping", 0.0)
    damping = 0.0 if math.isnan(damping) else damping
    if not 0 <= damping < 0.5:
        raise InputError(f"{source}: damping = {damping:g} must be a fraction from 0 to 0.5")
    slow = values["shear_velocity"]
    fast = values.get("pressure_velocity", math.nan)
    poisson = values.get("poisson_ratio", math.nan)
    if math.isnan(fast) and not math.isnan(poisson):
        if not 0 <= poisson < 0.5:
            raise InputError(f"{source}: poisson_ratio = {poisson:g} must lie from 0 to below 0.5")
        fast = slow * math.sqrt((2 - 2 * poisson) / (1 - 2 * poisson))
    if fast <= slow * math.sqrt(4 / 3):
        raise InputError(f"{source}: pressure_velocity = {fast:g} must be above √(4/3) times "
                         f"the shear velocity {slow:g}")  # fmt: skip
    strength = values.get("shear_strength", math.nan)
    friction = values.get("friction_angle", math.nan)
    if strength <= 0 or friction < 0 or friction >= 60:
        raise InputError(f"{source}: shear_strength must be above 0 and friction_angle from 0 to 60"
                         f" degrees, got {strength:g} Pa and {friction:g}")  # fmt: skip
    curve = values.get("curve", "")
    parse_curve(curve, source)
    return Ground(thickness, slow, fast, values["density"], damping,
                  "" if curve == "linear" else curve, values.get("name", ""),
                  values["row"], strength, friction)  # fmt: skip


def parse_curve(text: str, source: str) -> tuple[str, list[float]]:
    """Return name and parameters of a curve; for a file of a curve, only its name.

    `source`: file and row, for messages.
    """
    if not text or text.lower().endswith((".csv", ".txt")):
        return text, []
    match = _CURVE.fullmatch(text)
    if not match or match[1].lower() not in _FORMULAS:
        raise InputError(f"{source}: curve = {text!r}: use {', '.join(_FORMULAS)} followed "
                         "by numbers, or the name of a CSV file")  # fmt: skip
    try:
        return match[1].lower(), [float(item) for item in re.split(r"[,; ]+", match[2]) if item]
    except ValueError:
        raise InputError(f"{source}: curve = {text!r} contains an unreadable number") from None


def read_curve_table(file: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return shear strain, G/G_max and damping ratio of a CSV file, all as fractions.

    Headings may give units in brackets: %, or 1.
    """
    rows = read_rows(file)
    number, heads = rows[0]
    with located(file, ValueError, IndexError):
        has_heads = heads[0][:1] not in "0123456789.+-"
        numbers = np.array([[float(cell) for cell in cells] for _, cells in rows[has_heads:]])
        if numbers.ndim != 2 or numbers.shape[1] != 3:
            raise ValueError("three columns are required: strain, G/G_max and damping ratio")
    if has_heads:
        numbers = numbers * [_share_unit(head, file, number) for head in heads]
    strain, reduction, damping = numbers.T
    return strain, reduction, damping


def _share_unit(head: str, file: Path, row: int) -> float:
    """Return the unit of a heading of a curve file; without one, values are fractions."""
    match = _HEAD.fullmatch(head)
    unit = (match[2] if match else None) or ("%" if "%" in head else "1")
    if unit not in _SHARE:
        raise InputError(f"{file}, row {row}: {head}: the unit {unit!r} is not known; use "
                         f"{', '.join(_SHARE)}")  # fmt: skip
    return _SHARE[unit]
