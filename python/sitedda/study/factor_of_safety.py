# SPDX-License-Identifier: GPL-3.0-or-later
"""The task 'safety' of a study: factor of safety of a case."""

from ..stability import safety

RESULTS = ("factor_of_safety", "stands_at", "fails_at")


def factor_of_safety(file) -> dict:
    """Return the factor of safety of an input, see `sitedda.safety`.

    `file`: namelist input.

    Result: ``factor_of_safety``, its bounds ``stands_at`` and ``fails_at``, ``warning``.
    """
    result = safety(file)
    numbers = (result.factor, result.low, result.high)
    return dict(zip(RESULTS, numbers, strict=True)) | {"warning": result.warning}


factor_of_safety.results = RESULTS  # type: ignore[attr-defined]
