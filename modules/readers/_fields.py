"""A variable of a file as samples: axes in order and ascending, units, holes, and the errors that the file states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modules.data import correlation as correlated
from modules.data.accuracy import Flag
from modules.data.grid import Curvilinear, Frame, Grid
from modules.data.operators import Floats, scaling
from modules.data.units import UnitError, factor, linear
from modules.data.wires import Samples
from modules.readers import _cf
from modules.readers._budget import Budget, Wish
from modules.readers._cf import SPACE, Axis, Beside, Decoded
from modules.readers._files import ReadError, memory
from modules.readers._place import grid_of, local_plane
from modules.readers._store import Cut, Store, Variable

NARROW = 10.0
"""Degrees of latitude up to which a map is brought to metres on a plane unasked."""


@dataclass(frozen=True, eq=False)
class Layout:
    """How a variable's axes become a grid's.

    Parameters
    ----------
    cut : the part that is read: an index or everything along each axis
    kept : axes that stay, in the order of the file
    space : axes of the grid in the order z, y, x
    flips : which of these run downwards
    time : of the step, in seconds if its unit is known
    """

    axes: tuple[Axis, ...]
    cut: Cut
    kept: tuple[Axis, ...]
    space: tuple[Axis, ...]
    flips: tuple[bool, ...]
    time: float | None
    notes: tuple[str, ...]


def samples(store: Store, names: Sequence[str], content: str, wish: Wish) -> Samples:
    """One variable, or two or three as the components of a vector.

    Parameters
    ----------
    content : digest of the file, which names the terms

    Raises
    ------
    ReadError : no such variable, an axis that has to be cut, components that do not fit
    """
    parts = [_cf.chosen(store, name) for name in names or ("",)]
    first = parts[0]
    layout = _layout(store, first, wish)
    _fits(store, layout)
    for other in parts[1:]:
        if other.dims != first.dims or other.shape != first.shape or other.text("units") != first.text("units"):
            raise ReadError(f"{other.name!r} and {first.name!r} of {store.path.name!r} are not components of one vector")
    grid, flags = _grid(store, first, layout, wish)
    correlated.check(grid, wish.correlation, wish.length)
    values, members, half, words = _components(store, parts, layout)
    vector = len(parts) > 1
    name = "+".join(p.name.rsplit("/", 1)[-1] for p in parts)
    extra = (3,) if vector else ()
    builder = Budget(grid, 3 if vector else 1, _unit(first), f"{content}/{name}", _picked(layout), values.ravel(), wish)
    accuracy = builder.accuracy(half, words, members, [_stated(store, p, layout, wish) for p in parts])
    assumed = (*layout.notes, *store.notes, *builder.assumed)
    if assumed:
        flags = (*flags, Flag("assumed", "the file does not say it, so it was assumed that " + "; that ".join(assumed)))
    return Samples(
        grid=grid, values=values.reshape(*grid.shape, *extra), unit=_unit(first), name=name, time=layout.time,
        accuracy=accuracy.flag(*flags),
    )  # fmt: skip


def _fits(store: Store, layout: Layout) -> None:
    size = float(np.prod([a.size for a in layout.kept], dtype=float)) * 8
    if size > memory() / 2:
        room = f"{size / 2**30:.3g} GiB, more than half of the {memory() / 2**30:.3g} GiB of memory here"
        raise ReadError(f"{store.path.name!r}: this part takes {room}: cut an axis with 'at'")


def _unit(v: Variable) -> str:
    unit = v.text("units")
    return "" if unit == "1" else unit


# --- axes --------------------------------------------------------------------------------------------------------


def _layout(store: Store, v: Variable, wish: Wish) -> Layout:
    axes = _cf.axes(store, v)
    at = dict(wish.at)
    unknown = set(at) - {a.name for a in axes}
    if unknown:
        there = ", ".join(f"{a.name} ({a.size})" for a in axes)
        raise ReadError(f"{v.name!r} has no axis {unknown.pop()!r} to be cut at; its axes are {there}")
    cut: list[int | slice] = []
    kept: list[Axis] = []
    time, notes = None, []
    wide = sum(a.role in SPACE and a.size > 1 and a.name not in at for a in axes)
    for axis in axes:
        index = at.get(axis.name, wish.step if axis.role == "time" else None)
        if index is None and axis.size == 1 and (axis.role not in SPACE or wide):
            index = 0
        if index is None and axis.role not in (*SPACE, "member"):
            raise ReadError(f"{v.name!r} has an axis {axis.name!r} of {axis.size}: cut it with at = '{axis.name}=0'")
        if index is not None and not 0 <= index < axis.size:
            raise ReadError(f"{axis.name} = {index} of {v.name!r} is not there: it has {axis.size}, from 0 to {axis.size - 1}")
        if index is None:
            kept.append(axis)
        elif axis.role == "time":
            time = _seconds(axis, index)
        cut.append(slice(None) if index is None else index)
    space = tuple(sorted((a for a in kept if a.role in SPACE), key=lambda a: SPACE.index(a.role)))
    if not 1 <= len(space) <= 3 or len({a.role for a in kept}) < len(kept):
        raise ReadError(f"{v.name!r} has no axis that samples lie along: name another variable")
    notes = [f"samples lie 1 apart along {a.name}" for a in space if a.coordinates is None and not _cf.bent(store, v, space)]
    flips = tuple(_descends(store, v, a) for a in space)
    return Layout(axes, tuple(cut), tuple(kept), space, flips, time, tuple(notes))


def _descends(store: Store, v: Variable, axis: Axis) -> bool:
    x = axis.coordinates
    if x is None or len(x) < 2:
        return False
    steps = np.diff(x)
    if not np.isfinite(x).all() or not ((steps > 0).all() or (steps < 0).all()):
        raise ReadError(f"the coordinates {axis.name!r} of {v.name!r} in {store.path.name!r} neither rise nor fall throughout")
    return bool(steps[0] < 0)


def _seconds(axis: Axis, index: int) -> float | None:
    """The time of a step: in seconds since the file's own zero where its unit is known, else as stored."""
    if axis.coordinates is None:
        return None
    value = float(axis.coordinates[index])
    since = _cf.SECONDS.match(axis.unit)
    try:
        return value * factor(since.group(1) if since else axis.unit, "s")
    except UnitError:
        return value


