# SPDX-License-Identifier: GPL-3.0-or-later
"""`sitedda live`: the model in the browser, drawn while it is edited and while it runs."""
