"""The claims of one output, each held against what happens: propagation, spread, coverage, bounds, estimates, orders."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import erf

from app.verify.findings import Finding, Verdict
from app.verify.observe import View
from app.verify.runs import Run
from modules.data.accuracy import Missing, Term

Floats = NDArray[np.float64]

OFF = {"value": 0.02, "position": 0.25}
"""By which part of its size an error may come out otherwise than its operator says; the slope of two cells beside a point
of a line is not one number."""
SPREAD = {"value": 0.08, "position": 0.15}
"""By which part a spread may differ from the one that is stated, beside what so few runs leave open."""
WITHIN = 0.034
"""By how much coverage may differ from k's own (92 to 98 % for k = 2)."""
LEFT = 0.6
"""The most that a signed estimate may leave of an error, in root mean square."""
ORDER = 0.9
"""By how much the order of an estimate may differ from that of the error."""
MOSTLY = 0.5
"""Part of a total up to which estimates leave it a limit."""
ROUNDING = 1e-11
"""Of the size of the values: smaller differences are rounding."""
SLACK = {"value": 1e-6, "position": 0.25}
"""By which part a bound may be exceeded: positions follow from values to first order only."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """Runs in which errors of data came true.

    Parameters
    ----------
    small : id -> its primitives, and the run
    done : id, or "" for all together -> primitives by id, and the run, many times
    """

    small: Mapping[str, tuple[Floats, Run]]
    done: Mapping[str, Sequence[tuple[Mapping[str, Floats], Run]]]


def propagation(small: View | None, id: str, made: Floats, plain: Run) -> Iterator[Finding]:
    """Whether a small error comes out as the term's operator says."""
    term = _named(small, id)
    if small is None or term is None:
        return
    error, said, size = _moved(small, plain), small.realised(term, made), np.abs(small.size(term))
    slack = 2 * _bounds(small, frozenset({id})) + ROUNDING * small.scale
    looked = np.isfinite(error) & ~small.excused & (size > 0)
    if not looked.any() or np.sqrt(np.mean(said[looked] ** 2)) < 1e3 * ROUNDING * small.scale:
        yield _told(term, "propagation", "not judged", "too small to be told from rounding")
        return
    scale = np.maximum(size, 1e-3 * size[looked].max())[looked] * np.sqrt(np.mean((said[looked] / size[looked]) ** 2))
    rest = np.maximum(np.abs(error - said) - slack, 0.0)[looked] / scale
    off = float(np.sqrt(np.mean(np.sort(rest**2)[: math.ceil(0.97 * len(rest))])))
    good = off <= OFF[small.quantity]
    words = f"a small error comes out as stated, but for {off:.1%} of it" if good else (
        f"a small error comes out otherwise than stated, by {off:.0%} of its size"
    )
    yield _told(term, "propagation", "holds" if good else "wrong", words, off=off)


def drawn(id: str, runs: Sequence[tuple[Floats, View | None]], plain: Run, k: float) -> Iterator[Finding]:
    """Whether the spread of many realisations is the one stated, and how many lie within k of them; or within a bound."""
    views = [v for _, v in runs if v is not None and _named(v, id)]
    if not views:
        return
    term = _named(views[0], id)
    assert term is not None
    z = [one for v in views if len(one := _sizes(v, id, plain))]
    if not z:
        yield _told(term, "spread", "not judged", "there is no place where it is larger than rounding and no flag excuses it")
    elif term.kind != "bound" and len(z) < 2:
        yield _told(term, "spread", "not judged", "too few runs give it")
    elif term.kind == "bound":
        yield _bounded(term, np.concatenate(z), views[0].quantity)
    else:
        yield from _spread(term, z, k, views[0].quantity)


def _sizes(v: View, id: str, plain: Run) -> Floats:
    """Errors of a run over the size stated there, where there is one."""
    term = _named(v, id)
    assert term is not None
    error, size = _moved(v, plain), np.abs(v.size(term))
    looked = np.isfinite(error) & np.isfinite(size) & ~v.excused & (size > 100 * ROUNDING * v.scale)
    slack = 2 * _bounds(v, frozenset({id}))
    if term.kind != "bound":  # where a step rounds away what it is about, no spread can be told
        looked, slack = looked & (slack <= 0.3 * size), np.zeros(len(slack))
    return np.asarray(np.maximum(np.abs(error) - slack, 0.0)[looked] / size[looked])


def _bounded(term: Term, z: Floats, quantity: str) -> Finding:
    beyond = float(np.mean(z > 1 + SLACK[quantity]))
    good = beyond <= (0.0 if quantity == "value" else 0.01)
    words = f"never exceeded in {len(z)} errors; the largest was {z.max():.0%} of it" if not beyond else (
        f"exceeded by {beyond:.1%} of {len(z)} errors, by up to {z.max():.3g} times"
    )
    return _told(term, "bound", "holds" if good else "wrong", words, beyond=beyond, largest=float(z.max()))


