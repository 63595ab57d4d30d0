"""Every edit is written to a log beside the program's own files, so that a killed process loses at most its last second.

The log of a process that ended well is taken away; one that was left behind is offered at the next start. The user's
own file is never touched.
"""

from __future__ import annotations

import json
import os
import threading
import time
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QLockFile, QStandardPaths

from app.engine import document
from app.engine.catalogue import Catalogue
from app.engine.errors import NoniusError
from app.engine.network import Network

EVERY = 0.3
"""Seconds between two lines; edits between them become one."""
MOST = 8 << 20
"""Bytes of a log from which it is begun anew with its last line."""


def state_folder() -> Path:
    """Where the program keeps what it remembers: `$NONIUS_STATE`, or the platform's folder."""
    given = os.environ.get("NONIUS_STATE")
    if given:
        return Path(given)
    place = QStandardPaths.writableLocation(QStandardPaths.StandardLocation.GenericDataLocation)
    return Path(place) / "nonius" / "state"


@dataclass(frozen=True)
class Lost:
    """A document of a process that ended without closing.

    Parameters
    ----------
    log : its file
    path : of the document, None if it had none
    text : the network
    edits : after the last save
    at : seconds since 1970 of the last
    """

    log: Path
    path: Path | None
    text: str
    edits: int
    at: float

    @property
    def name(self) -> str:
        """As the user knows it."""
        return self.path.name if self.path else "an unsaved network"

    def network(self, catalogue: Catalogue) -> Network:
        """The network; paths of files in it are absolute."""
        return document.loads(self.text, catalogue, name="the recovery log").network

    def discard(self) -> None:
        """Forget it."""
        for file in (self.log, _lock_of(self.log)):
            file.unlink(missing_ok=True)


class Log:
    """The log of one window: a thread writes the newest network, some times a second.

    Parameters
    ----------
    catalogue : names the parameters that are paths
    folder : of the logs; below `state_folder` by default
    """

    def __init__(self, catalogue: Catalogue, folder: Path | None = None) -> None:
        self.folder = folder or state_folder() / "recovery"
        self.folder.mkdir(parents=True, exist_ok=True)
        self.file = self.folder / f"{os.getpid()}-{time.time_ns()}.jsonl"
        self.written = 0.0
        self._catalogue = catalogue
        self._lock = QLockFile(str(_lock_of(self.file)))
        self._lock.setStaleLockTime(0)
        self._lock.tryLock(0)
        self._some = threading.Condition()
        self._next: tuple[Network, Path | None, str, int] | None = None
        self._edits = 0
        self._fresh = False
        self._closed = False
        self._idle = True
        self._thread = threading.Thread(target=self._write_on, name="nonius-recovery", daemon=True)
        self._thread.start()

    def put(self, network: Network, path: Path | None, label: str) -> None:
        """Note an edit."""
        with self._some:
            self._edits += 1
            self._next = (network, path, label, self._edits)
            self._some.notify()

    def begin(self, network: Network | None, path: Path | None) -> None:
        """Another document, or a saved one: what was noted is no longer needed."""
        with self._some:
            self._edits, self._fresh, self._next = 0, True, None
            if network is not None:
                self._edits = 1
                self._next = (network, path, "", 1)
            self._some.notify()

    def flush(self, seconds: float = 5.0) -> bool:
        """Wait until all is written."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            with self._some:
                if self._next is None and not self._fresh and self._idle:
                    return True
            time.sleep(0.01)
        return False

    def close(self) -> None:
        """The window was closed: nothing is left to recover."""
        with self._some:
            self._closed = True
            self._some.notify()
        self._thread.join(5)
        self.file.unlink(missing_ok=True)
        self._lock.unlock()

    def _write_on(self) -> None:
        while True:
            with self._some:
                self._idle = True
                while self._next is None and not self._fresh and not self._closed:
                    self._some.wait()
                if self._closed:
                    return
                job, fresh = self._next, self._fresh
                self._next, self._fresh, self._idle = None, False, False
            try:
                self._write(job, fresh)
            except OSError:  # a full disk must not stop the window: it is tried again, until there is room
                with self._some:
                    if not self._fresh:  # else another document has begun
                        self._next, self._fresh = self._next or job, fresh
            except NoniusError:
                continue  # what cannot be written now is written with the next edit
            finally:
                time.sleep(EVERY)

    def _write(self, job: tuple[Network, Path | None, str, int] | None, fresh: bool) -> None:
        if job is None:
            self.file.unlink(missing_ok=True)
            return
        network, path, label, edits = job
        text = document.clipboard(network, self._catalogue)
        record = {"at": time.time(), "label": label, "edits": edits, "path": str(path) if path else None, "network": text}
        line = (json.dumps(record, ensure_ascii=False) + "\n").encode()
        if fresh or (self.file.exists() and self.file.stat().st_size + len(line) > MOST):
            part = self.file.with_suffix(".part")
            part.write_bytes(line)
            part.replace(self.file)
        else:
            with self.file.open("ab") as out:
                out.write(line)
                out.flush()
                os.fsync(out.fileno())
        self.written = time.monotonic()


def lost(folder: Path | None = None) -> list[Lost]:
    """Documents of processes that ended without closing, the latest first."""
    place = folder or state_folder() / "recovery"
    found: list[Lost] = []
    for file in sorted(place.glob("*.jsonl")) if place.is_dir() else ():
        lock = QLockFile(str(_lock_of(file)))
        lock.setStaleLockTime(0)
        if not lock.tryLock(0):
            continue  # of a window that is open
        lock.unlock()
        one = _last(file)
        if one is None:
            file.unlink(missing_ok=True)
        else:
            found.append(one)
    return sorted(found, key=lambda one: -one.at)


def _last(file: Path) -> Lost | None:
    """The last whole line; one that was being written is passed over."""
    try:
        lines = file.read_bytes().splitlines()
    except OSError:
        return None
    for line in reversed(lines):
        try:
            record = json.loads(line)
            path = Path(record["path"]) if record["path"] else None
            return Lost(file, path, str(record["network"]), int(record["edits"]), float(record["at"]))
        except (ValueError, KeyError, TypeError):
            continue
    return None


def _lock_of(log: Path) -> Path:
    return log.with_suffix(".lock")
