# SPDX-License-Identifier: GPL-3.0-or-later
"""Reproduce every result of the paper by runs, comparison with printed values and figures.

The paper: "Site response analysis with two-dimensional numerical discontinuous deformation analysis
method" (2013).
"""
