"""What the actions do, each a method named as in the table."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QSettings, QSize
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QFileDialog, QInputDialog, QMessageBox

from app import __version__
from app.commands.pictures import PAGE, Sheet
from app.engine.errors import NoniusError
from app.gui import dropping, folders, pictures, style
from app.gui.part_commands import PartCommands
from app.gui.picture_dialog import PictureDialog
from app.gui.places_page import Places
from app.gui.view_commands import ViewCommands

if TYPE_CHECKING:
    from app.gui.main_window import MainWindow

RECENT = 9
NETWORKS = "Networks and pictures (*.json *.png);;All files (*)"


class Commands(PartCommands, ViewCommands):
    """The actions of one window."""

    def __init__(self, window: MainWindow) -> None:
        self.window = window
        self.session = window.session
        self.settings = QSettings()

    def __call__(self, name: str) -> None:
        """Do an action; what goes wrong is one sentence."""
        do: Callable[[], object] = getattr(self, name)
        self.attempt(do)

    def attempt(self, do: Callable[[], object]) -> bool:
        """Whether it went well."""
        try:
            do()
        except (NoniusError, OSError) as error:
            self.session.message.emit("error", str(error))
            return False
        return True

    # --- files

    def new(self) -> None:
        """An empty network."""
        if self.may_leave():
            self.session.new()
            self.window.show_work()

    def open(self) -> None:
        """Ask for a file and open it."""
        chosen, _ = QFileDialog.getOpenFileName(self.window, "Open a network or a picture", self._folder("networks"), NETWORKS)
        if chosen:
            self.open_path(chosen)

    def open_path(self, path: str | Path) -> None:
        """Open a network or a picture."""
        if self.may_leave() and self.attempt(lambda: self.session.open(path)):
            self._remember(self.session.path)
            self.window.show_work()

    def open_data(self) -> None:
        """Ask for data and draw them."""
        chosen, _ = QFileDialog.getOpenFileName(self.window, "Open data", self._folder("data"))
        if chosen:
            self.add_data([Path(chosen)])

    def add_data(self, files: Iterable[Path]) -> None:
        """Add readers of files, with a first picture in an empty network."""
        for file in dropping.gathered(list(files)):
            dropping.read(self.session, file, lambda: self.window.show_work(), self._ask_shape)

    def _ask_shape(self, file: Path, facts: dict[str, Any], then: dropping.Asked) -> None:
        """A file of plain numbers: the user says what they are."""
        from app.gui.raw_dialog import ReadRaw

        dialog = ReadRaw(self.session, file, facts, self.window)
        dialog.accepted.connect(lambda: then(dialog.parameters))
        dialog.open()

    def save(self) -> bool:
        """Save; ask where if there is no file yet."""
        if self.session.path is None:
            return self.save_as()
        return self.attempt(self.session.save)

    def save_as(self) -> bool:
        """Ask where, and save."""
        start = str(self.session.path or Path(self._folder("networks")) / "network.json")
        chosen, _ = QFileDialog.getSaveFileName(self.window, "Save the network", start, "Networks (*.json)")
        if not chosen:
            return False
        path = Path(chosen) if Path(chosen).suffix else Path(chosen).with_suffix(".json")
        done = self.attempt(lambda: self.session.save(path))
        self._remember(self.session.path)
        return done

    def save_picture(self, node: str = "") -> None:
        """Ask how large and where, and write the view with its certificate."""
        shown = self.window.views.shown
        wanted = node or next((n for n in self.session.selection if n in shown), shown[0] if shown else "")
        pane = self.window.views.pane(wanted)
        scene = pane.scene() if pane else None
        if scene is None:
            self.session.message.emit("warning", "There is no picture yet: run the network first")
            return
        if self.session.stale(wanted):
            self.session.message.emit("warning", "The picture is of before the last edit: save it when the network has run")
            return
        dialog = PictureDialog(pane.back.plot.size() * pane.devicePixelRatioF() if pane else QSize(), self.window)
        if not dialog.exec():
            return
        stem = self.session.path.stem if self.session.path else "picture"
        start = str(Path(self._folder("pictures")) / f"{stem}-{wanted}.png")
        chosen, _ = QFileDialog.getSaveFileName(self.window, "Save the picture", start, "Pictures (*.png)")
        if chosen:
            self.write_picture(wanted, Path(chosen).with_suffix(".png"), dialog.sheet)

    def write_picture(self, node: str, target: Path, sheet: Sheet = PAGE) -> None:
        """Write the view of a node; `message` says when it is done."""
        session = self.session
        found = next(((o, v) for o, v in (session.outputs(node) or {}).items() if type(v).__name__ == "Scene"), None)
        if found is None:
            return
        output, scene = found
        network, path, catalogue = session.network, session.path, session.catalogue
        session.message.emit("info", f"Drawing {target.name}…")
        job = lambda: pictures.write(scene, node, output, target, network, path, catalogue, sheet)  # noqa: E731
        self.window.studio.do(("picture", target), job)

    def quit(self) -> None:
        """Close the window."""
        self.window.close()

    def may_leave(self) -> bool:
        """Ask about changes that are not saved; whether to go on."""
        if not self.session.modified:
            return True
        name = self.session.path.name if self.session.path else "This network"
        box = QMessageBox(self.window)
        box.setWindowTitle("Unsaved changes")
        box.setText(f"{name} has changes that are not saved.")
        save = box.addButton("Save", QMessageBox.ButtonRole.AcceptRole)
        box.addButton("Discard", QMessageBox.ButtonRole.DestructiveRole)
        cancel = box.addButton("Cancel", QMessageBox.ButtonRole.RejectRole)
        box.setDefaultButton(save)
        box.exec()
        if box.clickedButton() is save:
            return self.save()
        return box.clickedButton() is not cancel

    def recent(self) -> list[Path]:
        """Networks opened or saved, the latest first."""
        held: Any = self.settings.value("recent", [])
        return [Path(p) for p in (held if isinstance(held, list) else [held]) if p]

    def _remember(self, path: Path | None) -> None:
        if path is not None:
            kept = [str(path.absolute()), *(str(p) for p in self.recent() if p != path.absolute())][:RECENT]
            self.settings.setValue("recent", kept)
            self.window.fill_recent()

    def _folder(self, kind: str) -> str:
        return str(folders.start(kind, self.session.path))

    # --- edits

    def undo(self) -> None:
        """Back by a step."""
        self.session.undo()

    def redo(self) -> None:
        """Forward by a step."""
        self.session.redo()

    def cut(self) -> None:
        """Copy and delete."""
        self.window.canvas.hands.cut()

    def copy(self) -> None:
        """Copy as text."""
        self.session.copy()

    def paste(self) -> None:
        """Add what was copied."""
        self.session.paste(QGuiApplication.clipboard().text(), incoming=False)

    def paste_wired(self) -> None:
        """Add what was copied, with wires from nodes that are here."""
        self.session.paste(QGuiApplication.clipboard().text())

    def duplicate(self) -> None:
        """Again, beside it."""
        self.window.canvas.hands.duplicate()

    def remove(self) -> None:
        """Delete the chosen."""
        self.window.canvas.hands.remove()

    def select_all(self) -> None:
        """Choose every node."""
        self.session.select(self.session.network.nodes)

    def find(self) -> None:
        """Look for a node."""
        self.window.canvas.find()

    def rename(self) -> None:
        """Another title."""
        self.window.canvas.rename()

    def replace(self) -> None:
        """Another module in the place of the chosen one."""
        self.window.show_work()
        self.window.canvas.replace(self.session.selection[0])

    def frame(self) -> None:
        """A frame around the chosen."""
        self.window.canvas.hands.frame()

    def note(self) -> None:
        """A note on the canvas."""
        self.window.canvas.hands.note()

    def arrange(self) -> None:
        """Put the nodes in order."""
        self.window.canvas.hands.arrange()

    def add_module(self) -> None:
        """Search modules where the pointer is."""
        self.window.show_work()
        self.window.canvas.setFocus()
        self.window.canvas.quick_add()

    def preferences(self) -> None:
        """Theme, threads, cache."""
        from app.gui.preferences import Preferences

        Preferences(self.window).exec()

    # --- looking

    def fit_canvas(self) -> None:
        """All of the network."""
        self.window.canvas.fit()

    def zoom_selection(self) -> None:
        """To the chosen."""
        self.window.canvas.zoom_to(self.session.selection)

    def zoom_in(self) -> None:
        """Larger."""
        self.window.canvas.zoom_by(1.25)

    def zoom_out(self) -> None:
        """Smaller."""
        self.window.canvas.zoom_by(0.8)

    def zoom_one(self) -> None:
        """As it is."""
        self.window.canvas.set_zoom(1.0)

    def theme_system(self) -> None:
        """As the system has it."""
        self._theme("system")

    def theme_light(self) -> None:
        """Light."""
        self._theme("light")

    def theme_dark(self) -> None:
        """Dark."""
        self._theme("dark")

    def _theme(self, choice: str) -> None:
        self.settings.setValue("theme", choice)
        style.choose(choice)

    def start_page(self) -> None:
        """Examples and recent files."""
        self.window.show_start()

    # --- running

    def run_all(self) -> None:
        """Every node."""
        self.session.run_all()

    def run_to(self) -> None:
        """All that the chosen node needs."""
        self.session.run_to(self.session.selection[0])

    def fire(self) -> None:
        """The chosen nodes again."""
        for node in self.session.selection:
            self.session.fire(node)

    def stop(self) -> None:
        """Stop what runs."""
        self.session.cancel()

    def freeze(self) -> None:
        """Nothing runs, or runs again."""
        self.session.freeze(not self.session.frozen)

    def hold(self) -> None:
        """Hold the chosen nodes, or let them go."""
        for node in self.session.selection:
            self.session.hold(node)

    def disable(self) -> None:
        """Disable the chosen nodes, or enable them."""
        for node in self.session.selection:
            self.session.disable(node)

    def bypass(self) -> None:
        """Let what comes into the chosen nodes go on, or let them fire again."""
        self.session.bypass(self.session.selection)

    # --- accuracy and help

    def budget(self) -> None:
        """The page of the budget."""
        self.window.show_page("budget")

    def overview(self) -> None:
        """The page of all sources of a picture."""
        self.window.show_page("overview")

    def flags(self) -> None:
        """The page of the flags."""
        self.window.show_page("flags")

    def worst(self) -> None:
        """The page of the worst places."""
        self.window.show_page("worst")

    def next_place(self) -> None:
        """To the next place of the chosen flag or of the worst places."""
        page = self.window.pages.currentWidget()
        (page if isinstance(page, Places) else self.window.pages.flags).go(1)

    def problems(self) -> None:
        """The page of what does not run."""
        self.window.show_page("problems")

    def log(self) -> None:
        """The page of the log."""
        self.window.show_page("log")

    def coverage(self) -> None:
        """Ask for k."""
        words = "Standard deviations count k times in totals, legends and certificates; 2 covers about 95 %."
        k, done = QInputDialog.getDouble(self.window, "Coverage factor", words, self.session.network.k, 0.1, 10.0, 2)
        if done:
            self.session.edit("Set the coverage factor", self.session.network.settle(k=k))

    def palette(self) -> None:
        """Find an action by its name."""
        from app.gui.palette import Palette

        Palette(self.window).show()

    def about(self) -> None:
        """Which version this is."""
        words = (
            f"Nonius Explorer {__version__}\n\nNetworks of modules in which every wire carries the data and what is known "
            "about its accuracy.\n\nAfter A. Lopes, Accuracy in Scientific Visualization (1999)."
        )
        QMessageBox.about(self.window, "About Nonius Explorer", words)
