# SPDX-License-Identifier: GPL-3.0-or-later
"""Interface for callers: runs, their page and picture, representation in notebooks."""