def _spread(term: Term, z: list[Floats], k: float, quantity: str) -> Iterator[Finding]:
    squares = np.array([np.mean(np.minimum(one, 30.0) ** 2) for one in z])
    ratio = math.sqrt(squares.mean())
    alike = _alike(z)
    open_ = 3 * max(float(squares.std(ddof=1)) / max(2 * ratio, 1e-9), math.sqrt(alike / 2)) / math.sqrt(len(z))
    good = abs(ratio - 1) <= SPREAD[quantity] + open_
    words = f"the spread of {len(z)} runs is {ratio:.2f} of the one stated"
    yield _told(term, "spread", "holds" if good else "wrong", words, ratio=ratio)
    covered = np.array([np.mean(one <= k) for one in z])
    share, nominal = float(covered.mean()), float(erf(k / math.sqrt(2)))
    open_ = 3 * max(float(covered.std(ddof=1)), math.sqrt(alike * nominal * (1 - nominal))) / math.sqrt(len(z))
    good = abs(share - nominal) <= WITHIN + open_
    words = f"{share:.1%} of errors lie within {k:g} standard deviations; {nominal:.1%} should"
    yield _told(term, "coverage", "holds" if good else "wrong", words, covered=share, nominal=nominal)


def _alike(z: list[Floats]) -> float:
    """How much the errors of one run are one error: 0 for independent ones, 1 for a common one."""
    within = float(np.mean([one.var() for one in z])) / max(float(np.mean([np.mean(one**2) for one in z])), 1e-300)
    return float(np.clip(1 - within / (1 - 2 / math.pi), 0.0, 1.0))


def own(here: View, half: View, truth: Run, of_data: frozenset[str], unknown: Sequence[Missing]) -> Iterator[Finding]:
    """Whether the errors that the network makes itself are what it states of them."""
    signed = [t for t in here.terms if t.kind == "signed" and t.id not in of_data]
    error = here.off(truth, True)
    looked = np.isfinite(error) & ~here.excused
    if not looked.any():
        return
    estimate = _sum(here, signed)
    slack = 2 * _bounds(here, of_data) + 4.5 * _deviation(here, of_data)
    name = " + ".join(t.name for t in signed)
    scale = _rms(error[looked])
    if scale < 1e3 * ROUNDING * here.scale:
        return
    if signed:
        yield from _estimated(here, name, error, estimate, slack, looked, unknown)
        yield from _order(here, half, name, truth, looked, of_data, slack)
    elif slack.any():
        yield _within(here, of_data, np.abs(error)[looked], slack[looked])


def _estimated(
    here: View, name: str, error: Floats, estimate: Floats, slack: Floats, looked: NDArray[np.bool_], unknown: Sequence[Missing]
) -> Iterator[Finding]:
    rest = np.maximum(np.abs(error - estimate) - slack, 0.0)[looked]
    keep = np.argsort(np.abs(error[looked]))[: math.ceil(0.99 * len(rest))]
    left = _rms(rest[keep]) / max(_rms(error[looked][keep]), 1e-300)
    large = looked & (np.abs(error) > 0.3 * _rms(error[looked]))
    effective = float(np.median(np.abs(estimate[large]) / np.abs(error[large]))) if large.any() else math.nan
    good = left <= LEFT
    words = f"effectivity {effective:.2f} (estimated over true error); taking it off leaves {left:.2f} of the error"
    if not good and unknown:
        yield Finding("", "", name, "estimate", "not judged", f"{words}; {unknown[0].name} is not known", {"left": left})
        return
    numbers = {"effectivity": effective, "left": left}
    yield Finding("", "", name, "estimate", "holds" if good else "wrong", words, numbers)


def _order(
    here: View, half: View, name: str, truth: Run, looked: NDArray[np.bool_], of_data: frozenset[str], slack: Floats
) -> Iterator[Finding]:
    """Errors e(h) - e(h/4) and e(h/2) - e(h/4) of order p stand to each other as 2^p + 1 to 1."""
    error, finer = here.off(truth, True), half.off(truth, True)
    seen = np.isfinite(finer) & ~half.excused
    mine, theirs = (
        float(np.median(np.abs(_sum(v, [t for t in v.terms if t.kind == "signed" and t.id not in of_data])[rows])))
        if rows.any() else 0.0
        for v, rows in ((here, looked), (half, seen))
    )  # fmt: skip
    small = 1e4 * ROUNDING * here.scale
    if here.components > 1 and here.quantity == "position":
        return  # particles of finer lattices take other steps: their points do not stand for the same ones
    if not seen.any() or min(_rms(finer[seen]), mine, theirs) <= small or _rms(slack[looked]) > 0.1 * _rms(error[looked]):
        return
    ratio = float(np.median(np.abs(error[looked])) / max(float(np.median(np.abs(finer[seen]))), 1e-300))
    order, stated = math.log2(max(ratio - 1, 1e-3)), math.log2(mine / theirs)
    good = abs(order - stated) <= ORDER
    words = f"the error falls with order {order:.1f}, the estimate with {stated:.1f}"
    numbers = {"order": order, "stated": stated}
    yield Finding("", "", name, "order", "holds" if good else "wrong", words, numbers)


