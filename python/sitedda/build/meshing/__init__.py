# SPDX-License-Identifier: GPL-3.0-or-later
"""Divide blocks into cells that are welded into deformable bodies."""
