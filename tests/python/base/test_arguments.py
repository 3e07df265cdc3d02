# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrong arguments of public functions raise errors of the package that name the argument."""

import copy
import pickle

import numpy as np
import pytest

import sitedda
from sitedda import Column, HalfSpace, InputError, Layer, Model, Simulation
from sitedda.signals import spectral_acceleration
from sitedda.site import darendeli, hyperbolic


def stack() -> Model:
    """Return a block on a fixed block, with a measured point."""
    model = Model("stack", time_step=1e-3, duration=0.01, gravity=(0, -9.81))
    model.material("stone", density=2600.0, young_modulus=1e9, poisson_ratio=0.3)
    model.joint("dry", friction_angle=30.0)
    model.block([0, 0, 2, 0, 2, 1, 0, 1], name="base")
    model.block([0.5, 1, 1.5, 1, 1.5, 2, 0.5, 2], name="top")
    model.fixed_point(0.1, 0.1)
    model.fixed_point(1.9, 0.1)
    model.measured_point("p", 1.0, 1.5)
    return model


def column() -> Column:
    """Return a layer on a half-space."""
    soil = Layer(10.0, density=1800.0, shear_velocity=200.0, damping=0.02)
    return Column([soil], HalfSpace(density=2000.0, shear_velocity=800.0))


def simulated(change):
    """Return the result of a function of an open simulation of `stack`."""
    with Simulation(stack()) as simulation:
        return change(simulation)


WRONG = {
    "None is not a file name": lambda: sitedda.run(None),
    "b'a' is not a file name": lambda: sitedda.check(b"a"),
    "3 is not a file name": lambda: sitedda.open_output(3),
    "4 is not a file name": lambda: sitedda.read_record(4),
    "5 is not a file name": lambda: Model.read(5),
    "6 is not a file name": lambda: stack().write(6),
    "7 is not a file name": lambda: stack().run(output=7),
    r"changes = \[1\] must be a mapping": lambda: stack().run(changes=[1]),
    "changes = 'a' must be a mapping": lambda: simulated(lambda one: one.change("a")),
    "count = -1 must be a whole number": lambda: sitedda.modes(stack(), -1),
    "count = 2.5 must be a whole number": lambda: sitedda.modes(stack(), 2.5),
    "count = x must be a whole number": lambda: sitedda.modes(stack(), "x"),
    "direction = 'z' must be": lambda: sitedda.transfer(stack(), [1.0], "p", None, direction="z"),
    "frequencies must be finite": lambda: sitedda.transfer(stack(), [np.nan], "p", None),
    "frequencies must contain real": lambda: sitedda.transfer(stack(), "x", "p", None),
    "'q' is not a measured point": lambda: sitedda.transfer(stack(), [1.0], "q", None),
    "ensemble = -1 must be": lambda: sitedda.accuracy(stack(), ensemble=-1),
    "steps = x must be a whole number": lambda: simulated(lambda one: one.advance("x")),
    "gravity must contain real": lambda: simulated(lambda one: setattr(one, "gravity", "x")),
    "rates must contain real": lambda: simulated(lambda one: setattr(one, "rates", [1j])),
    "rates must have shape": lambda: simulated(lambda one: setattr(one, "rates", np.ones(3))),
    "cannot be pickled": lambda: simulated(pickle.dumps),
    "600 points are given, but at most 512": lambda: stack().block(circle(600)),
    r"character 2 of 'a\\ud800' is not valid": lambda: stack().block(circle(8), name="a\ud800"),
    "'zz' is not the name of a block": lambda: sitedda.move_supports(stack(), "zz"),
    "color must be one of": lambda: stack().run(output=False).draw(color="zz"),
    "thickness must be finite": lambda: Layer(-1.0, density=1.0, shear_velocity=1.0),
    "thickness must contain real": lambda: Layer("x", density=1.0, shear_velocity=1.0),
    "layers must contain at least one": lambda: Column([]),
    "kind must be one of": lambda: column().transfer([1.0], kind="zz"),
    "sample 1 of the motion is nan": lambda: column().response([0.0, np.nan, 0.0], time_step=0.01),
    "an array of accelerations needs": lambda: column().response(np.ones(9)),
    "mean_stress must contain real": lambda: darendeli("x"),
    "reference_strain must be finite": lambda: hyperbolic(0.0),
    "`surface` and `base` differ": lambda: sitedda.amplification([1.0, 2.0], [1.0, 2.0, 3.0], 0.1),
    "damping must be finite": lambda: sitedda.time_step_for_damping(np.nan, 3.0),
    "needs a time_step of at least": lambda: sitedda.theta_for_damping(0.9, 3.0, 1e-3),
    "damping must be in": lambda: spectral_acceleration(np.ones(9), 0.01, [1.0], damping=2.0),
}


def circle(corners: int) -> np.ndarray:
    """Return the corners of a regular polygon above the stack."""
    angle = 2 * np.pi * np.arange(corners) / corners
    return np.c_[np.cos(angle), 5 + np.sin(angle)]


@pytest.mark.parametrize("message", WRONG)
def test_wrong_argument_is_an_error_of_the_package(message):
    """A wrong argument raises InputError, which names it."""
    with pytest.raises(InputError, match=message):
        WRONG[message]()


@pytest.mark.parametrize(
    "duplicate", [copy.deepcopy, copy.copy, lambda m: pickle.loads(pickle.dumps(m))]
)
def test_model_is_copied_and_pickled(duplicate):
    """A copy of a model is equal to the model and gives the same run."""
    model = stack()
    other = duplicate(model)
    assert other == model and other.folder == model.folder
    original, copied = (one.run(output=False).history.displacement for one in (model, other))
    np.testing.assert_array_equal(original, copied)


def test_deep_copy_is_independent():
    """A change of a deep copy does not change the model."""
    model = stack()
    other = copy.deepcopy(model)
    other["material.stone"].density = 1.0
    other.joint("new", friction_angle=1.0)
    assert model == stack()


def test_supports_of_one_block_by_its_name():
    """The name of one block is as good as a list with this name."""
    model = stack()
    for point in model["fixed_point"]:
        point.block = "base"
    one, many = (sitedda.move_supports(model, b, (0, 1e-3), steps=2) for b in ("base", ["base"]))
    np.testing.assert_array_equal(one.reaction, many.reaction)
