# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine: simulations, checks, records, signals and the time integration as it has them."""

from ..base.core import FILES, api, checked, commit, engine_names, reduced_group, version

__all__ = ["FILES", "api", "checked", "commit", "engine_names", "reduced_group", "version"]
