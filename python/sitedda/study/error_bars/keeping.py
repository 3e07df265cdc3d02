# SPDX-License-Identifier: GPL-3.0-or-later
"""Store results with their error bars in the output of their run."""

import json
import math
import shutil
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ...base.errors import OutputError
from ...base.files import written
from .figures import Accuracy, Band, Figure

ATTRIBUTE = "accuracy"


def store_accuracy(results: Accuracy, output: Path, attributes: dict) -> None:
    """Write results with error bars into the attribute ``accuracy`` of an output, as JSON.

    `attributes`: attributes of the output as read, which are updated.

    Raises
    ------
    OutputError
        If the file cannot be written; then the output is unchanged.
    """
    import netCDF4

    text = json.dumps(_nan_to_null(results.to_dict()))
    with written(output, "a netCDF file") as copy:
        shutil.copyfile(output, copy)
        with netCDF4.Dataset(copy, "a") as data:
            data.setncattr(ATTRIBUTE, text)
    attributes[ATTRIBUTE] = text


def stored_accuracy(attributes: Mapping) -> Accuracy | None:
    """Return the results with error bars that an output contains; None if there are none.

    Raises
    ------
    OutputError
        If the attribute is damaged.
    """
    text = attributes.get(ATTRIBUTE)
    if not text:
        return None
    try:
        content = json.loads(text, parse_constant=float)
        numbers = {name: _null_to_nan(values) for name, values in content["figures"].items()}
        figures = {name: Figure(**values) for name, values in numbers.items()}
        end = _null_to_nan({"end": content["end_s"]})["end"]
        bands = {name: Band(**{key: np.array(row, float) for key, row in band.items()})
                 for name, band in content.get("bands", {}).items()}  # fmt: skip
        return Accuracy(figures, content["runs"], end, bands, content.get("cause", ""))
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        raise OutputError(f"the output is damaged: its attribute {ATTRIBUTE}") from None


def _nan_to_null(value):
    """Replace NaN, which JSON does not allow, by null in nested dicts and lists."""
    if isinstance(value, dict):
        return {name: _nan_to_null(item) for name, item in value.items()}
    if isinstance(value, list):
        return [_nan_to_null(item) for item in value]
    return None if isinstance(value, float) and math.isnan(value) else value


def _null_to_nan(values: dict) -> dict:
    return {name: math.nan if value is None else value for name, value in values.items()}
