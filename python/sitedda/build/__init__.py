# SPDX-License-Identifier: GPL-3.0-or-later
"""The input as a `Model`, and builders of its blocks: cutting, masonry, meshing, import."""