def _picked(layout: Layout) -> str:
    """Which part of the variable it is, for the names of errors that are each sample's own."""
    some = [f"{a.name}={c}" for a, c in zip(layout.axes, layout.cut, strict=True) if isinstance(c, int) and a.size > 1]
    return f"[{','.join(some)}]" if some else ""


def _grid(store: Store, v: Variable, layout: Layout, wish: Wish) -> tuple[Grid, tuple[Flag, ...]]:
    space = layout.space
    pair = _cf.bent(store, v, space)
    crs = _reference(store, v)
    if pair is not None:
        return _bent(store, pair, layout, wish, crs)
    stored = [np.arange(a.size, dtype=float) if a.coordinates is None else a.coordinates for a in space]
    axes = [x[::-1] if turned else x for x, turned in zip(stored, layout.flips, strict=True)][::-1]
    names, units = [a.name for a in reversed(space)], [a.unit for a in reversed(space)]
    rounding = [4 * float(np.spacing(a.stored.type(np.abs(x).max()))) if a.stored is not None and a.stored.kind == "f" else 0.0
                for a, x in zip(reversed(space), axes, strict=True)]  # fmt: skip
    down = any(a.role == "z" and _down(store, v, a) for a in space)
    flags: tuple[Flag, ...] = ()
    if len(space) > 1 and [a.role for a in space[-2:]] == ["y", "x"] and _flat(units, axes[1], wish):
        axes[0], axes[1], crs, flag, scales = local_plane(axes[0], axes[1])
        rounding[:2] = [r * s for r, s in zip(rounding[:2], scales, strict=True)]
        names[:2], units[:2], flags = ["x", "y"], ["m", "m"], (flag,)
    filled = [*units, *[units[0]] * 3][:3]
    frame = Frame(
        ([*names, "y", "z"][0], [*names, "y", "z"][1], [*names, "y", "z"][2] if len(names) != 1 else "z"),
        (filled[0], filled[1], filled[2]), "left" if down else "right", crs,
    )  # fmt: skip
    return grid_of([np.ascontiguousarray(a) for a in axes], tuple(rounding), frame), flags


def _flat(units: Sequence[str], latitude: Floats, wish: Wish) -> bool:
    """Whether longitude and latitude are brought to metres."""
    degrees = all(u.startswith("degree") for u in units[:2])
    return degrees and (float(np.ptp(latitude)) <= NARROW if wish.plane is None else wish.plane)


def _down(store: Store, v: Variable, axis: Axis) -> bool:
    along = _cf.beside(store, v.name, axis.name)
    return along is not None and along.text("positive").lower() == "down"


def _bent(
    store: Store, pair: tuple[Variable, Variable], layout: Layout, wish: Wish, crs: str
) -> tuple[Grid, tuple[Flag, ...]]:
    x, y = (_cf.decoded(store, one, ()).values for one in pair)
    if [a.name for a in layout.kept if a.role in SPACE] != [a.name for a in layout.space]:
        x, y = x.T, y.T
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        unknown = "some coordinates are not known, so the place of its samples is not"
        raise ReadError(f"{store.path.name!r}: {unknown}: cut a part out of it")
    units, flags = [one.text("units") for one in pair], tuple[Flag, ...]()
    if _flat(units, y, wish):
        x, y, crs, flag, _ = local_plane(x, y)
        units, flags = ["m", "m"], (flag,)
    nodes = np.stack([x, y, np.zeros_like(x)], axis=-1)
    return Curvilinear(nodes, frame=Frame(units=(units[0], units[1], units[0]), crs=crs)), flags


