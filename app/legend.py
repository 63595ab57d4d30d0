"""What a picture says of its accuracy, as plain data: what is drawn, what is not, what nobody gave.

Numbers are the largest over all items, standard deviations times k; bounds are rounded up, so that they stay bounds.
No matplotlib and no VTK here: window, picture and certificate read the same legend.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from app.draw import caption, numbers
from app.draw.parts import Bar, Block, Entry, Legend, Statistic, Swatch
from modules.data.accuracy import SIGNS, Accuracy, Flag, Missing, Term
from modules.data.geometry import Geometry, Shown
from modules.data.scene import (
    ChartLook,
    Colouring,
    ImageLook,
    LabelLook,
    Layer,
    LineLook,
    PointLook,
    Scene,
    SurfaceLook,
    VolumeLook,
)

__all__ = ["Bar", "Block", "Entry", "Legend", "Swatch", "legend"]

Check = Callable[[float], object]

LONG = 90
"""Letters of a flag's sentence from which only its first part stands in a legend."""

IN_WORDS: Mapping[str, str] = MappingProxyType({"kappa": "slope too small for the error"})
"""Names of flags that mean nothing to who has not read the theory."""


def legend(scene: Scene, *, k: float = 2.0, check: Check | None = None) -> Legend:
    """The legend of a scene; every term is evaluated over all its items.

    Parameters
    ----------
    k : coverage factor of standard deviations
    check : called with the fraction done; what it raises ends the work
    """
    found = _terms(scene.layers)
    entries: dict[tuple[str, str], Entry] = {}
    for i, (key, (term, layer)) in enumerate(found.items()):
        entries[key] = _entry(term, layer, k, _share(check, i, len(found)))
    drawn: set[tuple[str, str]] = set()
    owners = {e.id: found[key][1] for key, e in entries.items()}
    blocks = _gathered([(layer, _block(layer, entries, drawn, k)) for layer in scene.layers], owners)
    if scene.look.exaggeration != 1:
        blocks.insert(0, Block(title="", boxes=(f"heights ×{times(scene.look.exaggeration)}",)))
    rest = sorted((e for key, e in entries.items() if key not in drawn), key=_rank)
    rest = [replace(e, words=_told_apart(e, rest, scene.layers)) for e in rest]
    rest += [_missing(m) for m in _unique(m for a in _accuracies(scene.layers) for m in a.missing)]
    kept = tuple(b for b in reversed(blocks) if b.title or b.entries or b.boxes or b.bar)
    everything = [*(e for b in kept for e in b.entries), *rest]
    legend = Legend(
        drawn=kept, not_drawn=tuple(rest), flags=_flags(scene.layers), k=k, footer=_footer(everything, k), caption=""
    )
    return replace(legend, caption=caption.write(legend, scene.look.title))


def times(factor: float) -> str:
    """A factor without needless digits."""
    return numbers.grouped(f"{factor:.4g}")


def _accuracies(layers: Sequence[Layer]) -> Iterator[Accuracy]:
    for layer in layers:
        yield layer.accuracy
        if isinstance(layer.shape, Geometry):
            for primitive in layer.shape.primitives:
                yield primitive.accuracy


def _terms(layers: Sequence[Layer]) -> dict[tuple[str, str], tuple[Term, Layer]]:
    """Each source once for a quantity: where its items stand for themselves rather than for items of another shape."""
    found: dict[tuple[str, str], tuple[Term, Layer]] = {}
    for layer in layers:
        for accuracy in _accuracies([layer]):
            for term in accuracy.terms:
                key = (term.id, term.quantity)
                if key not in found or _preferred(term, layer) > _preferred(*found[key]):
                    found[key] = (term, layer)
    return found


def _preferred(term: Term, layer: Layer) -> tuple[bool, int]:
    return (not _derived(layer), term.count)


def _derived(layer: Layer) -> bool:
    """Whether the items stand for items of another shape, as words do: a sum over them would count some twice or not at all."""
    return isinstance(layer.look, LabelLook) or getattr(layer.shape, "origin", None) is not None


def _entry(term: Term, layer: Layer, k: float, check: Check | None) -> Entry:
    """A term evaluated, and put in words."""
    spread = term.kind in ("linear", "members")
    size = term.size(None, check) * (k if spread else 1.0)
    reach = _reach(layer) if term.quantity == "position" else math.inf
    beyond = int((~(size <= reach)).sum())
    largest = float(size.max()) if len(size) else 0.0
    p95 = float(np.quantile(size, 0.95, method="higher")) if len(size) else 0.0
    total = float(size.sum()) if term.kind == "metric" and not _derived(layer) else math.nan
    notes: list[str] = []
    up = term.source.rigour == "proven"

    def say(value: float) -> str:
        return numbers.quantity(value, term.unit, up=up)

    number = say(largest)
    statistic: Statistic = "largest"
    if math.isfinite(total):
        number, statistic = say(total), "in all"
        notes += [f"in all; largest {say(largest)} in one {_item(term)}"] if len(size) > 1 else []
    elif beyond:
        number, statistic = (say(p95), "95 %") if p95 <= reach else ("∞", "largest")
        notes.append(_unbounded(term, beyond, statistic))
    elif largest > 4 * p95 and len(size) >= 100:
        notes.append(f"{say(p95)} on 95 % of the {_item(term)}s" if p95 else f"none on 95 % of the {_item(term)}s")
    if term.kind == "members":
        notes.append(f"in {numbers.plural(term.value.shape[0], 'draw')}")
    return Entry(
        sign=term.source.sign, rigour=term.source.rigour, number=f"±{number}" if spread else number,
        words=term.name, notes=tuple(notes), statistic=statistic, value=_finite(largest, reach),
        p95=_finite(p95, reach), total=_finite(total, math.inf), beyond=beyond, count=len(size), spread=spread,
        id=term.id, quantity=term.quantity, unit=term.unit, stage=term.source.stage, rule=term.source.rule,
    )  # fmt: skip


