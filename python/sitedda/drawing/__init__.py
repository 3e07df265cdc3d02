# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures, movies and the view in a browser of blocks."""
