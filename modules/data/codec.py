"""A budget as text and numbered arrays, and back: exactly, with its operators, sharing what it shares. Nothing is run.

The text is JSON; an array is named in it by its number, its type and its shape, so that any container of plain arrays
holds it: a VTK file, an npz.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from modules.data.accuracy import SIGNS, Accuracy, Ended, Flag, Missing, Source, Term
from modules.data.operators import Chain, Gather, Identity, Matrix, Operator, Spread, Stencil, Sum

FORMAT = "nonius accuracy"
VERSION = 1
OPERATORS: Mapping[str, type[Operator]] = {
    kind.__name__: kind for kind in (Gather, Stencil, Chain, Sum, Identity, Spread, Matrix)
}
KINDS = ("linear", "bound", "signed", "members", "metric")


class CodecError(ValueError):
    """A text that is no budget, or one that this version does not know."""


class Writer:
    """Collects arrays and operators, each once."""

    def __init__(self) -> None:
        self.arrays: list[NDArray[Any]] = []
        self.operators: list[dict[str, Any]] = []
        self._known: dict[int, tuple[Any, Any]] = {}

    def array(self, array: Any) -> Any:
        """A plain number, or a reference to an array that is stored beside the text."""
        array = np.asarray(array)
        if not array.ndim:
            return array.item()
        known = self._known.get(id(array))
        if known is not None:
            return known[1]
        stored = np.ascontiguousarray(array)
        reference = {"array": len(self.arrays), "type": stored.dtype.str, "shape": list(stored.shape)}
        if not stored.size:
            reference["array"] = -1
        else:
            self.arrays.append(native(stored).ravel())
        self._known[id(array)] = (array, reference)
        return reference

    def operator(self, operator: Operator) -> int:
        """The number of an operator in the list; those that it needs come first."""
        known = self._known.get(id(operator))
        if known is not None:
            return int(known[1])
        name = type(operator).__name__
        if OPERATORS.get(name) is not type(operator):
            raise CodecError(f"an operator {name!r} has no form in a file: add it to {__name__}.OPERATORS")
        record: dict[str, Any] = {"kind": name}
        if isinstance(operator, Matrix):
            entries = csr_array(operator.entries)
            record |= {"shape": [int(n) for n in entries.shape]}
            record |= {part: self.array(getattr(entries, part)) for part in ("data", "indices", "indptr")}
        else:
            record |= {f.name: self._field(getattr(operator, f.name)) for f in fields(operator)}
        self.operators.append(record)
        self._known[id(operator)] = (operator, len(self.operators) - 1)
        return len(self.operators) - 1

    def _field(self, value: Any) -> Any:
        if isinstance(value, Operator):
            return self.operator(value)
        if isinstance(value, tuple):
            return [self.operator(v) if isinstance(v, Operator) else int(v) for v in value]
        return int(value) if isinstance(value, int) else self.array(value)

    def accuracy(self, accuracy: Accuracy) -> dict[str, Any]:
        """The record of a budget; its operators are in `operators`."""
        return {
            "terms": [self._term(t) for t in accuracy.terms],
            "missing": [[m.name, m.reason] for m in accuracy.missing],
            "flags": [self._flag(f) for f in accuracy.flags],
            "ended": {i: [e.name, e.why] for i, e in accuracy.ended.items()},
        }

    def _term(self, term: Term) -> dict[str, Any]:
        s = term.source
        return {
            "id": term.id, "name": s.name, "stage": s.stage, "rigour": s.rigour, "rule": s.rule, "kind": term.kind,
            "quantity": term.quantity, "unit": term.unit, "place": term.place, "components": term.components,
            "value": self.array(term.value), "operator": self.operator(term.operator),
            "points": None if term.points is None else self.array(term.points),
        }  # fmt: skip

    def _flag(self, flag: Flag) -> dict[str, Any]:
        return {
            "name": flag.name, "words": flag.words, "place": flag.place,
            "items": None if flag.items is None else self.array(flag.items),
            "values": None if flag.values is None else self.array(flag.values),
        }  # fmt: skip


class Reader:
    """Rebuilds arrays, operators and budgets; checks that no index leads outside."""

    def __init__(self, operators: list[dict[str, Any]], arrays: Callable[[int], NDArray[Any]]) -> None:
        self._records = operators
        self._arrays = arrays
        self._operators: list[Operator] = []
        self._known: dict[int, NDArray[Any]] = {}
        for record in operators:
            self._operators.append(self._operator(record))

    def array(self, reference: Any) -> NDArray[Any]:
        """The array of a reference, or a number as a 0-d array."""
        if not isinstance(reference, Mapping):
            return np.asarray(reference, dtype=float)
        number, kind, shape = reference["array"], np.dtype(reference["type"]), tuple(reference["shape"])
        if kind.kind not in "fiub" or kind.hasobject:
            raise CodecError(f"an array of {kind} is no part of a budget")
        if number == -1:
            return np.zeros(shape, kind)
        if number not in self._known:
            self._known[number] = np.asarray(self._arrays(number)).ravel().astype(kind).reshape(shape)
        return self._known[number]

    def _operator(self, record: Mapping[str, Any]) -> Operator:
        kind = OPERATORS.get(record["kind"])
        if kind is None:
            raise CodecError(f"the operator {record['kind']!r} is not known to this version: update the program")
        if kind is Matrix:
            data, indices, indptr = (self.array(record[part]) for part in ("data", "indices", "indptr"))
            operator: Operator = Matrix(csr_array((data, indices, indptr), shape=tuple(record["shape"])))
        else:
            operator = kind(**{f.name: self._field(kind, f.name, record[f.name]) for f in fields(kind)})
        _inside(operator)
        return operator

    def _field(self, kind: type[Operator], name: str, stored: Any) -> Any:
        if name in ("first", "then"):
            return self._earlier(stored)
        if name == "parts":
            return tuple(self._earlier(i) for i in stored)
        if name == "lattice":
            return tuple(int(n) for n in stored)
        return int(stored) if name in ("n", "n_in", "n_out", "axis") else self.array(stored)

    def _earlier(self, number: int) -> Operator:
        if not 0 <= number < len(self._operators):
            raise CodecError(f"operator {len(self._operators)} names operator {number}, which does not come before it")
        return self._operators[number]

    def accuracy(self, record: Mapping[str, Any]) -> Accuracy:
        """The budget of a record."""
        return Accuracy(
            tuple(self._term(t) for t in record["terms"]),
            tuple(Missing(name, reason) for name, reason in record["missing"]),
            tuple(self._flag(f) for f in record["flags"]),
            {i: Ended(name, why) for i, (name, why) in record["ended"].items()},
        )

    def _term(self, t: Mapping[str, Any]) -> Term:
        if t["kind"] not in KINDS or t["rigour"] not in SIGNS:
            raise CodecError(f"the term {t['name']!r} is of kind {t['kind']!r}, {t['rigour']!r}: unknown to this version")
        return Term(
            Source(t["name"], t["stage"], t["rigour"], t["rule"]), t["kind"], t["quantity"], t["unit"], self.array(t["value"]),
            self._earlier(t["operator"]), t["place"], int(t["components"]), t["id"],
            None if t["points"] is None else self.array(t["points"]),
        )  # fmt: skip

    def _flag(self, f: Mapping[str, Any]) -> Flag:
        items, values = (None if f[key] is None else self.array(f[key]) for key in ("items", "values"))
        return Flag(f["name"], f["words"], f["place"], items, values)


def _inside(operator: Operator) -> None:
    """Refuse an operator whose entries lead outside, for the folds do not look."""
    if isinstance(operator, Gather):
        good = operator.index.ndim == 2 and operator.weight.shape in ((), operator.index.shape)
        good = good and _within(operator.index, operator.n_in)
    elif isinstance(operator, Stencil):
        good = 0 <= operator.axis < len(operator.lattice) and operator.columns.shape == operator.weights.shape
        good = good and operator.columns.ndim == 2 and _within(operator.columns, operator.lattice[operator.axis])
    elif isinstance(operator, Chain):
        good = operator.then.shape[1] == operator.first.shape[0]
    elif isinstance(operator, Sum):
        good = len({part.shape for part in operator.parts}) == 1
    elif isinstance(operator, Matrix):
        operator.entries.check_format(full_check=True)
        good = True
    else:
        good = min(operator.shape) >= 0
    if not good:
        raise CodecError(f"an operator of the budget ({type(operator).__name__}) leads outside its data: the file is damaged")


def _within(index: NDArray[Any], n: int) -> bool:
    return not index.size or (int(index.min()) >= 0 and int(index.max()) < n)


def native(array: NDArray[Any]) -> NDArray[Any]:
    """The same numbers in this machine's order of bytes, rows together, truths as 0 and 1: what containers hold."""
    kind = np.dtype(np.uint8) if array.dtype.kind == "b" else array.dtype.newbyteorder("=")
    return np.ascontiguousarray(array, dtype=kind)


