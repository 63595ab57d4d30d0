"""Formulas that a person types: read by a small evaluator of ours, never by Python's.

    Formula.parse("sin(x) * where(y > 0, y, 0)").value({"x": x, "y": y})

Numbers, names, + - * / **, comparisons, and, or, not, and the functions listed in `FUNCTIONS`. Everything is float64;
a comparison gives 1 or 0. Derivatives are formulas too.
"""

from __future__ import annotations

import ast
import difflib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from modules.data.derivative import derivatives
from modules.data.expression import FUNCTIONS, Floats, FormulaError, Node, evaluate, order, words

__all__ = ["CONSTANTS", "FUNCTIONS", "Formula", "FormulaError"]

LONGEST = 4000
"""Characters of a formula."""
DEEPEST = 150
"""Nested operations."""

CONSTANTS: Mapping[str, float] = {"pi": math.pi, "e": math.e}

BINARY: Mapping[type, str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**"}
COMPARE: Mapping[type, str] = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
INSTEAD: Mapping[type, str] = {
    ast.BitXor: "write ** for a power", ast.FloorDiv: "write floor(a / b)", ast.Mod: "write a - b * floor(a / b)",
    ast.BitAnd: "write 'and'", ast.BitOr: "write 'or'", ast.MatMult: "write * for a product",
}  # fmt: skip


@dataclass(frozen=True)
class Formula:
    """An expression over names.

    Parameters
    ----------
    root : the expression
    names : names that may be used, whether or not they are
    """

    root: Node
    names: tuple[str, ...]

    @classmethod
    def parse(cls, text: str, names: Sequence[str] = ("x", "y", "z", "t")) -> Formula:
        """Read a formula.

        Raises
        ------
        FormulaError : with the column, what is wrong there and what to write instead
        """
        return cls(_Reader(text, tuple(names)).read(), tuple(names))

    @property
    def used(self) -> frozenset[str]:
        """Names that occur."""
        return frozenset(n.what[1:] for n in order(self.root) if n.what.startswith("$"))

    def value(self, values: Mapping[str, ArrayLike]) -> Floats:
        """The formula for some values of its names, which broadcast against each other.

        Returns
        -------
        float array of their common shape; NaN or infinity where it has no number

        Raises
        ------
        FormulaError : a name that it uses is not given
        """
        return evaluate([self.root], values)[0]

    def derivative(self, name: str) -> Formula:
        """The derivative after one name; 0 for steps, one-sided at corners of abs, min, max."""
        return Formula(derivatives(self.root, name), self.names)

    def gradient(self, values: Mapping[str, ArrayLike], names: Sequence[str]) -> Floats:
        """(..., len(names)) derivatives after some names."""
        roots = [self.derivative(name).root for name in names]
        return np.stack(evaluate(roots, values), axis=-1)

    def __str__(self) -> str:
        return words(self.root)


class _Reader:
    """Turns the syntax tree of Python's parser into nodes, and refuses all that is not a formula."""

    def __init__(self, text: str, names: tuple[str, ...]) -> None:
        self.text = text
        self.names = names
        self.shift = len(text) - len(text.lstrip())

    def read(self) -> Node:
        text = self.text.strip().replace("\n", " ").replace("\r", " ")
        if not text:
            raise FormulaError("the formula is empty: write for example x**2 + y**2")
        if len(text) > LONGEST:
            raise FormulaError(f"the formula has {len(text)} characters; {LONGEST} are allowed: split it into steps")
        try:
            tree = ast.parse(text, mode="eval")
        except SyntaxError as error:
            raise self._unreadable(text, error) from None
        except (RecursionError, MemoryError, ValueError):
            raise FormulaError(f"the formula is nested too deeply; {DEEPEST} levels are allowed: split it into steps") from None
        return self._node(tree.body, 0)

    def _unreadable(self, text: str, error: SyntaxError) -> FormulaError:
        at = error.offset or len(text) + 1
        rest = text[at - 1 :].split() or ["the end"]
        hint = f"cannot be read at {rest[0][:20]!r}"
        if "invalid decimal literal" in error.msg:
            hint = "write a * between a number and a name"
        elif "=" in text and "==" not in text and "<=" not in text and ">=" not in text:
            hint = "write == to compare; a formula has no ="
        elif "nested" in error.msg:
            hint = f"nested too deeply; {DEEPEST} levels are allowed: split it into steps"
        elif "never closed" in error.msg or "unmatched" in error.msg:
            hint = "a bracket has no partner"
        elif at > len(text):
            hint = "something is missing at the end"
        return FormulaError(f"column {at + self.shift}: {hint}")

    def _wrong(self, tree: ast.AST, sentence: str) -> FormulaError:
        return FormulaError(f"column {getattr(tree, 'col_offset', 0) + 1 + self.shift}: {sentence}")

    def _node(self, tree: ast.expr, depth: int) -> Node:
        if depth > DEEPEST:
            raise self._wrong(tree, f"nested too deeply; {DEEPEST} levels are allowed: split it into steps")
        match tree:
            case ast.Constant():
                return self._number(tree)
            case ast.Name():
                return self._name(tree)
            case ast.Call():
                return self._call(tree, depth)
            case ast.BinOp():
                if type(tree.op) not in BINARY:
                    raise self._wrong(tree, INSTEAD.get(type(tree.op), "this operation is not known"))
                return Node(BINARY[type(tree.op)], (self._node(tree.left, depth + 1), self._node(tree.right, depth + 1)))
            case ast.UnaryOp():
                return self._unary(tree, depth)
            case ast.Compare():
                return self._compare(tree, depth)
            case ast.BoolOp():
                word = "and" if isinstance(tree.op, ast.And) else "or"
                return _folded(word, [self._node(one, depth + 1) for one in tree.values])
            case ast.IfExp():
                raise self._wrong(tree, "write where(condition, yes, no) instead of 'if'")
        raise self._wrong(tree, "only numbers, names, operations and functions make a formula")

    def _number(self, tree: ast.Constant) -> Node:
        if isinstance(tree.value, bool) or not isinstance(tree.value, int | float):
            raise self._wrong(tree, f"{str(tree.value)[:20]!r} is not a number")
        try:
            number = float(tree.value)
        except OverflowError:
            number = math.inf
        if math.isinf(number):
            raise self._wrong(tree, "the number is too large")
        return Node("number", number=number)

    def _name(self, tree: ast.Name) -> Node:
        if tree.id in self.names:
            return Node("$" + tree.id)
        if tree.id in CONSTANTS:
            return Node("number", number=CONSTANTS[tree.id])
        if tree.id in FUNCTIONS:
            raise self._wrong(tree, f"{tree.id!r} is a function: write {tree.id}(...)")
        raise self._wrong(tree, f"there is no {tree.id!r}{self._hint(tree.id, (*self.names, *CONSTANTS, *FUNCTIONS))}")

    def _hint(self, name: str, known: Sequence[str]) -> str:
        close = difflib.get_close_matches(name, known, n=1, cutoff=0.6)
        return f"; did you mean {close[0]!r}?" if close else f"; names are {', '.join(self.names)}"

    def _call(self, tree: ast.Call, depth: int) -> Node:
        if not isinstance(tree.func, ast.Name):
            raise self._wrong(tree, "only functions can be called: write * for a product")
        name = tree.func.id
        if name not in FUNCTIONS:
            if name in self.names or name in CONSTANTS:
                raise self._wrong(tree, f"{name!r} is not a function: write {name} * (...)")
            raise self._wrong(tree, f"there is no function {name!r}{self._hint(name, tuple(FUNCTIONS))}")
        if tree.keywords or any(isinstance(a, ast.Starred) for a in tree.args):
            raise self._wrong(tree, f"{name} takes plain arguments")
        wanted, got = FUNCTIONS[name].arguments, len(tree.args)
        if got != wanted if wanted > 0 else got < -wanted:
            takes = f"{wanted} argument{'s' * (wanted > 1)}" if wanted > 0 else f"{-wanted} arguments or more"
            raise self._wrong(tree, f"{name} takes {takes}, not {got}")
        inputs = [self._node(one, depth + 1) for one in tree.args]
        return _folded(name, inputs) if wanted < 0 else Node(name, tuple(inputs))

    def _unary(self, tree: ast.UnaryOp, depth: int) -> Node:
        inner = self._node(tree.operand, depth + 1)
        if isinstance(tree.op, ast.UAdd):
            return inner
        if isinstance(tree.op, ast.Invert):
            raise self._wrong(tree, "write 'not'")
        return Node("not" if isinstance(tree.op, ast.Not) else "neg", (inner,))

    def _compare(self, tree: ast.Compare, depth: int) -> Node:
        sides = [self._node(one, depth + 1) for one in (tree.left, *tree.comparators)]
        pairs = []
        for i, operation in enumerate(tree.ops):
            if type(operation) not in COMPARE:
                raise self._wrong(tree, "compare with <, <=, >, >=, == or !=")
            pairs.append(Node(COMPARE[type(operation)], (sides[i], sides[i + 1])))
        return _folded("and", pairs)


def _folded(what: str, nodes: Sequence[Node]) -> Node:
    result = nodes[0]
    for node in nodes[1:]:
        result = Node(what, (result, node))
    return result
