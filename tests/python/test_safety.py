# SPDX-License-Identifier: GPL-3.0-or-later
"""Unusual use from Python is safe: odd arrays, closed handles, threads, processes."""

import gc
import multiprocessing
import os
import sys
import textwrap
import threading
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest
from environment import DEADLINE, captured
from model_text import flying_block, namelist, tower, without

import sitedda
from sitedda.engine import api, checked


@pytest.fixture
def small(write_input):
    """Return a tower that is ready to run."""
    with sitedda.Simulation(write_input(tower(steps=20))) as run:
        yield run


# --- Arrays --------------------------------------------------------------------------------------

RIGHT = np.arange(24, dtype=float).reshape(4, 6) / 100


@pytest.mark.parametrize(
    "values",
    [
        np.asfortranarray(RIGHT),
        np.repeat(np.repeat(RIGHT, 2, axis=0), 3, axis=1)[::2, ::3],
        RIGHT[::-1][::-1],
        RIGHT.tolist(),
        RIGHT.astype(">f8"),
        RIGHT.astype(np.longdouble),
        np.frombuffer(RIGHT.tobytes()).reshape(4, 6),  # not writable
        np.ma.array(RIGHT),
    ],
    ids=["fortran", "strided", "reversed", "list", "big endian", "long", "read-only", "masked"],
)
def test_arrays_of_any_layout_are_read_correctly(values, write_input):
    """The blocks are free, because supports would change their rates."""
    free = [group for group in tower(steps=20) if group[0] != "fixed_point"]
    with sitedda.Simulation(write_input(free)) as run:
        run.rates = values
        assert np.array_equal(run.rates, RIGHT)


@pytest.mark.parametrize(
    ("message", "values"),
    [
        *((r"shape \(4, 6\)", v) for v in (RIGHT[:3], RIGHT.T, RIGHT.ravel(), RIGHT[None], 3.0)),
        *(("rates must be finite", np.where(RIGHT == 0, v, RIGHT)) for v in (np.nan, np.inf)),
        *((None, v) for v in (np.zeros((4, 0)), None, "fast", [["x"] * 6] * 4, RIGHT * 1j)),
        *((None, v) for v in ([[1.0] * 6, [1.0] * 5], np.full((4, 6), object()))),
    ],
    ids=lambda values: str(np.shape(values) if isinstance(values, np.ndarray) else type(values)),
)
@pytest.mark.filterwarnings("ignore::numpy.exceptions.ComplexWarning")
def test_arrays_that_are_not_rates_are_refused(message, values, small):
    before = small.rates
    with pytest.raises((TypeError, ValueError), match=message):
        small.rates = values
    assert np.array_equal(small.rates, before)


def test_returned_arrays_are_copies(small):
    for name in ("coordinates", "rates", "stresses", "point_motions"):
        before = getattr(small, name)
        getattr(small, name)[:] = np.nan
        assert np.array_equal(getattr(small, name), before), name
    small.polygons[0][:] = np.nan
    small.contacts["gap"][:] = np.nan
    before = small.coordinates
    first = before.copy()
    small.advance(3)
    assert np.all(np.isfinite(small.coordinates))
    assert np.array_equal(before, first)


@pytest.mark.parametrize("steps", ["3", None, 2**31, 2**63, -(2**40), [1, 2]])
def test_invalid_numbers_of_steps_are_refused(steps, small):
    with pytest.raises((TypeError, ValueError, OverflowError, sitedda.InputError)):
        small.advance(steps)
    assert small.steps == 0


def test_zero_and_negative_numbers_of_steps(small):
    assert not small.advance(0)
    with pytest.raises(sitedda.InputError, match="steps = -5 must be a whole number from 0"):
        small.advance(-5)
    assert small.steps == 0


@pytest.mark.parametrize(
    "series", [[], [1.0], np.zeros((3, 3)), [1.0, np.nan, 2.0], ["a", "b"], None, [1j, 2j]]
)
@pytest.mark.filterwarnings("ignore::numpy.exceptions.ComplexWarning")
def test_invalid_series_are_refused(series):
    with pytest.raises((TypeError, ValueError)):
        sitedda.fourier_spectrum(series, 0.01)
    with pytest.raises((TypeError, ValueError)):
        sitedda.amplification(series, series, 0.01)


@pytest.mark.parametrize("text", ["x" * 10_000_000, "a\0b", "地" * 100, "", " "])
def test_arguments_may_be_texts_of_any_length(text, tmp_path):
    file = tmp_path / "record.txt"
    file.write_text("0 1\n1 2\n2 1\n")
    with pytest.raises((sitedda.SiteddaError, ValueError)):
        sitedda.read_record(file, text, "acceleration" if not text.strip() else text, "hands")
    if text.strip():
        with pytest.raises((sitedda.SiteddaError, ValueError, OSError)):
            sitedda.Simulation(text)


# --- Handles -------------------------------------------------------------------------------------


def test_a_closed_simulation_raises_errors(write_input):
    run = sitedda.Simulation(write_input(tower(steps=5)))
    run.close()
    run.close()
    kinds = {name: kind for base in sitedda.Simulation.__mro__ for name, kind in vars(base).items()}
    looks = [name for name, kind in kinds.items() if isinstance(kind, property)]
    looks.remove("is_open")
    assert len(looks) > 10 and not run.is_open
    for name in looks:
        with pytest.raises(sitedda.InputError, match="closed"):
            getattr(run, name)
    for call in (run.advance, run.finish, lambda: setattr(run, "rates", RIGHT)):
        with pytest.raises(sitedda.InputError, match="closed"):
            call()


