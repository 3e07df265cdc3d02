# SPDX-License-Identifier: GPL-3.0-or-later
"""Run the engine step by step or to the end."""

import os
import threading
import time
import weakref
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, nullcontext
from pathlib import Path

import numpy as np

from ..base.arguments import Range, floats
from ..base.arrays import parts_of
from ..base.core import FILES, api, checked, engine_names
from ..base.errors import InputError, InterruptedRun, OutputError, SiteddaError
from ..base.numbers import counted
from ..base.reading import file_path
from ..base.stop import SIGNALS, Stop, program_handles_interrupt
from ..input.added_stage import PresentStage, with_stage
from ..input.changes import BETWEEN_STEPS, changed_input, changes_text, flat_changes, merged
from ..input.groups import checked as checked_value
from ..input.groups import group_text
from ..input.input_text import cited, find_groups
from ..input.source import Built, blocks_text, needs_building, opened_input
from .maxima import Maximum, as_maxima

_LONGEST_CALL = 80  # largest number of characters of a call in a message
_CHUNK_TIME = 0.1  # s between checks for signals, if a step does not take longer


class Simulation:
    """A model and its state.

    Parameters
    ----------
    file : path or Model
        Namelist input; groups of joints and masonry are converted to blocks.
    output : path, True or None
        Output file; True: as in the input; None: no file is written.
    resume : bool
        Continue from the last checkpoint of the output, which must belong to the same input with
        the same changes; without a checkpoint, start from the beginning. If the output is complete,
        the run has ended and the blocks are in their initial position. `notice` reports the case.
    changes : mapping, optional
        Variables to change in the input, by ``group.variable`` or, if an input has several groups
        of a kind, ``group.name.variable``: ``{"material.clay.density": 1900.0}``.
    drawn : bool
        Leave the blocks in their initial position.  The first stage, which may compute a static
        equilibrium, begins with the first call of `advance`, even with 0 steps.
    **variables
        Changes as keywords: ``time_step=5e-4``, ``contact={"normal_stiffness": 1e12}``; see
        `sitedda.changes.changed_input`.

    Raises
    ------
    InputError
        If the input cannot be run; the message names file, group and value.
    OutputError
        If the output cannot be written; a `CheckpointError` if none of its checkpoints is usable.

    Notes
    -----
    The object can be used in a ``with`` statement.  It is freed when it is closed or collected.
    Only `rates`, `gravity` and `time_step` can be set; `change` sets other variables.
    """

    __slots__ = (
        "__weakref__", "_free", "_handle", "_lock", "_writes", "built", "done", "file",
    )  # fmt: skip

    def __init__(
        self,
        file,
        output=None,
        *,
        resume: bool = False,
        changes: Mapping | None = None,
        drawn: bool = False,
        **variables,
    ):
        if resume and output is None:
            raise InputError("only a run with an output file can be resumed")
        changes = merged(changes, variables)
        path = dict(flat_changes(changes)).get("output.file")
        if output is True and isinstance(path, str | os.PathLike):
            output = path  # callers may name any path; inputs may not
        target = b"" if output in (None, True) else os.fsencode(file_path(output))
        self._writes = output is not None
        self._lock = threading.RLock()  # locked while the engine works on this simulation
        write_blocks = getattr(file, "put", blocks_text)
        with opened_input(file) as (file, text):
            if changes:
                text = changed_input(text, changes, file=file)
            self.built = Built()
            if needs_building(text):
                from ..build.building import built_text

                text, self.built = built_text(text, file, write_blocks)
            writes = self._writes + bool(resume)
            with FILES:
                data = text.encode("utf-8", "surrogateescape")
                request = (os.fsencode(file), data, target, writes, bool(drawn))
                self._handle = checked(api.open_run, *request)
        self._free = weakref.finalize(self, api.close_run, self._handle)
        self.file = file
        self.done = False

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __repr__(self) -> str:
        """Return title, number of blocks and time."""
        if not self.is_open:
            return f"<sitedda.Simulation of {self.file}, closed>"
        blocks = counted(len(self.rates), "block", "blocks")
        progress = f"{self.time:g} of {self.duration:g} s"
        return f"<sitedda.Simulation {self.title!r}: {blocks}, {progress}>"

    def __reduce__(self):
        """Reject `pickle` and `copy`: the state of a run is in the engine."""
        raise InputError("a Simulation cannot be pickled or copied; pickle its Model, or a Run")

    def close(self) -> None:
        """Free the simulation; an incomplete output remains as FILE.partial, with a checkpoint."""
        with self._lock, self._output_lock():
            self._free()
            self._handle = 0

    @property
    def is_open(self) -> bool:
        """Return whether the simulation is open."""
        return bool(self._handle)

    def advance(self, steps: int = 1) -> bool:
        """Take up to `steps` steps; return whether the run has ended, see `ending`.

        Raises
        ------
        ConvergenceError
            If a step does not converge; the message names step, contact and blocks.
        """
        if isinstance(steps, str):  # `Range` also reads the texts of command lines
            raise InputError(f"steps = {steps} must be a whole number")
        steps = Range(0, 2**31 - 1, whole=True).check("steps", steps)
        with self._lock, self._output_lock():
            ended = self._call_engine("advance_run", steps)
        self.done = bool(ended)
        return self.done

    def change(self, changes: Mapping | None = None, **variables) -> None:
        """Change variables of the input from the present time on.

        Variables that can change: ``time_step`` and ``gravity`` of &control; the strengths of a
        &joint; a &load; the record of a &motion and its processing; ``direction``, ``motion_x`` and
        ``motion_y`` of a &fixed_point.  The values are checked like those of an input.

        Parameters
        ----------
        changes, **variables
            As for `Simulation`: ``change({"joint[bed].friction_angle": 30.0})``,
            ``change(gravity=(0.0, -5.0))``.

        Raises
        ------
        InputError
            If a value cannot be used, or the variable cannot change; then nothing has changed.

        Notes
        -----
        A point that is fixed again, or follows another motion, starts from its present position.
        Bonds and closed contacts do not change.  With another time step, the remaining time is
        rounded up to whole steps. The energy term ``changed`` contains the energy added or removed.
        The same changes at the same steps give bit-identical results.  Checkpoints contain the
        changes, and the output lists them in its attribute ``changes``.
        """
        changes = merged(changes, variables)
        with self._lock:
            text = changed_input(self.present_input, changes, BETWEEN_STEPS, self.file)
            self._change_input(text, text_of_changes := changes_text(changes),
                               f"change({text_of_changes})")  # fmt: skip

    def add(self, kind: str, **values) -> None:
        """Add a load or a fixed point from the present time on.

        Parameters
        ----------
        kind : str
            ``"load"``, whose times are times of the run, or ``"fixed_point"``, which fixes the
            present position.
        **values
            Variables of the group; ``x`` and ``y`` (m) are the initial position of the point.
        """
        if kind not in ("load", "fixed_point"):
            raise InputError(f"&{kind} cannot be added during a run, only &load and &fixed_point")
        group = group_text(kind, {k: checked_value(kind, k, v) for k, v in values.items()})
        with self._lock:
            text = f"{self.present_input.rstrip()}\n{group}"
            self._change_input(text, group.strip(), f"add({kind!r}, …)")

    def begin_stage(self, name: str, kind: str = "dynamic", **values) -> None:
        """End the present stage and begin another: excavate, release supports, change joints.

        With adaptive steps, the stage begins at the second next multiple of Δt.  `present_input`
        then contains the stage; running this input gives bit-identical results.

        Parameters
        ----------
        name : str
            Name of the stage.
        kind : {'dynamic', 'static'}
            A static stage computes an equilibrium; a dynamic one continues from the present state.
        **values
            Variables of &stage: ``remove``, ``release``, ``drop``, ``change_joints``,
            ``change_materials``, ``zero_displacements``, ``displacement``, ``duration`` or
            ``steps``, ``time_step``, ``integration``, ``theta``.
            Without a duration, the stage lasts until the end of the run.

        Raises
        ------
        InputError
            If the stage cannot follow; then nothing has changed.
        """
        with self._lock:
            text = with_stage(self.present_input, self.present_stage, self.file, name, kind, values)
            self._change_input(text, f"stage {name}", f"begin_stage({name!r}, …)")

    @property
    def present_stage(self) -> PresentStage:
        """Progress of the present stage."""
        clock = self._read_clock()
        steps, time = int(clock[3] - clock[9]), float(clock[0] - clock[10])
        return PresentStage(steps, time, planned=int(clock[11]), time_step=float(clock[12]))

    @property
    def input_text(self) -> str:
        """The text of the input at the start of the run."""
        return self._read_text("input").decode("utf-8", "surrogateescape")

    @property
    def present_input(self) -> str:
        """The text of the input with the changes so far."""
        return self._read_text("changed").decode("utf-8", "surrogateescape") or self.input_text

    @property
    def input_values(self) -> str:
        """The values of the input as JSON: given, default and derived values of its groups."""
        return self._read_line("values")

    def _change_input(self, text: str, label: str, call: str) -> None:
        """Continue the run with another input; errors name the call, not the generated text."""
        try:
            with self._lock, FILES:  # locks are always acquired in this order, to avoid deadlocks
                data = text.encode("utf-8", "surrogateescape")
                self._call_engine("change_input", data, label.encode())
        except InputError as error:
            short_call = call if len(call) <= _LONGEST_CALL else f"{call[:_LONGEST_CALL]}…"
            groups = find_groups(self.present_input, self.file, ("block",))
            calls = {group.line: group.called() for group in groups}
            message = cited(str(error), self.file, lambda kind, n: calls.get(n, f"&{kind}"))
            raise InputError(f"Simulation.{short_call}: {message}") from None

    def checkpoint(self) -> None:
        """Write a checkpoint now, in addition to those of the input.

        Raises
        ------
        OutputError
            If the checkpoint cannot be written; the previous one remains.
        """
        with self._lock, FILES:
            self._call_engine("save_state")

    def finish(self) -> Path | None:
        """Close the output file, if one is written, and return its path.

        If the duration is not reached, FILE.partial contains the results so far, and the run can be
        resumed from a checkpoint.
        """
        with self._lock, FILES:
            self._call_engine("finish_run")
        return self.output

    @property
    def output(self) -> Path:
        """Path of the output, also if it is not written."""
        return Path(os.fsdecode(self._read_text("output").strip()))

    def _output_lock(self):
        """Return the lock of netCDF files if this simulation has an output; otherwise no lock."""
        return FILES if self._writes else nullcontext()

    def _call_engine(self, routine: str, *arguments):
        """Call a routine of the engine for this simulation, in one thread at a time."""
        with self._lock:
            return checked(getattr(api, routine), self._handle, *arguments)

    def _read_table(self, name: str) -> np.ndarray:
        """Return a table of the engine, see `take_state` and `take_course` in `api/tables.f90`."""
        with self._lock:
            return api.read_table(self._handle, *self._call_engine("make_table", name))

    def _read_text(self, name: str) -> bytes:
        """Return a text of the engine, see `make_text` in `api/tables.f90`."""
        with self._lock:
            text = api.read_text(self._handle, self._call_engine("make_text", name))
            return text.astype("u1").tobytes()

    def _read_line(self, name: str) -> str:
        """Return a text of the engine without blanks at its ends."""
        return self._read_text(name).decode("utf-8", "replace").strip()

    def _read_clock(self) -> np.ndarray:
        """Return times, steps, gravity and stiffness of the engine in one array."""
        return self._read_table("clock")[0]

    @property
    def title(self) -> str:
        """Title of the run."""
        return self._read_line("title")

    @property
    def summary(self) -> str:
        """Summary of the time step control so far."""
        return self._read_line("summary")

    @property
    def warning(self) -> str:
        """Warning of the energy audit so far; empty if the energies balance."""
        return self._read_line("warning")

    @property
    def description(self) -> str:
        """One line about the analysis and one per motion: peaks, drift removal, final values.

        Plane strain or plane stress; PGA, PGV and PGD of the motion; the largest velocity and
        displacement that drift removal subtracted; velocity and displacement at the end of the
        record, and the motion after the end.
        """
        return self._read_line("description")

    @property
    def notes(self) -> str:
        """Warnings about probable mistakes of the input, one line each; empty if there are none."""
        return self._read_line("notes")

    @property
    def thread_notes(self) -> str:
        """Note on the time in which fewer processors than threads were free; otherwise empty."""
        return self._read_line("threads")

    @property
    def peak_warnings(self) -> list[str]:
        """Warnings about amplification peaks of a linear run that differ from exact ones."""
        with self._lock, FILES:
            return self._read_line("peaks").splitlines()

    @property
    def ending(self) -> str:
        """Reason of the end of the run: "duration reached" or a rule of &stop; empty before it."""
        return self._read_line("ending")

    @property
    def notice(self) -> str:
        """The time from which a resumed simulation continued, in words; otherwise blank."""
        return self._read_line("notice")

    @property
    def time(self) -> float:
        """Present time, s."""
        return float(self._read_clock()[0])

    @property
    def duration(self) -> float:
        """Duration of the run, s."""
        return float(self._read_clock()[1])

    @property
    def time_step(self) -> float:
        """Length of the last time step, s; may be set, see `change`."""
        return float(self._read_clock()[2])

    @time_step.setter
    def time_step(self, value: float) -> None:
        self.change(time_step=value)

    @property
    def gravity(self) -> np.ndarray:
        """Acceleration of gravity, shape (2,), m/s²; may be set, see `change`."""
        return self._read_clock()[5:7]

    @gravity.setter
    def gravity(self, values) -> None:
        self.change(gravity=tuple(floats("gravity", values).ravel()))

    @property
    def normal_stiffness(self) -> float:
        """Penalty stiffness k_n of closed contacts, N/m: value of the input or default."""
        return float(self._read_clock()[7])

    @property
    def steps(self) -> int:
        """Number of steps so far."""
        return int(self._read_clock()[3])

    @property
    def iterations(self) -> int:
        """Number of open-close iterations in the last step."""
        return int(self._read_clock()[4])

    @property
    def block_names(self) -> list[str]:
        """Names of the blocks, blank if the input gives none."""
        return self._read_text("blocks").decode("utf-8", "replace").split("\n")[:-1]

    @property
    def point_names(self) -> list[str]:
        """Names of the measured points."""
        return self._read_text("points").decode("utf-8", "replace").split("\n")[:-1]

    @property
    def block_materials(self) -> np.ndarray:
        """Number of each block's present material, from 0 in the order of the input."""
        return self._read_table("blocks")[:, 0].astype(int)

    @property
    def edge_joints(self) -> np.ndarray:
        """Number of each edge's present joint, shape (edges,), from 0, in the order of `polygons`.

        An edge has the index of the vertex where it begins.
        """
        return self._read_table("edges")[:, 1].astype(int)

    @property
    def block_bodies(self) -> np.ndarray:
        """Number of the body of each cell, shape (blocks,), from 1; 0: the block is no cell."""
        return self._read_table("blocks")[:, 1].astype(int)

    @property
    def welded_edges(self) -> np.ndarray:
        """1 for edges within a body, 0 for others; shape (edges,), in the order of `polygons`."""
        return self._read_table("edges")[:, 2].astype(int)

    @property
    def coordinates(self) -> np.ndarray:
        """Block coordinates, shape (blocks, 6): x, y (m), rotation (rad), strains ex, ey, gxy."""
        return self._read_table("coordinates").T

    @property
    def removed_blocks(self) -> np.ndarray:
        """Whether each block has been removed by a stage, shape (blocks,), bool."""
        return self._read_table("blocks")[:, 2].astype(bool)

    @property
    def block_states(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """`coordinates`, `rates` and `stresses` at the same time."""
        with self._lock:
            return self.coordinates, self.rates, self.stresses

    @property
    def rates(self) -> np.ndarray:
        """Rates of the coordinates, shape (blocks, 6), per second; may be set."""
        return self._read_table("rates").T

    @rates.setter
    def rates(self, values) -> None:
        values = floats("rates", values)
        n = len(self.rates)
        if values.shape != (n, 6):
            raise InputError(f"rates must have shape ({n}, 6), not {values.shape}")
        self._call_engine("set_block_states", values.T)

    @property
    def stresses(self) -> np.ndarray:
        """Block stresses in the model's axes, shape (blocks, 3): sigma_x, sigma_y, tau_xy, Pa."""
        return self._read_table("stresses").T

    @property
    def stress_errors(self) -> np.ndarray:
        """Estimated stress errors of cells from the stress jumps at faces, shape (blocks,), Pa.

        The estimate is the uniaxial-strain stress with the energy of the jumps; 0 for other blocks.
        """
        return self._read_table("stress_errors")[0]

    @property
    def plastic_strains(self) -> np.ndarray:
        """Largest plastic strain within each block, shape (blocks,); 0 without yielding.

        The plastic strain is the accumulated strain on which softening ('mohr_coulomb') depends.
        """
        return self._read_table("plastic_strains")[0]

    @property
    def edge_damages(self) -> np.ndarray:
        """Damage of the welded faces of each edge, shape (edges,): 0 intact, 1 broken."""
        return self._read_table("edge_damages")[0]

    @property
    def loads(self) -> np.ndarray:
        """Forces of weight, loads, water and supports on each block, shape (blocks, 6).

        Forces in x and y (N/m), moment about the centroid (N), forces conjugate to the strains (N).
        """
        return self._read_table("loads").T

    @property
    def polygons(self) -> list[np.ndarray]:
        """Vertices of each block, shape (vertices, 2), m, counter-clockwise."""
        owner = self._read_table("edges")[:, 0]
        begin = np.flatnonzero(np.diff(owner, prepend=-1, append=-1))
        return parts_of(self._read_table("vertices").T, begin)

    @property
    def contacts(self) -> dict[str, np.ndarray]:
        """Contacts of the last step.

        ``vertex`` and ``edge`` (from 0), ``state`` (0 open, 1 slide, 2 stick), ``bonded``,
        ``joint`` (from 0, in the order of the input);
        ``gap`` (m), ``normal_force`` and ``shear_force`` (N/m), ``stretch`` (m). Under joint laws:
        ``length`` (m) that a contact represents, ``slip_path`` (m), ``weakened`` (0 … 1), and
        ``place``, the position of a point between corners as fraction of the edge that begins at
        ``vertex``; 0 for corners.  With cohesive joints: ``damage`` (0 … 1), and bounds of the
        dissipated energy per area, ``fracture_energy_lower`` and ``fracture_energy_upper`` (N/m).
        """
        table = dict(zip(engine_names("contacts"), self._read_table("contacts").T, strict=True))
        return table | {name: table[name].astype(int) for name in engine_names("whole contacts")}

    @property
    def closed_contacts(self) -> np.ndarray:
        """Contacts under compression in the last step, shape (contacts, 5).

        Vertex and edge (from 0), `place`, normal and shear force (N/m), as in `contacts`.
        """
        return self._read_table("closed contacts")

    @property
    def boundary_edges(self) -> dict[str, np.ndarray]:
        """Parts of edges that belong to groups ``&boundary``, each array of shape (parts,).

        ``edge`` (by its first vertex) and ``group`` (in the order of the input), both from 0;
        ``from`` and ``to``: start and end of the part as fractions of the edge.
        """
        edge, group, *fractions = self._read_table("boundary_edges").T
        values = (edge.astype(int), group.astype(int), *fractions)
        return dict(zip(("edge", "group", "from", "to"), values, strict=True))

    @property
    def bolts(self) -> dict[str, np.ndarray]:
        """States of bolts after the last step, each of shape (bolts,), in the order of the output.

        ``force`` along the bolt (tension positive), ``shear_force`` of a grouted bolt (N/m),
        ``elongation`` (m), ``state`` (0 absent, 1 elastic, 2 yielding, 3 slack, 4 broken).
        """
        names = ("force", "shear_force", "elongation", "state")
        values = dict(zip(names, self._read_table("bolts"), strict=True))
        return values | {"state": values["state"].astype(int)}

    @property
    def water(self) -> dict[str, np.ndarray]:
        """State of the water in the channels of joints after the last step.

        ``pressure`` (Pa) and ``saturation`` at both ends, each of shape (channels, 2), ``flux``
        from the first to the second end (m²/s), (channels,), initial ``places`` of the ends (m),
        (channels, 2, 2), and a ``block`` beside each channel, (channels,).
        """
        table = self._read_table("water")
        return {
            "pressure": table[:2].T,
            "saturation": table[2:4].T,
            "flux": table[4],
            "places": table[5:9].T.reshape(-1, 2, 2),
            "block": table[9].astype(int),
        }

    @property
    def energies(self) -> dict[str, float]:
        """Energies, J per metre of thickness; ``balance`` is the residual of the budget."""
        values = map(float, self._read_table("energies")[0])
        return dict(zip(engine_names("energies"), values, strict=True))

    @property
    def maxima(self) -> dict[str, Maximum]:
        """The largest values of all steps so far, by name, as `Run.maxima`.

        The ``residual`` of each is the present value.
        """
        names, units = engine_names("maxima"), engine_names("maxima units")
        table = self._read_table("maxima")
        values, (blocks, points) = table[:3], np.split(table[3:].astype(int), 2)
        block_names = [name or f"block {i + 1}" for i, name in enumerate(self.block_names)]
        rows = zip(names, units, *values, blocks.T, points.T, strict=True)
        return as_maxima(rows, block_names, self.point_names)

    @property
    def counts(self) -> dict[str, int]:
        """Counts since the start.

        ``steps``; open-close ``iterations``; neighbour ``searches``; linear systems (``solves``),
        computed ``factors``, ``solver_iterations``, systems ``handed_over`` to the direct solver;
        ``broken`` bonds.
        """
        values = map(int, self._read_table("counts")[0])
        return dict(zip(engine_names("counts"), values, strict=True))

    @property
    def solver(self) -> str:
        """The present linear solver, which ``'auto'`` may change."""
        return self._read_line("solver")

    def block_notes(self) -> str:
        """Return notes on removed and merged blocks and on slivers."""
        from ..build.cutting.small_blocks import in_words, slivers

        cut_note = in_words(self.built.slivers)  # replaced by a note on the present slivers
        notes = [note for note in self.built.messages if note != cut_note]
        return "\n".join(filter(None, [*notes, in_words(slivers(self.polygons, self.block_names))]))

    def phase_times(self) -> dict[str, float]:
        """Return the time of each phase of the steps (s) since the first call of this method.

        ``search`` (neighbours, symbolic factorisation), ``detect`` (contacts and their history),
        ``assemble``, ``factorise``, ``solve``, ``iterate`` (open-close iteration without solves)
        and ``update`` (new state, energy audit).
        """
        values = map(float, self._read_table("phases")[0])
        return dict(zip(engine_names("phases"), values, strict=True))

    @property
    def point_motions(self) -> np.ndarray:
        """Displacements, velocities and accelerations of points, shape (3, points, 2), SI."""
        return np.swapaxes(self._read_table("points").T.reshape(-1, 3, 2), 0, 1)

    @property
    def base_displacement(self) -> np.ndarray:
        """Displacement of the base since the first frame, shape (2,), m; 0 without a motion."""
        return self._read_table("base")[:, 0]


def run_to_end(
    simulation: Simulation, progress: Callable[[Simulation], None] | None, stop: Stop
) -> bool:
    """Advance in chunks until the end or a stop request; return whether the run has ended.

    `progress`: called after each chunk.
    `stop`: watches for signals.
    """
    chunk = 1
    try:
        while not stop.requested:
            start = time.perf_counter()
            ended = simulation.advance(chunk)
            if progress:
                progress(simulation)
            if ended:
                return True
            if time.perf_counter() - start < _CHUNK_TIME:
                chunk *= 2
            elif chunk > 1:
                chunk //= 2
    except KeyboardInterrupt:
        if program_handles_interrupt():
            raise
    except BaseException as error:
        try:
            simulation.finish()
        except OutputError as failure:  # append it to the error that ended the run
            if not isinstance(error, SiteddaError):
                raise
            raise type(error)(f"{error}; {failure}") from error
        raise
    return False


@contextmanager
def completed_run(
    file,
    output,
    progress: Callable | None = None,
    signals=SIGNALS,
    waits: bool = False,
    **options,
) -> Iterator[tuple[Path, Simulation]]:
    """Run an input to its end; yield its output and the finished simulation.

    `progress`, `signals`: see `run_to_end` and `Stop`; `options`: see `Simulation`.
    `waits`: a signal takes effect only after the model has been built.
    A signal raises InterruptedRun; the output then contains the results so far.
    """
    stop = Stop(signals, program=signals == SIGNALS)
    with ExitStack() as stack:
        if waits:
            stack.enter_context(stop)
        simulation = stack.enter_context(Simulation(file, output, **options))
        if not waits:
            stack.enter_context(stop)
        is_complete = run_to_end(simulation, progress, stop)
        path = simulation.finish()
        if not is_complete:
            raise InterruptedRun("interrupted")
        yield path, simulation
