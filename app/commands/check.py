"""`nonius check FILE`: whether a picture is what it was, and its claims hold; or whether a network could run."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from app import paths
from app.commands import nets, wave
from app.commands.console import Console, Usage
from app.engine import certificate, document, pngtext, writing
from app.engine import check as legal
from app.engine import paths as files
from app.engine.catalogue import Catalogue
from app.engine.errors import NetworkError, hint
from app.engine.network import Network

UNMET = 3


def run(options: argparse.Namespace, console: Console) -> int:
    """Check a certificate, a picture by its certificate, or a network."""
    place = Path(options.file).expanduser()
    if place.suffix.lower() == ".png":
        place = certificate.beside(place)
        if not place.is_file():
            raise Usage(f"{options.file!r} has no certificate beside it: {place.name} is not there")
    if not place.name.endswith(certificate.SUFFIX):
        return check_network(options.file, console)
    if not place.is_file():
        around = [p.name for p in (place.parent if place.parent.is_dir() else Path()).glob(f"*{certificate.SUFFIX}")]
        raise Usage(f"there is no certificate {str(place)!r}{hint(place.name, around)}")
    return check_picture(place, console, rerun=not options.no_run, threads=options.threads)


# --- a network ----------------------------------------------------------------------------------------------------


def check_network(word: str, console: Console) -> int:
    """Whether a network could run as it is; 2 if not, with a sentence for each obstacle."""
    catalogue = Catalogue.load()
    found = nets.find(word, catalogue)
    network = found.network
    for warning in found.warnings:
        console.complain(f"nonius: {warning}")
    problems: list[str] = [str(e) for e in legal.problems(network.nodes, network.wires, catalogue)]
    identities = files.identities(network, catalogue) or {}
    problems += [f"{node}.{name}: {one.problem}" for (node, name), one in sorted(identities.items()) if one.problem]
    for sentence in writing.changed_files(network, catalogue, identities):
        console.complain(f"nonius: {sentence}")
    for line in nets.reads(network, catalogue):
        console.say(line)
    for problem in problems:
        console.complain(f"nonius: {problem}")
    if not problems:
        console.say(f"{word}: {len(network.nodes)} nodes and {len(network.wires)} wires; it could run")
    return NetworkError.exit_code if problems else 0


# --- a picture ----------------------------------------------------------------------------------------------------


def check_picture(place: Path, console: Console, *, rerun: bool = True, threads: int | None = None) -> int:
    """Whether all stored bytes are as they were, and the numbers come out again; 3 if not."""
    content, changed = certificate.unseal(place.read_bytes(), place.name)
    problems = [f"{place.name}: {changed}"] if changed else []
    catalogue = Catalogue.load()
    try:
        text, said = _picture(content, place.parent)
        problems += said
        network = _network(content, text, place, catalogue, problems)
        if network is not None:
            problems += _data(content, network, catalogue)
        if network is not None and rerun:
            problems += _again(content, network, catalogue, Console(quiet=True, verbose=console.verbose), threads)
    except (KeyError, TypeError, AttributeError) as error:
        problems.append(f"{place.name}: a part of it is missing or not what it should be ({type(error).__name__}: {error})")
    for problem in problems:
        console.complain(f"nonius: {problem}")
    for note in _notes(content):
        console.say(note)
    if problems:
        console.complain(f"nonius: {place.name} does not hold: {len(problems)} difference{'s' if len(problems) > 1 else ''}")
        return UNMET
    how = "recomputed, every number within the tolerance" if rerun else "digests agree; not recomputed"
    console.say(f"{place.name} holds: {how}")
    return 0


def _picture(content: dict[str, Any], folder: Path) -> tuple[str | None, list[str]]:
    """(the network's text, what was changed in the picture)."""
    claim = content["picture"]
    name = Path(claim["file"]).name
    path = folder / name
    if not path.is_file():
        return None, [f"the picture {name!r} is not beside the certificate"]
    png = path.read_bytes()
    problems = []
    if certificate.digest(png) != claim["sha256"]:
        problems.append(f"the picture {name!r} was changed: {_which(png, claim)}")
    try:
        text = pngtext.texts(png).get(certificate.NETWORK)
    except pngtext.NotPNG:
        return None, problems
    if text is None:
        return None, [*problems, f"the picture {name!r} no longer carries its network"]
    if certificate.digest(text.encode()) != content["network"]["sha256"]:
        problems.append(f"the network in {name!r} is another than the one certified")
    return text, problems


def _which(png: bytes, claim: dict[str, Any]) -> str:
    from app.commands.pictures import pixels

    try:
        pngtext.texts(png)
        digest, size = pixels(png)
    except (pngtext.NotPNG, ValueError) as error:
        return str(error)
    if size != claim["size"] or digest != claim["pixels"]:
        return "its pixels differ"
    return "its pixels are the same, what it carries beside them differs"


def _network(
    content: dict[str, Any], text: str | None, place: Path, catalogue: Catalogue, problems: list[str]
) -> Network | None:
    """The network of the picture; and whether the file it came from is as it was."""
    source = content["network"]["from"]
    packaged = source.removeprefix("packaged:") if source.startswith("packaged:") else ""
    origin = paths.networks().get(packaged) if packaged else place.parent / source
    if origin is not None and origin.is_file() and certificate.digest(origin.read_bytes()) != content["network"]["from_sha256"]:
        problems.append(f"the network file {source!r} was changed since the picture was made")
    if text is None:
        return None
    try:
        return document.loads(text, catalogue, place.parent.absolute(), name="the network in the picture").network
    except NetworkError as error:
        problems.append(f"the network in the picture cannot be read: {error}")
        return None


def _data(content: dict[str, Any], network: Network, catalogue: Catalogue) -> Iterator[str]:
    """Sentences for data files that are not as they were."""
    claimed = {(e["node"], e["parameter"]): e for e in content["data"]}
    found = {(e["node"], e["parameter"]): e for e in certificate.data_files(network, catalogue)}
    for key in sorted({*claimed, *found}):
        name = ".".join(key)
        if key not in found:
            yield f"{name}: the certificate names a file that the network does not read"
        elif key not in claimed:
            yield f"{name}: the network reads a file that the certificate does not name"
        elif problem := found[key].get("problem"):
            yield f"{name}: {problem}"
        elif found[key]["files"] != claimed[key]["files"]:
            now = {f["name"]: f["sha256"] for f in found[key]["files"]}
            then = {f["name"]: f["sha256"] for f in claimed[key]["files"]}
            which = sorted(n for n in {*now, *then} if now.get(n) != then.get(n))
            yield f"{name}: the data file {', '.join(which) or found[key]['path']} was changed since the picture was made"


def _again(
    content: dict[str, Any], network: Network, catalogue: Catalogue, console: Console, threads: int | None
) -> Iterator[str]:
    """Sentences for numbers that do not come out again."""
    node, output = content["view"]["node"], content["view"]["output"]
    outcome = wave.watch(network, [node], catalogue, console, threads)
    entry = outcome.entries.get(node)
    if entry is None:
        yield "; ".join(str(e) for e in outcome.errors.values()) or f"{node} could not be run again"
        return
    layers = json.loads(json.dumps(certificate.layers(entry.outputs[output], network.k)))
    tolerance = {name: min(float(content["tolerance"][name]), own) for name, own in certificate.TOLERANCE.items()}
    yield from certificate.differences(content["layers"], layers, tolerance)
    if network.k != content["k"]:
        yield f"k is {network.k!r}, the certificate says {content['k']!r}"
    for name in sorted({*outcome.keys, *content["keys"]}):
        if outcome.keys.get(name) != content["keys"].get(name):
            yield f"{name}: its key differs: another module version, other settings or other data gave the picture"


def _notes(content: dict[str, Any]) -> Iterator[str]:
    then, now = content.get("versions", {}), paths.versions()
    other = [f"{n} {then[n]} (here {now.get(n)})" for n in sorted(then) if then[n] != now.get(n)]
    if other:
        yield f"made with {', '.join(other)}"
