# SPDX-License-Identifier: GPL-3.0-or-later
"""The factor of safety of a case in place of its run."""

from ..stability import safety


def factor_of_safety(file) -> dict:
    """The factor of safety of an input, see `sitedda.safety`.

    Parameters
    ----------
    file : path
        Namelist input.

    Returns
    -------
    dict
        ``factor_of_safety``; the model ``stands_at`` one factor and ``fails_at`` another;
        ``warning``.
    """
    found = safety(file)
    return {
        "factor_of_safety": found.factor,
        "stands_at": found.low,
        "fails_at": found.high,
        "warning": found.warning,
    }
