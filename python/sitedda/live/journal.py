# SPDX-License-Identifier: GPL-3.0-or-later
"""Store the session of a server in a private folder, from which the next server continues it.

The model is written after each edit, before the page is informed.  Input and actions of a run are
written before they take effect.  The engine stores results and checkpoints in the same folder.
"""

import fcntl
import hashlib
import json
import os
from pathlib import Path

from ..base.errors import OutputError
from ..base.files import UNCHECKED, write
from .guard import private_folder

_MOST_SERVERS = 20  # largest number of servers of a working folder at a time


class Journal:
    """Storage of a session in the private folder that belongs to a working folder.

    `folder`: the working folder.  The private folder is readable by its owner only.
    """

    def __init__(self, folder: Path):
        key = hashlib.sha256(os.fsencode(folder.resolve())).hexdigest()[:16]
        for number in range(_MOST_SERVERS):
            self.folder = private_folder(state_folder() / f"{key}-{number}")
            self._lock = os.open(self.folder / "lock", os.O_RDWR | os.O_CREAT, 0o600)
            try:
                fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return
            except OSError:
                os.close(self._lock)
        raise OutputError(f"{_MOST_SERVERS} servers already use {folder}; end one of them")

    def close(self) -> None:
        """Release the folder for another server."""
        os.close(self._lock)

    def keep(self, name: str, value: dict | None) -> None:
        """Store plain values under a name, or delete them."""
        file = self.folder / f"{name}.json"
        if value is None:
            file.unlink(missing_ok=True)
        else:
            # Written data survive the end of the process, so synchronisation is not needed.
            write(file, json.dumps(value), UNCHECKED, sync=False)

    def kept(self, name: str) -> dict | None:
        """Return the stored value of a name; None if it is missing or damaged."""
        try:
            value = json.loads((self.folder / f"{name}.json").read_bytes())
        except (OSError, ValueError):
            return None
        return value if isinstance(value, dict) else None

    @property
    def output(self) -> Path:
        """Return the path of the output of the run."""
        return self.folder / "run.nc"

    def forget_run(self) -> None:
        """Delete the files of the last run."""
        self.keep("run", None)
        for file in self.folder.glob("run.nc*"):
            file.unlink(missing_ok=True)
        for file in self.folder.glob(".run.nc*"):
            file.unlink(missing_ok=True)


def state_folder() -> Path:
    """Return the folder in which the sessions of this user are stored."""
    home = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(home) / "sitedda" / "live"
