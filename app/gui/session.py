"""One document in the window: the one door for every change, and the place where all that is shown is asked for."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal
from PySide6.QtGui import QGuiApplication

from app.commands.budget import glance as glance_of
from app.commands.budget import reach
from app.engine import document, paths
from app.engine.catalogue import Catalogue, mine
from app.engine.errors import DocumentError, NoniusError
from app.engine.history import History
from app.engine.network import Network
from app.engine.results import Results
from app.gui import clips
from app.gui.budgets import Budget, budget_of
from app.gui.recovery import Log
from app.gui.runs import Runs
from app.gui.state import NodeState
from app.gui.worker import Looker
from modules.data.accuracy import Accuracy, Line
from modules.data.wires import Scene

__all__ = ["NodeState", "Session"]

COALESCE = 30
"""Milliseconds in which edits of a held slider become one wave."""


class Session(QObject):
    """A document that is edited, run and looked at.

    Parameters
    ----------
    catalogue : the modules; everything installed by default
    results : store of results; a new one by default
    workers : nodes that run at once; as many as cores for 0
    log : where edits are written for the case that the program is killed; nowhere by default
    """

    networkChanged = Signal()
    stateChanged = Signal(str)
    resultChanged = Signal(str)
    selectionChanged = Signal()
    waveDone = Signal(str)
    message = Signal(str, str)
    pathChanged = Signal()

    def __init__(
        self,
        catalogue: Catalogue | None = None,
        *,
        results: Results | None = None,
        log: Log | None = None,
        workers: int = 0,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.catalogue = mine() if catalogue is None else catalogue
        self.history = History(Network())
        self.path: Path | None = None
        self.selection: tuple[str, ...] = ()
        self.frozen = False
        self.log = log
        self.looker = Looker(self)
        self.looker.ready.connect(self._looked)
        self.runs = Runs(self.catalogue, results, self, workers)
        self.runs.stateChanged.connect(self.stateChanged)
        self.runs.resultChanged.connect(self.resultChanged)
        self.runs.waveDone.connect(self.waveDone)
        self._observed: dict[str, tuple[str, ...]] = {}
        self._timer = QTimer(self, singleShot=True)
        self._timer.timeout.connect(self._want)
        self._interim = False
        self._closed = False

    # --- the document

    @property
    def network(self) -> Network:
        """The present network."""
        return self.history.network

    @property
    def modified(self) -> bool:
        """Whether the file holds another network, or there is none."""
        return self.history.modified

    def edit(self, label: str, network: Network, *, merge: Hashable = None, interim: bool = False) -> None:
        """Go on from an edit: the one door for every change.

        Parameters
        ----------
        label : in the words of the Edit menu, "Set interval"
        merge : edits in a row under one such word are one step of undo
        interim : more is to come, a slider is held
        """
        same = network is self.network
        self.history.commit(label, network, merge)
        if not interim and merge is not None:
            self.history.seal()
        if same:
            if self._interim and not interim:
                self._schedule(interim=False)
            return
        self._follow(interim)

    def amend(self, network: Network) -> None:
        """Change how the network is looked at, without a step of undo and without firing: a camera, an open panel."""
        if network is not self.network:
            self.history.amend(network)
            self._follow(interim=False)

    def undo(self) -> None:
        """Back by a step."""
        self._go(self.history.undo)

    def redo(self) -> None:
        """Forward by a step."""
        self._go(self.history.redo)

    def _go(self, step: Any) -> None:
        before = self.network
        if step() is not before:
            self._follow(interim=False)

    def _follow(self, interim: bool) -> None:
        network = self.network
        fires = self.runs.follow(network)
        if self.log is not None:
            self.log.put(network, self.path, self.history.labels[self.history.place])
        kept = tuple(n for n in self.selection if n in network.nodes)
        self.networkChanged.emit()
        if kept != self.selection:
            self.select(kept)
        if fires:
            self._schedule(interim)

    # --- files

    def new(self) -> None:
        """An empty document."""
        self.adopt(Network(), None)

    def open(self, path: Path | str) -> None:
        """Open a network, or the one a picture carries (frozen).

        Raises
        ------
        NoniusError : it cannot be read; the present document stays
        """
        from app.commands import nets

        found = nets.find(str(path), self.catalogue)
        picture = found.kind == "picture"
        self.adopt(found.network, found.path if found.kind == "file" else None, frozen=picture)
        for sentence in found.warnings:
            self.message.emit("warning", sentence)
        if picture:
            reads = nets.reads(found.network, self.catalogue)
            what = "; ".join(reads) if reads else "it reads no file"
            self.message.emit("info", f"Opened frozen, from a picture: {what}. Unfreeze it in the Run menu to run it")

    def adopt(self, network: Network, path: Path | None, *, frozen: bool = False, unsaved: bool = False) -> None:
        """Take a network as a new document.

        Parameters
        ----------
        unsaved : it holds more than its file
        """
        self.runs.cancel()
        self.looker.forget()
        self.history = History(network)
        if unsaved:
            self.history.saved(Network())
            self.history.amend(network)
        self.path, self.frozen, self.selection = path, frozen, ()
        self._observed.clear()
        self.runs.follow(network, fresh=True)
        if self.log is not None:
            self.log.begin(network if unsaved else None, path)
        self.networkChanged.emit()
        self.pathChanged.emit()
        self.selectionChanged.emit()
        self._schedule(interim=False)

    def save(self, path: Path | str | None = None) -> None:
        """Write the network to its file, or to another.

        Raises
        ------
        NoniusError : it could not be written, or has no file yet
        """
        target = Path(path) if path is not None else self.path
        if target is None:
            raise DocumentError("this network has no file yet: choose one with Save as")
        saved = document.save(self.network, target, self.catalogue)
        self.history.saved(saved.network)
        self.path = saved.path
        self.runs.follow(self.network)
        if self.log is not None:
            self.log.begin(None, self.path)
        self.networkChanged.emit()
        self.pathChanged.emit()
        for sentence in saved.warnings:
            self.message.emit("warning", sentence)
        self.message.emit("info", f"Saved {saved.path.name}")

    def copy(self) -> str:
        """The selected nodes as text, also on the clipboard."""
        if not self.selection:
            return ""
        text = clips.text(self.network.part(self.selection), self.catalogue)
        QGuiApplication.clipboard().setText(text)
        return text

    def paste(self, text: str, incoming: bool = True) -> None:
        """Add nodes from text and select them; text that is no network says so in a message."""
        try:
            part = clips.part(text, self.catalogue)
            names = self.network.pasted_ids(part)
            network = self.network.paste(part, self.catalogue, incoming=incoming, by=(32.0, 32.0))
        except NoniusError as error:
            self.message.emit("error", str(error))
            return
        self.edit("Paste", network)
        self.select(names.values())

    # --- looking

    def select(self, nodes: Iterable[str]) -> None:
        """Choose nodes; their panels are shown and their results wanted."""
        chosen = tuple(dict.fromkeys(n for n in nodes if n in self.network.nodes))
        if chosen == self.selection:
            return
        self.selection = chosen
        self.selectionChanged.emit()
        self.observe("selection", chosen[:1])

    def observe(self, who: str, nodes: Iterable[str]) -> None:
        """Say whose results are looked at by a part of the window; "views" are all views until someone says."""
        names = tuple(nodes)
        before = self._observed.get(who, ())
        self._observed[who] = names
        if not set(names) <= set(before):
            self._schedule(interim=False)

    @property
    def wanted(self) -> tuple[str, ...]:
        """Nodes whose results are looked at."""
        said = {"views": self.views(), **self._observed}
        return tuple(dict.fromkeys(n for names in said.values() for n in names if n in self.network.nodes))

    def views(self) -> tuple[str, ...]:
        """Nodes that give a scene."""
        return tuple(n for n, node in self.network.nodes.items() if self._gives_scene(node.module))

    def _gives_scene(self, module: str) -> bool:
        record = self.catalogue.get(module)
        return record is not None and any(o.type is Scene for o in record.outputs)

    def state(self, node: str) -> NodeState:
        """How a node is."""
        return self.runs.state(node)

    def outputs(self, node: str) -> Mapping[str, Any] | None:
        """The last good result of a node, also when it is stale; None if there is none."""
        entry = self.runs.entry(node)
        return None if entry is None else entry.outputs

    def stale(self, node: str) -> bool:
        """Whether `outputs` are of an earlier network."""
        return self.runs.stale(node)

    def facts(self, node: str) -> Mapping[str, Mapping[str, Any]]:
        """Facts of the outputs of a node, as far as known."""
        return self.runs.facts(node)

    def input_facts(self, node: str) -> Mapping[str, Mapping[str, Any]]:
        """Facts of what is wired to the ports of a node, by port."""
        found: dict[str, Mapping[str, Any]] = {}
        for port, origins in self.network.incoming.get(node, {}).items():
            source, output = origins[0]
            facts = self.facts(source).get(output.partition(":")[0])
            if facts:
                found[port] = facts
        return found

    def peeked(self, node: str) -> Mapping[str, Mapping[str, Any]]:
        """What a reader's file says of itself, under the name of the parameter; empty until it was read."""
        there = self.network[node]
        record = self.catalogue.get(there.module)
        if record is None or record.peek is None:
            return {}
        found: dict[str, Mapping[str, Any]] = {}
        for parameter in record.parameters:
            value = there.parameters.get(parameter.name)
            if parameter.is_path and value:
                facts = self.look("peek", node, str(value), job=partial(self._peek, record.peek, value, self.network.folder))
                found |= {parameter.name: facts} if isinstance(facts, Mapping) else {}
        return found

    @staticmethod
    def _peek(peek: Callable[[Path], Mapping[str, Any]], value: Any, folder: Path | None) -> Mapping[str, Any]:
        return dict(peek(paths.locate(value, folder)))

    def glance(self, node: str, output: str) -> tuple[Line, ...]:
        """What is known of the accuracy of an output, over some items; () until it is known, then `resultChanged`."""
        accuracy = self.accuracy(node, output)
        if accuracy is None:
            return ()
        found = self.looker.ask(("glance", node, output, self.runs.key(node)), lambda: tuple(glance_of(accuracy)))
        return found if isinstance(found, tuple) else ()

    def budget(self, node: str, output: str) -> Budget | None:
        """The budget of an output with its totals; None until it is known, then `resultChanged`."""
        accuracy = self.accuracy(node, output)
        if accuracy is None:
            return None
        k, value = self.network.k, (self.outputs(node) or {}).get(output.partition(":")[0])
        key = ("budget", node, output, self.runs.key(node), k)
        found = self.looker.ask(key, lambda: budget_of(accuracy, k, reach(value)))
        return found if isinstance(found, Budget) else None

    def accuracy(self, node: str, output: str) -> Accuracy | None:
        """Unevaluated, of an output whose result is there."""
        value = (self.outputs(node) or {}).get(output.partition(":")[0])
        found = getattr(value, "accuracy", None)
        return found if isinstance(found, Accuracy) else None

    def look(self, what: str, node: str, *key: Hashable, job: Callable[[], Any]) -> Any:
        """What a job gives that is done outside the window's thread; None until it is done, then `resultChanged`."""
        return self.looker.ask((what, node, *key), job)

    def _looked(self, key: Hashable) -> None:
        if isinstance(key, tuple) and key[1] in self.network.nodes:
            self.resultChanged.emit(key[1])

    # --- running

    def cancel(self) -> None:
        """Stop what runs; what has been computed stays."""
        self._timer.stop()
        self._observed.pop("run to", None)
        self.runs.cancel()

    def fire(self, node: str) -> None:
        """Run a node, also one that is held or failed before."""
        self.runs.fire(node)

    def run_to(self, node: str) -> None:
        """Run all that a node needs, and the node."""
        self._observed["run to"] = (node,)
        self._schedule(interim=False, always=True)

    def run_all(self) -> None:
        """Run every node on which no other hangs."""
        self._observed["run to"] = self.network.sinks()
        self._schedule(interim=False, always=True)

    def freeze(self, frozen: bool) -> None:
        """Run nothing until unfrozen; edits go on."""
        if frozen != self.frozen:
            self.frozen = frozen
            if frozen:
                self.cancel()
            else:
                self._schedule(interim=False)
            self.networkChanged.emit()

    def hold(self, node: str) -> None:
        """Let a node fire only when it is told to, or let it go again."""
        held = self.network[node].view.get("held")
        self.amend(self.network.look(node, held=None if held else True))
        self.stateChanged.emit(node)
        self._schedule(interim=False)

    def disable(self, node: str) -> None:
        """Let a node give nothing, or give again."""
        off = not self.network[node].disabled
        self.edit(f"{'Disable' if off else 'Enable'} {node}", self.network.disable(node, off))

    def bypass(self, nodes: Iterable[str]) -> None:
        """Let what comes into nodes go on in place of what they give; if all are bypassed they fire again.

        Raises
        ------
        TypeMismatch : a node gives another type than it takes
        """
        names = tuple(nodes)
        on = not all(self.network[n].bypass for n in names)
        network = self.network
        for name in names:
            network = network.pass_through(name, on, self.catalogue)
        what = names[0] if len(names) == 1 else f"{len(names)} nodes"
        self.edit(f"Bypass {what}" if on else f"Let {what} fire again", network)

    def _schedule(self, interim: bool, always: bool = False) -> None:
        if self._closed or (self.frozen and not always):
            return
        if not interim:
            self._interim = False
            self._timer.start(0)
        elif not self._timer.isActive():
            self._interim = True
            self._timer.start(COALESCE)

    def _want(self) -> None:
        wanted = self.wanted
        self.runs.keep = frozenset(wanted)
        self.runs.want(wanted, self._interim)

    def close(self) -> None:
        """Stop the threads; the edits are no longer needed for recovery."""
        self._closed = True
        self._timer.stop()
        self.runs.close()
        self.looker.close()
        if self.log is not None:
            self.log.close()
