# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps of a result over two parameters, and fractiles of samples."""

from dataclasses import dataclass

import numpy as np

from ..base.errors import InputError
from ..base.numbers import axis_label

FRACTILES = (0.16, 0.5, 0.84)


@dataclass(frozen=True)
class Map:
    """A quantity as a function of two parameters."""

    x: np.ndarray  # values of the parameters
    y: np.ndarray
    values: np.ndarray  # the quantity, shape (y, x); NaN if a case failed or is missing
    names: tuple[str, str, str]  # axis labels of x, y and the quantity, with units
    level: float | None = None  # value of a contour that is drawn, such as a factor of safety of 1

    def picture(self):
        """Draw a map with contours, and crosses for missing results; return the figure."""
        from ..report.style import INK, new_figure

        figure, axes = new_figure(size=(7.0, 5.0))
        masked = np.ma.masked_invalid(self.values)
        mesh = axes.pcolormesh(self.x, self.y, masked, shading="nearest", cmap="viridis")
        figure.colorbar(mesh, ax=axes, label=self.names[2])
        finite = np.isfinite(self.values)
        if min(self.values.shape) > 1 and finite.sum() > 3 and np.ptp(self.values[finite]) > 0:
            lines = axes.contour(self.x, self.y, masked, 6, colors="white", linewidths=0.8)
            axes.clabel(lines, fontsize=8)
            low, high = self.values[finite].min(), self.values[finite].max()
            if self.level is not None and low < self.level < high:
                axes.contour(self.x, self.y, masked, [self.level], colors=INK, linewidths=2)
        for i, j in zip(*np.nonzero(~finite), strict=True):
            axes.plot(self.x[j], self.y[i], "x", color=INK, ms=8)
        axes.set(xlabel=self.names[0], ylabel=self.names[1])
        return figure


def parameter_map(table, quantity: str, x: str, y: str, level: float | None = None) -> Map:
    """Return a map of a quantity over two dimensions of a study.

    Parameters
    ----------
    table : xarray.Dataset
        Results of a study.
    quantity, x, y : str
        Name of the quantity, and its two dimensions.
    level : float, optional
        Value of a contour to draw.
    """
    values = table[quantity]
    if set(values.dims) != {x, y} or x == y:
        raise InputError(f"{quantity} has the dimensions {values.dims}, not {x!r} and {y!r}; "
                         "select one value of each other dimension")  # fmt: skip
    coordinates = [np.asarray(table[name].values) for name in (x, y)]
    if any(coordinate.dtype.kind not in "fiu" for coordinate in coordinates):
        raise InputError("a map requires two parameters with numbers as values")
    names = label_of(table, x), label_of(table, y), label_of(table, quantity)
    orders = [np.argsort(coordinate) for coordinate in coordinates]
    grid = values.transpose(y, x).values[np.ix_(orders[1], orders[0])]
    return Map(coordinates[0][orders[0]], coordinates[1][orders[1]], grid, names, level)


@dataclass(frozen=True)
class Bands:
    """Median and fractiles of a quantity over samples."""

    coordinate: np.ndarray  # coordinate of the second dimension of the quantity
    fractiles: np.ndarray  # 16, 50 and 84 % fractiles, shape (3, n)
    samples: np.ndarray  # all samples with results, shape (samples, n)
    names: tuple[str, str]  # axis labels of the coordinate and the quantity

    def picture(self):
        """Draw samples, median and fractiles; return the figure."""
        from ..report.style import BLUE, GREY, canvas

        figure, (axes,) = canvas(1, size=(7.5, 4.8))
        for row in self.samples[:200]:
            axes.plot(self.coordinate, row, color=GREY, lw=0.4, alpha=0.25)
        low, median, high = self.fractiles
        axes.fill_between(self.coordinate, low, high, color=BLUE, alpha=0.25, lw=0,
                          label="16 to 84 % fractile")  # fmt: skip
        axes.plot(self.coordinate, median, color=BLUE, lw=2,
                  label=f"median of {len(self.samples)} cases")  # fmt: skip
        axes.set(xlabel=self.names[0], ylabel=self.names[1])
        axes.set_xlim(self.coordinate[0], self.coordinate[-1])
        if np.all(self.samples >= 0):
            axes.set_ylim(0, 1.1 * np.quantile(self.samples.max(axis=1), 0.95))
        axes.legend(frameon=False)
        return figure


def bands(table, quantity: str, dim: str = "sample") -> Bands:
    """Return median, 16 and 84 % fractiles of an array quantity over samples.

    Parameters
    ----------
    table : xarray.Dataset
        Results of a study.
    quantity : str
        Name of a quantity with the dimension of the samples and one more dimension.
    dim : str
        Dimension of the samples.
    """
    values = table[quantity]
    remaining = [name for name in values.dims if name != dim]
    if dim not in values.dims or len(remaining) != 1:
        raise InputError(f"{quantity} has the dimensions {values.dims}; give {dim!r} and "
                         "one other dimension")  # fmt: skip
    samples = values.transpose(dim, remaining[0]).values
    samples = samples[np.all(np.isfinite(samples), axis=1)]
    if not len(samples):
        raise InputError(f"no case has a result {quantity}")
    names = (label_of(table, remaining[0]), label_of(table, quantity))
    coordinate = np.asarray(table[remaining[0]].values)
    return Bands(coordinate, np.quantile(samples, FRACTILES, axis=0), samples, names)


def label_of(table, name: str) -> str:
    """Return the name of a variable with its unit, as an axis label."""
    return axis_label(name, str(table[name].attrs.get("units", "")))
