# SPDX-License-Identifier: GPL-3.0-or-later
"""Run-time errors: one message (what, where, when, remedy) and an exit status above 0."""

import numpy as np
import pytest
import xarray as xr
from model_text import DRY, changed, flying_block, group, rectangle, tower

import sitedda

ROLLING = {"steps": 40_000, "solver": "direct"}
SOLVERS = ("direct", "lagged", "jacobi", "sor")


def flying(velocity: float, **control) -> list:
    """Return a block with an initial velocity (m/s)."""
    return changed(flying_block(**control), "material", initial_velocity=[velocity, 0.0, 0.0])


def hopeless(solver: str) -> list:
    """Return a tower with a numerically singular matrix: stiff penalties and very soft blocks."""
    stiff = changed(
        tower(steps=5, solver=solver), "contact", normal_stiffness=1e18, fixed_point_ratio=1e6
    )
    return changed(stiff, "material", young_modulus=1e-6, density=1e-15)


def jammed(**control) -> list:
    """Return blocks with little friction that fall on each other, with too few iterations."""
    groups = flying_block(steps=500, gravity=[-3.0, -9.81], **control)
    groups = changed(groups, "contact", max_iterations=2, force_tolerance=1e-15)
    wedges = [
        group("block", name="left", vertices=rectangle(-0.6, -1.01, 1.0, 1.0)),
        group("block", name="right", vertices=rectangle(1.6, -1.02, 1.0, 1.0)),
        *(group("fixed_point", x=x, y=-0.5) for x in (-0.2, 0.2, 1.8, 2.2)),
    ]
    return [*changed(groups, "joint", friction_angle=5.0), *wedges]


def fault(case: str, groups, *arguments: str, exception="ConvergenceError", status=3):
    """Return a case: name, input, words of the message, exception and exit status."""
    return pytest.param(groups, exception, status, arguments, id=case)


FAULTS = [
    fault("leaves slowly", flying(500.0, **ROLLING), "'brick' has left the model"),
    fault("leaves at once", flying(1e29), "'brick' has left the model", "step 1 "),
    fault("leaves in leaps", flying(1e5), "moves too far in one step"),
    fault("leaves in leaps, adaptive",
          flying(1e12, time_step_control="adaptive", least_time_step=1e-5), "least_time_step"),
    fault("never closes", jammed(), "does not converge; worst contact: ", "block 1 'brick'",
          ", error of its force ", " N/m, allowed ", " s, time step ", "try ",
          "time_step_control = 'adaptive'"),
    fault("never closes, adaptive", jammed(time_step_control="adaptive", least_time_step=9e-4),
          "does not converge", "worst contact", "least_time_step"),
    fault("never closes, original rules",
          changed(jammed(), "contact", contact_rules="original", normal_stiffness=1e12),
          "does not converge by the original rules"),
    *(fault(f"no pivot, {name}", hopeless(name), "not positive definite", exception="SolverError",
            status=4) for name in SOLVERS),
    fault("load beyond measure",
          [*flying_block(), group("load", x=1.0, y=0.5, time=[0.0, 1.0], force_x=[1e30, 1e30])],
          "moves too far"),
    fault("stress beyond measure",
          changed(flying_block(), "material", initial_stress=[1e25, 0.0, 0.0]), "moves too far"),
]  # fmt: skip


@pytest.mark.parametrize(("groups", "exception", "status", "phrases"), FAULTS)
def test_a_fault_is_one_message_and_a_status(
    groups, exception, status, phrases, write_input, binary, main, tmp_path
):
    file = write_input(groups)
    messages = []
    for program in (binary, main):
        output = tmp_path / f"{program.name}.nc"
        process = program("run", file, "--quiet", "--output", output)
        assert process.returncode == status, process.stderr
        lines = process.stderr.strip().splitlines()
        messages.append(lines[-1].removeprefix(f"{program.name}: "))
        for phrase in ["step ", "t = ", "; ", *phrases]:
            assert phrase in messages[-1], messages[-1]
        assert "nan" not in messages[-1].lower()
        assert not output.exists()
        steps = finite_and_unfinished(output.with_name(output.name + ".partial"))
        assert f"step {steps} " in messages[-1], messages[-1]
    assert messages[0] == messages[1]
    with pytest.raises(getattr(sitedda, exception)) as caught:
        sitedda.run(file)
    assert messages[0] in str(caught.value)


def finite_and_unfinished(file) -> int:
    """Check that the results so far can be read, are marked incomplete, and are finite.

    Returns the number of samples, which is the number of the failed step.
    """
    with xr.open_dataset(file) as data:
        assert data.attrs["complete"] == "no"
        assert data.sizes["time"] >= 1
        for name in data.data_vars:
            if not np.issubdtype(data[name].dtype, np.floating):
                continue
            values = data[name].values
            if "maximum" in data[name].dims:  # NaN: no such value
                values = values[~np.isnan(values)]
            assert np.all(np.isfinite(values)), name
        return data.sizes["time"]


@pytest.mark.parametrize("speed", [1e160, 1e300])
def test_overflowing_energies_are_an_error(speed, write_input):
    with sitedda.Simulation(write_input(flying_block())) as run:
        with pytest.raises((sitedda.SiteddaError, ValueError)):
            run.rates = np.full((1, 6), speed)
            run.advance(1)


def test_a_failed_run_cannot_continue(write_input):
    """After an error, further steps raise the error again."""
    with sitedda.Simulation(write_input(flying(1e29))) as run:
        for _ in range(3):
            with pytest.raises(sitedda.ConvergenceError):
                run.advance(5)
        assert not run.done


def test_a_slow_fall_is_no_error(write_input):
    """A falling block is a valid result while its position has enough digits."""
    free = changed(flying_block(steps=3000), "control", gravity=[0.0, -9.81])
    end = sitedda.run(write_input(free)).history.displacement.sel(point="corner").isel(time=-1)
    assert end.values[1] == pytest.approx(-0.5 * 9.81 * 3.0**2, rel=1e-3)


@pytest.mark.filterwarnings("error::sitedda.AuditWarning")
def test_open_contacts_and_dry_joints_are_no_error(write_input):
    """Nor are rounding errors in the audit of a model without weight."""
    assert sitedda.run(write_input(tower(joint=DRY, steps=20))).complete
