"""The window: canvas and views in the middle, librarian, panel and budget around them."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtCore import QByteArray, QSettings, Qt, QTimer
from PySide6.QtGui import QAction, QCloseEvent, QDragEnterEvent, QDropEvent, QKeyEvent
from PySide6.QtWidgets import (
    QDialog,
    QDockWidget,
    QMainWindow,
    QMenu,
    QSplitter,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from app.engine.errors import NoniusError
from app.gui import dropping, panel_window, style, toolbar
from app.gui.actions import ACTIONS, MENUS
from app.gui.canvas import Canvas
from app.gui.commands import Commands
from app.gui.control_panel import ControlPanel
from app.gui.first_run import FirstRun
from app.gui.help_page import HelpPage
from app.gui.icons import icon
from app.gui.keys_page import KeysPage
from app.gui.librarian import Librarian
from app.gui.lower import Lower
from app.gui.places_page import Spot
from app.gui.recovery import Lost
from app.gui.session import Session
from app.gui.status import Overall, Status
from app.gui.studio import Studio
from app.gui.viewport_widget import Views

WIDTHS = (224, 300)
BUDGET = 210
STATE = 1
"""Number of the arrangement of docks; a remembered one of another number is not restored."""


class MainWindow(QMainWindow):
    """The window of one session.

    Parameters
    ----------
    session : what it shows
    lost : documents that a killed process left
    """

    def __init__(self, session: Session, lost: list[Lost] | None = None) -> None:
        super().__init__()
        self.session = session
        self.commands = Commands(self)
        self.studio = Studio(self)
        self.made: dict[str, QAction] = {}
        self.setObjectName("nonius")
        self.setAcceptDrops(True)
        self.setDockNestingEnabled(True)
        self.canvas = Canvas(session)
        self.views = Views(session, self.studio)
        self.pages = Lower(session)
        self.librarian = Librarian(session)
        self.panel = ControlPanel(session)
        self._actions()
        self.first = FirstRun(self, lost or [])
        self._middle()
        self._docks()
        self.status = Status(session)
        self.setStatusBar(self.status)
        self.overall = Overall(session)
        self.bar = toolbar.build(self)
        self.addToolBar(self.bar)
        self._connect()
        room = self.screen().availableSize()
        self.resize(min(1600, room.width()), min(1000, room.height()))
        self._restore_layout()
        self._titled()
        self.enable()
        self.show_start()

    # --- parts

    def _middle(self) -> None:
        self.work = QSplitter(Qt.Orientation.Vertical)
        self.work.addWidget(self.canvas)
        self.work.addWidget(self.views)
        self.work.setHandleWidth(1)
        self.work.setStretchFactor(0, 45)
        self.work.setStretchFactor(1, 55)
        self.work.setSizes([450, 500])
        self.stack = QStackedWidget()
        self.stack.addWidget(self.first)
        self.stack.addWidget(self.work)
        self.setCentralWidget(self.stack)

    def _docks(self) -> None:
        for corner, area in (
            (Qt.Corner.BottomLeftCorner, Qt.DockWidgetArea.LeftDockWidgetArea),
            (Qt.Corner.BottomRightCorner, Qt.DockWidgetArea.RightDockWidgetArea),
        ):
            self.setCorner(corner, area)
        sides = Qt.DockWidgetArea
        self.docks = {
            "Librarian": self._dock("Librarian", self.librarian, sides.LeftDockWidgetArea),
            "Control panel": self._dock("Control panel", self.panel, sides.RightDockWidgetArea),
            "Budget": self._dock("Budget", self.pages, sides.BottomDockWidgetArea),
        }
        self.resizeDocks([self.docks["Librarian"], self.docks["Control panel"]], list(WIDTHS), Qt.Orientation.Horizontal)
        self.resizeDocks([self.docks["Budget"]], [BUDGET], Qt.Orientation.Vertical)
        menu = self.menus["Window"]
        before = self.made["start_page"]
        for dock in self.docks.values():
            menu.insertAction(before, dock.toggleViewAction())

    def _dock(self, title: str, inside: QWidget, area: Qt.DockWidgetArea) -> QDockWidget:
        dock = QDockWidget(title, self)
        dock.setObjectName(title)
        dock.setWidget(toolbar.headed(title, inside) if title == "Librarian" else inside)
        dock.setTitleBarWidget(QWidget())
        self.addDockWidget(area, dock)
        return dock

    def _actions(self) -> None:
        self.menus: dict[str, QMenu] = {name: self.menuBar().addMenu(name) for name in MENUS}
        for action in ACTIONS:
            made = QAction(action.label, self)
            if action.key:
                made.setShortcut(action.key)
            if action.icon:
                made.setIcon(icon(action.icon))
            made.setCheckable(action.check)
            keys = f" ({action.keys})" if action.keys else ""
            made.setToolTip(f"{action.words.rstrip('…')}{keys}" + (f"\n{action.tip}" if action.tip else ""))
            made.triggered.connect(partial(self._do, action.id))
            menu = self.menus[action.menu]
            if action.apart:
                menu.addSeparator()
            menu.addAction(made)
            self.made[action.id] = made
            if action.id == "open_data":
                self.recent = menu.addMenu("Open recent")
        self.fill_recent()

    def _do(self, name: str) -> None:
        self.commands(name)
        self.enable()

    def _connect(self) -> None:
        session = self.session
        for signal in (session.networkChanged, session.selectionChanged, session.pathChanged):
            signal.connect(self._titled)
        self._soon = QTimer(self, singleShot=True, interval=50)
        self._soon.timeout.connect(self.enable)
        session.stateChanged.connect(lambda _: self._soon.start())
        session.resultChanged.connect(lambda _: self._soon.start())
        session.networkChanged.connect(self._soon.start)
        session.selectionChanged.connect(self.enable)
        session.networkChanged.connect(lambda: self.show_work() if session.network.nodes else None)
        self.pages.counted.connect(lambda flags, _: self.status.tell_flags(flags))
        self.pages.zoomAsked.connect(self.zoom_to)
        self.pages.went.connect(self.canvas.go_to)
        self.pages.sequence.exportAsked.connect(self.commands.export_frames)
        self.canvas.wireSelected.connect(self.pages.show_wire)
        self.canvas.helpRequested.connect(self.show_help)
        self.canvas.settingsRequested.connect(self.commands.settings_of)
        self.canvas.panelRequested.connect(partial(panel_window.show, self))
        self.canvas.said.connect(lambda words: self.status.say("info", words))
        self.panel.helpAsked.connect(self.show_help)
        self.panel.replaceAsked.connect(self.canvas.replace)
        self.librarian.addRequested.connect(self._add)
        self.librarian.openRequested.connect(self.commands.open_path)
        self.librarian.helpRequested.connect(self.show_help)
        self.librarian.brokenRequested.connect(self._broken)
        self.views.pictureAsked.connect(self.commands.save_picture)
        self.studio.did.connect(self._pictured)
        self.status.pageAsked.connect(self.show_page)
        style.watch().changed.connect(self._restyle)

    # --- following

    def _titled(self) -> None:
        name = self.session.path.name if self.session.path else "New network"
        self.setWindowTitle(f"{name}{' •' if self.session.modified else ''} – Nonius Explorer")

    def enable(self) -> None:
        """What can be done now; what is on."""
        session = self.session
        there = {
            "": True,
            "selection": bool(session.selection),
            "undo": bool(session.history.undo_label),
            "redo": bool(session.history.redo_label),
            "view": bool(self.views.shown),
            "running": bool(session.runs.busy),
            "network": bool(session.network.nodes),
        }
        for action in ACTIONS:
            self.made[action.id].setEnabled(there.get(action.need, True))
        for name, label in (("undo", session.history.undo_label), ("redo", session.history.redo_label)):
            words = name.capitalize()
            self.made[name].setText(f"{words} “{label}”" if label else words)
        views = self.views
        checked = {"freeze": session.frozen, "as_saved": views.as_saved}
        checked |= {"link_cameras": views.linked, "same_colours": views.shared}
        checked |= {f"split_{name}": views.most == n for name, n in (("one", 1), ("two", 2), ("four", 4))}
        checked |= {f"theme_{name}": style.watch().choice == name for name in ("system", "light", "dark")}
        for name, on in checked.items():
            self.made[name].setChecked(on)

    def _restyle(self) -> None:
        for action in ACTIONS:
            if action.icon:
                self.made[action.id].setIcon(icon(action.icon))
        self.enable()

    def fill_recent(self) -> None:
        """The menu of recent files."""
        self.recent.clear()
        for path in self.commands.recent():
            made = self.recent.addAction(path.name, partial(self.commands.open_path, path))
            made.setToolTip(str(path))
        self.recent.setEnabled(not self.recent.isEmpty())

    # --- what is shown

    def show_start(self) -> None:
        """The first page; the docks make way."""
        self.first.build()
        self.stack.setCurrentWidget(self.first)
        self._around(False)

    def show_work(self) -> None:
        """Canvas and views."""
        if self.stack.currentWidget() is not self.work:
            self.stack.setCurrentWidget(self.work)
            self._around(True)
            self.canvas.setFocus()
            QTimer.singleShot(0, self.canvas.fit)

    def _around(self, on: bool) -> None:
        for dock in self.docks.values():
            dock.setVisible(on)
        self.bar.setVisible(on)

    def show_page(self, name: str) -> None:
        """A page of the lower dock, by the name of its action."""
        self.show_work()
        self.docks["Budget"].show()
        self.pages.show_page(name)

    def zoom_to(self, spot: Spot) -> None:
        """Bring a place of the data into view."""
        if not self.views.look_at(spot.node, spot.point, spot.seen):
            self.session.message.emit("warning", f"No view shows what {spot.node} gives: wire it into one to see the place")

    def show_help(self, module: str) -> None:
        """The help page of a module, in a window of its own; that of keys for none."""
        if not module:
            KeysPage(self).show()
            return
        window = QDialog(self)
        window.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        window.setWindowTitle("Help")
        page = HelpPage(self.session.catalogue)
        page.openRequested.connect(self.commands.open_path)
        page.show_module(module)
        column = QVBoxLayout(window)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(page)
        window.resize(640, 720)
        window.show()

    def restore(self, one: Lost, frozen: bool) -> None:
        """Take a document that a killed process left; its file is not touched."""
        try:
            network = one.network(self.session.catalogue)
        except NoniusError as error:
            self.session.message.emit("error", f"It cannot be restored: {error}")
            return
        self.session.adopt(network, one.path, frozen=frozen, unsaved=True)
        if self.session.log is not None:
            self.session.log.flush(2.0)
        one.discard()
        self.show_work()
        self.session.message.emit("info", f"Restored {one.name}; save it to keep it")

    def _add(self, module: str) -> None:
        self.show_work()
        self.canvas.hands.add(module)

    def _broken(self, name: str) -> None:
        broken = self.session.catalogue.broken.get(name)
        if broken is not None:
            self.pages.log.write(f"{broken.where} did not load: {broken.sentence}\n{broken.traceback}")
            self.show_page("log")

    def _pictured(self, tag: object, result: Any) -> None:
        if not (isinstance(tag, tuple) and tag[0] == "picture"):
            return
        if isinstance(result, Exception):
            self.session.message.emit("error", f"{tag[1].name} was not written: {result}")
        else:
            self.session.message.emit("info", f"Saved {tag[1].name} and its certificate. {result[1]}")

    # --- events

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Esc stops what runs, wherever the focus is."""
        if event.key() == Qt.Key.Key_Escape:
            self.session.cancel()
        else:
            super().keyPressEvent(event)

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Files are welcome."""
        if any(url.isLocalFile() for url in event.mimeData().urls()):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        """Open a network or a picture; read data."""
        self.take([Path(url.toLocalFile()) for url in event.mimeData().urls() if url.isLocalFile()])
        event.acceptProposedAction()

    def take(self, files: list[Path]) -> None:
        """Do the right thing with files."""
        networks = [f for f in files if dropping.is_network(f)]
        if networks:
            self.commands.open_path(networks[0])
        self.commands.add_data([f for f in files if f not in networks])

    def closeEvent(self, event: QCloseEvent) -> None:
        """Ask about changes; remember the arrangement; stop the threads."""
        if not self.commands.may_leave():
            event.ignore()
            return
        settings = QSettings()
        settings.setValue("geometry", self.saveGeometry())
        if self.stack.currentWidget() is self.work:
            settings.setValue("state", self.saveState(STATE))
        self.shut()
        event.accept()

    def shut(self) -> None:
        """Stop all threads."""
        self._soon.stop()
        self.session.close()
        self.studio.close()

    def _restore_layout(self) -> None:
        settings = QSettings()
        geometry, state = settings.value("geometry"), settings.value("state")
        if isinstance(geometry, QByteArray):
            self.restoreGeometry(geometry)
        if isinstance(state, QByteArray):
            self.restoreState(state, STATE)
