"""Network to text, and text to disk."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from app.engine import paths
from app.engine.catalogue import Catalogue
from app.engine.errors import DocumentError
from app.engine.network import Network, Node, Socket
from modules.declare import Module
from modules.parameters import plain


def text(format_: str, schema: int, network: Network, catalogue: Catalogue) -> str:
    """The file of a network."""
    head: dict[str, Any] = {"format": format_, "schema": schema}
    lines = [f"{_json(key)}: {_json(value)}" for key, value in head.items()]
    lines.append(f'"settings": {_json(dict(network.settings))}')
    if network.files:
        lines.append(_block("files", "{", [f"{_json(k)}: {_json(v)}" for k, v in sorted(network.files.items())], "}"))
    nodes = [_json(node_record(node, catalogue, network.folder)) for _, node in sorted(network.nodes.items())]
    lines.append(_block("nodes", "[", nodes, "]"))
    lines.append(_block("wires", "[", [_json(wire) for wire in wires(network, catalogue)], "]"))
    lines += [f"{_json(key)}: {_json(value)}" for key, value in sorted(network.extras.items())]
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _block(key: str, begin: str, lines: list[str], end: str) -> str:
    inside = ",\n".join(lines)
    return f'"{key}": {begin}\n{inside}\n{end}' if lines else f'"{key}": {begin}{end}'


def node_record(node: Node, catalogue: Catalogue, folder: Path | None) -> dict[str, Any]:
    """A node as it is written: all parameter values, defaults too."""
    found = catalogue.get(node.module)
    record: dict[str, Any] = {
        "id": node.id,
        "module": found.id if found else node.module,
        "version": max(node.version, found.version) if found else node.version,
        "parameters": dict(sorted(_values(node, found, folder).items())),
    }
    if node.disabled:
        record["disabled"] = True
    if node.bypass:
        record["bypass"] = dict(sorted(node.bypass.items()))
    if node.follows:
        record["follows"] = dict(sorted(node.follows.items()))
    if node.view:
        record["view"] = dict(node.view)
    return record | dict(sorted(node.extras.items()))


def _values(node: Node, record: Module | None, folder: Path | None) -> dict[str, Any]:
    values = {name: plain(value) for name, value in node.parameters.items()}
    for parameter in record.parameters if record else ():
        value = node.parameters.get(parameter.name, parameter.default)
        if parameter.is_path and value is not None:
            values[parameter.name] = paths.saved(value, folder, folder)[0]
        else:
            values[parameter.name] = plain(parameter.plain(value))
    return values


def wires(network: Network, catalogue: Catalogue) -> Iterator[str]:
    """The wires as they are written, sorted by where they end."""
    for end in sorted(network.wires):
        source, output = network.wires[end]
        yield f"{source}.{output} -> {socket(network, end, catalogue)}"


def socket(network: Network, end: Socket, catalogue: Catalogue) -> str:
    """Where a wire ends, with its place if that is a list."""
    target, port, slot = end
    record = catalogue.get(network.nodes[target].module)
    declared = record.port(port) if record else None
    listed = declared.many if declared else slot >= 0 and not (record and record.parameter(port))
    return f"{target}.{port}[{max(slot, 0)}]" if listed else f"{target}.{port}"


def _json(value: Any) -> str:
    try:
        return json.dumps(_plain(value), ensure_ascii=False, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise DocumentError(f"{str(value)[:60]!r} cannot be written to a file: {error}") from None


def _plain(value: Any) -> Any:
    """With infinite numbers as text, numpy's numbers as plain ones."""
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, float) and value in (float("inf"), float("-inf")):
        return "inf" if value > 0 else "-inf"
    return value


# --- files ------------------------------------------------------------------------------------------------------


def _with_paths(network: Network, catalogue: Catalogue, change: Callable[[str, Path], Path]) -> Network:
    nodes = dict(network.nodes)
    for name, parameter, path in paths.named(network, catalogue):
        changed = change(name, path)
        if changed != path:
            nodes[name] = replace(nodes[name], parameters={**nodes[name].parameters, parameter: changed})
    return replace(network, nodes=nodes)


def moved(network: Network, folder: Path, catalogue: Catalogue) -> tuple[Network, list[str]]:
    """The network with its paths as seen from a folder, and a warning for each that leads out of it."""
    warnings: list[str] = []

    def change(node: str, path: Path) -> Path:
        text, outside = paths.saved(path, network.folder, folder)
        if outside:
            warnings.append(f"{node}: {text!r} lies outside the network's folder; on another computer it will not be found")
        return Path(text)

    return replace(_with_paths(network, catalogue, change), folder=folder), warnings


def absolute(network: Network, catalogue: Catalogue) -> Network:
    """The network with absolute paths, as it travels to another document."""

    def change(node: str, path: Path) -> Path:
        text = path.as_posix()
        return path if paths.unset(path) or text.startswith(paths.PACKAGE) else paths.locate(path, network.folder)

    return replace(_with_paths(network, catalogue, change), folder=None)


def files(network: Network, catalogue: Catalogue) -> dict[str, Mapping[str, Any]]:
    """Size and digest of each single data file; what cannot be read now keeps what was known."""
    listed: dict[str, Mapping[str, Any]] = {}
    for name, _, path in paths.named(network, catalogue):
        if paths.unset(path):
            continue
        text = paths.saved(path, network.folder, network.folder)[0]
        before = network.files.get(text, {})
        identity = paths.identify(path, network.folder, catalogue.get(network.nodes[name].module))
        if identity is not None and identity.sha256:
            listed[text] = {**before, "size": identity.stamps[0][3], "sha256": identity.sha256}
        elif before:
            listed[text] = before
    return listed


def changed_files(network: Network, catalogue: Catalogue, identities: paths.Identities) -> list[str]:
    """Sentences for data files that are not as they were when the network was saved."""
    found = []
    for name, parameter, path in paths.named(network, catalogue):
        known = network.files.get(paths.saved(path, network.folder, network.folder)[0], {}).get("sha256")
        identity = identities.get((name, parameter))
        if known and identity and identity.sha256 and identity.sha256 != known:
            found.append(f"{name}.{parameter}: {path.as_posix()!r} has changed since the network was saved")
    return found


def atomic(path: Path, data: bytes) -> None:
    """Write a file whole or not at all, the version before kept as `<name>~1`; nothing if it would not change.

    Raises
    ------
    DocumentError : the folder is missing, or the disk refuses
    """
    temporary = ""
    try:
        if path.is_file() and path.read_bytes() == data:
            return
        handle, temporary = tempfile.mkstemp(prefix=f".{path.name}-", dir=path.parent)
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        if path.is_file():
            shutil.copymode(path, temporary)
            _keep(path)
        else:
            os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
        _sync(path.parent)
    except OSError as error:
        if temporary and os.path.exists(temporary):
            os.unlink(temporary)
        why = error.strerror or error
        raise DocumentError(f"{str(path)!r} was not written: {why}; what was there is still there") from None


def _keep(path: Path) -> None:
    handle, temporary = tempfile.mkstemp(prefix=f".{path.name}-", dir=path.parent)
    os.close(handle)
    shutil.copy2(path, temporary)
    os.replace(temporary, path.with_name(f"{path.name}~1"))


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _sync(folder: Path) -> None:
    if os.name != "posix":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
