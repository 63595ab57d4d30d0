"""Text to record, record to network. Each refusal names the file, the line or node, and what to do."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NoReturn

from app.engine import check, following
from app.engine.catalogue import Catalogue
from app.engine.errors import DocumentError, NetworkError, ValueRefused
from app.engine.network import NAME, SETTINGS, Network, Node, Origin, Socket, without_gaps
from modules.declare import Module

WIRE = re.compile(
    r"(?P<source>[^.\s]+)\.(?P<output>\w+(:accuracy)?) -> (?P<target>[^.\s]+)\.(?P<port>\w+)(\[(?P<slot>\d{1,6})\])?"
)
KEYS = ("format", "schema", "settings", "files", "nodes", "wires")
NODE_KEYS = ("id", "module", "version", "parameters", "view", "disabled", "bypass", "follows")


def parse(text: str | bytes, name: str) -> dict[str, Any]:
    """JSON to a record: strict, so that nothing is lost in silence.

    Raises
    ------
    DocumentError : not UTF-8, not JSON, a key twice, NaN
    """
    try:
        plain = text if isinstance(text, str) else text.decode("utf-8-sig")
        plain.encode()
        record = json.loads(plain.removeprefix("\ufeff"), object_pairs_hook=_once, parse_constant=_constant)
        json.dumps(record, ensure_ascii=False).encode()
    except UnicodeError as error:
        raise DocumentError(f"{name} is not UTF-8 text: {getattr(error, 'reason', error)}; is it a network?") from None
    except json.JSONDecodeError as error:
        raise DocumentError(f"{name}, line {error.lineno}, column {error.colno}: {_said(error, plain)}") from None
    except _Refused as error:
        raise DocumentError(f"{name}{_line(plain, str(error.args[1]))}: {error.args[0]}") from None
    except RecursionError:
        raise DocumentError(f"{name} is nested too deeply to be a network") from None
    if not isinstance(record, dict):
        raise DocumentError(f"{name} is JSON but no network: it holds {_kind(record)}, not an object")
    return record


class _Refused(ValueError):
    """(sentence, text near the place)."""


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    record: dict[str, Any] = {}
    for key, value in pairs:
        if key in record:
            raise _Refused(f"the key {key!r} occurs twice in one object: take one out", _near(pairs))
        record[key] = value
    return record


def _near(pairs: list[tuple[str, Any]]) -> str:
    named = dict(pairs).get("id")
    return f'"id": {json.dumps(named, ensure_ascii=False)}' if isinstance(named, str) else f'"{pairs[0][0]}"'


def _constant(word: str) -> float:
    if word == "NaN":
        raise _Refused("NaN is not a value: write null for 'automatic'", "NaN")
    return float(word.replace("Infinity", "inf"))


def _said(error: json.JSONDecodeError, text: str) -> str:
    if not text.strip():
        return "the file is empty"
    line = text.splitlines()[error.lineno - 1].strip() if error.lineno <= len(text.splitlines()) else ""
    return f"this is not JSON ({error.msg}){f' near {line[:60]!r}' if line else ''}"


def _line(text: str, near: str) -> str:
    if near and near in text:
        return f", line {text[: text.index(near)].count(chr(10)) + 1}"
    return ""


def _kind(value: Any) -> str:
    names = {list: "a list", str: "text", bool: "true or false", int: "a number", float: "a number", type(None): "null"}
    return names.get(type(value), "an object")


class Reader:
    """Makes a network of a record; collects warnings.

    Parameters
    ----------
    name, text : of the file, to name lines
    """

    def __init__(self, catalogue: Catalogue, name: str, text: str) -> None:
        self.catalogue = catalogue
        self.warnings: list[str] = []
        self._name = name
        self._text = text
        self._lenient: set[str] = set()

    def network(self, record: Mapping[str, Any], folder: Path | None) -> Network:
        """The live network."""
        nodes = self._nodes(self._typed(record, "nodes", list, []))
        wires = self._wires(self._typed(record, "wires", list, []), nodes)
        settings = self._settings(self._typed(record, "settings", dict, {}))
        files = self._typed(record, "files", dict, {})
        if wrong := [f for f, known in files.items() if not isinstance(known, dict)]:
            self._refuse(f'"files": {wrong[0]!r} has {_kind(files[wrong[0]])}, not an object', wrong[0])
        extras = {k: v for k, v in record.items() if k not in KEYS}
        self._finite([settings, extras, files])
        network, loose = following.judged(Network(nodes, wires, settings, extras, files, folder), self.catalogue)
        for node, sentence in loose:
            self._warn(sentence, f'"id": {json.dumps(node, ensure_ascii=False)}')
        return network

    # --- parts

    def _settings(self, record: dict[str, Any]) -> dict[str, Any]:
        try:
            return dict(Network(settings={**SETTINGS, **record}).settle().settings)
        except ValueRefused as error:
            self._refuse(str(error), '"settings"')

    def _nodes(self, records: list[Any]) -> dict[str, Node]:
        nodes: dict[str, Node] = {}
        for i, record in enumerate(records, 1):
            if not isinstance(record, dict) or not isinstance(record.get("id"), str):
                self._refuse(f'node {i} is {_kind(record)} without an "id": give it one, such as "contour-1"', "")
            node = self._node(record)
            if node.id in nodes:
                self._refuse(f"two nodes have the id {node.id!r}: rename one, and its wires", f'"id": "{node.id}"', last=True)
            nodes[node.id] = node
        return dict(sorted(nodes.items()))

    def _node(self, record: dict[str, Any]) -> Node:
        name = record["id"]
        near = f'"id": {json.dumps(name, ensure_ascii=False)}'
        if not NAME.fullmatch(name):
            self._refuse(f"{name!r} cannot be the id of a node: use letters, digits, '_' and '-' inside", near)
        module = record.get("module")
        if not isinstance(module, str) or not module:
            self._refuse(f'node {name!r} has no "module"', near)
        version = record.get("version", 1)
        if isinstance(version, bool) or not isinstance(version, int):
            self._refuse(f'node {name!r}: "version" is a whole number, not {version!r}', near)
        disabled = record.get("disabled", False)
        if not isinstance(disabled, bool):
            self._refuse(f'node {name!r}: "disabled" is true or false, not {disabled!r}', near)
        bypass = self._typed(record, "bypass", dict, {}, f"node {name!r}: ", near)
        if not all(isinstance(port, str) for port in bypass.values()):
            self._refuse(f'node {name!r}: "bypass" names a port for each output, not {bypass!r}', near)
        follows = self._typed(record, "follows", dict, {}, f"node {name!r}: ", near)
        if not all(isinstance(led, str) and len(led.split(".")) == 2 for led in follows.values()):
            self._refuse(f'node {name!r}: "follows" names parameters, such as "contour-1.interval", not {follows!r}', near)
        values = self._typed(record, "parameters", dict, {}, f"node {name!r}: ", near)
        view = self._typed(record, "view", dict, {}, f"node {name!r}: ", near)
        extras = {k: v for k, v in record.items() if k not in NODE_KEYS}
        self._finite([view, extras], near)
        found = self.catalogue.get(module)
        if found is None:
            self._finite(values, near)
            self._warn(f"{name}: there is no module {module!r}{self.catalogue.nearest(module)}; it is kept as it is", near)
            return Node(name, module, version, values, view, extras, disabled, bypass, follows)
        values = self._values(name, found, version, values, near)
        return Node(name, found.id, max(version, found.version), values, view, extras, disabled, bypass, follows)

    def _values(self, name: str, record: Module, version: int, given: dict[str, Any], near: str) -> dict[str, Any]:
        """Values in their types. Of another version, what does not fit is kept, and told when it runs."""
        if version != record.version:
            self._lenient.add(name)
            age = "a later" if version > record.version else "an earlier"
            now = f"version {version}; this is {record.version}"
            self._warn(f"{name}: it was saved with {age} {record.title!r} ({now}): results may differ", near)
        values: dict[str, Any] = {}
        for parameter, value in sorted(given.items()):
            try:
                values[parameter] = check.value(name, record, parameter, value)
            except NetworkError as error:
                if name not in self._lenient:
                    self._refuse(str(error), near, kind=type(error))
                self._warn(f"{error}; it is kept as it is", near)
                values[parameter] = value
        return values

    def _wires(self, lines: list[Any], nodes: Mapping[str, Node]) -> dict[Socket, Origin]:
        wires: dict[Socket, Origin] = {}
        for line in lines:
            near = json.dumps(line, ensure_ascii=False) if isinstance(line, str) else ""
            found = WIRE.fullmatch(line) if isinstance(line, str) else None
            if found is None:
                self._refuse(f"{line!r} is no wire: write 'contour-1.lines -> dust-1.lines', with [0] for a list", near)
            end = self._end(found, nodes)
            if end in wires:
                self._refuse(f"two wires end at {line.split(' -> ')[1]!r}: take one out", near, last=True)
            origin = (found["source"], found["output"])
            try:
                check.wire(nodes, end, origin, self.catalogue)
            except NetworkError as error:
                known = found["source"] in nodes and found["target"] in nodes
                if not known or not self._lenient & {found["source"], found["target"]}:
                    self._refuse(str(error), near, kind=type(error))
                self._warn(f"{error}; it is kept as it is", near)
            wires[end] = origin
        try:
            check.circle(wires)
        except NetworkError as error:
            self._refuse(str(error), "", kind=type(error))
        closed = without_gaps(wires)
        if closed.keys() != wires.keys():
            self._warn("the places of a list had gaps; they were closed", "")
        return closed

    def _end(self, found: re.Match[str], nodes: Mapping[str, Node]) -> Socket:
        """Where a wire ends. At a port that nobody knows, -1 says that it was written without a place."""
        node = nodes.get(found["target"])
        record = self.catalogue.get(node.module) if node else None
        known = record is not None and (record.port(found["port"]) or record.parameter(found["port"]))
        slot = found["slot"]
        return found["target"], found["port"], int(slot) if slot else (0 if known or node is None else -1)

    # --- sentences

    def _typed(
        self, record: Mapping[str, Any], key: str, kind: type, default: Any, where: str = "", near: str = ""
    ) -> Any:
        value = record.get(key, default)
        if not isinstance(value, kind):
            wanted = "a list" if kind is list else "an object"
            self._refuse(f'{where}"{key}" is {_kind(value)}, not {wanted}', near or f'"{key}"')
        return value

    def _finite(self, value: Any, near: str = "Infinity") -> None:
        for inner in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
            if isinstance(inner, float) and not math.isfinite(inner):
                self._refuse("an infinite number has no place here", near)
            self._finite(inner, near)

    def _refuse(self, sentence: str, near: str, *, last: bool = False, kind: type[NetworkError] = DocumentError) -> NoReturn:
        place = self._text
        at = ""
        if near and near in place:
            start = place.rindex(near) if last else place.index(near)
            at = f", line {place[:start].count(chr(10)) + 1}"
        raise kind(f"{self._name}{at}: {sentence}")

    def _warn(self, sentence: str, near: str) -> None:
        self.warnings.append(f"{self._name}{_line(self._text, near)}: {sentence}")
