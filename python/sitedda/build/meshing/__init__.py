# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks divided into cells, which are welded into bodies that bend."""