def _item(term: Term) -> str:
    return "point" if term.place == "own" else term.place


def _unbounded(term: Term, beyond: int, statistic: str) -> str:
    which = f"{numbers.count(beyond)} of {numbers.count(term.count)} {_item(term)}s"
    far = "leaves the picture" if term.quantity == "position" else "has no bound"
    return f"on 95 %; {far} at {which}" if statistic == "95 %" else f"{far} at {which}"


def _finite(value: float, reach: float) -> float | None:
    return value if math.isfinite(value) and value <= reach else None


def _reach(layer: Layer) -> float:
    """The size of a shape: an error of position beyond it says nothing."""
    bounds = getattr(layer.shape, "bounds", None)
    if bounds is None:
        return math.inf
    return math.dist(bounds[::2], bounds[1::2]) or math.inf


def _block(layer: Layer, entries: dict[tuple[str, str], Entry], drawn: set[tuple[str, str]], k: float) -> Block:
    shown: list[Entry] = []
    boxes: list[str] = []
    its = {t.id for t in layer.accuracy.terms}
    for one in layer.shows:
        keys = [key for key, e in entries.items() if (e.words, e.quantity) == (one.name, one.quantity) and e.id in its]
        drawn.update(keys)
        mine = [entries[key] for key in keys]
        if not mine:
            mine = [_total(layer, one, k)]
            drawn.update(key for key, e in entries.items() if e.quantity == one.quantity)
        notes = (one.note,) if one.note else ()
        swatch = swatch_of(layer)
        shown += [replace(e, notes=(*e.notes, *notes), swatch=swatch) for e in mine]
        if one.factor != 1:
            boxes.append(f"errors ×{times(one.factor)}")
    shown += _valueless(layer)
    swatch = swatch_of(layer) if layer.title and not layer.shows else None
    return Block(
        title=layer.title, swatch=swatch, bar=_bar(layer), entries=tuple(shown), boxes=tuple(dict.fromkeys(boxes))
    )  # fmt: skip


def _told_apart(entry: Entry, others: Sequence[Entry], layers: Sequence[Layer]) -> str:
    """The words of an entry, with its quantity where another has the same words."""
    if sum(e.words == entry.words for e in others) < 2:
        return entry.words
    names = {layer.shape.name for layer in layers if getattr(layer.shape, "name", "")}
    value = names.pop() if len(names) == 1 else "the value"
    return f"{entry.words}, in {value if entry.quantity == 'value' else entry.quantity}"


def _total(layer: Layer, shown: Shown, k: float) -> Entry:
    """What is shown is no single source: the combined error of the quantity."""
    accuracy, quantity = layer.accuracy, shown.quantity
    terms = accuracy.select(quantity)
    if not terms:
        return Entry(sign=SIGNS["unknown"], rigour="unknown", number="", words=shown.name, statistic="", quantity=quantity)
    size = accuracy.total(k, quantity, terms[0].place)
    word = accuracy.word(quantity)
    largest = float(size.max()) if len(size) else 0.0
    number = numbers.quantity(largest, terms[0].unit, up=word == "proven")
    return Entry(
        sign=SIGNS[word], rigour=word, number=number, words=shown.name, value=_finite(largest, math.inf),
        count=len(size), quantity=quantity, unit=terms[0].unit,
        spread=any(t.kind in ("linear", "members") for t in terms),
    )  # fmt: skip


def _gathered(blocks: Sequence[tuple[Layer, Block]], owners: Mapping[str, Layer]) -> list[Block]:
    """Errors shown by a layer without a title stand under the layer that they are errors of; the same one stands once."""
    layers = [layer for layer, _ in blocks]
    out = [block for _, block in blocks]
    for i, (_, block) in enumerate(blocks):
        if block.title or block.bar or not block.entries:
            continue
        owner = owners.get(block.entries[0].id)
        at = next((j for j, layer in enumerate(layers) if layer is owner and j != i and out[j].title), None)
        if at is None:
            continue
        known = {e.id for e in out[at].entries}
        entries = (*out[at].entries, *(e for e in block.entries if not e.id or e.id not in known))
        out[at] = replace(out[at], entries=entries, boxes=tuple(dict.fromkeys((*out[at].boxes, *block.boxes))))
        out[i] = Block(title="")
    return out


