"""A formula over the samples of several inputs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from modules.api import Literal, Samples, modeller
from modules.data.dimensions import converted, measured
from modules.data.expression import Node, order
from modules.data.formula import Formula, FormulaError
from modules.data.operators import Floats
from modules.data.units import UnitError
from modules.modellers._formulas import Column, Formulas, calculated

PORTS = "abcd"
COORDINATES = ("x", "y", "z", "t")


@modeller(
    "Calculator",
    output="samples",
    aliases=("formula", "expression", "arithmetic", "compute", "ratio", "sum", "product", "component", "combine fields"),
)
def calculator(
    a: Samples,
    b: Samples | None = None,
    c: Samples | None = None,
    d: Samples | None = None,
    *,
    formula: str = "a",
    unit: str = "",
    units: Literal["checked", "ignored"] = "checked",
    name: str = "",
) -> Samples:
    """Each sample computed by a formula from those of up to four inputs at its place.

    Names are a, b, c, d, the coordinates x, y, z and the time t. Components of a vector are a_x, a_y, a_z, of a tensor a_xx to
    a_zz; a vector by its name alone is reckoned component by component. Three formulas with ; between make a vector.
    There are + - * / **, comparisons, and, or, not, where(condition, yes, no), min, max, abs, sqrt, exp, log, log10, sin, cos,
    tan, asin, acos, atan, atan2, sinh, cosh, tanh, floor, ceil, sign, hypot, pi and e.

    Parameters
    ----------
    a, b, c, d : samples on one grid
    formula : for example sqrt(a**2 + b**2), or where(b > 0, a / b, 0)
    unit : of the outcome; the formula's own by default, which is converted. A number that is typed has the unit beside it
    units : checked brings kilometres to metres and refuses to add them to seconds; ignored reckons with plain numbers
    name : of the outcome; automatic: the formula

    Raises
    ------
    ValueError : a formula that cannot be read, a name without data, units that do not fit, inputs on different grids

    Accuracy: errors go through the derivatives of the formula, found by rule; what inputs have in common is known, so
    a - a is 0 without error. What bounds do beyond first order is enclosed by interval arithmetic and added, proven. Where
    deviations reach so far that the slope does not tell, it is flagged as not linear; members go through the formula itself.
    Where the formula has no number there is a hole, and it is flagged.
    Source: JCGM 100:2008, 5.1 and 5.2; Moore 1966.
    """
    inputs = {p: s for p, s in zip(PORTS, (a, b, c, d), strict=True) if s is not None}
    for port, samples in inputs.items():
        if not samples.grid.same_place(a.grid):
            raise ValueError(
                f"{port} lies on {samples.grid.shape} samples, a on {a.grid.shape} elsewhere: bring it there with 'resample'"
            )
    roots, extra = _read(formula, inputs)
    exact = _coordinates(a, roots)
    columns = _columns(roots, inputs)
    given = {one.name: list(inputs.values())[one.input].unit for one in columns}
    given |= dict(zip("xyz", a.grid.frame.units, strict=True)) | {"t": ""}
    if units == "checked":
        roots, unit = _in_one_unit(roots, given, unit)
    values, accuracy = calculated(Formulas(tuple(inputs.values()), roots, columns, exact), unit)
    return Samples(
        grid=a.grid,
        values=values.reshape(*a.grid.shape, *extra),
        unit=unit,
        name=name or " ".join(formula.split()),
        accuracy=accuracy,
        time=a.time,
    )


def _names(port: str, samples: Samples) -> list[str]:
    """Names of the components of an input."""
    along = {1: [""], 3: list("xyz"), 9: [i + j for i in "xyz" for j in "xyz"]}[samples.components]
    return [f"{port}_{one}" if one else port for one in along]


def _read(text: str, inputs: dict[str, Samples]) -> tuple[list[Node], tuple[int, ...]]:
    """The expression of each component, over names of components, and the shape of these."""
    names = list(dict.fromkeys([*inputs, *(n for p, s in inputs.items() for n in _names(p, s)), *COORDINATES]))
    parts = [one for one in text.split(";") if one.strip()] or [text]
    shape = {1: (), 3: (3,), 9: (3, 3)}.get(len(parts))
    if shape is None:
        raise FormulaError(f"{len(parts)} formulas with ; between: one makes numbers, three a vector, nine a tensor")
    read = [_parsed(one, names, inputs) for one in parts]
    whole = {p: inputs[p] for one in read for p in one.used if p in inputs and inputs[p].components > 1}
    if not whole:
        return [one.root for one in read], shape
    sizes = {s.components for s in whole.values()}
    if len(sizes) > 1 or len(parts) > 1:
        raise FormulaError(
            f"{' and '.join(sorted(whole))} by name alone are reckoned component by component, which does not fit here: "
            "write a component, such as a_x"
        )
    (count,) = sizes
    renamed = [{p: _names(p, s)[k] for p, s in whole.items()} for k in range(count)]
    return [_renamed(read[0].root, names_) for names_ in renamed], {3: (3,), 9: (3, 3)}[count]


def _parsed(text: str, names: Sequence[str], inputs: dict[str, Samples]) -> Formula:
    try:
        return Formula.parse(text, names)
    except FormulaError as error:
        absent = [p for p in PORTS if p not in inputs and f"there is no {p!r}" in str(error)]
        if absent:
            raise FormulaError(f"nothing is wired to {absent[0]}, which the formula uses") from None
        raise


def _renamed(root: Node, names: dict[str, str]) -> Node:
    found: dict[int, Node] = {}
    for node in order(root):
        inner = tuple(found[id(one)] for one in node.inputs)
        what = "$" + names[node.what[1:]] if node.what.startswith("$") and node.what[1:] in names else node.what
        found[id(node)] = Node(what, inner, node.number)
    return found[id(root)]


def _used(roots: Sequence[Node]) -> set[str]:
    return {n.what[1:] for n in order(*roots) if n.what.startswith("$")}


def _columns(roots: Sequence[Node], inputs: dict[str, Samples]) -> list[Column]:
    """The components that the formulas use."""
    used = _used(roots)
    return [
        Column(name, i, k)
        for i, (port, samples) in enumerate(inputs.items())
        for k, name in enumerate(_names(port, samples))
        if name in used
    ]


def _coordinates(a: Samples, roots: Sequence[Node]) -> dict[str, Floats]:
    used = _used(roots)
    exact: dict[str, Floats] = {}
    if used & set("xyz"):
        points = a.grid.points()
        exact = {name: points[:, i] for i, name in enumerate("xyz") if name in used}
    if "t" in used:
        if a.time is None:
            raise FormulaError("the formula uses the time t, and a has none")
        exact["t"] = np.full(a.grid.count, a.time)
    return exact


def _in_one_unit(roots: Sequence[Node], given: dict[str, str], wanted: str) -> tuple[list[Node], str]:
    """The expressions with conversions, all in one unit."""
    found = [measured(root, given) for root in roots]
    unit = wanted or next((u for _, u in found if u), "")
    result = []
    for node, own in found:
        if own is None or own == unit or (not own and wanted):
            result.append(node)
            continue
        try:
            result.append(converted(node, own, unit))
        except UnitError as error:
            raise FormulaError(f"the outcome is in {own or 'plain numbers'}, not in {unit}: {error}") from None
    return result, unit
