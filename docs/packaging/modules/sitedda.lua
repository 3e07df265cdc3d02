-- SPDX-License-Identifier: GPL-3.0-or-later
-- A module for Lmod: set prefix to the virtual environment that holds sitedda.
help([[Two-dimensional discontinuous deformation analysis: sitedda --help]])
whatis("Name: sitedda")
whatis("Version: 0.3.0")
local prefix = "/opt/sitedda/0.3.0"
prepend_path("PATH", pathJoin(prefix, "bin"))
setenv("OPENBLAS_NUM_THREADS", "1")