def swatch_of(layer: Layer) -> Swatch | None:
    """A sample of a layer's look; None where a colour bar or nothing tells more."""
    look = layer.look
    if getattr(look, "colouring", None) is not None:
        return None
    if isinstance(look, LineLook):
        return Swatch(kind="line", colour=look.colour, size=look.width, dashed=look.dashed)
    if isinstance(look, PointLook):
        return Swatch(kind="dust" if layer.shows else "points", colour=look.colour, size=look.size)
    if isinstance(look, SurfaceLook) and not look.relief:
        return Swatch(kind="surface", colour=look.colour)
    if isinstance(look, ChartLook):
        kinds = {"curve": "line", "bars": "surface", "scatter": "points", "band": "surface", "error bars": "line"}
        return Swatch(kind=kinds[look.kind], colour=look.colour, size=3.0)  # type: ignore[arg-type]  # one of the kinds
    return None


def _bar(layer: Layer) -> Bar | None:
    look = layer.look
    if not isinstance(look, SurfaceLook | LineLook | PointLook | ImageLook | VolumeLook) or look.colouring is None:
        return None
    colouring = look.colouring
    values = coloured_values(layer, colouring)
    finite = values[np.isfinite(values)]
    ends = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    low, high = colouring.range or ends
    return Bar(
        title=colouring.title, unit=colouring.unit, colours=tuple(tuple(float(v) for v in c) for c in colouring.map.colours),
        low=low, high=high, scale=colouring.map.scale, steps=colouring.map.steps,
        under=bool(ends[0] < low), over=bool(ends[1] > high),
    )  # fmt: skip


def _valueless(layer: Layer) -> list[Entry]:
    """What gets no colour since nobody knows its value; samples without one are holes in the data and are left clear."""
    colouring = getattr(layer.look, "colouring", None)
    if colouring is None or not isinstance(layer.shape, Geometry):
        return []
    values = coloured_values(layer, colouring)
    missing = int(np.isnan(values).sum())
    if not missing:
        return []
    place = layer.shape.values[colouring.by].place
    drawn = "hatched" if isinstance(layer.look, SurfaceLook) else "grey"
    where = f"{numbers.count(missing)} of {numbers.plural(len(values), place)}"
    words = f"{colouring.title or colouring.by} not known at {where}, {drawn}"
    return [Entry(sign=SIGNS["unknown"], rigour="unknown", number="", words=words, statistic="")]


def coloured_values(layer: Layer, colouring: Colouring) -> Any:
    """(n,) the values that give a layer its colours; vectors by their length."""
    shape = layer.shape
    found = shape.values[colouring.by].values if isinstance(shape, Geometry) else shape.values
    values = np.asarray(found, float)
    return np.linalg.norm(values, axis=1) if isinstance(shape, Geometry) and values.ndim > 1 else values.ravel()


def _rank(entry: Entry) -> tuple[int, str, float, str]:
    order = ("position", "value", "velocity", "area", "length")
    place = order.index(entry.quantity) if entry.quantity in order else len(order)
    size = entry.total if entry.total is not None else entry.value
    return (place, entry.quantity, -math.inf if size is None else -size, entry.words)


def _missing(missing: Missing) -> Entry:
    words = f"{missing.name} {missing.reason}" if missing.reason == "not given" else f"{missing.name}: {missing.reason}"
    return Entry(sign=SIGNS["unknown"], rigour="unknown", number="", words=words, statistic="")


def _unique(missing: Iterator[Missing]) -> list[Missing]:
    return list(dict.fromkeys(missing))


def _flags(layers: Sequence[Layer]) -> tuple[str, ...]:
    """Flags on the whole in their own words; of others each kind with the number of its places, equal ones once."""
    seen: dict[int, Flag] = {id(f): f for a in _accuracies(layers) for f in a.flags}
    whole = dict.fromkeys(_short(f.words) for f in seen.values() if f.items is None)
    counts: dict[str, int] = {}
    for flag in seen.values():
        if flag.items is not None:
            counts[flag.name] = counts.get(flag.name, 0) + flag.count
    return (*whole, *(f"{IN_WORDS.get(name, name)}: {numbers.plural(n, 'place')}" for name, n in counts.items()))


def _short(words: str) -> str:
    """The part of a sentence before its details."""
    return words.split(";")[0].split(" (")[0] if len(words) > LONG else words


def _footer(entries: Sequence[Entry], k: float) -> str:
    if not any(e.number for e in entries):
        return ""
    parts = ["numbers are the largest of all items" if any(e.statistic == "largest" for e in entries) else ""]
    parts.append(f"± is k = {k:g} standard deviations" if any(e.spread for e in entries) else "")
    words = "; ".join(p for p in parts if p)
    return words[:1].upper() + words[1:]


def _share(check: Check | None, i: int, n: int) -> Check | None:
    return None if check is None else lambda f: check((i + f) / n)
