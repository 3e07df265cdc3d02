# SPDX-License-Identifier: GPL-3.0-or-later
"""Reproduction of all results of the paper: runs, comparisons with printed values, pictures.

The paper: "Site response analysis with two-dimensional numerical discontinuous deformation analysis
method" (2013).
"""
