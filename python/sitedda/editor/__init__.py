# SPDX-License-Identifier: GPL-3.0-or-later
"""Help for writing inputs in an editor: completion, hover, diagnostics, schema, grammar."""
