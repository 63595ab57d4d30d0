"""Which network is meant by a word on the command line, and the edits of `--set`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from app import paths
from app.commands.console import Usage
from app.engine import certificate, document, pngtext
from app.engine import paths as files
from app.engine.catalogue import Catalogue
from app.engine.errors import DocumentError, hint
from app.engine.network import SETTINGS, Network


@dataclass(frozen=True)
class Found:
    """A network, where it came from, and what its reader should know.

    Parameters
    ----------
    kind : file, packaged, or picture
    name : for the files that are written
    edits : what `--set` changed
    """

    network: Network
    kind: Literal["file", "packaged", "picture"]
    path: Path
    name: str
    warnings: tuple[str, ...] = ()
    edits: tuple[str, ...] = ()


def find(word: str, catalogue: Catalogue) -> Found:
    """The network in a file, in a picture, or packaged under a bare name.

    Raises
    ------
    NetworkError : no such thing, or it cannot be read
    """
    place = Path(word).expanduser()
    if place.suffix.lower() == ".png":
        return in_picture(place, catalogue)
    if place.is_file():
        loaded = document.read(place, catalogue)
        return Found(loaded.network, "file", place, place.stem, loaded.warnings)
    packaged = paths.networks()
    bare = word.removesuffix(".json").removeprefix("networks/")
    if bare in packaged:
        loaded = document.read(packaged[bare], catalogue)
        return Found(loaded.network, "packaged", packaged[bare], bare, loaded.warnings)
    if place.is_dir():
        raise Usage(f"{word!r} is a folder: name a network in it")
    around = [p.name for p in (place.parent if place.parent.is_dir() else Path()).glob("*.json")]
    raise Usage(f"there is no network {word!r}, neither a file nor a packaged one{hint(word, [*packaged, *around])}")


def in_picture(place: Path, catalogue: Catalogue) -> Found:
    """The network that a picture carries."""
    if not place.is_file():
        around = [p.name for p in (place.parent if place.parent.is_dir() else Path()).glob("*.png")]
        raise Usage(f"there is no picture {str(place)!r}{hint(place.name, around)}")
    try:
        text = pngtext.texts(place.read_bytes()).get(certificate.NETWORK)
    except pngtext.NotPNG as error:
        raise DocumentError(f"{place.name}: {error}") from None
    if text is None:
        raise DocumentError(f"{place.name} carries no network: it was not made by nonius, or another program wrote it anew")
    loaded = document.loads(text, catalogue, place.parent.absolute(), name=f"the network in {place.name}")
    return Found(loaded.network, "picture", place, f"{place.stem}-again", loaded.warnings)


def reads(network: Network, catalogue: Catalogue) -> list[str]:
    """What a network would read, one line a path."""
    return [f"{node}.{parameter} reads {path.as_posix()}" for node, parameter, path in files.named(network, catalogue)]


def edited(found: Found, edits: Iterable[str], catalogue: Catalogue) -> Found:
    """With the values of `--set`; a path is as seen from the current folder, `k=3` is a setting.

    Raises
    ------
    NetworkError : no such node or parameter, or a value that it does not take
    """
    network = found.network
    for text in edits:
        name, equals, value = text.partition("=")
        node, dot, parameter = name.strip().partition(".")
        if not equals or (not dot and node not in SETTINGS):
            raise Usage(f"--set {text!r}: write it as NODE.PARAM=VALUE, such as contour-1.interval=50; or k=3")
        if not dot:
            network = _settled(network, node, value)
            continue
        record = catalogue.get(network[node].module)
        declared = record.parameter(parameter) if record else None
        given: str | Path | None = value
        if declared and declared.automatic and value in ("", "automatic"):
            given = None
        elif declared and declared.is_path and not value.startswith(files.PACKAGE):
            given = Path.cwd() / Path(value).expanduser()
        network = network.set(node, parameter, given, catalogue)
    return replace(found, network=network, edits=tuple(edits))


def _settled(network: Network, setting: str, value: str) -> Network:
    if setting != "k":
        return network.settle(**{setting: value})
    try:
        return network.settle(k=float(value))
    except ValueError:
        raise Usage(f"--set k={value!r}: k takes a number, not {value!r}") from None