def _within(here: View, of_data: frozenset[str], error: Floats, slack: Floats) -> Finding:
    beyond = float(np.mean(error > slack * (1 + 1e-6) + ROUNDING * here.scale))
    names = " + ".join(t.name for t in here.terms if t.id not in of_data and t.kind in ("bound", "linear") and np.any(t.value))
    good = beyond <= 0.001
    words = "what it leaves out is never larger than stated" if good else f"{beyond:.1%} of its errors are larger than stated"
    return Finding("", "", names, "bound", "holds" if good else "wrong", words, {"beyond": beyond})


def unless(unknown: Sequence[Missing], finding: Finding) -> Finding:
    """A finding that is no reproach where the output says itself that a source is not known."""
    if finding.verdict != "wrong" or not unknown:
        return finding
    return replace(finding, verdict="not judged", words=f"{finding.words}; {unknown[0].name} is not known")


def total(
    views: Sequence[View | None], plain: View, truth: Run, k: float, unknown: Sequence[Missing]
) -> Iterator[Finding]:
    """How often the truth lies within all that is stated together.

    Estimates of the network's own errors are made from noisy data and are noisy themselves, which they do not state; so the
    claim is judged with the estimates of the data without noise wherever these are of the same items, and both are told.
    Places where estimates are most of the total are left out: an estimate is as often too small as too large.
    """
    shares, strict = [], []
    for v in views:
        if v is None or not len(v.items):
            continue
        error = v.off(truth, True).reshape(-1, v.components)
        looked = np.isfinite(error).all(axis=1) & ~v.excused.reshape(-1, v.components).any(axis=1)
        if not looked.any():
            continue
        limit = v.accuracy.total(k, v.quantity, "point", v.items)
        looked &= _estimates(v) <= MOSTLY * limit
        if not looked.any():
            continue
        size, limit = np.linalg.norm(error[looked], axis=1) - ROUNDING * v.scale, limit[looked]
        strict.append(float(np.mean(size <= limit * (1 + 1e-9))))
        if v.quantity == "value" and len(v.items) == len(plain.items):
            limit = limit + _estimates(plain)[looked] - _estimates(v)[looked]
        shares.append(float(np.mean(size <= limit * (1 + 1e-9))))
    if not shares:
        return
    share, nominal = float(np.mean(shares)), float(erf(k / math.sqrt(2)))
    open_ = 3 * float(np.std(shares, ddof=1)) / math.sqrt(len(shares)) if len(shares) > 1 else 1.0
    good = share >= nominal - WITHIN - open_
    words = f"the truth lies within the total at {share:.1%} of the places; at least {nominal - WITHIN:.0%} should"
    if float(np.mean(strict)) < nominal - WITHIN:
        words += f" ({np.mean(strict):.1%} where the estimates are made from noisy data)"
    verdict: Verdict = "holds" if good else "not judged" if unknown else "wrong"
    if verdict == "not judged":
        words = f"{words}; {unknown[0].name} is not known"
    yield Finding("", "", "", "total", verdict, words, {"covered": share, "with noisy estimates": float(np.mean(strict))})


def _estimates(v: View) -> Floats:
    """(items,) sizes of the signed estimates."""
    sizes = [np.linalg.norm(v.size(t).reshape(-1, v.components), axis=1) for t in v.terms if t.kind == "signed"]
    return sum(sizes, np.zeros(len(v.items)))


# --- what the parts have in common -----------------------------------------------------------------------------------


def _named(v: View | None, id: str) -> Term | None:
    return next((t for t in v.terms if t.id == id), None) if v is not None else None


def _told(term: Term, check: str, verdict: Verdict, words: str, **numbers: float) -> Finding:
    return Finding("", "", term.name, check, verdict, words, numbers)


def _rms(numbers: Floats) -> float:
    return float(np.sqrt(np.mean(numbers**2))) if len(numbers) else 0.0


def _sum(v: View, terms: Sequence[Term]) -> Floats:
    return sum((v.size(t) for t in terms), np.zeros(len(v.excused)))


def _bounds(v: View, without: frozenset[str]) -> Floats:
    """(rows,) bounds of steps that change values, such as rounding; those of drawing lie between points."""
    return _sum(v, [t for t in v.terms if t.kind == "bound" and t.id not in without and t.source.stage != "mapping"])


def _moved(v: View, plain: Run) -> Floats:
    """(rows,) errors against the run without noise, without what a drawing is off from its own field in both."""
    drawn = [t for t in v.terms if v.components == 1 and t.kind == "signed" and t.source.stage == "mapping"]
    return v.off(plain, False) - _sum(v, drawn)


def _deviation(v: View, without: frozenset[str]) -> Floats:
    """(rows,) deviation of what steps added themselves."""
    sizes = [v.size(t) ** 2 for t in v.terms if t.kind in ("linear", "members") and t.id not in without]
    return np.sqrt(sum(sizes, np.zeros(len(v.excused))))