def encode(accuracy: Accuracy) -> tuple[str, list[NDArray[Any]]]:
    """A budget as JSON and the arrays that it names by number."""
    writer = Writer()
    record = writer.accuracy(accuracy)
    return dumps({"format": FORMAT, "version": VERSION, **record, "operators": writer.operators}), writer.arrays


def decode(text: str, arrays: Callable[[int], NDArray[Any]]) -> Accuracy:
    """The budget of `encode`.

    Raises
    ------
    CodecError : no budget, a newer version, or damaged
    """
    record = loads(text, FORMAT, VERSION)
    return guarded(lambda: Reader(record["operators"], arrays).accuracy(record))


def dumps(record: Mapping[str, Any]) -> str:
    """JSON in ASCII, which every container holds."""
    return json.dumps(record, ensure_ascii=True, separators=(",", ":"))


def loads(text: str, form: str, version: int) -> dict[str, Any]:
    """The record of a text of the given format and at most this version."""
    try:
        record = json.loads(text)
    except ValueError as error:
        raise CodecError(f"the {form} of the file is no JSON: {error}") from None
    if not isinstance(record, dict) or record.get("format") != form:
        raise CodecError(f"the file holds something else where its {form} should be")
    if not isinstance(record.get("version"), int) or record["version"] > version:
        raise CodecError(f"the {form} is of version {record.get('version')}; this program knows {version}: update it")
    return cast(dict[str, Any], record)


def guarded(build: Callable[[], Accuracy]) -> Accuracy:
    """What `build` gives; what it raises on a damaged record as one sentence."""
    try:
        return build()
    except CodecError:
        raise
    except (KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
        raise CodecError(f"the accuracy in the file is damaged ({type(error).__name__}: {error})") from error
