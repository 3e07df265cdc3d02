# SPDX-License-Identifier: GPL-3.0-or-later
"""Makers of blocks: joints that cut, masonry, cells, outlines of other programs."""
