# SPDX-License-Identifier: GPL-3.0-or-later
"""Every result of the paper, reproduced: runs, values beside the printed ones, figures.

The paper: "Site response analysis with two-dimensional numerical discontinuous deformation analysis
method" (2013).
"""
