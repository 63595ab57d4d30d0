"""What each module gave in one packaged network, in a few numbers: a changed output without a new version is found.

    python tests/golden.py     writes tests/golden.json anew; refuses where a version should have been raised
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))

from app.engine.catalogue import Catalogue
from app.engine.keys import digest
from app.engine.network import Network
from app.engine.results import Entry
from modules.data.accuracy import Accuracy

FILE = Path(__file__).parent / "golden.json"
LEAST = 2e-3
"""Relative differences below this are another processor's, not another algorithm's."""


def numbers(value: Any) -> Any:
    """A wire value in a few numbers: sizes and quantiles of its arrays, lines of its budget."""
    if isinstance(value, Accuracy):
        lines = [[x.name, x.kind, x.quantity, x.place, _round(x.median), _round(x.p95)] for x in value.budget(500)]
        flags = [[f.name, f.count] for f in value.flags]
        return {"budget": lines, "missing": [m.name for m in value.missing], "flags": flags}
    if isinstance(value, np.ndarray):
        return _array(value)
    if isinstance(value, bool | str | None):
        return value
    if isinstance(value, int | float | np.number):
        return _round(float(value))
    if isinstance(value, Mapping):
        return {str(k): numbers(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [numbers(v) for v in value]
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: numbers(getattr(value, f.name)) for f in fields(value) if f.init}
    return type(value).__name__


def _array(array: np.ndarray[Any, Any]) -> Any:
    if array.dtype.kind not in "fiub" or not array.size:
        return [list(array.shape)]
    plain = array[np.isfinite(array)].astype(float)
    told = np.quantile(plain, (0.05, 0.5, 0.95)) if plain.size else ()
    return [list(array.shape), *map(_round, map(float, told))]


def _round(number: float) -> float | str:
    return float(f"{number:.4g}") if math.isfinite(number) else str(number)


def differs(one: Any, other: Any, scale: float = 0.0) -> str:
    """The first place where two descriptions differ, "" if nowhere."""
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        if one.keys() != other.keys():
            return f"has {sorted(other)}, had {sorted(one)}"
        return next((f"{k}: {said}" for k in one if (said := differs(one[k], other[k], scale))), "")
    if isinstance(one, list) and isinstance(other, list):
        if len(one) != len(other):
            return f"has {len(other)} parts, had {len(one)}"
        scale = max((abs(x) for x in one if isinstance(x, float | int)), default=scale)
        return next((said for x, y in zip(one, other, strict=True) if (said := differs(x, y, scale))), "")
    if isinstance(one, float | int) and isinstance(other, float | int):
        near = abs(one - other) <= LEAST * max(abs(one), abs(other), scale, 1e-9)
        return "" if near else f"is {other:g}, was {one:g}"
    return "" if one == other else f"is {other!r}, was {one!r}"


def taken(network: Network, node: str, entries: Mapping[str, Entry], catalogue: Catalogue) -> dict[str, Any]:
    """What a node takes and gives: module version, values, inputs and outputs."""
    here = network.nodes[node]
    record = catalogue[here.module]
    inputs = {
        port: [numbers(entries[source].outputs[output.partition(":")[0]]) for source, output in origins]
        for port, origins in network.incoming.get(node, {}).items()
    }
    values = {p.name: str(here.parameters.get(p.name, p.default)) for p in record.parameters if not p.is_path}
    outputs = {name: numbers(value) for name, value in entries[node].outputs.items()}
    return {"version": record.version, "takes": _digest([values, inputs]), "gives": outputs}


def _digest(what: Any) -> str:
    """Of values and inputs, rounded."""
    return digest(json.dumps(what, sort_keys=True).encode())


def complaint(before: Mapping[str, Any] | None, now: Mapping[str, Any]) -> str:
    """What is wrong with what a module gives now, "" if nothing."""
    if before is None:
        return "it is not in tests/golden.json: run python tests/golden.py"
    if before["version"] != now["version"]:
        return f"tests/golden.json knows version {before['version']}: run python tests/golden.py"
    said = differs(before["gives"], now["gives"])
    if said and before["takes"] != now["takes"]:
        return f"it takes something else in its example now ({said}): run python tests/golden.py"
    if said:
        return f"its output changed ({said}): raise its version, then run python tests/golden.py"
    return ""


def load() -> dict[str, Any]:
    """What is written down: module -> network, node, version, what it takes and gives."""
    return dict(json.loads(FILE.read_text("utf-8"))) if FILE.exists() else {}


def smallest(firings: Iterable[tuple[str, str, Entry]]) -> tuple[str, str]:
    """The example that says most with least: the first by bytes."""
    name, node, _ = min(firings, key=lambda one: (one[2].bytes, one[0], one[1]))
    return name, node


def main() -> int:
    """Write the file anew; 1 if a version should be raised first."""
    from tests import test_conformance as examples

    before, after, wrong = load(), {}, 0
    for record in examples.MODULES:
        firings = examples.firings(record)
        if not firings:
            continue
        name, node = smallest(firings)
        ran = examples.examples()[name]
        now = {"network": name, "node": node, **taken(ran.network, node, ran.entries, examples.catalogue())}
        old = before.get(record.id, now)
        said = differs(old["gives"], now["gives"])
        if said and old["version"] == now["version"] and old["takes"] == now["takes"]:
            print(f"{record.id}: its output changed ({said}): raise its version", file=sys.stderr)
            wrong = 1
        after[record.id] = now
    if not wrong:
        lines = [f"{json.dumps(module)}: {json.dumps(said, sort_keys=True)}" for module, said in sorted(after.items())]
        FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    return wrong


if __name__ == "__main__":
    raise SystemExit(main())
