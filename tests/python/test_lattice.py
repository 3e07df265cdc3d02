# SPDX-License-Identifier: GPL-3.0-or-later
"""Moduli of bonded squares: both in series are those of the continuum."""

import numpy as np
import pytest

from sitedda.lattice import square_lattice


@pytest.mark.parametrize("plane_strain", [True, False])
@pytest.mark.parametrize(("poisson", "ratio"), [(0.25, 1.0), (0.0, 2.0), (0.4, 40.0)])
def test_blocks_and_contacts_in_series_have_the_moduli_of_the_continuum(
    poisson, ratio, plane_strain
):
    young = 2e9
    own = square_lattice(young, poisson, ratio, plane_strain)
    assert own.normal_stiffness == ratio * young and own.shear_ratio == 1.0

    def compliance(young, poisson):
        if plane_strain:
            young, poisson = young / (1 - poisson**2), poisson / (1 - poisson)
        return np.array([[1, -poisson, 0], [-poisson, 1, 0], [0, 0, 2 * (1 + poisson)]]) / young

    joints = np.diag([0.5, 0.5, 1.0]) / own.normal_stiffness
    together = compliance(own.young_modulus, own.poisson_ratio) + joints
    np.testing.assert_allclose(together, compliance(young, poisson), rtol=1e-12, atol=1e-24)


@pytest.mark.parametrize("ratio", [0.0, -1.0, 0.3])
def test_contacts_softer_than_the_continuum_are_refused(ratio):
    with pytest.raises(ValueError, match="softer than the continuum"):
        square_lattice(2e9, 0.25, ratio)
