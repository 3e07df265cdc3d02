# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures, movies and the view in a browser of blocks, and the style of every figure."""

from .style import *  # noqa: F403
from .style import __all__ as __all__
