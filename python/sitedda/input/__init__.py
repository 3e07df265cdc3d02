# SPDX-License-Identifier: GPL-3.0-or-later
"""The input: its groups of variables, their text, their values and changes of them."""
