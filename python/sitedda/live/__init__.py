# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda live`: edit and run a model in the browser, which draws it continuously."""
