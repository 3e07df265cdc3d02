# SPDX-License-Identifier: GPL-3.0-or-later
"""A run in a separate thread, which the user controls: run, pause, step, stop, changes, stages.

The engine runs for about 1/30 s at a time without the lock of the interpreter. Between these
intervals, the thread executes commands and sends frames to open pages.
"""

import hashlib
import queue
import re
import signal
import threading
import time
import warnings
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import numpy as np

from ..base.core import api
from ..base.errors import InputError, InterruptedRun, SiteddaError
from ..engine.simulation import Simulation
from ..input.added_stage import PresentStage, with_stage
from ..input.changes import Typed
from ..input.source import InputOfRun
from .drawn import draw_simulation
from .frames import Frames, frame_message

_CHUNK_TIME = 0.03  # s for which the engine runs between checks for commands
_FRAME = 0.04  # s between frames, or more if they need more than `_FRAME_FRACTION`
_FRAME_FRACTION = 0.04  # of the processor time
_IDLE_FRAME = 1.0  # s between frames while no page is open
_STATUS = 0.2  # s between reports of progress
_CHECKPOINT = 5.0  # s between checkpoints, or more if checkpoints need more than 1 % of the time
_TO_THE_END = 2**31 - 1  # largest number of steps in a call of the engine
END_STATUSES = ("done", "stopped", "failed")
ENDED = "the run has ended and cannot be changed; edit the model to run it with other values"


