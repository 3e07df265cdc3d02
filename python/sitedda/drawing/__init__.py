# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures, movies, the view in a browser and files for VTK of blocks."""
