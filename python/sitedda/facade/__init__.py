# SPDX-License-Identifier: GPL-3.0-or-later
"""What a caller has: runs, their page and picture, and how things show themselves."""
