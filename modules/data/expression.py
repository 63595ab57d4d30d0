"""Expressions over names: their operations, and how several are computed at once, shared parts once."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

BLOCK = 1 << 16
"""Values that are computed at once."""


class FormulaError(ValueError):
    """A formula that cannot be read or computed; the sentence names the column."""


@dataclass(frozen=True, eq=False)
class Node:
    """A number, a name, or an operation on nodes. Nodes are shared: compare them by identity."""

    what: str
    inputs: tuple[Node, ...] = ()
    number: float = 0.0


@dataclass(frozen=True)
class Function:
    """What may be called: how it is computed, and how many arguments it takes (-2: two or more)."""

    compute: Callable[..., Any]
    arguments: int


def _truth(a: ArrayLike) -> NDArray[np.bool_]:
    return np.asarray(np.asarray(a) != 0)


def _where(condition: ArrayLike, yes: ArrayLike, no: ArrayLike) -> Any:
    return np.where(_truth(condition), yes, no)


def _power(a: Floats, b: Floats) -> Any:
    return a * a if np.ndim(b) == 0 and b == 2 else np.power(a, b)


FUNCTIONS: Mapping[str, Function] = {
    "abs": Function(np.abs, 1), "sqrt": Function(np.sqrt, 1), "exp": Function(np.exp, 1), "log": Function(np.log, 1),
    "log10": Function(np.log10, 1), "sin": Function(np.sin, 1), "cos": Function(np.cos, 1), "tan": Function(np.tan, 1),
    "asin": Function(np.arcsin, 1), "acos": Function(np.arccos, 1), "atan": Function(np.arctan, 1),
    "atan2": Function(np.arctan2, 2), "sinh": Function(np.sinh, 1), "cosh": Function(np.cosh, 1),
    "tanh": Function(np.tanh, 1), "floor": Function(np.floor, 1), "ceil": Function(np.ceil, 1),
    "sign": Function(np.sign, 1), "hypot": Function(np.hypot, 2), "min": Function(np.minimum, -2),
    "max": Function(np.maximum, -2), "where": Function(_where, 3),
}  # fmt: skip
"""Name -> function that a formula may call."""

OPERATIONS: Mapping[str, Callable[..., Any]] = {
    "+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "**": _power, "neg": np.negative,
    "<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal, "==": np.equal, "!=": np.not_equal,
    "and": lambda a, b: _truth(a) & _truth(b), "or": lambda a, b: _truth(a) | _truth(b), "not": lambda a: ~_truth(a),
    **{name: function.compute for name, function in FUNCTIONS.items()},
}  # fmt: skip


def order(*roots: Node) -> list[Node]:
    """All nodes once, inputs first."""
    done: dict[int, Node] = {}
    stack = [(root, False) for root in roots]
    while stack:
        node, ready = stack.pop()
        if id(node) in done:
            continue
        if ready:
            done[id(node)] = node
        else:
            stack.append((node, True))
            stack.extend((one, False) for one in node.inputs)
    return list(done.values())


def evaluate(roots: Sequence[Node], values: Mapping[str, ArrayLike]) -> list[Floats]:
    """Several expressions at once, each shared node computed once, in blocks."""
    nodes = order(*roots)
    given = {n.what[1:]: None for n in nodes if n.what.startswith("$")}
    lacking = [name for name in given if name not in values]
    if lacking:
        raise FormulaError(f"the formula uses {', '.join(map(repr, lacking))}, which has no value here")
    arrays = {name: np.asarray(values[name], dtype=float) for name in values}
    shape = np.broadcast_shapes(*(a.shape for a in arrays.values()))
    full = {name: np.broadcast_to(arrays[name], shape) for name in given}
    results = [np.empty(shape) for _ in roots]
    lines = shape[0] if shape else 1
    step = max(1, BLOCK * lines // max(1, math.prod(shape)))
    for start in range(0, lines, step):
        part = slice(start, start + step) if shape else ()
        found = _compute(nodes, {name: a[part] for name, a in full.items()})
        for result, root in zip(results, roots, strict=True):
            result[part] = found[id(root)]
    return results


def _compute(nodes: Iterable[Node], values: Mapping[str, Floats]) -> dict[int, Any]:
    found: dict[int, Any] = {}
    with np.errstate(all="ignore"):
        for node in nodes:
            if node.what == "number":
                found[id(node)] = np.float64(node.number)
            elif node.what.startswith("$"):
                found[id(node)] = values[node.what[1:]]
            else:
                result = OPERATIONS[node.what](*(found[id(one)] for one in node.inputs))
                found[id(node)] = result.astype(float) if result.dtype == bool else result
    return found


def words(root: Node) -> str:
    """The expression as text that `Formula.parse` reads."""
    text: dict[int, str] = {}
    for node in order(root):
        inner = [text[id(one)] for one in node.inputs]
        if node.what == "number":
            text[id(node)] = repr(node.number) if math.isfinite(node.number) and node.number >= 0 else f"({node.number!r})"
        elif node.what.startswith("$"):
            text[id(node)] = node.what[1:]
        elif node.what in FUNCTIONS:
            text[id(node)] = f"{node.what}({', '.join(inner)})"
        elif len(inner) == 1:
            text[id(node)] = f"({'-' if node.what == 'neg' else 'not '}{inner[0]})"
        else:
            text[id(node)] = f"({inner[0]} {node.what} {inner[1]})"
    return text[id(root)]
