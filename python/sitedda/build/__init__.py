# SPDX-License-Identifier: GPL-3.0-or-later
"""The input as a `Model`; makers of its blocks: joints that cut, masonry, cells, outlines."""
