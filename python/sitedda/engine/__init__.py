# SPDX-License-Identifier: GPL-3.0-or-later
"""Interface to the engine: simulations, checks, records, signals and time integration."""

from ..base.core import FILES, api, checked, commit, engine_names, reduced_group, version

__all__ = ["FILES", "api", "checked", "commit", "engine_names", "reduced_group", "version"]
