# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of a run: output file, scenes, verdict and amplifications."""

from .output_file import load, open_output

__all__ = ["load", "open_output"]
