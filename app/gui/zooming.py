"""Zoom to a place: a view is brought near it, and a ring says where it is until the view is moved."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, QObject, QPointF, Qt, QTimer
from PySide6.QtGui import QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from app.gui import cameras, motion, style

if TYPE_CHECKING:
    from app.gui.backends import BackEnd
    from app.gui.cameras import Camera

STAYS = 8000
"""Milliseconds after which the ring goes by itself."""
RING, ARM = 10.0, 7.0


class Ring(QWidget):
    """A ring with four arms in the middle of a view."""

    def __init__(self, back: BackEnd) -> None:
        super().__init__(back)
        self.back = back
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.hide()
        self._gone = QTimer(self, singleShot=True, interval=STAYS)
        self._gone.timeout.connect(self.hide)
        back.installEventFilter(self)

    def point(self) -> None:
        """Show it for a while."""
        side = round(2 * (RING + ARM) + 6)
        self.setGeometry((self.back.width() - side) // 2, (self.back.height() - side) // 2, side, side)
        self.show()
        self.raise_()
        self._gone.start()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """It goes when the view is moved or has another size."""
        if event.type() in (QEvent.Type.MouseButtonPress, QEvent.Type.Wheel, QEvent.Type.Resize):
            self.hide()
        return False

    def paintEvent(self, event: QPaintEvent) -> None:
        """Dark below light, so that it is seen on any ground."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle = QPointF(self.width() / 2, self.height() / 2)
        for role, wide in (("panel", 4.0), ("text", 1.75)):
            painter.setPen(QPen(style.colour(role), wide))
            painter.drawEllipse(middle, RING, RING)
            for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                painter.drawLine(middle + QPointF(x, y) * (RING - 3), middle + QPointF(x, y) * (RING + ARM))


def fly(back: BackEnd, point: Sequence[float], seen: float) -> Camera | None:
    """Bring a view near a point, never farther away than it is; the camera at the end, None while nothing is drawn.

    Parameters
    ----------
    point : of the data; heights are stretched as those of the scene are
    seen : how much of the world is to be seen from top to bottom
    """
    start, scene = back.camera, back.scene
    if start is None or scene is None:
        return None
    factor = 1.0 if back.flat else scene.look.exaggeration
    place = (float(point[0]), float(point[1]), float(point[2]) * factor)
    end = cameras.looking_at(start, place, min(seen, cameras.seen(start)))
    ring = next((c for c in back.findChildren(Ring)), None) or Ring(back)
    begin = dict(start)

    def step(t: float) -> None:
        back.set_camera(cameras.between(begin, end, t))
        if t >= 1.0:
            ring.point()
            back.cameraChanged.emit(end)

    motion.glide(back, motion.ZOOM, step)
    return end
