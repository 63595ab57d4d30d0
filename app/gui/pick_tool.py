"""Picking in a view: a click, or P under the pointer, asks what is there; the answer is worked out in another thread."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import count
from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtCore import QEvent, QObject, QPointF, Qt
from PySide6.QtGui import QCursor, QKeyEvent, QMouseEvent
from PySide6.QtWidgets import QWidget

from app.draw.sight import Sight
from app.gui import pick_points
from app.gui.backends import BackEnd
from app.gui.pick_box import Deed, PickBox
from app.gui.pick_marks import Handle, Mark, Ring
from app.gui.pick_points import Spot
from app.pick import Hit, pick
from app.readout import Readout, read_out
from modules.data.scene import Scene
from modules.progress import Progress, Stop

if TYPE_CHECKING:
    from app.gui.session import Session

STILL = 4.0
"""Pixels that the mouse may go between press and release of a click."""
NUMBERS = count(1)


@dataclass(frozen=True)
class _Asked:
    """A question that is being answered."""

    number: int
    scene: Scene
    stop: Stop
    key: tuple[Any, ...]
    job: Any


class PickTool(QObject):
    """The pick of one view.

    Parameters
    ----------
    session : whose network is looked at
    back : the back end; its picture and camera are picked
    keys : what the view does with other keys; whether it did something
    """

    def __init__(self, session: Session, back: BackEnd, parent: QObject, keys: Callable[[QKeyEvent], bool]) -> None:
        super().__init__(parent)
        self._more = keys
        self.session, self.back = session, back
        self.node = ""
        self.active = False
        self.scene: Scene | None = None
        self.hit: Hit | None = None
        self.ring = Ring(back)
        self.box = PickBox(back)
        self.box.closed.connect(self.close)
        self.handles: dict[Spot, Handle] = {}
        self._asked: _Asked | None = None
        self._pressed: QPointF | None = None
        made = getattr(back, "surfaceMade", None)
        if made is not None:
            made.connect(self._watch)
        self._watch(back.surface)
        back.moved.connect(self.follow)
        session.networkChanged.connect(self._renew)
        session.selectionChanged.connect(self._renew)

    def _watch(self, surface: QWidget | None) -> None:
        if surface is not None:
            surface.installEventFilter(self)
            surface.setMouseTracking(True)
            self.use(self.active)

    # --- the tool

    def use(self, on: bool) -> None:
        """Whether a click picks; with Ctrl it always does."""
        self.active = on
        surface = self.back.surface
        if surface is not None:
            surface.setCursor(Qt.CursorShape.CrossCursor) if on else surface.unsetCursor()
        self._renew()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """A click, or the key of the tool; nothing of it is taken from the view but the keys."""
        kind = event.type()
        if kind == QEvent.Type.MouseButtonPress and isinstance(event, QMouseEvent):
            left = event.button() == Qt.MouseButton.LeftButton
            wanted = self.active or bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier)
            self._pressed = event.position() if left and wanted else None
        elif kind == QEvent.Type.MouseButtonRelease and isinstance(event, QMouseEvent) and self._pressed is not None:
            by, self._pressed = event.position() - self._pressed, None
            if abs(by.x()) + abs(by.y()) <= STILL and isinstance(watched, QWidget):
                self.ask(watched.mapTo(self.back, event.position()) if watched is not self.back else event.position())
        elif kind in (QEvent.Type.KeyPress, QEvent.Type.KeyRelease) and isinstance(event, QKeyEvent):
            if kind == QEvent.Type.KeyPress and (self._key(event) or self._more(event)):
                return True
            if watched is not self.back:  # VTK has keys of its own: they would change the picture behind the network's back
                event.ignore()
                return True
        return False

    def _key(self, event: QKeyEvent) -> bool:
        if event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier:
            return False
        if event.key() == Qt.Key.Key_P:
            at = QPointF(self.back.mapFromGlobal(QCursor.pos()))
            plot = self.back.plot.toRectF()
            self.ask(at if plot.contains(at) else plot.center())
            return True
        if event.key() == Qt.Key.Key_Escape and self.box.isVisible():
            self.close()
            return True
        return False

    # --- asking

    def show_scene(self, node: str, scene: Scene | None) -> None:
        """Look at another picture; what was picked is read anew where it was, if something is there."""
        if node != self.node or scene is None:
            self.close()
        self.node, before, self.scene = node, self.scene, scene
        if scene is not None and before is not scene and self.box.isVisible():
            at = self._window(self._drawn(np.asarray(self.hit.at))) if self.hit is not None else None
            if at is not None:
                self.ask(at, again=True)
        self._renew()

    def ask(self, at: QPointF, again: bool = False) -> None:
        """What lies under a place of the back end; a question that is not yet answered is dropped."""
        camera, scene = self.back.camera, self.scene
        if camera is None or scene is None:
            return
        self._drop()
        plot = self.back.plot
        place = at - plot.topLeft().toPointF()
        stop, k = Stop(), self.session.network.k
        size = (float(plot.width()), float(plot.height()))
        job = partial(looked, scene, dict(camera), size, (place.x(), place.y()), k, Progress(stop=stop))
        number = next(NUMBERS)
        self._asked = _Asked(number, scene, stop, ("pick", self.node, number), job)
        if not again:
            self.hit = None
            self.box.release()
            self.ring.put(at)
        self.refresh()

    def _drop(self) -> None:
        if self._asked is not None:
            self._asked.stop.set()
            self._asked = None

    def refresh(self) -> None:
        """Show the answer when it is there."""
        asked = self._asked
        if asked is None:
            return
        found = self.session.look(*asked.key[:2], *asked.key[2:], job=asked.job)
        if found is None:
            return
        self._asked = None
        if isinstance(found, Exception):
            self.box.wait(f"It cannot be read: {found}")
            return
        hit, readout = found
        if hit is None or readout is None:
            self.hit = None
            self.ring.put(None)
            self.box.wait("Nothing is drawn there. Pick a line, a point, a surface or an image.")
            self.box.beside(self.ring.middle)
            return
        self.hit = hit
        self.box.tell(readout, self._deeds(hit))
        self.follow()

    def _deeds(self, hit: Hit) -> list[Deed]:
        """What can be done with the place: it can become a position of a module above the view."""
        made: list[Deed] = []
        for spot in pick_points.spots(self.session, self.node)[:3]:
            tip = f"Set the {spot.words} to this place. Undo takes it back."
            made.append((f"Set as {spot.name}", tip, partial(self._put, spot, np.asarray(hit.at), False)))
        return made

    def close(self) -> None:
        """Show nothing picked."""
        self._drop()
        self.hit = None
        self.ring.put(None)
        self.box.hide()
        self.box.release()

    # --- marks

    def _sight(self) -> Sight | None:
        camera, plot = self.back.camera, self.back.plot
        return None if camera is None else Sight(camera, (float(plot.width()), float(plot.height())))

    def _drawn(self, at: Any) -> Any:
        """A place as it is drawn."""
        flat = self.scene is None or self.scene.look.dimensions == 2
        return np.asarray(at, float) * [1.0, 1.0, 1.0 if flat or self.scene is None else self.scene.look.exaggeration]

    def _window(self, drawn: Any) -> QPointF | None:
        """Where a place is drawn in the back end; None behind the eye."""
        sight = self._sight()
        if sight is None:
            return None
        (pixel,), _ = sight.pixels(drawn[None])
        if not np.isfinite(pixel).all():
            return None
        return QPointF(*(float(v) for v in pixel)) + self.back.plot.topLeft().toPointF()

    def follow(self) -> None:
        """Ring, box and handles go with the picture."""
        if self.hit is not None and self.scene is not None:
            at = self._window(self._drawn(self.hit.at))
            self._stand(self.ring, at)
            if at is not None:
                self.box.beside(at)
        for spot, handle in self.handles.items():
            where = pick_points.value(self.session, spot) if spot.node in self.session.network.nodes else None
            if not handle.held:
                self._stand(handle, None if where is None else self._window(self._drawn(where)))

    def _stand(self, mark: Mark, at: QPointF | None) -> None:
        mark.put(at)
        if at is not None and self.back.surface is not self.back and mark.mask().isEmpty():
            mark.shaped()

    def _renew(self) -> None:
        """A handle for each position that is set: of the chosen module, or of all while the tool is in use."""
        there = pick_points.spots(self.session, self.node) if self.scene is not None else ()
        chosen = [s for s in there if self.active or s.node in self.session.selection]
        wanted = [s for s in chosen if pick_points.value(self.session, s) is not None]
        for spot in [s for s in self.handles if s not in wanted]:
            self.handles.pop(spot).deleteLater()
        for spot in wanted:
            if spot not in self.handles:
                handle = Handle(self.back, lambda spot=spot: f"Move the {spot.words}")  # type: ignore[misc]  # bound now
                handle.dragged.connect(partial(self._dragged, spot))
                self.handles[spot] = handle
        self.follow()

    def _dragged(self, spot: Spot, to: QPointF, more: bool) -> None:
        """A handle was dragged: its position goes along, as far from the eye as it was."""
        sight, at = self._sight(), pick_points.value(self.session, spot)
        if sight is None or at is None:
            return
        drawn = self._drawn(at)
        _, (depth,) = sight.pixels(drawn[None])
        place = to - self.back.plot.topLeft().toPointF()
        new = sight.place(place.x(), place.y(), float(depth)) / self._drawn(np.ones(3))
        if self.back.flat:
            new[2] = at[2]
        self._put(spot, new, more)

    def _put(self, spot: Spot, at: Any, more: bool) -> None:
        pick_points.put(self.session, spot, at, interim=more)
        if not more:
            self._renew()


def looked(
    scene: Scene, camera: dict[str, Any], size: tuple[float, float], at: tuple[float, float], k: float, progress: Progress
) -> tuple[Hit | None, Readout | None]:
    """What lies there, and what is known of it; in no window's thread."""
    hit = pick(scene, camera, size, at, check=progress)
    return (None, None) if hit is None else (hit, read_out(scene.layers[hit.layer], hit, k=k, check=progress))
