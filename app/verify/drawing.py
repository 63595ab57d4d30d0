"""Whether what a drawing leaves is what it states: chords against arcs, triangles against the surface, by points on them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from app.verify.findings import Finding
from app.verify.runs import Bench, Run
from app.verify.shapes import Level, chords, levels_of, measure_of, triangle_reach
from modules.data.accuracy import Term
from modules.data.grid import Rectilinear, Regular
from modules.data.wires import Geometry

Floats = NDArray[np.float64]

SEGMENTS, TRIANGLES = 400, 300
"""Looked at, at most."""
TIGHT = 0.02
"""By which part numbers that are exact may differ from those by points, which leave so much themselves."""


def drawing(bench: Bench, run: Run, node: str, output: str) -> Iterator[Finding]:
    """What lies between the points of lines and surfaces, against the network's own field."""
    shape, model = run.outputs[node][output], bench.model_of(node, run)
    if not isinstance(shape, Geometry) or model is None or model.law.name != "linear":
        return
    level = levels_of(shape)
    if level is None or not isinstance(model.grid, Regular | Rectilinear) or model.samples.components != 1:
        return
    if model.grid.dimensions == 2 and np.any(shape.points[:, 2]):
        return  # lifted into space: its lengths are no longer those of the plane
    truth = Level.of(model, False, measure_of(model))
    if len(shape.lines):
        yield from _lines(shape, level, truth)
    elif len(shape.polygons):
        yield from _polygons(shape, level, truth)


def _mapping(shape: Geometry, kind: str, quantity: str, place: str) -> list[Term]:
    return [
        t for t in shape.accuracy.terms
        if t.source.stage == "mapping" and (t.kind, t.quantity, t.place) == (kind, quantity, place)
        and t.source.rigour in ("exact", "proven")
    ]  # fmt: skip


def _some(n: int, most: int) -> NDArray[np.int64]:
    return np.arange(n) if n <= most else np.sort(np.random.default_rng(3).choice(n, most, replace=False))


def _lines(shape: Geometry, level: Floats, truth: Level) -> Iterator[Finding]:
    which = _some(len(shape.segments()), SEGMENTS)
    ends = shape.segments()[which]
    seen = chords(shape, ends, level[ends[:, 0]], truth)
    bounds = [t for t in _mapping(shape, "bound", "position", "point") if np.any(t.value)]
    if bounds:
        stated = sum((t.error(ends.ravel()).reshape(-1, 2).max(axis=1) for t in bounds), np.zeros(len(ends)))
        yield _beyond(bounds, "distance", seen.farthest, stated, "chords")
    for quantity, found in (("area", seen.area), ("length", seen.longer)):
        for term in _mapping(shape, "metric", quantity, "segment"):
            yield _equal(term, quantity, found, term.error(which))


def _polygons(shape: Geometry, level: Floats, truth: Level) -> Iterator[Finding]:
    corners = shape.triangles
    if len(corners) != len(shape.polygons):
        return
    unproven = np.zeros(len(corners), bool)
    for flag in shape.accuracy.flags:
        if flag.place == "cell" and flag.items is not None:
            unproven[flag.items] = True
    which = np.flatnonzero(~unproven)
    which = which[_some(len(which), TRIANGLES)]
    bounds = [t for t in _mapping(shape, "bound", "position", "point") if np.any(t.value)]
    if bounds and len(which):
        seen = triangle_reach(shape, which, level[corners[which, 0]], truth)
        stated = sum((t.error(corners[which].ravel()).reshape(-1, 3).max(axis=1) for t in bounds), np.zeros(len(which)))
        yield _beyond(bounds, "distance", seen, stated, "triangles")


def _beyond(bounds: list[Term], check: str, seen: Floats, stated: Floats, what: str) -> Finding:
    name = " + ".join(t.name for t in bounds)
    met = np.isfinite(seen)
    wrong = met & (seen > stated * (1 + TIGHT) + 1e-9 * float(np.nanmax(stated, initial=0.0)) + 1e-12)
    beyond = float(wrong.sum() / max(1, met.sum()))
    if not wrong.any():
        nearest = float(np.max(seen[met] / np.maximum(stated[met], 1e-300), initial=0.0))
        words = f"none of {int(met.sum())} {what} is farther from the field's level than stated; at most {nearest:.0%} of it"
        return Finding("", "", name, check, "holds" if met.any() else "not judged", words, {"largest": nearest})
    words = f"{beyond:.1%} of {int(met.sum())} {what} are farther from the field's level than stated"
    return Finding("", "", name, check, "wrong", words, {"beyond": beyond})


def _equal(term: Term, quantity: str, seen: Floats, stated: Floats) -> Finding:
    met = np.isfinite(seen)
    scale = float(np.max(np.abs(seen[met]), initial=0.0))
    wrong = met & ~(np.abs(seen - stated) <= TIGHT * np.abs(seen) + 2e-3 * scale)
    share = float(wrong.sum() / max(1, met.sum()))
    if share <= 0.01:
        words = f"as found by points on {int(met.sum())} segments"
        return Finding("", "", term.name, quantity, "holds" if met.any() else "not judged", words, {"off": share})
    words = f"{share:.1%} of {int(met.sum())} segments have another {quantity} than stated"
    return Finding("", "", term.name, quantity, "wrong", words, {"off": share})
