"""Files dropped on the window: networks and pictures are opened, data are read, modelled and drawn."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from app.engine.errors import NoniusError
from app.engine.network import Network
from app.gui.session import Session
from modules.records import Module

COLUMN, STEP = 226.0, 112.0


def is_network(file: Path) -> bool:
    """Whether a file is opened rather than read as data."""
    if file.suffix.lower() == ".json":
        return True
    if file.suffix.lower() != ".png":
        return False
    from app.engine import certificate, pngtext

    try:
        return certificate.NETWORK in pngtext.texts(file.read_bytes())
    except (OSError, pngtext.NotPNG):
        return False


def gathered(files: Sequence[Path]) -> list[Path]:
    """Files whose names differ in one number alone are a series: one pattern."""
    pattern = pattern_of(files)
    return list(files) if pattern is None else [pattern]


def pattern_of(some: Sequence[Path]) -> Path | None:
    """The pattern of files whose names differ in one number alone; None if they do not."""
    if len(some) < 2 or len({p.parent for p in some}) > 1:
        return None
    parts = [re.split(r"(\d+)", p.name) for p in some]
    if len({len(p) for p in parts}) > 1:
        return None
    differ = [i for i, words in enumerate(zip(*parts, strict=True)) if len(set(words)) > 1]
    if len(differ) != 1 or differ[0] % 2 == 0:
        return None
    return some[0].parent / "".join("*" if i == differ[0] else word for i, word in enumerate(parts[0]))


Asked = Callable[[dict[str, Any]], None]
Ask = Callable[[Path, dict[str, Any], Asked], object]


def read(session: Session, file: Path, done: Callable[[], object], ask: Ask) -> None:
    """Add a reader of a file; in an empty network with a model and a first picture. Files are looked at in a thread.

    Parameters
    ----------
    done : called when the network has it
    ask : called with the file, its facts and what to call with the parameters, of a file that does not say what it holds
    """

    def look() -> Any:
        return reader_of(session, file)

    def add(key: object) -> None:
        if key != ("data", str(file)):
            return
        session.looker.ready.disconnect(add)
        found = session.looker.ask(key, look)
        if not isinstance(found, tuple):
            session.message.emit("error", f"{file.name} cannot be read: {found or 'no reader takes it'}")
            return
        record, facts = found
        if facts.get("problem"):
            ask(file, facts, lambda parameters: put(record, facts, parameters))
        else:
            put(record, facts, {})

    def put(record: Module, facts: dict[str, Any], parameters: dict[str, Any]) -> None:
        try:
            network, node = added(session, file, record, facts, parameters)
        except NoniusError as error:
            session.message.emit("error", str(error))
            return
        session.edit(f"Read {file.name}", network)
        session.select([node])
        done()

    session.looker.ready.connect(add)
    if session.looker.ask(("data", str(file)), look) is not None:
        add(("data", str(file)))


def reader_of(session: Session, file: Path) -> tuple[Module, dict[str, Any]] | str:
    """The reader that takes a file with what it says of it; or why the one whose kind of file it is does not."""
    why, second, bare = "", None, None  # second: takes the file, though its points lie on no lattice
    for record in session.catalogue.room("readers"):
        if record.peek is None:
            continue
        try:
            facts = dict(record.peek(file))
        except Exception as error:
            why = why or str(error)
            continue
        problem = facts.get("problem")
        if not problem and facts.get("lattice", True):
            return record, facts
        if facts.get("bytes") and not facts.get("foreign"):  # numbers without a header: the user is asked
            bare = (record, facts)
        if not problem:
            second = second or (record, facts)
        elif not facts.get("foreign"):
            why = why or str(problem)
    kind = "folders" if file.is_dir() else "files"
    return second or bare or why or f"no reader takes {kind} that end in {file.suffix or 'nothing'!r}"


def added(
    session: Session, file: Path, record: Module, facts: dict[str, Any], parameters: dict[str, Any]
) -> tuple[Network, str]:
    """The network with the reader, and the id of that."""
    network, catalogue = session.network, session.catalogue
    lowest = max((float(n.view.get("position", (0, 0))[1]) for n in network.nodes.values()), default=-STEP)
    y = lowest + STEP
    path = next(p.name for p in record.parameters if p.is_path)
    node = network.fresh_id(record.id)
    view = {"position": [0.0, y]}
    network = network.add(record.id, catalogue, id=node, parameters={path: file.absolute(), **parameters}, view=view)
    shape = tuple(reversed(parameters.get("size", facts.get("shape") or ())))
    return _drawn(session, network, node, y, {**facts, "shape": shape}), node


def _drawn(session: Session, network: Network, node: str, y: float, facts: dict[str, Any]) -> Network:
    """With a model, contour lines over the relief, where they may lie if the file states errors, and a view.

    Of what has three axes only the model.
    """
    catalogue = session.catalogue

    def put(network: Network, module: str, column: int, row: float, wires: list[tuple[str, str]]) -> tuple[Network, str]:
        name = network.fresh_id(catalogue.find(module).id)
        network = network.add(module, catalogue, id=name, view={"position": [column * COLUMN, y + row * STEP]})
        for source, port in wires:
            output = catalogue[network[source].module].outputs[0].name
            network = network.connect(source, output, name, port, catalogue)
        return network, name

    if facts.get("scattered"):
        network, node = put(network, "modellers.grid_points.grid_points", 0, 1, [(node, "points")])
    network, model = put(network, "modellers.interpolate.interpolate", 1, 0, [(node, "samples")])
    shape = facts.get("shape") or ()
    if len([n for n in shape if n > 1]) > 2:
        return network
    network, contour = put(network, "mappers.contour.contour", 2, 0, [(model, "model")])
    network, lines = put(network, "renderers.lines.lines", 3, 0, [(contour, "geometry")])
    network, relief = put(network, "renderers.image.image", 3, 1, [(node, "samples")])
    layers = [(relief, "layers"), (lines, "layers")]
    if facts.get("errors"):
        network, band = put(network, "accuracy_mappers.band.band", 3, 2, [(contour, "lines"), (model, "model")])
        network, fuzz = put(network, "renderers.surface.surface", 4, 2, [(band, "geometry")])
        network = network.set(fuzz, "colour", "dust", catalogue).set(fuzz, "opacity", 0.14, catalogue)
        layers.insert(1, (fuzz, "layers"))
    network, _ = put(network, "renderers.view.view", 5 if facts.get("errors") else 4, 0, layers)
    return network.set(relief, "show", "relief", catalogue)
