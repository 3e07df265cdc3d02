# SPDX-License-Identifier: GPL-3.0-or-later
"""Recipe for Spack: copy to packages/py-sitedda/package.py of a repository of recipes."""

from spack_repo.builtin.build_systems.python import PythonPackage

from spack.package import *


class PySitedda(PythonPackage):
    """Two-dimensional discontinuous deformation analysis for site response, masonry and rock."""

    pypi = "sitedda/sitedda-0.3.0.tar.gz"
    license("GPL-3.0-or-later")

    version("0.3.0")  # the checksum is that of the archive on the index

    depends_on("c", type="build")
    depends_on("fortran", type="build")
    depends_on("python@3.11:", type=("build", "run"))
    depends_on("py-meson-python@0.16:", type="build")
    depends_on("ninja", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("openblas")
    depends_on("arpack-ng")
    depends_on("fftw@3:")
    depends_on("netcdf-fortran")
    depends_on("suite-sparse")
    depends_on("metis@5:")
    for library in ("numpy@2:", "scipy@1.11:", "xarray", "pandas", "netcdf4", "matplotlib"):
        depends_on(f"py-{library}", type=("build", "run"))
    for library in ("pillow@10.1:", "shapely@2:", "tqdm"):
        depends_on(f"py-{library}", type=("build", "run"))
