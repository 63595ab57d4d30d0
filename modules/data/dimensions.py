"""Units of formulas: what unit an expression has, and what must be converted on the way.

Metres and kilometres are added after a conversion; metres and seconds are not. A number that is typed takes the unit beside
it: in `a + 3` it is 3 of the unit of a. Temperatures with a zero of their own are taken in kelvin where they are multiplied,
and where one is taken from another.
"""

from __future__ import annotations

from collections.abc import Mapping

from modules.data import units
from modules.data.derivative import make, number
from modules.data.expression import FormulaError, Node, evaluate, order, words
from modules.data.units import UnitError

Measured = tuple[Node, str | None]
"""An expression and its unit; None for a number that takes the unit beside it."""

COMPARED = ("<", "<=", ">", ">=", "==", "!=")
JOINED = ("+", "-", "min", "max", "hypot", "atan2", *COMPARED)
ANGLES = ("sin", "cos", "tan")
PLAIN = ("exp", "log", "log10", "sinh", "cosh", "tanh", "asin", "acos", "atan")
SAME = ("neg", "abs", "floor", "ceil")


def measured(root: Node, given: Mapping[str, str]) -> Measured:
    """The expression with conversions where units ask for them, and its unit; None if it is of typed numbers alone.

    Parameters
    ----------
    given : name -> unit

    Raises
    ------
    FormulaError : quantities that do not fit; the sentence names both with their units
    """
    found: dict[int, Measured] = {}
    for node in order(root):
        inner = [found[id(one)] for one in node.inputs]
        if node.what == "number":
            found[id(node)] = node, None
        elif node.what.startswith("$"):
            found[id(node)] = node, given[node.what[1:]]
        else:
            try:
                found[id(node)] = _of(node, inner)
            except UnitError as error:
                raise FormulaError(f"{words(node)}: {error}") from None
    return found[id(root)]


def converted(node: Node, unit: str, into: str) -> Node:
    """The expression in another unit.

    Raises
    ------
    UnitError : they measure different things
    """
    scale, offset = units.linear(unit, into)
    return make("+", make("*", number(scale), node), number(offset))


def _of(node: Node, inner: list[Measured]) -> Measured:
    what = node.what
    if what in JOINED:
        return _joined(what, inner[0], inner[1])
    if what == "where":
        yes, no, unit = _together(inner[1], inner[2])
        return make("where", inner[0][0], yes, no), unit
    if what in ("*", "/"):
        (a, one), (b, other) = _kelvin(inner[0]), _kelvin(inner[1])
        both = None if one is None and other is None else units.product(one or "", other or "", 1 if what == "*" else -1)
        return make(what, a, b), both
    if what == "**":
        return _power(_kelvin(inner[0]), inner[1])
    if what in SAME:
        one_node, unit = _kelvin(inner[0]) if what in ("neg", "abs") else inner[0]
        return make(what, one_node), unit
    if what == "sqrt":
        (a, unit) = _kelvin(inner[0])
        return make(what, a), None if unit is None else units.root(unit)
    if what in ANGLES:
        return make(what, _angle(inner[0])), None if inner[0][1] is None else ""
    if what in PLAIN:
        turned = "rad" if what in ("asin", "acos", "atan") else ""
        return make(what, _plain(what, inner[0])), None if inner[0][1] is None else turned
    return make(what, *(one for one, _ in inner)), ""


def _joined(what: str, one: Measured, other: Measured) -> Measured:
    apart = [unit is not None and _own_zero(unit) for _, unit in (one, other)]
    if what in ("+", "-", "hypot", "atan2") and any(apart) and one[1] is not None and other[1] is not None:
        if all(apart) or what not in ("+", "-") or (what == "-" and apart[1]):
            one, other = _kelvin(one), _kelvin(other)
        else:  # a temperature and a difference
            low, high = (one, other) if apart[0] else (other, one)
            assert low[1] is not None and high[1] is not None
            moved = make("*", number(units.factor(high[1], low[1])), high[0])
            return make(what, low[0], moved), low[1]
    a, b, unit = _together(one, other)
    if what in COMPARED:
        return make(what, a, b), ""
    return make(what, a, b), "rad" if what == "atan2" and unit is not None else unit


def _together(one: Measured, other: Measured) -> tuple[Node, Node, str | None]:
    """Both in the unit of the first that has one."""
    (a, unit), (b, second) = one, other
    if unit is None or second is None or units.same(unit, second):
        return a, b, second if unit is None else unit
    try:
        return a, converted(b, second, unit), unit
    except UnitError:
        said = [f"{words(n)} is in {u or 'plain numbers'}" for n, u in ((a, unit), (b, second))]
        raise FormulaError(
            f"{said[0]}, {said[1]}: these do not add or compare; 'transform' changes a unit, "
            "or choose units 'ignored' to reckon with plain numbers"
        ) from None


def _own_zero(unit: str) -> bool:
    return units.known(unit) and units.parse(unit).offset != 0


def _kelvin(one: Measured) -> Measured:
    node, unit = one
    return (converted(node, unit, "K"), "K") if unit is not None and _own_zero(unit) else one


def _angle(one: Measured) -> Node:
    node, unit = one
    return node if unit is None or unit.strip().lower() in units.PURE else converted(node, unit, "rad")


def _plain(what: str, one: Measured) -> Node:
    node, unit = one
    if unit is None:
        return node
    try:
        return converted(node, unit, "")
    except UnitError:
        said = f"{what} takes plain numbers and {words(node)} is in {unit}: divide it by something in {unit}"
        raise UnitError(said) from None


def _power(base: Measured, exponent: Measured) -> Measured:
    (a, unit), (b, second) = base, exponent
    if second is not None:
        b = _plain("an exponent", exponent)
        return make("**", _plain("a power", base), b), ""
    value = float(evaluate([b], {})[0])
    whole = number(value)
    if unit is None:
        return make("**", a, whole), None
    if value == round(value):
        return make("**", a, whole), units.product("", unit, int(value))
    if value == 0.5:
        return make("**", a, whole), units.root(unit)
    return make("**", _plain("a broken power", base), whole), ""
