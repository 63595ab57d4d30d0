"""The certificate of a picture: what is claimed about it, in a form that a machine can check.

    picture.png                  its network, keys and claims in text chunks
    picture.accuracy.json        the claims and the digests of all stored bytes, sealed by a digest of its own

A stored file that was changed is noticed by digest. A recomputation is compared by number within the stated tolerance,
since digests of results are not portable between processors.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeGuard

from app.engine import paths, writing
from app.engine.catalogue import Catalogue
from app.engine.demands import PLACES, statistics
from app.engine.document import dumps
from app.engine.errors import NetworkError
from app.engine.network import Network
from modules.data.accuracy import SIGNS, Accuracy, Flag, Line
from modules.data.fold import Check

FORMAT = 1
ACCURACY_FORMAT = 1
"""Raised when the meaning of terms, kinds or totals changes."""

SUFFIX = ".accuracy.json"
NETWORK, KEYS, ACCURACY = "nonius:network", "nonius:keys", "nonius:accuracy"

TOLERANCE = {"relative": 1e-6, "of_largest": 1e-9}
"""Two numbers agree within `relative` of the larger, or within `of_largest` of the largest of their kind."""

NUMBERS = ("max", "mean", "median", "p95", "sum")


class CertificateError(NetworkError):
    """A file that is no certificate, or cannot be read as one."""


def beside(picture: Path) -> Path:
    """Where the certificate of a picture lies."""
    return picture.with_name(picture.name.removesuffix(picture.suffix) + SUFFIX)


# --- what is claimed ----------------------------------------------------------------------------------------------


def layers(scene: Any, k: float, check: Check | None = None) -> list[dict[str, Any]]:
    """What is claimed of each layer of a scene, all items looked at; layers of one shape are looked at once."""
    known: dict[int, dict[str, Any]] = {}
    for layer in scene.layers:
        if id(layer.accuracy) not in known:
            known[id(layer.accuracy)] = budget(layer.accuracy, k, check)
    return [
        {
            "title": layer.title,
            "shape": type(layer.shape).__name__,
            "shows": [{"name": s.name, "quantity": s.quantity, "note": s.note, "factor": s.factor} for s in layer.shows],
            **known[id(layer.accuracy)],
        }
        for layer in scene.layers
    ]


def budget(accuracy: Accuracy, k: float, check: Check | None = None) -> dict[str, Any]:
    """An accuracy as plain values: every term with its numbers, the totals, and what is missing, flagged and ended."""
    return {
        "rigour": accuracy.rigour(),
        "sign": SIGNS[accuracy.rigour()],
        "items": dict(accuracy.of.counts) if accuracy.of else {},
        "terms": [term(line) for line in accuracy.budget(None, check)],
        "totals": totals(accuracy, k, check),
        "missing": [{"name": m.name, "reason": m.reason} for m in accuracy.missing],
        "flags": [flag(f) for f in accuracy.flags],
        "ended": [{"id": i, "name": e.name, "why": e.why} for i, e in sorted(accuracy.ended.items())],
    }


def term(line: Line) -> dict[str, Any]:
    """One evaluated term as plain values."""
    words = ("name", "stage", "rigour", "sign", "kind", "quantity", "unit", "place", "rule", "id", "count", "looked")
    return {w: getattr(line, w) for w in words} | {n: number(getattr(line, n)) for n in NUMBERS}


def totals(accuracy: Accuracy, k: float, check: Check | None = None) -> list[dict[str, Any]]:
    """All terms of one quantity at one place together: bounds add, standard deviations in squares, times k."""
    found = []
    for quantity in sorted({t.quantity for t in accuracy.terms}):
        for place in PLACES:
            terms = accuracy.select(quantity, place)
            if not terms:
                continue
            units = sorted({t.unit for t in terms})
            head = {"quantity": quantity, "place": place, "k": k, "unit": units[0] if len(units) == 1 else ""}
            if len(units) > 1:
                found.append({**head, "why": f"no total: the terms come in {', '.join(u or 'plain numbers' for u in units)}"})
                continue
            sizes = accuracy.total(k, quantity, place, None, check)
            found.append({**head, "count": len(sizes), **{n: number(v) for n, v in statistics(sizes).items()}})
    return found


def flag(one: Flag) -> dict[str, Any]:
    """A flag as plain values."""
    values = one.values
    top = number(float(abs(values).max())) if values is not None and len(values) else None
    return {"name": one.name, "words": one.words, "place": one.place, "count": one.count, "largest": top}


def number(value: float) -> float | str | None:
    """A number as JSON holds it: infinite ones as text, none for NaN."""
    if math.isnan(value):
        return None
    return value if math.isfinite(value) else ("inf" if value > 0 else "-inf")


# --- what it was made from ----------------------------------------------------------------------------------------


def stored(network: Network, folder: Path, catalogue: Catalogue) -> str:
    """The network as a picture in `folder` carries it: paths as seen from there, all values, digests of its files."""
    moved, _ = writing.moved(network, folder, catalogue)
    listed = Network(moved.nodes, moved.wires, moved.settings, moved.extras, writing.files(moved, catalogue), folder)
    return dumps(listed, catalogue)


def data_files(network: Network, catalogue: Catalogue) -> list[dict[str, Any]]:
    """Each path that the network reads, with digests of the files behind it."""
    found = []
    for node, parameter, path in paths.named(network, catalogue):
        if paths.unset(path):
            continue
        identity = paths.identify(path, network.folder, catalogue.get(network.nodes[node].module)) or paths.Identity()
        entry: dict[str, Any] = {"node": node, "parameter": parameter, "path": path.as_posix(), "files": []}
        for stamp in identity.stamps:
            digest = paths.DIGESTS.of(Path(stamp[0]))[0]
            entry["files"].append({"name": Path(stamp[0]).name, "bytes": stamp[3], "sha256": digest})
        if identity.sampled:
            entry["note"] = "identity by sample: the files are large"
        if identity.problem:
            entry["problem"] = identity.problem
        found.append(entry)
    return found


def digest(data: bytes) -> str:
    """sha256 in hexadecimal."""
    return sha256(data).hexdigest()


# --- the file -----------------------------------------------------------------------------------------------------


def seal(content: Mapping[str, Any]) -> bytes:
    """The file of a certificate: its content, and the digest of that."""
    plain = {k: v for k, v in content.items() if k != "digest"}
    return _written({"digest": digest(_canonical(plain)), **plain})


def unseal(data: bytes, name: str) -> tuple[dict[str, Any], str]:
    """(content, what was changed since it was sealed; "" if nothing).

    Raises
    ------
    CertificateError : it is no certificate, or of a later version
    """
    try:
        content = json.loads(data.decode("utf-8"))
    except ValueError as error:
        raise CertificateError(f"{name} is no certificate: it is not JSON ({error})") from None
    if not isinstance(content, dict) or "certificate" not in content:
        raise CertificateError(f'{name} is JSON but no certificate: it has no "certificate"')
    if not isinstance(content["certificate"], int) or content["certificate"] > FORMAT:
        raise CertificateError(f"{name} is of a later version (certificate {content['certificate']!r}): update the program")
    plain = {k: v for k, v in content.items() if k != "digest"}
    if content.get("digest") != digest(_canonical(plain)):
        return content, "its content was changed: the digest over it differs"
    return content, "" if _written(content) == data else "its bytes were changed, though not what it says"


def _canonical(content: Mapping[str, Any]) -> bytes:
    return json.dumps(content, ensure_ascii=False, allow_nan=False, sort_keys=True, separators=(",", ":")).encode()


def _written(content: Mapping[str, Any]) -> bytes:
    return (json.dumps(content, ensure_ascii=False, allow_nan=False, indent=1) + "\n").encode()


# --- comparing ----------------------------------------------------------------------------------------------------


def differences(claimed: list[Any], found: list[Any], tolerance: Mapping[str, float]) -> list[str]:
    """Sentences for all in which two lists of layers differ: numbers beyond the tolerance, all else at all."""
    if len(claimed) != len(found):
        return [f"the picture has {len(found)} layers, the certificate {len(claimed)}"]
    result: list[str] = []
    for i, (one, other) in enumerate(zip(claimed, found, strict=True)):
        name = f"layer {i + 1} ({one.get('title') or one.get('shape')})" if isinstance(one, dict) else f"layer {i + 1}"
        largest = _largest(one, other)
        _compare(one, other, name, tolerance, largest, result)
    return result


def _compare(
    one: Any, other: Any, where: str, tolerance: Mapping[str, float], largest: Mapping[str, float], result: list[str]
) -> None:
    if isinstance(one, dict) and isinstance(other, dict):
        here = f"{where}, {one['name']!r}" if isinstance(one.get("name"), str) else where
        quantity = str(one.get("quantity", ""))
        for key in sorted({*one, *other}):
            a, b = one.get(key), other.get(key)
            if _number(a) and _number(b):
                if not agree(a, b, tolerance, largest.get(quantity, 0.0)):
                    what = f"{quantity} {key}" if quantity else key
                    result.append(f"{here}: {what} is {b!r}, the certificate says {a!r}")
            else:
                _compare(a, b, f"{here}, {key}", tolerance, largest, result)
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        for a, b in zip(_ordered(one), _ordered(other), strict=True):
            _compare(a, b, where, tolerance, largest, result)
    elif one != other:
        result.append(f"{where} is {_short(other)}, the certificate says {_short(one)}")


def agree(one: float, other: float, tolerance: Mapping[str, float], largest: float = 0.0) -> bool:
    """Whether two numbers are one within the tolerance; whole numbers must be equal."""
    if isinstance(one, int) and isinstance(other, int):
        return one == other
    near = tolerance["relative"] * max(abs(one), abs(other))
    return abs(one - other) <= max(near, tolerance["of_largest"] * largest)


def _ordered(items: list[Any]) -> list[Any]:
    """Terms by who they are: two of nearly one size may come in either order."""
    if not all(isinstance(item, dict) for item in items):
        return items
    return sorted(items, key=lambda item: tuple(str(item.get(w, "")) for w in ("quantity", "place", "name", "id")))


def _largest(*budgets: Any) -> dict[str, float]:
    found: dict[str, float] = {}
    for one in budgets:
        for item in one.get("terms", []) if isinstance(one, dict) else ():
            if isinstance(item, dict) and _number(item.get("max")):
                quantity = str(item.get("quantity"))
                found[quantity] = max(found.get(quantity, 0.0), abs(item["max"]))
    return found


def _number(value: Any) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _short(value: Any) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) < 80 else f"{text[:77]}..."
