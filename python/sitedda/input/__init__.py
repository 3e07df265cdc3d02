# SPDX-License-Identifier: GPL-3.0-or-later
"""The input: groups of variables, as text, with changes, and their values."""
