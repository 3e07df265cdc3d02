# SPDX-License-Identifier: GPL-3.0-or-later
"""Evidence for sitedda: analytic cases (`sitedda validate`) and the paper (`sitedda paper`).

`catalogue.VALIDATION` and `catalogue.PAPER` contain the cases by name.
"""
