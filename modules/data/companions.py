"""Errors that lie beside an array under its name: X with X_std, X_lo and X_hi, X_members; and the rounding of X itself.

X_min and X_max are limits only if they enclose X: many files call other things so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from hashlib import sha256
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modules.data.accuracy import Accuracy, Missing, Source, Term
from modules.data.fold import Kind
from modules.data.operators import Floats, Identity

DEVIATIONS = ("_std", "_sigma", "_stderr", "_unc", "_uncertainty", "_error", "_errors", "_spread")
LIMITS = (("_lo", "_hi"), ("_lower", "_upper"), ("_min", "_max"))
DOUBTFUL = ("_min", "_max")
MEMBERS = "_members"
ENDINGS = (*DEVIATIONS, *(ending for pair in LIMITS for ending in pair), MEMBERS)


def rounding(dtype: np.dtype[Any], largest: float) -> tuple[float, str]:
    """Largest error of numbers stored as `dtype` and read as float64, up to `largest` in size; how, in words."""
    read = float(np.spacing(np.float64(largest))) / 2
    if dtype.kind in "iub":
        return max(0.5, read), f"half a unit of {dtype.name}"
    kind = min((dtype.newbyteorder("="), np.dtype(float)), key=lambda k: k.itemsize)
    spacing = float(np.spacing(kind.type(largest)))
    return spacing / 2, f"half the distance between neighbouring {kind.name} numbers at {largest:g}"


def largest(values: NDArray[Any]) -> float:
    """Largest size of the finite numbers; 0 if there is none."""
    finite = values[np.isfinite(values)]
    return max(abs(float(finite.max())), abs(float(finite.min()))) if finite.size else 0.0


def is_companion(name: str, names: Iterable[str]) -> bool:
    """Whether an array states the error of another one."""
    return any(name.endswith(e) and name.removesuffix(e) in names for e in ENDINGS)


def found(
    name: str,
    values: NDArray[Any],
    unit: str,
    names: Iterable[str],
    array: Callable[[str], NDArray[Any]],
    quantity: str = "value",
    content: str = "",
) -> Accuracy:
    """The budget of an array by what lies beside it: rounding, deviations, limits, members.

    Parameters
    ----------
    values : (n,) or (n, 3) as stored
    names, array : what lies beside it, and how it is got
    content : identity of the file; by default of the values

    Raises
    ------
    ValueError : a companion of another length, or with sizes that are none
    """
    names = set(names)
    flat = np.asarray(values).reshape(len(values), -1)
    content = content or sha256(np.ascontiguousarray(flat).tobytes()).hexdigest()
    components = flat.shape[1]

    def term(what: str, kind: Kind, value: NDArray[Any], rigour: Any, rule: str, called: str) -> Term:
        operator = Identity(flat.size)
        value = np.asarray(value, float)
        return Term(
            Source(called, "data", rigour, rule), kind, quantity, unit, value, operator, "point", components,
            f"{content}/{name}/{what}",
        )  # fmt: skip

    half, words = rounding(flat.dtype, largest(flat))
    words += " (rounding of stored numbers/1)"
    terms = [term("quantisation", "bound", np.asarray(half), "proven", words, "Quantisation")]
    for ending in DEVIATIONS:
        if name + ending in names:
            sizes = _sizes(name + ending, array(name + ending), flat)
            rule = f"{name + ending!r} in the file, taken as independent standard deviations (companion array/1)"
            terms.append(term(ending[1:], "linear", sizes, "estimated", rule, f"Stated by {name + ending}"))
    for low, high in LIMITS:
        if {name + low, name + high} <= names:
            room = _limits(name, flat, array(name + low), array(name + high))
            if room is None and low in DOUBTFUL:
                continue
            if room is None:
                raise ValueError(f"the limits {name + low!r} and {name + high!r} do not enclose its values")
            rule = f"{name + low!r} and {name + high!r} in the file, taken as limits (companion array/1)"
            terms.append(term("limits", "bound", room, "estimated", rule, f"Stated by {name + low}, {name + high}"))
    if name + MEMBERS in names:
        members = _members(name + MEMBERS, array(name + MEMBERS), flat)
        rule = f"{len(members)} members in {name + MEMBERS!r} of the file (companion array/1)"
        terms.append(term("members", "members", members, "sampled", rule, f"Members {name + MEMBERS}"))
    missing = (Missing("Measurement error", "the file states none"),) if len(terms) == 1 else ()
    return Accuracy(tuple(terms), missing)


def _sizes(name: str, stated: NDArray[Any], flat: NDArray[Any]) -> Floats:
    sizes = _fitting(name, stated, flat)
    holes = np.isnan(flat).ravel()
    if (~holes & ~(np.isfinite(sizes) & (sizes >= 0))).any():
        raise ValueError(f"{name!r} should hold standard deviations; it holds negative sizes, NaN or infinity")
    return np.where(holes, 0.0, sizes)


def _limits(name: str, flat: NDArray[Any], low: NDArray[Any], high: NDArray[Any]) -> Floats | None:
    """How far the limits lie from the values; None if they do not enclose them."""
    lower, upper = _fitting(name + "_lo", low, flat), _fitting(name + "_hi", high, flat)
    values = flat.astype(float).ravel()
    sizes = np.maximum(values - lower, upper - values)
    holes = np.isnan(values)
    if (~holes & ~((lower <= values) & (values <= upper) & np.isfinite(sizes))).any():
        return None
    return np.where(holes, 0.0, sizes)


def _members(name: str, stated: NDArray[Any], flat: NDArray[Any]) -> Floats:
    """(k, n) members less the values; the array beside has one row a sample."""
    members = np.asarray(stated, float)
    if members.size % flat.size or members.size < 2 * flat.size:
        raise ValueError(f"{name!r} has {members.size} numbers for {flat.size} values: it should have two or more for each")
    errors = members.reshape(flat.size, -1).T - flat.astype(float).ravel()
    return np.asarray(np.nan_to_num(errors, nan=0.0))


def _fitting(name: str, stated: NDArray[Any], flat: NDArray[Any]) -> Floats:
    array = np.asarray(stated, float)
    if array.size == len(flat) and flat.shape[1] > 1:
        array = np.repeat(array.ravel(), flat.shape[1])
    if array.size != flat.size:
        raise ValueError(f"{name!r} has {array.size} numbers for {flat.size} values")
    return array.ravel()


def readable(name: str, values: NDArray[Any], accuracy: Accuracy, quantity: str = "value") -> dict[str, NDArray[Any]]:
    """What other programs read of a budget: X_std, X_lo and X_hi, X_members, all per point.

    Deviations add in squares; limits are the sum of the bounds and of the sizes of signed errors. What is correlated,
    and who made which error, only the full budget says.
    """
    beside: dict[str, NDArray[Any]] = {}
    terms = [t for t in accuracy.select(quantity, "point") if t.kind != "metric"]
    random = [t.error() ** 2 for t in terms if t.kind in ("linear", "members")]
    if random:
        beside[f"{name}_std"] = np.sqrt(np.sum(random, axis=0))
    straight = [np.abs(t.error()) for t in terms if t.kind in ("bound", "signed")]
    if straight:
        size = np.sum(straight, axis=0)
        centre = np.asarray(values, float).reshape(size.shape)
        beside |= {f"{name}_lo": centre - size, f"{name}_hi": centre + size}
    for term in terms:
        if term.kind == "members" and f"{name}{MEMBERS}" not in beside:
            members = np.stack([term.operator.apply(member) for member in term.value], axis=-1)
            beside[f"{name}{MEMBERS}"] = np.asarray(values, float).reshape(-1, 1) + members
    return beside
