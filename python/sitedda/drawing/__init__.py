# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures, movies and the view in a browser of blocks, and the style of every figure."""


def __getattr__(name: str):
    """Colours and functions of the style, which needs matplotlib: when they are asked for."""
    if name.startswith("__"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from . import style

    return getattr(style, name)