class LiveRun:
    """A run of an input.

    `text`: the input.
    `file`: file of the input.
    `output`: output of the run, in a private folder.
    `publish`: called with messages for the page, from the thread of the run.
    `is_page_open`: returns whether a page is open.
    `store_actions`: called with all actions of the run before a checkpoint is written.
    `actions`: actions, as in `script.py`, of an earlier run that is continued.
    """

    def __init__(
        self,
        text: str,
        file: Path,
        output: Path,
        publish: Callable,
        is_page_open: Callable[[], bool],
        store_actions: Callable[[list[dict]], None],
        actions: list[dict] | None = None,
    ):
        self.text, self.file, self.output = text, file, output
        self.actions = list(actions or [])
        self.resumes = actions is not None
        self.frames = Frames()
        self.status = "opening"
        self.trouble: dict = {}
        self.words: dict = {}
        self.result: Path | None = None
        self.drawn = b""
        self._publish, self._watched, self._keep = publish, is_page_open, store_actions
        self._tasks: queue.Queue = queue.Queue()
        self._simulation: Simulation | None = None
        self._chunk = 1
        self._last_frame = self._last_report = self._saved = 0.0
        self._time_used = self._frame_cost = 0.0  # processor time up to, and of, the last frame, s
        self._speeds: list[tuple[float, float]] = []
        self._has_begun = self._closing = self._interrupted = False
        self._thread = threading.Thread(target=self._run_thread, name="run", daemon=True)
        self._thread.start()

    # --- commands -----------------------------------------------------------------------------

    def rest(self) -> None:
        """Compute the static equilibrium before the first dynamic step, then pause."""
        self._tasks.put(self._find_equilibrium)

    def run(self) -> None:
        """Compute steps until the end of the run or a pause."""
        self._tasks.put(lambda: self._set_status("running"))

    def pause(self) -> None:
        """Pause the run after the present step."""
        self._tasks.put(self._pause_run)

    def step(self, steps: int) -> None:
        """Compute a number of steps, then pause."""
        self._tasks.put(lambda: self._take_steps(steps))

    def stop(self) -> None:
        """End the run at the present time and keep its results."""
        self._interrupt()
        self._tasks.put(self._stop_run)

    def change(self, values: dict[str, str]) -> None:
        """Change variables of the input from the present time; values are texts as in the input."""
        self._tasks.put(lambda: self._apply_action({"do": "change", "changes": values}))

    def stage(self, values: dict[str, str]) -> None:
        """Begin a stage after the present step; values are texts as in the input."""
        if "name" not in values:
            raise InputError("a stage needs a name")
        self._tasks.put(lambda: self._apply_action({"do": "stage", "values": values}))

    def close(self) -> None:
        """End the thread; keep the results and a checkpoint."""
        self._closing = True
        self._interrupt()
        self._tasks.put(None)
        self._thread.join()

    def _interrupt(self) -> None:
        """Interrupt a long static stage or step in the engine."""
        if self.status in ("resting", "running"):
            self._interrupted = True
            api.stop_engine(signal.SIGINT)

    # --- thread -------------------------------------------------------------------------------

    def _run_thread(self) -> None:
        """Open the simulation, execute commands and advance the run until `close` is called."""
        try:
            self._open_simulation()
            while not self._closing:
                self._execute_commands()
                if self.status == "running" and not self._closing:
                    self._advance_run()
        except Exception as error:  # faults of the program are reported as well
            self._report_failure(error)
        finally:
            self._close_simulation()

    def _execute_commands(self) -> None:
        """Execute the commands in the queue; while the run does not advance, wait for commands."""
        wait = self.status != "running"
        while not self._closing:
            try:
                task = self._tasks.get(block=wait, timeout=None)
            except queue.Empty:
                return
            wait = False
            if task is None:
                continue
            if self.status in END_STATUSES:
                self._publish({"kind": "refused", "message": ENDED})
                continue
            try:
                task()
            except SiteddaError as error:
                if self.status == "failed" or self._simulation is None:
                    raise
                self._publish({"kind": "refused", "message": str(error)})
            wait = self.status != "running"

    def _open_simulation(self) -> None:
        """Draw the model and start its simulation, or continue the simulation of an earlier run."""
        source = InputOfRun(self.file, self.text)
        with Simulation(source, drawn=True) as model:
            drawing = draw_simulation(model, run=True)
        self.drawn, self._start = drawing.message, drawing.start.copy()
        self._publish(self.drawn)
        if not self.resumes:
            self._simulation = Simulation(source, output=self.output, drawn=True)
            self._set_status("ready")
            return
        self._simulation = Simulation(source, output=self.output, resume=True)
        self._set_reference(_first_positions(self.output))
        self._repeat_actions()
        self._send_frame()
        self._set_status("paused")

    def _advance_steps(self, steps: int) -> bool:
        """Compute steps; return whether the run has ended.

        As in the output, displacements count from the end of an initial static stage.
        """
        if not self._has_begun:
            self._simulation.advance(0)
            self._set_reference(self._simulation.coordinates[:, :3])
        return self._simulation.advance(steps)

    def _set_reference(self, positions: np.ndarray) -> None:
        """Set the reference of displacements: positions (m) and rotations, shape (blocks, 3)."""
        self._start[:, :3] = positions
        self._has_begun = True

    def _repeat_actions(self) -> None:
        """Repeat the actions that followed the checkpoint from which the run continues."""
        simulation = self._simulation
        current_key = _input_key(simulation)
        matches = [i for i, a in enumerate(self.actions, 1) if a["mark"] == current_key]
        for action in self.actions[max(matches, default=0) :]:
            if simulation.steps < action["step"]:
                simulation.advance(action["step"] - simulation.steps)
            self._execute_action(action)

    def _find_equilibrium(self) -> None:
        self._set_status("resting")
        self._report_if_failed(lambda: self._advance_steps(0))
        if self.status == "resting" and not self._closing:
            self._send_frame()
            self._set_status("paused")

    def _take_steps(self, steps: int) -> None:
        self._set_status("running")
        self._report_if_failed(lambda: self._close_if_ended(self._advance_steps(steps)))
        if self.status == "running":
            self._send_frame()
            self._set_status("paused")

    def _pause_run(self) -> None:
        if self.status == "running":
            self._send_frame()
            self._write_checkpoint()
            self._set_status("paused")

    def _stop_run(self) -> None:
        if self.status in END_STATUSES:
            return
        self._send_frame()
        self._close_output("stopped")

    def _advance_run(self) -> None:
        """Compute steps for about `_CHUNK_TIME` seconds; then report and store if this is due."""
        start = time.perf_counter()
        self._report_if_failed(lambda: self._close_if_ended(self._advance_steps(self._chunk)))
        elapsed = time.perf_counter() - start
        if elapsed < 0.5 * _CHUNK_TIME:
            self._chunk = min(2 * self._chunk, _TO_THE_END)
        elif elapsed > _CHUNK_TIME:
            self._chunk = max(1, self._chunk // 2)
        time_now = time.perf_counter()
        if self.status != "running":
            return
        interval = _FRAME if self._watched() else _IDLE_FRAME
        is_affordable = time.thread_time() - self._time_used > self._frame_cost / _FRAME_FRACTION
        if time_now - self._last_frame > interval and is_affordable:
            self._send_frame()
        if time_now - self._last_report > _STATUS:
            self._send_progress()
        if time_now - self._saved > _CHECKPOINT:
            self._write_checkpoint()

    def _report_if_failed(self, function: Callable) -> None:
        """Execute some work; if it fails, report this and keep the earlier results."""
        try:
            function()
        except InterruptedRun as error:
            if not self._interrupted:
                self._report_failure(error)
        except SiteddaError as error:
            self._report_failure(error)
        finally:
            if self._interrupted:
                self._interrupted = False
                api.stop_engine(0)

    def _close_if_ended(self, ended: bool) -> None:
        if ended:
            self._send_frame()
            self._close_output("done")

    def _apply_action(self, action: dict) -> None:
        """Execute an action and store it with its step, time, stage and resulting input."""
        simulation = self._simulation
        stage = asdict(simulation.present_stage)
        action = {"step": simulation.steps, "time": simulation.time, "stage": stage} | action
        self._execute_action(action)
        self.actions.append(action | {"mark": _input_key(simulation)})
        self._keep(self.actions)
        self._write_checkpoint()
        self._send_progress()

    @property
    def steps_to_repeat(self) -> int | None:
        """Return the number of steps of a stopped run; None if the run is complete."""
        return None if self.status == "done" else self.words.get("step")

    @property
    def namelist(self) -> str:
        """Return the input with the added stages."""
        text = self.text
        for action in self.actions:
            if action["do"] == "stage":
                name, kind, values = _stage_values(action)
                stage = PresentStage(**action["stage"])
                text = with_stage(text, stage, self.file, name, kind, values)
        return text

    def _execute_action(self, action: dict) -> None:
        if action["do"] == "change":
            self._simulation.change({k: Typed(v) for k, v in action["changes"].items()})
        else:
            name, kind, values = _stage_values(action)
            self._simulation.begin_stage(name, kind, **values)

    # --- reports ------------------------------------------------------------------------------

    def _set_status(self, status: str) -> None:
        """Set the status, restart the measurement of speed and report to the page."""
        self.status = status
        self._speeds.clear()
        self._send_progress()

    def described(self) -> dict:
        """Return the progress of the run for the page."""
        return {"kind": "run", "status": self.status, "actions": self.actions} | self.words

    def _send_progress(self) -> None:
        """Send time, steps and the estimated remaining time (s) to the page."""
        simulation, clock = self._simulation, time.perf_counter()
        self._last_report = clock
        if simulation is not None and simulation.is_open:
            self._speeds = [*self._speeds[-40:], (clock, simulation.time)]
            (t0, s0), (t1, s1) = self._speeds[0], self._speeds[-1]
            remaining = (simulation.duration - s1) * (t1 - t0) / (s1 - s0) if s1 > s0 else None
            names = ("time", "duration", "iterations", "time_step", "summary")
            self.words |= {name: getattr(simulation, name) for name in names}
            self.words |= {"step": simulation.steps, "left": remaining}
        self._publish(self.described())

    def _send_frame(self) -> None:
        self._last_frame, self._time_used = time.perf_counter(), time.thread_time()
        message = frame_message(self._simulation, self._start)
        self.frames.add(message)
        self._publish(message)
        self._frame_cost = time.thread_time() - self._time_used

    def _write_checkpoint(self) -> None:
        """Write a checkpoint; wait at least 100 times its duration until the next one."""
        start = time.perf_counter()
        self._simulation.checkpoint()
        elapsed = time.perf_counter() - start
        self._saved = start + max(0.0, 100.0 * elapsed - _CHECKPOINT)

    # --- ends ---------------------------------------------------------------------------------

    def _close_output(self, status: str, **attributes) -> None:
        """Close the output; report its verdict, `attributes` values and the status."""
        simulation = self._simulation
        self._send_progress()
        message = {"doubts": [], "lines": [], "audit": simulation.warning} | attributes
        output = simulation.finish()
        self.result = output if output.exists() else output.with_name(f"{output.name}.partial")
        try:
            message |= _read_verdict(self.result)
            message["doubts"] = [w for w in (simulation.warning, *simulation.peak_warnings) if w]
        except SiteddaError as error:
            message["doubts"].append(str(error))
        self.words |= {"verdict": message, "ending": simulation.ending}
        self._set_status(status)

    def _report_failure(self, error: BaseException) -> None:
        """Close the output, and report an error and the blocks that its message names."""
        text = str(error) or type(error).__name__
        message: dict = {"failure": text, "blocks": self._named_blocks(text)}
        try:
            if self._simulation is not None and self._simulation.steps > 0:
                self._send_frame()
                self._close_output("failed", **message)
                return
        except SiteddaError as second_error:
            message["failure"] += f"; {second_error}"
        self.words |= {"verdict": {"lines": [], "doubts": []} | message}
        self._set_status("failed")

    def _named_blocks(self, message: str) -> list[int]:
        """Return the indices of the blocks that a message names."""
        if self._simulation is None or not self._simulation.is_open:
            return []
        indices = dict.fromkeys(int(number) - 1 for number in re.findall(r"\bblock (\d+)", message))
        return [index for index in indices if index < len(self._start)]

    def _close_simulation(self) -> None:
        try:
            if self._simulation is not None:
                self._simulation.close()
        except SiteddaError:
            pass  # the data that can be stored have been stored


def _stage_values(action: dict) -> tuple[str, str, dict[str, Typed]]:
    """Return name, kind and other values of a stage."""
    values = {name: Typed(value) for name, value in action["values"].items()}
    return str(values.pop("name")), str(values.pop("kind", "dynamic")), values


def _first_positions(output: Path) -> np.ndarray:
    """Return positions (m) and rotations of the blocks in the first frame of an open output."""
    from ..output.output_file import load
    from ..output.scene import Scene

    return Scene(load(output.with_name(f"{output.name}.partial"))).coordinates(0)[:, :3]


def _input_key(simulation: Simulation) -> str:
    """Return a key that identifies the present input."""
    return hashlib.sha256(simulation.present_input.encode("utf-8", "surrogateescape")).hexdigest()


def _read_verdict(output: Path) -> dict:
    """Return the verdict and all histories of an output in the form that the page draws."""
    from ..drawing.view.encode import Encoded, encode_histories
    from ..output.output_file import load
    from ..output.scene import Scene
    from ..output.verdict import verdict

    history = load(output)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        lines = verdict(history).lines
    encoded = Encoded()
    encode_histories(encoded, Scene(history))
    return {"lines": lines, "charts": encoded.meta["charts"], "streams": encoded.streams}