@pytest.mark.parametrize("handle", [-1, 0, 65536, 65537, 2**31 - 1, -(2**31)])
def test_unknown_handles_are_refused(handle):
    for name, options in [
        ("advance_run", (1,)),
        ("finish_run", ()),
        ("make_table", ("blocks",)),
        ("make_text", ("title",)),
        ("check_run", ()),
    ]:
        with pytest.raises(sitedda.InputError, match="closed"):
            checked(getattr(api, name), handle, *options)
    api.close_run(handle)


# --- Threads and processes -----------------------------------------------------------------------


def state_of(run) -> bytes:
    """Return the state of a simulation as bytes."""
    return run.coordinates.tobytes() + run.rates.tobytes() + run.contacts["stretch"].tobytes()


def final_state(file) -> bytes:
    """Return the final state of a run as bytes."""
    with sitedda.Simulation(file) as run:
        while not run.advance(7):
            pass
        return state_of(run)


def output_bits(job) -> bytes:
    """Return the history of a run that writes a file, as bytes."""
    file, output = job
    history = sitedda.run(file, output=output).history
    return b"".join(history[name].values.tobytes() for name in ("displacement", "energy_balance"))


def test_runs_in_threads_are_bit_identical(write_input, tmp_path):
    files = [write_input(tower(layers=n, steps=300), f"tower_{n}.nml") for n in (2, 3, 4, 5)]
    expected = [final_state(file) for file in files]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(final_state, 3 * files)) == 3 * expected
        jobs = [(file, tmp_path / f"{i}.nc") for i, file in enumerate(2 * files)]
        written = list(pool.map(output_bits, jobs))
    assert written[:4] == written[4:]


@pytest.mark.parametrize("method", ["fork", "spawn", "forkserver"])
def test_runs_in_other_processes_are_bit_identical(method, write_input):
    file = write_input(tower(steps=60))
    expected = final_state(file)
    context = multiprocessing.get_context(method)
    with sitedda.Simulation(file) as simulation, ProcessPoolExecutor(2, mp_context=context) as pool:
        simulation.advance(30)
        assert list(pool.map(final_state, 3 * [file], timeout=DEADLINE)) == 3 * [expected]
        simulation.advance(30)
        assert state_of(simulation) == expected


def test_threads_of_the_engine_survive_a_fork(write_input, tmp_path):
    """The wall is large enough for several threads; it runs before and after a fork."""
    wall = ("wall", {"brick_length": 0.5, "brick_height": 0.2, "bricks": 20, "courses": 12})
    groups = without(without(flying_block(steps=4), "block"), "measured_point")
    file = write_input([*groups, wall])
    script = tmp_path / "forks.py"
    script.write_text(
        textwrap.dedent(f"""
        import os, sys, time
        sys.path.insert(0, {os.path.dirname(__file__)!r})
        from test_safety import final_state
        expected = final_state({str(file)!r})
        child = os.fork()
        if child == 0:
            os._exit(0 if final_state({str(file)!r}) == expected else 3)
        for _ in range(600):
            done, status = os.waitpid(child, os.WNOHANG)
            if done:
                sys.exit(os.waitstatus_to_exitcode(status))
            time.sleep(0.1)
        os.kill(child, 9)
        sys.exit("the child hangs")
        """)
    )
    environment = os.environ | {"OMP_NUM_THREADS": "2"}
    process = captured([sys.executable, script], env=environment)
    assert process.returncode == 0, process.stderr


def test_one_simulation_in_many_threads(write_input):
    """Simultaneous steps, reads and close of one object are executed in sequence."""
    run = sitedda.Simulation(write_input(tower(layers=6, steps=1_000_000)))
    failure = []

    def use(call):
        try:
            for _ in range(200):
                call()
        except sitedda.InputError as error:
            assert "closed" in str(error)
        except Exception as error:
            failure.append(error)

    calls = [lambda: run.advance(20), lambda: run.advance(3), lambda: run.contacts,
             lambda: run.energies]  # fmt: skip
    threads = [threading.Thread(target=use, args=(call,)) for call in calls]
    for thread in threads:
        thread.start()
    threads[-1].join(0.2)
    run.close()
    for thread in threads:
        thread.join(60)
        assert not thread.is_alive()
    assert not failure


# --- Life ----------------------------------------------------------------------------------------


def resident() -> int:
    """Return the memory of this process, bytes."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="needs Linux")
def test_ten_thousand_models_do_not_leak_memory(write_input):
    good = write_input(flying_block(steps=3))
    bad = write_input(namelist(flying_block()).replace("2643.0", "-1"), "bad.nml")
    sizes = []
    for i in range(10_000):
        if i % 4 == 3:
            with pytest.raises(sitedda.InputError):
                sitedda.Simulation(bad)
        else:
            run = sitedda.Simulation(good)
            if i % 4 == 0:
                run.advance(1)
            if i % 4 == 1:
                run.close()
            del run
        if i % 1000 == 999:
            gc.collect()
            sizes.append(resident())
    assert sizes[-1] - sizes[1] < 4e6, sizes


def test_exceptions_are_returned_from_other_processes(write_input):
    file = write_input(namelist(flying_block()).replace("2643.0", "-1"))
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        with pytest.raises(sitedda.InputError, match="density = -1"):
            pool.submit(final_state, file).result(timeout=DEADLINE)
