"""The canvas: a view of the network in which it is built by hand."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, QLineF, QPoint, QPointF, QRect, QRectF, Qt, Signal
from PySide6.QtGui import (
    QContextMenuEvent,
    QCursor,
    QDragEnterEvent,
    QDragMoveEvent,
    QDropEvent,
    QFocusEvent,
    QHelpEvent,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPen,
    QResizeEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QGraphicsView, QToolTip, QWidget

from app.engine.network import Network, Socket
from app.gui import glyphs, keys, motion, mouse, style
from app.gui.board import Board
from app.gui.bubble import Bubble
from app.gui.find_bar import FindBar
from app.gui.gestures import Gesture
from app.gui.glyphs import Look, font
from app.gui.hands import Hands
from app.gui.minimap import Minimap
from app.gui.quick_add import QuickAdd
from app.gui.replacing import Replace
from app.gui.writing_line import WritingLine
from app.gui.zoom_box import ZoomBox

if TYPE_CHECKING:
    from app.gui.edits import Held
    from app.gui.marks import MarkItem
    from app.gui.session import Session

MODULE = "application/x-nonius-module"
"""What the librarian drags: the id of a module."""
SMALLEST, LARGEST = 0.08, 3.0
DOTS = 24


class Canvas(QGraphicsView):
    """The network, to be seen and edited.

    Signals
    -------
    wireSelected : (node, output) of the wire that was clicked; ("", "") for none
    helpRequested : id of a module
    settingsRequested : the panel of the selected node, by Enter
    panelRequested : node whose panel is wanted in a window of its own
    zoomChanged : the scale, 1 for 100 %
    said : a sentence for the status bar
    """

    wireSelected = Signal(str, str)
    helpRequested = Signal(str)
    panelRequested = Signal(str)
    settingsRequested = Signal()
    zoomChanged = Signal(float)
    said = Signal(str)

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session, self.look = session, Look()
        self.board = Board(session, self.look, self)
        self.setScene(self.board)
        self.hands = Hands(self)
        self.gesture: Gesture | None = None
        self.wire: Socket | None = None
        self.band = QRectF()
        self.guides: tuple[QLineF, ...] = ()
        self.spaced = self.panned = False
        self._fresh = True
        self.setRenderHint(QPainter.RenderHint.Antialiasing)
        self.setFrameShape(QGraphicsView.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setTransformationAnchor(QGraphicsView.ViewportAnchor.NoAnchor)
        self.setResizeAnchor(QGraphicsView.ViewportAnchor.NoAnchor)
        self.setMouseTracking(True)
        self.setAcceptDrops(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("Network")
        self.bubble = Bubble(self.viewport(), self.look)
        self.minimap = Minimap(self)
        self.zoom_box = ZoomBox(self)
        self.finder = FindBar(self)
        self.line = WritingLine(self)
        self.popup: QuickAdd | None = None
        session.networkChanged.connect(self._follow)
        session.stateChanged.connect(self.board.refresh)
        session.resultChanged.connect(self.board.result)
        session.selectionChanged.connect(self._selected)
        session.stateChanged.connect(lambda _: self.minimap.update())
        style.watch().changed.connect(self.follow_theme)
        self.sync(session.network)

    # --- following the session

    def _follow(self) -> None:
        if self.gesture is not None and not isinstance(self.gesture, mouse.LOOKING):
            self.drop_gesture()
        self.sync(self.session.network)

    def sync(self, network: Network) -> None:
        """Draw another network; only what changed is touched."""
        empty = not self.board.nodes
        self.board.sync(network)
        if self.wire is not None and self.wire not in self.board.lines:
            self.choose_wire(None)
        if empty and self.board.nodes:
            self._fresh = True
            self.fit()
        self.minimap.update()
        if empty or not self.board.nodes:
            self.viewport().update()

    def _selected(self) -> None:
        self.board.select(self.session.selection)
        if self.session.selection:
            self.choose_wire(None)
        self.minimap.update()

    def choose_wire(self, end: Socket | None) -> None:
        """Select a wire, or none; its budget is asked for."""
        for old in (self.wire, end):
            if old is not None and (line := self.board.lines.get(old)):
                line.chosen = old == end
                line.update()
        if end != self.wire:
            self.wire = end
            self.wireSelected.emit(*(self.board.lines[end].origin if end is not None else ("", "")))

    def say(self, sentence: str) -> None:
        """A sentence for the status bar, and beside the pointer."""
        self.said.emit(sentence)
        QToolTip.showText(QCursor.pos(), sentence, self)

    # --- theme

    def follow_theme(self) -> None:
        """Draw in the theme in force."""
        if self.look.set(glyphs.current()):
            self.board.colour()
            for child in (self.minimap, self.zoom_box, self.bubble, self.finder, self.viewport()):
                child.update()

    # --- looking

    @property
    def zoom(self) -> float:
        """The scale, 1 for 100 %."""
        return self.transform().m11()

    def pan(self, dx: float, dy: float) -> None:
        """Scroll by pixels of the screen."""
        self._fresh = False
        across, down = self.horizontalScrollBar(), self.verticalScrollBar()
        across.setValue(across.value() + round(dx))
        down.setValue(down.value() + round(dy))
        self.minimap.update()

    def zoom_by(self, factor: float, at: QPointF | None = None) -> None:
        """Scale, with a place of the window (its middle by default) held still."""
        self._fresh = False
        place = at or QPointF(self.viewport().rect().center())
        before = self.mapToScene(place.toPoint())
        scale = min(max(self.zoom * factor, SMALLEST), LARGEST)
        if abs(scale - 1) < 0.02:
            scale = 1.0
        self._show(scale, before, place)

    def _show(self, scale: float, spot: QPointF, place: QPointF) -> None:
        """Scale so that a spot of the network lies at a place of the window."""
        self.resetTransform()
        self.scale(scale, scale)
        off = self.mapFromScene(spot) - place.toPoint()
        for bar, by in ((self.horizontalScrollBar(), off.x()), (self.verticalScrollBar(), off.y())):
            bar.setValue(bar.value() + by)
        self.zoomChanged.emit(scale)
        self.minimap.update()

    def set_zoom(self, scale: float) -> None:
        """Take a scale round the middle."""
        self.zoom_by(scale / self.zoom)

    def fit(self) -> None:
        """Show the whole network, at most at 100 %."""
        self.zoom_to(None)
        self._fresh = True

    def zoom_to(self, nodes: list[str] | tuple[str, ...] | None) -> None:
        """Show some nodes, all by default."""
        rect = self.board.bounds(nodes)
        if rect.isNull():
            rect = QRectF(0, 0, 1, 1)
        rect.adjust(-32, -32, 32, 32)
        room = self.viewport().rect()
        scale = min(room.width() / rect.width(), room.height() / rect.height(), 1.0)
        self._show(max(scale, SMALLEST), rect.center(), QPointF(room.center()))

    def show_node(self, node: str) -> None:
        """Bring a node into sight, if it is not."""
        rect = self.board.nodes[node].scene_rect()
        if not self.mapToScene(self.viewport().rect()).boundingRect().contains(rect):
            self.centerOn(rect.center())
            self.minimap.update()

    def go_to(self, node: str) -> None:
        """Bring a node into the middle, in one movement that the eye can follow."""
        if node not in self.board.nodes:
            return
        start, end = self.middle(), self.board.nodes[node].scene_rect().center()
        motion.glide(self, motion.CANVAS, lambda t: self.centerOn(start + (end - start) * t))
        self._fresh = False
        self.minimap.update()

    def middle(self) -> QPointF:
        """The middle of what is seen."""
        return self.mapToScene(self.viewport().rect().center())

    def pointer(self) -> QPoint:
        """The pointer in the viewport; the middle if it is elsewhere."""
        at = self.viewport().mapFromGlobal(QCursor.pos())
        return at if self.viewport().rect().contains(at) else self.viewport().rect().center()

    # --- asking for a module, text

    def quick_add(self, at: QPoint | None = None, held: Held | None = None) -> None:
        """Ask for a module at a place of the window, one that fits the wire in the hand."""
        self.popup = QuickAdd(self, at or self.pointer(), held)
        self.popup.beside = at is None and not self.viewport().underMouse()
        self.popup.open()

    def replace(self, node: str) -> None:
        """Ask for a module to stand in the place of a node."""
        corner = self.mapFromScene(self.board.nodes[node].scene_rect().bottomLeft())
        self.popup = Replace(self, corner, node)
        self.popup.open()

    def find(self) -> None:  # type: ignore[override]
        """Look for a node by name."""
        self.finder.open()

    def rename(self) -> None:
        """Write another title for the selected node."""
        if self.session.selection and (item := self.board.nodes.get(self.session.selection[0])):
            name = item.node.id
            box = QRectF(28, 2, item.width - 54, 24).translated(item.pos())
            self.line.open(box, item.title, lambda text: self.hands.rename(name, text))

    def write(self, mark: MarkItem) -> None:
        """Write a note, or the title of a frame."""
        kind, index = mark.kind, mark.index
        box = QRectF(8, 1, mark.size[0] - 16, 26).translated(mark.pos())
        self.line.open(box, mark.text, lambda text: self.hands.written(kind, index, text))

    # --- drawing

    def drawBackground(self, painter: QPainter, rect: QRectF | QRect) -> None:
        """The ground and its dots."""
        area = QRectF(rect)
        painter.fillRect(area, self.look["canvas"])
        if self.zoom < 0.6:
            return
        painter.setPen(QPen(self.look["canvas dots"], 1.5))
        x0, y0 = int(area.left() // DOTS) * DOTS, int(area.top() // DOTS) * DOTS
        for x in range(x0, int(area.right()) + DOTS, DOTS):
            painter.drawPoints([QPointF(x, y) for y in range(y0, int(area.bottom()) + DOTS, DOTS)])

    def drawForeground(self, painter: QPainter, rect: QRectF | QRect) -> None:
        """The rubber band, guides, and what an empty canvas says."""
        if self.guides:
            pen = QPen(self.look["action"], 1, Qt.PenStyle.DashLine)
            pen.setCosmetic(True)
            painter.setPen(pen)
            painter.drawLines(list(self.guides))
        if not self.band.isNull():
            line = QPen(self.look["action"], 1)
            line.setCosmetic(True)
            painter.setPen(line)
            ground = self.look["action"].toRgb()
            ground.setAlphaF(0.12)
            painter.setBrush(ground)
            painter.drawRect(self.band)
        if not self.board.nodes and not self.board.marks:
            painter.save()
            painter.resetTransform()
            box = QRectF(self.viewport().rect())
            painter.setPen(self.look["text"])
            painter.setFont(font(15, True))
            painter.drawText(box.adjusted(0, 0, 0, -28), Qt.AlignmentFlag.AlignCenter, "Space adds a module")
            painter.setPen(self.look["text 2"])
            painter.setFont(font(12))
            words = "or drag one from the librarian, or drop a data file here"
            painter.drawText(box.adjusted(0, 28, 0, 0), Qt.AlignmentFlag.AlignCenter, words)
            painter.restore()

    # --- events

    def drop_gesture(self) -> None:
        """Put back what the mouse has begun."""
        if self.gesture is not None:
            gesture, self.gesture = self.gesture, None
            gesture.cancel()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Begin."""
        self.board.show_focus(False)
        mouse.press(self, event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Go on."""
        mouse.move(self, event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """End."""
        mouse.release(self, event)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Rename, write, or ask for a module."""
        mouse.double_click(self, event)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom at the pointer; a touch pad scrolls, with Ctrl it zooms."""
        mouse.wheel(self, event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Keys of the canvas."""
        if not keys.press(self, event):
            super().keyPressEvent(event)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        """Space let go without a drag asks for a module."""
        if not keys.release(self, event):
            super().keyReleaseEvent(event)

    def focusNextPrevChild(self, forward: bool) -> bool:
        """Tab asks for a module; Shift+Tab leaves the canvas."""
        if forward:
            self.quick_add()
            return True
        return super().focusNextPrevChild(forward)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Forget that Space is held."""
        self.spaced = self.panned = False
        super().focusOutEvent(event)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Keep the map in its corner, and all in view until someone has looked elsewhere."""
        super().resizeEvent(event)
        self.minimap.place()
        self.zoom_box.place()
        self.finder.place()
        if self._fresh and self.board.nodes:
            self.fit()

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        """The menu key opens the menu of the selected node, or that of the canvas; the mouse has its own way."""
        if event.reason() == QContextMenuEvent.Reason.Keyboard:
            item = next((self.board.nodes[n] for n in self.session.selection if n in self.board.nodes), None)
            spot = item.scene_rect().center() if item is not None else self.middle()
            mouse.menu(self, self.mapFromScene(spot))
        event.accept()

    def viewportEvent(self, event: QEvent) -> bool:
        """Say what is under the pointer."""
        if event.type() == QEvent.Type.ToolTip and isinstance(event, QHelpEvent):
            QToolTip.showText(event.globalPos(), mouse.words(self, event.pos()), self)
            return True
        if event.type() == QEvent.Type.Leave:
            mouse.leave(self)
        return super().viewportEvent(event)

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Take modules; other things are the window's."""
        if event.mimeData().hasFormat(MODULE):
            event.acceptProposedAction()
        else:
            event.ignore()

    def dragMoveEvent(self, event: QDragMoveEvent) -> None:
        """Take modules."""
        if event.mimeData().hasFormat(MODULE):
            event.acceptProposedAction()
        else:
            event.ignore()

    def dropEvent(self, event: QDropEvent) -> None:
        """Add the module under the pointer."""
        if event.mimeData().hasFormat(MODULE):
            name = bytes(event.mimeData().data(MODULE).data()).decode()
            self.hands.add(name, self.mapToScene(event.position().toPoint()) - QPointF(75, 14))
            event.acceptProposedAction()
            self.setFocus()
        else:
            event.ignore()
