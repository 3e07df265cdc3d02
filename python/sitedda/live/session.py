# SPDX-License-Identifier: GPL-3.0-or-later
"""The session of a user: start page, edited model and run.

A thread of the server executes commands in order.  Drawing, checking, running and saving have
separate threads or processes.  Their messages are sent to all open pages.
"""

import threading
import time
import traceback
from collections.abc import Callable
from pathlib import Path

from ..base.errors import InputError, SiteddaError
from ..base.files import is_below, make_folder, write
from .checker import Checker
from .document import Document, locate_error
from .drawn import card, draw_model
from .journal import Journal
from .running import END_STATUSES, ENDED, LiveRun
from .saving import ENDINGS, place, save_movie, save_namelist, save_output, save_report, save_script
from .starts import EMPTY, BundledFiles

_MOST_FILES = 500  # largest number of inputs on the start page
# Commands that are methods of Document, methods of LiveRun that start a run, and other methods:
_EDITS = ("write", "add", "take_out", "undo", "redo")
_START_COMMANDS = ("rest", "run", "step")
_CONTROLS = ("pause", "stop", "change", "stage")


class Session:
    """The state that all pages of a server show.

    `folder`: the working folder, in which inputs are opened and saved.
    `publish`: called with a message for all pages, a dict or bytes, from any thread.
    `is_page_open`: returns whether a page is open.
    """

    def __init__(
        self,
        folder: Path,
        journal: Journal,
        bundled_files: BundledFiles,
        publish: Callable,
        is_page_open: Callable,
    ):
        self.folder, self.journal, self.bundled_files = folder, journal, bundled_files
        self.publish, self._watched = publish, is_page_open
        self.document: Document | None = None
        self.run: LiveRun | None = None
        self._drawn: bytes | None = None
        self._opened = 0  # number of models that have been opened
        # last message of each kind that new pages receive
        self._last_messages: dict[str, dict] = {}
        self._cards: dict[str, dict] = {}
        self._cards_requested = False
        self._work = threading.Condition()
        self._requested_version = 0  # number of requested drawings
        self._closing = False
        self._checker = Checker(self._publish)
        self._saver = threading.Lock()
        threading.Thread(target=self._draw_repeatedly, name="draw", daemon=True).start()

    # --- pages ----------------------------------------------------------------------------------

    def welcome(self) -> list[dict | bytes]:
        """Return the messages for a new page."""
        messages: list[dict | bytes] = [self._start_message()]
        if self.document is None:
            if not self._cards_requested:
                self._cards_requested = True
                threading.Thread(target=self._send_thumbnails, name="cards", daemon=True).start()
            return [*messages, *self._cards.values()]
        messages.append(self._model_message())
        if self.run is None:
            messages += [self._drawn] if self._drawn else []
        else:
            messages += [self.run.drawn] if self.run.drawn else []
            messages += [*self.run.frames, self.run.described()]
        persistent = ("good", "trouble", "check")
        return messages + [m for kind, m in self._last_messages.items() if kind in persistent]

    def _start_message(self) -> dict:
        """Return the message with the content of the start page."""
        files = sorted(f.name for f in self.folder.glob("*.nml") if f.is_file())[:_MOST_FILES]
        return {
            "kind": "start",
            "screen": "start" if self.document is None else "model",
            "folder": str(self.folder),
            "examples": {name: text for name, (text, _) in self.bundled_files.examples.items()},
            "files": files,
            "records": sorted(self.bundled_files.records),
            "endings": ENDINGS,
        }

    def _model_message(self) -> dict:
        """Return the message with the edited input."""
        message = {"kind": "model", "running": self.run is not None, "opened": self._opened}
        return message | self.document.described()

    def _send_thumbnails(self) -> None:
        """Send small pictures of the examples to all pages."""
        for name, (_, file) in self.bundled_files.examples.items():
            try:
                outlines = card(file.read_text(encoding="utf-8"), file)
            except SiteddaError:
                continue
            self._cards[name] = {"kind": "card", "name": name} | outlines
            self.publish(self._cards[name])
            if self._closing:
                return

    # --- commands -------------------------------------------------------------------------------

    def carry_out(self, command: str, fields: dict) -> None:
        """Execute a command of a page."""
        if command in _EDITS:
            getattr(self._editable_document(), command)(**fields)
            self._save_edit()
        elif command in _START_COMMANDS:
            getattr(self._run_or_start(), command)(**fields)
        elif command in _CONTROLS:
            getattr(self._active_run(), command)(**fields)
        else:
            getattr(self, f"_do_{command}")(**fields)

    def _do_open(self, source: str, name: str) -> None:
        """Open an empty model, an example, or a file of the working folder."""
        if source == "empty":
            self.open_text(EMPTY, self.folder / "model.nml")
        elif source == "example":
            if name not in self.bundled_files.examples:
                raise InputError(f"there is no example {name!r}")
            file = self.bundled_files.examples[name][1]
            self.open_text(file.read_text(encoding="utf-8"), file)
        elif source == "file":
            file, folder = self.folder / name, self.folder.resolve()
            if not is_below(self.folder, name) or not file.resolve().is_relative_to(folder):
                raise InputError(f"{name!r} is not a file in {self.folder}")
            self.open_file(file)
        else:
            raise InputError(f"{source!r} cannot be opened")

    def open_file(self, file: Path) -> None:
        """Open an input."""
        from ..input.source import read_input

        self.open_text(read_input(file), file)

    def open_text(self, text: str, file: Path) -> None:
        """Open a text for editing; its file need not exist."""
        document = Document(text, file)
        self._end_run()
        self.document = document
        self._opened += 1
        self._save_edit()
        self.publish(self._start_message())

    def _do_leave(self) -> None:
        """Close the model and show the start page."""
        self._end_run()
        self._checker.stop()
        self.document, self._drawn = None, None
        self._last_messages.clear()
        self.journal.keep("model", None)
        for message in self.welcome():
            self.publish(message)

    def _editable_document(self) -> Document:
        """Return the document; raise an error if there is none or a run exists."""
        if self.document is None:
            raise InputError("there is no model; open one first")
        if self.run is not None:
            raise InputError("a model cannot be edited during its run; leave the run first")
        return self.document

    def _do_set(self, group: str, number: int, variable: str, value: str | None) -> None:
        """Set a variable; report an invalid value at its field."""
        try:
            self._editable_document().set(group, number, variable, value)
        except InputError as error:
            field = {"group": group, "number": number, "variable": variable}
            self._publish({"kind": "trouble", "message": str(error)} | field)
            return
        self._save_edit()

    def _do_settle(self) -> None:
        """End a series of edits that are undone together."""
        if self.document is not None:
            self.document.settle()

    def _do_record(self, number: int, name: str) -> None:
        """Assign a shipped record to a motion; copy it if the model is in the working folder."""
        document, records = self._editable_document(), self.bundled_files.records
        if name not in records:
            raise InputError(f"there is no record {name!r}")
        if document.file.parent.resolve() == self.folder.resolve():
            make_folder(self.folder / "records")
            write(self.folder / "records" / name, records[name].read_bytes(), "the example")
        for variable in ("values", "time_step", "quantity", "unit"):
            document.set("motion", number, variable, None)
        document.set("motion", number, "file", f"records/{name}")
        self._save_edit()

    def _do_check(self) -> None:
        """Start a check of the model."""
        document = self._editable_document()
        self._checker.start(document.text, document.file, document.version)

    def _save_edit(self) -> None:
        """Store the edited model, inform the pages and request a drawing."""
        document = self.document
        self.journal.keep("model", {"file": str(document.file), "text": document.text})
        self._checker.stop()
        self._last_messages.pop("check", None)
        self._last_messages.pop("trouble", None)
        self.publish(self._model_message())
        with self._work:
            self._requested_version += 1
            self._work.notify()

    # --- drawing --------------------------------------------------------------------------------

    def _draw_repeatedly(self) -> None:
        """Draw the latest version after each edit, until the session ends."""
        drawn_version = 0
        while not self._closing:
            with self._work:
                while not self._closing and self._requested_version == drawn_version:
                    self._work.wait()
                document, drawn_version = self.document, self._requested_version
            if document is not None and self.run is None and not self._closing:
                self._draw_version(document, document.version, document.text)

    def _draw_version(self, document: Document, version: int, text: str) -> None:
        """Draw a version, and send the drawing if no other document or run has started."""
        start = time.perf_counter()
        try:
            drawing = draw_model(text, document.file, version=version)
        except SiteddaError as error:
            failure = {"kind": "trouble", "message": str(error), "version": version}
            self._publish(failure | locate_error(str(error), text, document.file))
            return
        except Exception as error:
            traceback.print_exc()
            self._publish({"kind": "trouble", "message": f"an error in sitedda: {error}"})
            return
        if document is not self.document or self.run is not None:
            return
        self._last_messages.pop("trouble", None)
        self._drawn = drawing.message
        self.publish(drawing.message)
        elapsed = time.perf_counter() - start
        self._publish({"kind": "good", "version": version, "seconds": elapsed})

    def _publish(self, message: dict) -> None:
        """Send a message to all pages, and store it for pages that open later."""
        self._last_messages[message["kind"]] = message
        self.publish(message)

    # --- run ------------------------------------------------------------------------------------

    def _run_or_start(self) -> LiveRun:
        """Return the run; start one if there is none."""
        if self.run is None:
            document = self._editable_document()
            self._checker.stop()
            self.journal.forget_run()
            self._start_run(document, None)
        return self.run

    def _start_run(self, document: Document, actions: list[dict] | None) -> None:
        """Start a run; if actions are given, continue the stored run that had them."""
        text, file = document.text, document.file

        def store_actions(actions: list[dict]) -> None:
            state = {"file": str(file), "text": text, "actions": actions}
            self.journal.keep("run", state)

        store_actions(actions or [])
        self.run = LiveRun(text, file, self.journal.output, self.publish, self._watched,
                           store_actions, actions)  # fmt: skip
        self.publish(self._model_message())

    def _end_run(self) -> None:
        if self.run is not None:
            run, self.run = self.run, None
            run.close()
            self.journal.forget_run()

    def _active_run(self) -> LiveRun:
        """Return the run; raise an error if there is none or it has ended."""
        if self.run is None:
            raise InputError("there is no run; start one first")
        if self.run.status in END_STATUSES:
            raise InputError(ENDED)
        return self.run

    def _do_back(self) -> None:
        """Leave the run and return to the edited model."""
        self._end_run()
        if self.document is not None:
            self._save_edit()

    def recover(self) -> bool:
        """Continue the session of the last server of this folder; return whether there is one."""
        model, run = self.journal.kept("model"), self.journal.kept("run")
        if model is None:
            return False
        try:
            self.document = Document(str(model["text"]), str(model["file"]))
            if run is not None:
                actions = list(run["actions"])
                self.document.text = str(run["text"])
        except (KeyError, TypeError):
            self.document = None
            return False
        self._save_edit()
        if run is not None:
            self._start_run(self.document, actions)
        return True

    # --- saving ---------------------------------------------------------------------------------

    def _do_save(self, what: str, name: str) -> None:
        """Save an input, script, report, movie or output in the working folder, in a thread."""
        target = place(self.folder, name, what)
        if self.document is None:
            raise InputError("there is no model; open one first")
        if what in ("report", "movie", "output"):
            if self.run is None or self.run.result is None:
                raise InputError(f"a run must end before its {what} is saved; stop or wait")
            self.publish({"kind": "saving", "what": what})
        save, arguments = self._save_and_report, (what, target)
        threading.Thread(target=save, args=arguments, name="save", daemon=True).start()

    def _save_and_report(self, kind: str, target: Path) -> None:
        """Write a file and send its name, or the error, to the page."""
        with self._saver:
            try:
                files = self._write_files(kind, target)
            except Exception as error:  # the page must receive a response to any failure
                message = str(error) or type(error).__name__
                self.publish({"kind": "refused", "message": message, "what": kind})
                return
        names = [str(file.relative_to(self.folder)) for file in files]
        self.publish({"kind": "saved", "what": kind, "files": names, "folder": str(self.folder)})

    def _write_files(self, kind: str, target: Path) -> list[Path]:
        """Write a file of a kind, and the files that it needs; return their paths."""
        run, document = self.run, self.document
        if kind == "namelist":
            text = document.text if run is None else run.namelist
            actions = [] if run is None else run.actions
            return save_namelist(text, document.file, target, actions)
        if kind == "script":
            model = target.with_name(f"{target.stem}_input.nml")
            files = save_namelist(document.text, document.file, model, [])
            actions, steps = ([], None) if run is None else (run.actions, run.steps_to_repeat)
            return [save_script(model, target, target.stem, actions, steps), *files]
        save = {"report": save_report, "movie": save_movie, "output": save_output}[kind]
        return [save(run.result, target)]

    def close(self) -> None:
        """End all threads; model and run remain stored in the journal."""
        self._closing = True
        self._checker.stop()
        with self._work:
            self._work.notify()
        if self.run is not None:
            self.run.close()
