"""One view of a network: its picture, its legend, what is picked in it, and a note when the picture is of before."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from PySide6.QtCore import QEvent, QObject, Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QFrame, QHBoxLayout, QInputDialog, QLabel, QVBoxLayout, QWidget

from app.draw.styles import Ranges, Wardrobe
from app.gui import bookmarks, cameras, icons, style, view_menu
from app.gui.backends import BackEnd, back_end
from app.gui.legend_box import LegendBox
from app.gui.pick_tool import PickTool
from app.gui.session import Session
from app.gui.studio import Studio
from app.gui.widgets.parts import Elided, tool
from app.legend import Legend, legend
from modules.data.scene import Scene


class ViewPane(QWidget):
    """One view: a title bar, the picture, the legend over it."""

    pictureAsked = Signal(str)
    sceneChanged = Signal()

    def __init__(self, session: Session, studio: Studio, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session = session
        self.node = ""
        self.as_saved = False
        self.back: BackEnd = back_end(studio, self)
        self.legend = LegendBox(self.back)
        self.legend.placed.connect(self.back.reserve)
        self.pick = PickTool(session, self.back, self, self._keys)
        self._wardrobe = Wardrobe()
        self._ranges: Ranges = {}
        self._dress: tuple[str, bool] = ("as made", False)
        self._scene: Scene | None = None
        self._shown: Scene | None = None
        self._tag: object = None
        self._build()
        self.back.cameraChanged.connect(self.keep_camera)
        self.back.framed.connect(self._framed)
        self.back.failed.connect(self._cannot)
        self.back.installEventFilter(self)
        session.resultChanged.connect(self._result)
        session.networkChanged.connect(self._redress)
        session.stateChanged.connect(self._state)
        style.watch().changed.connect(self._restyle)

    def _build(self) -> None:
        self.title = style.labelled("View", "title")
        self.name = Elided("quiet")
        self.note = style.labelled("", "boxed")
        self.note.setFixedHeight(20)
        self.bar = QFrame()
        self.bar.setProperty("kind", "bar")
        self.bar.setFixedHeight(32)
        row = QHBoxLayout(self.bar)
        row.setContentsMargins(12, 0, 6, 0)
        row.setSpacing(8)
        row.addWidget(self.title)
        row.addWidget(self.name, 1)
        row.addWidget(self.note)
        tip = "Pick: a click reads value and error there. P picks under the pointer, Ctrl+click without the tool"
        self.picker = tool("target", tip, self._picking)
        self.picker.setCheckable(True)
        self.cube = tool("cube", "How it is seen: axes, bookmarks, perspective, wireframe", self._menu)
        self.tools = [
            self.picker,
            self.cube,
            tool("fit", "See all of the scene (double click)", lambda: self.back.fit()),
            tool("camera", "Save the picture with its certificate…", lambda: self.pictureAsked.emit(self.node)),
        ]
        for one in self.tools:
            row.addWidget(one)
        self.words = QLabel(self.back)
        self.words.setProperty("kind", "quiet")
        self.words.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.words.setWordWrap(True)
        self.words.setTextFormat(Qt.TextFormat.PlainText)
        self.words.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.bar)
        column.addWidget(self.back, 1)

    # --- what is shown

    def show_node(self, node: str) -> None:
        """Show the view of a node; "" for none."""
        if node != self.node:
            self.node = node
            self._scene = self._shown = None
            self.legend.tell(None)
            self.back.show_scene(None, None)
            self.pick.show_scene(node, None)
        self.refresh()

    def refresh(self) -> None:
        """Show the newest result, and how the node is."""
        session = self.session
        if self.node not in session.network.nodes:
            return
        title = session.network[self.node].parameters.get("title")
        self.name.setText(str(title or self.node))
        self.setAccessibleName(f"View {title or self.node}")
        scene = self.scene()
        dress = (self.drawing, self.numbered)
        fresh = scene is not None and scene is not self._scene
        if fresh or (dress != self._dress and self._scene is not None):
            self._scene, self._dress = scene or self._scene, dress
            self._draw()
        if fresh:
            self.sceneChanged.emit()
        if self._scene is not None:
            self._legend()
        self.pick.refresh()
        self._note()

    def scene(self) -> Scene | None:
        """The last one there was."""
        outputs = self.session.outputs(self.node) or {}
        return next((v for v in outputs.values() if isinstance(v, Scene)), None)

    def _draw(self) -> None:
        assert self._scene is not None
        scene = self._wardrobe.dressed(self._scene, self.drawing, self._ranges)
        if not self.as_saved and scene.look.theme != style.present().name:
            scene = replace(scene, look=replace(scene.look, theme=style.present().name))
        camera = None
        if self._shown is None:
            camera = self.session.network[self.node].view.get("camera")
        self._shown = scene
        self._tag = self._scene
        self.back.show_scene(scene, camera, self._tag, self.numbered)
        self.pick.show_scene(self.node, scene)

    def _legend(self) -> None:
        scene, k = self._shown, self.session.network.k
        if scene is None:
            return
        found = self.session.look("legend", self.node, id(scene), k, job=lambda: (scene, legend(scene, k=k)))
        if isinstance(found, tuple) and isinstance(found[1], Legend):
            if self.legend.legend is not found[1]:
                self.legend.tell(found[1], scene.look.legend)

    def _note(self) -> None:
        state = self.session.state(self.node)
        shown = self._scene is not None
        late = shown and (self.session.stale(self.node) or self.back.tag is not self._tag)
        note = ""
        if state.kind in ("failed", "blocked", "disabled", "missing", "held") and shown:
            note = f"previous picture: {state.sentence or state.kind}"
        elif late:
            running = next((self.session.state(n) for n in self.session.runs.busy), None)
            part = f", next at {running.progress:.0%}" if running and running.progress else ""
            note = f"previous picture{part}" if self.back.tag is not None else "drawing…"
        if self.session.frozen and late:
            note = "previous picture: the network is frozen"
        self.note.setText(note if len(note) < 70 else note[:68] + "…")
        self.note.setToolTip(note)
        self.note.setVisible(bool(note))
        self._say("" if shown else self._empty(state.kind, state.sentence))

    def _empty(self, kind: str, sentence: str) -> str:
        if self.session.frozen:
            return "Frozen. Unfreeze the network in the Run menu to see it."
        if kind in ("queued", "running", "dirty"):
            busy = self.session.runs.busy
            return f"{busy[0]} is running…" if busy else "Waiting for the network…"
        return sentence or "Nothing to see yet: wire a layer into this view."

    def _say(self, words: str) -> None:
        self.words.setText(words)
        self.words.setVisible(bool(words))
        self.words.setGeometry(self.back.rect().adjusted(24, 24, -24, -24))

    # --- what happens

    def _result(self, node: str) -> None:
        if node == self.node:
            self.refresh()

    def _redress(self) -> None:
        if self._scene is not None and (self.drawing, self.numbered) != self._dress:
            self.refresh()

    def _state(self, node: str) -> None:
        if self.node in self.session.network.nodes:
            self._note()

    def _framed(self, tag: object) -> None:
        self._note()

    def keep_camera(self, camera: dict[str, Any]) -> None:
        """Remember from where the view is seen, in the view data of its node."""
        network = self.session.network
        if self.node in network.nodes and self._scene is not None and network[self.node].view.get("camera") != camera:
            self.session.amend(network.look(self.node, camera=camera))

    def _cannot(self, sentence: str) -> None:
        self._say(sentence)
        self.session.message.emit("error", f"{self.node} cannot be drawn: {sentence}")

    def _restyle(self) -> None:
        for one in self.tools:
            one.setIcon(icons.icon(str(one.property("drawing")), "text 2"))
        if self._scene is not None:
            self._draw()
        self.pick.box.restyle()
        self.legend.arrange()

    def _picking(self) -> None:
        self.pick.use(self.picker.isChecked())

    # --- how it is seen

    @property
    def drawing(self) -> str:
        """How surfaces are drawn; view data of the node."""
        return str(self._view("drawing", "as made"))

    @property
    def numbered(self) -> bool:
        """Whether the axes of a scene in space have numbers; view data of the node."""
        return bool(self._view("numbers", False))

    def _view(self, name: str, otherwise: object) -> object:
        network = self.session.network
        return network[self.node].view.get(name, otherwise) if self.node in network.nodes else otherwise

    def draw_as(self, drawing: str) -> None:
        """Draw surfaces in another way."""
        if self.node and drawing != self.drawing:
            told = None if drawing == "as made" else drawing
            self.session.edit(f"Draw {drawing}", self.session.network.look(self.node, drawing=told))

    def number(self) -> None:
        """Put numbers on the axes, or take them away."""
        if self.node:
            told = None if self.numbered else True
            self.session.edit("Numbers on the axes", self.session.network.look(self.node, numbers=told))

    def colour_on(self, ranges: Ranges) -> None:
        """Colour values on ranges that other views have too."""
        self._ranges = ranges
        if self._scene is not None:
            self._draw()
            self._legend()

    def see(self, camera: cameras.Camera) -> None:
        """See from there."""
        self.back.set_camera(camera)
        self.keep_camera(camera)

    def bookmark(self) -> None:
        """Ask for a name, and keep from where the view is seen."""
        camera, network = self.back.camera, self.session.network
        if camera is None:
            return
        words = "Name of the bookmark; Ctrl+1 to Ctrl+9 lead back to it"
        name, done = QInputDialog.getText(self, "Bookmark the view", words, text=bookmarks.fresh(network, self.node))
        if done and name.strip():
            self.session.edit(f"Bookmark {name.strip()}", bookmarks.kept(network, self.node, name.strip(), camera))

    def forget(self, name: str) -> None:
        """Take a bookmark away."""
        self.session.edit(f"Forget {name}", bookmarks.without(self.session.network, self.node, name))

    def _menu(self) -> None:
        if self.back.camera is not None:
            view_menu.build(self).exec(self.cube.mapToGlobal(self.cube.rect().bottomLeft()))

    def _keys(self, event: QKeyEvent) -> bool:
        return view_menu.press(self, event)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """The legend and the words follow the size of the picture."""
        if event.type() == QEvent.Type.Resize:
            self.legend.arrange()
            self.pick.box.arrange()
            self.words.setGeometry(self.back.rect().adjusted(24, 24, -24, -24))
        return False
