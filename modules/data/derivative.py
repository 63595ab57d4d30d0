"""Derivatives of formulas, as formulas: one rule per function, nodes shared, so that nothing blows up."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from modules.data.expression import OPERATIONS, Node, order

ZERO = Node("number", number=0.0)
ONE = Node("number", number=1.0)


def number(value: float) -> Node:
    """A number."""
    return Node("number", number=float(value))


def _is(node: Node, value: float) -> bool:
    return node.what == "number" and node.number == value


def make(what: str, *inputs: Node) -> Node:
    """An operation, with what is 0 or 1 left out and numbers computed."""
    if what in ("+", "-", "*", "/", "**", "neg") and all(one.what == "number" for one in inputs):
        with np.errstate(all="ignore"):
            return number(float(OPERATIONS[what](*(np.float64(one.number) for one in inputs))))
    if what == "neg":
        return inputs[0].inputs[0] if inputs[0].what == "neg" else Node("neg", inputs)
    if what == "where" and inputs[1] is inputs[2]:
        return inputs[1]
    if what in ("+", "-", "*", "/", "**"):
        a, b = inputs
        simple = _SIMPLER[what](a, b)
        if simple is not None:
            return simple
    return Node(what, inputs)


def _sum(a: Node, b: Node) -> Node | None:
    return b if _is(a, 0) else a if _is(b, 0) else None


def _difference(a: Node, b: Node) -> Node | None:
    return make("neg", b) if _is(a, 0) else a if _is(b, 0) else None


def _product(a: Node, b: Node) -> Node | None:
    if _is(a, 0) or _is(b, 0):
        return ZERO
    return b if _is(a, 1) else a if _is(b, 1) else None


def _quotient(a: Node, b: Node) -> Node | None:
    return ZERO if _is(a, 0) else a if _is(b, 1) else None


def _power(a: Node, b: Node) -> Node | None:
    return ONE if _is(b, 0) else a if _is(b, 1) else None


_SIMPLER: Mapping[str, Callable[[Node, Node], Node | None]] = {
    "+": _sum, "-": _difference, "*": _product, "/": _quotient, "**": _power,
}  # fmt: skip


def _of_one(node: Node, u: Node) -> Node:
    """Derivative of a function of one argument, by that argument."""
    rules: Mapping[str, Callable[[], Node]] = {
        "abs": lambda: Node("sign", (u,)),
        "sqrt": lambda: make("/", number(0.5), node),
        "exp": lambda: node,
        "log": lambda: make("/", ONE, u),
        "log10": lambda: make("/", number(1 / np.log(10)), u),
        "sin": lambda: Node("cos", (u,)),
        "cos": lambda: make("neg", Node("sin", (u,))),
        "tan": lambda: make("+", ONE, make("*", node, node)),
        "asin": lambda: make("/", ONE, Node("sqrt", (make("-", ONE, make("*", u, u)),))),
        "acos": lambda: make("/", number(-1), Node("sqrt", (make("-", ONE, make("*", u, u)),))),
        "atan": lambda: make("/", ONE, make("+", ONE, make("*", u, u))),
        "sinh": lambda: Node("cosh", (u,)),
        "cosh": lambda: Node("sinh", (u,)),
        "tanh": lambda: make("-", ONE, make("*", node, node)),
        "neg": lambda: number(-1),
    }
    rule = rules.get(node.what)
    return rule() if rule else ZERO


def _of_two(node: Node, du: Node, dv: Node) -> Node:
    u, v = node.inputs
    match node.what:
        case "+" | "-":
            return make(node.what, du, dv)
        case "*":
            return make("+", make("*", du, v), make("*", u, dv))
        case "/":
            return make("/", make("-", du, make("*", node, dv)), v)
        case "**":
            return _of_power(node, du, dv)
        case "atan2":
            return make("/", make("-", make("*", v, du), make("*", u, dv)), make("+", make("*", u, u), make("*", v, v)))
        case "hypot":
            return make("/", make("+", make("*", u, du), make("*", v, dv)), node)
        case "min":
            return make("where", Node("<=", (u, v)), du, dv)
        case "max":
            return make("where", Node(">=", (u, v)), du, dv)
    return ZERO


def _of_power(node: Node, du: Node, dv: Node) -> Node:
    u, v = node.inputs
    base = make("*", make("*", v, make("**", u, make("-", v, ONE))), du)
    if _is(dv, 0):
        return base
    return make("+", base, make("*", make("*", node, Node("log", (u,))), dv))


def derivatives(root: Node, name: str) -> Node:
    """The derivative of an expression after a name."""
    found: dict[int, Node] = {}
    for node in order(root):
        inner = [found[id(one)] for one in node.inputs]
        if node.what == "$" + name:
            result = ONE
        elif all(_is(one, 0) for one in inner):
            result = ZERO
        elif node.what == "where":
            result = make("where", node.inputs[0], inner[1], inner[2])
        elif len(inner) == 2:
            result = _of_two(node, inner[0], inner[1])
        else:
            result = make("*", _of_one(node, node.inputs[0]), inner[0])
        found[id(node)] = result
    return found[id(root)]
