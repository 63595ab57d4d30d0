"""Networks in files: text -> record -> migrated record -> live network, and back, byte for byte.

UTF-8 JSON, one node a line sorted by id, one wire a line. All parameter values are written, since a changed default
must not change an old picture. What this program does not know is kept: keys at every level, modules that are not here.
Nothing in a file is executed, and no data file is read when it is opened.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from app.engine import paths, writing
from app.engine.catalogue import Catalogue, mine
from app.engine.errors import DocumentError, NewerSchema
from app.engine.network import Network
from app.engine.reading import Reader, parse

FORMAT = "nonius-network"
SCHEMA = 1

MIGRATIONS: Mapping[int, Callable[[dict[str, Any]], dict[str, Any]]] = {}
"""schema -> what makes a record of the next one."""


@dataclass(frozen=True)
class Loaded:
    """A network from a file, and what the reader of it should know."""

    network: Network
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Saved:
    """The network as it was written (paths and digests are those of the file), and what its writer should know."""

    network: Network
    path: Path
    warnings: tuple[str, ...] = ()


def load(path: Path | str, catalogue: Catalogue | None = None) -> Network:
    """The network in a file; see `read` for its warnings."""
    return read(path, catalogue).network


def read(path: Path | str, catalogue: Catalogue | None = None) -> Loaded:
    """The network in a file, with warnings: modules that are not here, other versions.

    Raises
    ------
    DocumentError, NewerSchema and other NetworkErrors : with file, place, and what to do
    """
    place = Path(path)
    try:
        text = place.read_bytes()
    except FileNotFoundError:
        sentence = paths.identify(Path(place.name), place.parent.absolute())
        raise DocumentError(sentence.problem if sentence else f"there is no file {str(path)!r}") from None
    except OSError as error:
        raise DocumentError(f"{str(path)!r} cannot be read: {error.strerror or error}") from None
    return loads(text, catalogue, place.parent.absolute(), name=place.name)


def loads(
    text: str | bytes, catalogue: Catalogue | None = None, folder: Path | None = None, *, name: str = "the text"
) -> Loaded:
    """A network from its text: of a file, a picture, the clipboard.

    Parameters
    ----------
    folder : where relative paths start
    name : of the file, for sentences
    """
    record = parse(text, name)
    migrate(record, name)
    plain = text if isinstance(text, str) else text.decode("utf-8-sig")
    reader = Reader(mine() if catalogue is None else catalogue, name, plain)
    network = reader.network(record, folder)
    return Loaded(network, tuple(reader.warnings))


def migrate(record: dict[str, Any], name: str) -> None:
    """Bring a record to this schema, in place.

    Raises
    ------
    DocumentError : it is no network
    NewerSchema : this program is too old for it
    """
    if record.get("format") != FORMAT:
        found = f'"format" is {record["format"]!r}' if "format" in record else 'it has no "format"'
        raise DocumentError(f'{name} is JSON but no network of Nonius Explorer: {found}, not "{FORMAT}"')
    schema = record.get("schema")
    if isinstance(schema, bool) or not isinstance(schema, int) or schema < 1:
        raise DocumentError(f'{name}: "schema" is a whole number from 1, not {schema!r}')
    if schema > SCHEMA:
        raise NewerSchema(
            f"{name} was written by a later version of Nonius Explorer (schema {schema}; this one reads up to "
            f"{SCHEMA}): update the program, or save the network there for an older version"
        )
    for number in range(schema, SCHEMA):
        changed = MIGRATIONS[number](record)
        record.clear()
        record.update(changed, schema=number + 1)


def dumps(network: Network, catalogue: Catalogue | None = None) -> str:
    """The text of a network, the same for the same network. Paths are as seen from its folder."""
    return writing.text(FORMAT, SCHEMA, network, mine() if catalogue is None else catalogue)


def save(network: Network, path: Path | str, catalogue: Catalogue | None = None) -> Saved:
    """Write a network: whole or not at all; the version before is kept as `<name>~1`.

    Raises
    ------
    DocumentError : it could not be written, or would not read back as it is
    """
    modules = mine() if catalogue is None else catalogue
    place = Path(path).absolute()
    moved, warnings = writing.moved(network, place.parent, modules)
    listed = replace(moved, files=writing.files(moved, modules))
    text = dumps(listed, modules)
    try:
        back = dumps(loads(text, modules, place.parent, name=place.name).network, modules)
    except Exception as error:
        raise DocumentError(f"{place.name} was not written, it would not read back: {error}") from error
    if back != text:
        raise DocumentError(f"{place.name} was not written, it would read back as another network: {_first(text, back)}")
    writing.atomic(place, text.encode())
    return Saved(listed, place, tuple(warnings))


def _first(one: str, other: str) -> str:
    pairs = zip(one.splitlines(), other.splitlines(), strict=False)
    return next((f"line {i}: {a!r} became {b!r}" for i, (a, b) in enumerate(pairs, 1) if a != b), "the end is missing")


def clipboard(part: Network, catalogue: Catalogue | None = None) -> str:
    """A part of a network as text, paths absolute."""
    modules = mine() if catalogue is None else catalogue
    return dumps(writing.absolute(part, modules), modules)
