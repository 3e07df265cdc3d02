# SPDX-License-Identifier: GPL-3.0-or-later
"""Analytic cases: each with its formula, the engine's figure, the error, and a picture."""
