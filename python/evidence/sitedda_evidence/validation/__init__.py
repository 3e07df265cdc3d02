# SPDX-License-Identifier: GPL-3.0-or-later
"""Analytic cases, each with formula, result of the engine, error and picture."""
