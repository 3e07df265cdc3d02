# SPDX-License-Identifier: GPL-3.0-or-later
"""A record for tests of sites, and columns as profiles of pystrata."""

import pytest

import sitedda


@pytest.fixture(scope="session")
def record(root):
    return sitedda.read_record(root / "inputs/records/LomaPrieta1989_USGS1002_APEEL2_133.smc")


@pytest.fixture(scope="session")
def strata_profile():
    """Return the profile of a column on a half-space; it is linear without curves."""
    site = pytest.importorskip("pystrata").site

    def profile(layers, rock, curves=()):
        media = [*((layer, layer.thickness) for layer in layers), (rock, 0.0)]
        soils = [
            (site.NonlinearProperty("", curve.strain, curve.reduction, "mod_reduc"),
             site.NonlinearProperty("", curve.strain, curve.damping, "damping"))
            for curve in curves
        ] or [(None, layer.damping) for layer in layers]  # fmt: skip
        pairs = zip(media, [*soils, (None, rock.damping)], strict=True)
        return site.Profile([
            site.Layer(site.SoilType(str(i), medium.density * 9.80665e-3, *soil), thickness,
                       medium.shear_velocity)
            for i, ((medium, thickness), soil) in enumerate(pairs)
        ])  # fmt: skip

    return profile
