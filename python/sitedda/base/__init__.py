# SPDX-License-Identifier: GPL-3.0-or-later
"""The lowest layer: errors, files, arguments, signals, calls of the engine."""
