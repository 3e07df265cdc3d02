# SPDX-License-Identifier: GPL-3.0-or-later
"""Outputs follow the CF conventions 1.11 and their own schema."""

import re

import netCDF4
import numpy as np
import pytest

import sitedda
from sitedda.output.variables import FAMILIES, VARIABLES

UNIT = r"(1|m|s|kg|N|J|Pa|rad)(\^\d)?"  # units of UDUNITS that outputs use
STANDARD_NAMES: set[str] = set()  # the CF table has no names for blocks and contacts


@pytest.fixture(scope="module")
def output(tmp_path_factory):
    """Return a run with variables of all families."""
    model = sitedda.Model()
    model.control(time_step=1e-3, steps=4, gravity=[0.0, 0.0], analysis="plane_strain")
    model.contact(normal_stiffness=1e10)
    rock = {"density": 2500.0, "young_modulus": 2e10, "poisson_ratio": 0.25}
    model.material(name="rock", **rock)
    model.material(name="weak", **rock, fracture="crack")
    model.material(name="soil", **rock, law="mohr_coulomb", cohesion=1e4, friction_angle=30.0)
    model.joint(name="dry", friction_angle=30.0)
    model.joint(
        name="crack", law="cohesive", friction_angle=30.0, tensile_strength=1e5, cohesion=2e5,
        fracture_energy=10.0, normal_stiffness_per_area=1e12,
    )  # fmt: skip
    per_area = {"normal_stiffness_per_area": 1e11, "shear_stiffness_per_area": 1e11}
    model.joint(name="worn", law="plesha", friction_angle=30.0, asperity_angle=5.0)
    model.joint(name="soft", law="crushing", friction_angle=30.0, crushing_strength=1e6)
    model.joint(
        name="rough", law="continuously_yielding", friction_angle=30.0,
        initial_friction_angle=40.0, roughness=1e-3, **per_area,
    )  # fmt: skip
    model.joint(
        name="aging", law="rate_state", friction_angle=30.0, direct_effect=0.01,
        state_distance=1e-4, reference_velocity=1e-3, threshold_velocity=1e-9, **per_area,
    )  # fmt: skip
    model.block(vertices=[0, -1, 3, -1, 3, 0, 0, 0], name="floor", joint="dry")
    for i, material in enumerate(("weak", "weak", "soil")):
        body = {"body": "body"} if material == "weak" else {}
        model.block(
            vertices=[i, 0, i + 1, 0, i + 1, 1, i, 1], name=f"b{i}", material=material, **body,
            joint="dry",
        )  # fmt: skip
    model.motion(name="quake", values=[0.0, 0.1, 0.0], time_step=1e-3, quantity="velocity")
    model.boundary(
        name="base", kind="compliant", side="bottom", blocks="floor", motion_x="quake",
        density=2500.0, shear_velocity=1000.0, pressure_velocity=2000.0,
    )  # fmt: skip
    model.bolt(
        **{"name": "cable", "from": (0.5, -0.5), "to": (2.5, 0.5), "through": [(1.5, 0.5)]},
        axial_stiffness=1e8,
    )
    model.flow(joints="dry", aperture=1e-4)
    model.measured_point(name="top", x=0.5, y=1.0)
    model.measured_joint("foot", blocks="b*", against="floor")
    model.output(block_interval=2)
    file = tmp_path_factory.mktemp("conventions") / "out.nc"
    model.run(output=file)
    with netCDF4.Dataset(file) as data:
        data.set_auto_mask(False)
        yield data


def test_an_output_has_the_variables_of_its_families(output):
    assert {VARIABLES[name].family for name in output.variables} == set(FAMILIES)
    for name, expected in VARIABLES.items():
        variable_of_output = output[name]
        text = expected.kind == "text"
        assert variable_of_output.dimensions == expected.dimensions + ("letter",) * text
        assert (
            getattr(variable_of_output, "units", "") == expected.unit
            and variable_of_output.long_name
        )


def test_an_output_follows_the_conventions(output):
    assert output.Conventions == "CF-1.11" and isinstance(output.title, str) and output.source
    for name, variable in output.variables.items():
        assert re.fullmatch(r"[A-Za-z]\w*", name)
        units = getattr(variable, "units", "1")
        assert re.fullmatch(f"{UNIT}(/{UNIT})*", units), (name, units)
        assert getattr(variable, "standard_name", None) in {None} | STANDARD_NAMES
        for label in getattr(variable, "coordinates", "").split():
            assert set(output[label].dimensions) <= {*variable.dimensions, "letter"}, name
        if variable.dimensions == (name,):
            assert np.all(np.diff(variable[:]) >= 0), name


def test_flags_have_values_and_meanings(output):
    flags = [v for v in output.variables.values() if "flag_values" in v.ncattrs()]
    assert {v.name for v in flags} == {n for n, v in VARIABLES.items() if v.kind == "flag"}
    for variable in flags:
        values = np.atleast_1d(variable.flag_values)
        assert values.dtype == variable.dtype and list(values) == list(range(len(values)))
        assert len(variable.flag_meanings.split()) == len(values)
        assert np.isin(variable[:], values).all()