def _reference(store: Store, v: Variable) -> str:
    """What is said of the reference system: its well-known text, else its name."""
    said = v.text("grid_mapping").split(":")[0].strip()
    mapping = _cf.beside(store, v.name, said) if said else None
    if mapping is not None:
        return mapping.text("crs_wkt") or mapping.text("spatial_ref") or mapping.text("grid_mapping_name")
    return str(store.attributes.get("crs", ""))


# --- numbers -----------------------------------------------------------------------------------------------------


def _ordered(array: Floats, layout: Layout, dims: Sequence[Axis]) -> Floats:
    """An array over some of the axes that stay, in the order (member, z, y, x) and along ascending axes; others get size 1."""
    wanted = [*(a for a in layout.kept if a.role == "member"), *layout.space]
    there = [a.name for a in dims]
    moved = np.transpose(array, [there.index(a.name) for a in wanted if a.name in there])
    shape = [a.size if a.name in there else 1 for a in wanted]
    turned = dict(zip((a.name for a in layout.space), layout.flips, strict=True))
    cut = tuple(slice(None, None, -1 if turned.get(a.name) else 1) for a in wanted)
    return moved.reshape(shape)[cut]


def _components(store: Store, parts: Sequence[Variable], layout: Layout) -> tuple[Floats, Floats | None, Floats, str]:
    """Values and halves (..., components), members less their mean (k, ...) or None, how they are rounded."""
    found = [_cf.decoded(store, v, layout.cut) for v in parts]
    if len(found) > 1 and len(found) < 3:
        zero = np.zeros_like(found[0].values)
        found += [Decoded(zero, np.asarray(0.0), "")] * (3 - len(found))
    halves = [np.broadcast_to(d.half, d.values.shape) if d.half.ndim else d.half for d in found]
    same = all(h.ndim == 0 and h == halves[0] for h in halves)
    values = np.stack([_ordered(d.values, layout, layout.kept) for d in found], axis=-1)
    half = halves[0] if same else np.stack(
        [_ordered(np.broadcast_to(h, d.values.shape), layout, layout.kept) for h, d in zip(halves, found, strict=True)], axis=-1
    )  # fmt: skip
    words = found[0].stored
    if not any(a.role == "member" for a in layout.kept):
        return values, None, half, words
    if len(values) < 2:
        return values[0], None, half[0] if half.ndim else half, words
    mean = values.mean(axis=0)
    return mean, np.nan_to_num(values - mean, nan=0.0), half.max(axis=0) if half.ndim else half, f"{words}, of each member"


def _stated(store: Store, v: Variable, layout: Layout, wish: Wish) -> list[tuple[Beside, Floats]]:
    """Errors beside a variable, in its unit, brought to its axes."""
    found = []
    for one in _cf.stated(store, v, wish.multiple):
        named = dict(zip(v.dims, zip(layout.axes, layout.cut, strict=True), strict=True))
        which, its = f"{one.variable.name!r} of {store.path.name!r}", one.variable
        alike = its.dims == v.dims or (its.shape == v.shape and not any(its.dims))
        if not alike and any(d not in named or not d for d in one.variable.dims):
            raise ReadError(f"{which} has axes that {v.name!r} has not, whose errors it states")
        if alike and one.variable.shape != v.shape:
            raise ReadError(f"{which} has shape {one.variable.shape}, {v.name!r} {v.shape}")
        pairs = list(zip(layout.axes, layout.cut, strict=True)) if alike else [named[d] for d in its.dims]
        sizes = _cf.decoded(store, one.variable, tuple(c for _, c in pairs)).values * one.factor
        over = [a for a, c in pairs if not isinstance(c, int)]
        ordered = _ordered(sizes, layout, over)
        if any(a.role == "member" for a in layout.kept):
            ordered = ordered.mean(axis=0)
        found.append((one, np.broadcast_to(ordered, tuple(a.size for a in layout.space))))
    return found


def with_unit(wire: Samples, unit: str) -> Samples:
    """In another unit: a conversion, or a name where the file gives none.

    Raises
    ------
    ReadError : it does not fit
    """
    if not wire.unit:
        terms = tuple(replace(t, unit=unit) for t in wire.accuracy.terms)
        return replace(wire, unit=unit, accuracy=replace(wire.accuracy, terms=terms))
    try:
        scale, offset = linear(wire.unit, unit)
    except UnitError as error:
        raise ReadError(f"unit = {unit!r} does not fit the file's: {error}") from None
    flags = wire.accuracy.flags
    accuracy = wire.accuracy
    if scale != 1:
        accuracy = accuracy.push(scaling(np.full(wire.values.size, scale)), unit=unit)
    else:
        accuracy = replace(accuracy, terms=tuple(replace(t, unit=unit) for t in accuracy.terms))
    return replace(wire, values=wire.values * scale + offset, unit=unit, accuracy=replace(accuracy, flags=flags))
