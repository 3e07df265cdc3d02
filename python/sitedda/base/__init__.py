# SPDX-License-Identifier: GPL-3.0-or-later
"""What everything stands on: errors, files, arguments, signals, calls of the engine."""
