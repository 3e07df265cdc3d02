# SPDX-License-Identifier: GPL-3.0-or-later
"""The input: groups of variables, as text, as a `Model`, with changes, made into blocks."""
