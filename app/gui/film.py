"""The frames of a sequence written from the window: one after the other, each with its certificate, then index and film."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject

from app.commands import films
from app.commands.outbox import Outbox
from app.engine.errors import NoniusError
from app.gui import pictures
from modules.data.scene import Scene

if TYPE_CHECKING:
    from app.gui.main_window import MainWindow


class Film(QObject):
    """Shows each frame, waits until it has run, and draws it as a file.

    Parameters
    ----------
    window : whose sequence runs
    node : the view that is drawn
    target : sweep.png gives sweep-001.png and on, sweep.frames.json and sweep.apng
    fps : frames a second of the film
    """

    def __init__(self, window: MainWindow, node: str, target: Path, fps: int) -> None:
        super().__init__(window)
        self.window, self.session, self.page = window, window.session, window.pages.sequence
        self.node, self.target, self.fps = node, target, fps
        self.done: list[tuple[dict[str, Any], Path]] = []
        self.at, self.drawing = 0, False
        self.session.waveDone.connect(self._ran)
        self.session.resultChanged.connect(self._came)
        window.studio.did.connect(self._drawn)
        self._show()

    def _show(self) -> None:
        if self.at >= self.page.count:
            self._finish()
            return
        self.page.show_frame(self.at)
        self._ran("settled")

    def _came(self, _node: str) -> None:
        self._ran("settled")

    def _ran(self, outcome: str) -> None:
        """Draw the frame, if the view has it."""
        if outcome == "cancelled":
            self._end("Export stopped; frames that were drawn are kept", "warning")
            return
        session = self.session
        if self.drawing or session.runs.busy or self.page.place != self.at or session.state(self.node).kind == "queued":
            return
        kind = session.state(self.node).kind
        if kind in ("failed", "blocked", "missing", "disabled"):
            self._end(f"Frame {self.at + 1} gave no picture: {session.state(self.node).sentence}", "error")
            return
        if session.stale(self.node) or kind not in ("clean", "cached"):
            return
        found = next(((o, v) for o, v in (session.outputs(self.node) or {}).items() if isinstance(v, Scene)), None)
        if found is None:
            return
        self.drawing = True
        path = films.numbered(self.target, self.at + 1, self.page.count)
        output, scene = found
        network, file, catalogue = session.network, session.path, session.catalogue
        session.message.emit("info", f"Drawing frame {self.at + 1} of {self.page.count}…")
        job = lambda: pictures.write(scene, self.node, output, path, network, file, catalogue)  # noqa: E731
        self.window.studio.do(("film", self, self.page.value()), job)

    def _drawn(self, tag: object, result: Any) -> None:
        if not (isinstance(tag, tuple) and tag[:2] == ("film", self)):
            return
        if isinstance(result, Exception):
            self._end(f"Frame {self.at + 1} was not written: {result}", "error")
            return
        self.done.append((tag[2], result[0]))
        self.at, self.drawing = self.at + 1, False
        self._show()

    def _finish(self) -> None:
        try:
            with Outbox() as outbox:
                films.index(self.target, [(v, p, p.read_bytes()) for v, p in self.done], self.fps, outbox)
                outbox.commit()
        except (NoniusError, OSError, ValueError) as error:
            self._end(f"The film was not written: {error}", "error")
            return
        film = self.target.with_suffix(".apng").name
        self._end(f"Saved {len(self.done)} frames with their certificates, and the film {film}", "info")

    def _end(self, words: str, kind: str) -> None:
        self.session.waveDone.disconnect(self._ran)
        self.session.resultChanged.disconnect(self._came)
        self.window.studio.did.disconnect(self._drawn)
        self.drawing = True  # nothing more is drawn
        self.session.message.emit(kind, words)
        self.deleteLater()
