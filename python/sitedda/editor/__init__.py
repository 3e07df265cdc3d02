# SPDX-License-Identifier: GPL-3.0-or-later
"""Support for writing inputs in an editor: completion, hover, diagnostics, grammar."""
