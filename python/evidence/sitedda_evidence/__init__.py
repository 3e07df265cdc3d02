# SPDX-License-Identifier: GPL-3.0-or-later
"""Evidence for sitedda: analytic cases and the paper, run by `sitedda validate` and `paper`.

`catalogue.VALIDATION` and `catalogue.PAPER` hold them by name.
"""
