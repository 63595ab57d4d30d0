"""Columns of a table as a curve, bars, a scatter, or a band of error."""

from __future__ import annotations

import numpy as np

from modules.api import Annotated, ChartLook, Choice, Layer, Literal, Shown, Table, renderer


@renderer("Chart", version=3, aliases=("graph", "plot", "curve", "histogram", "error over time", "error bars"), output="layer")
def chart(
    table: Table,
    *,
    kind: Literal["curve", "bars", "scatter", "band", "error bars"] = "curve",
    x: Annotated[str, Choice(of="table.names")] = "",
    y: Annotated[str, Choice(of="table.names")] = "",
    upper: Annotated[str, Choice(of="table.names")] = "",
    x_scale: Literal["linear", "logarithmic"] = "linear",
    y_scale: Literal["linear", "logarithmic"] = "linear",
    colour: str = "line",
    title: str = "",
) -> Layer:
    """A column of a table over another one. Several charts in one view share their axes, named after the first.

    Parameters
    ----------
    kind : curve (a gap where a number is missing), bars or scatter; band, what lies between y and `upper`; or error bars, which
        run from y to `upper`
    x, y : columns; automatic: the first and the second. Of a band or error bars y is automatically the column that ends in
        "less error"
    upper : the other end of a band or of error bars; automatic: the column that ends in "and error"
    x_scale, y_scale : of the axes. On a logarithmic one numbers of 0 and less have no place: there are gaps, and the legend
        counts them
    colour : a role or "#rrggbb"
    title : for the legend; automatic: the column, and nothing where the error itself stands there

    Raises
    ------
    ValueError : no such column, a column of words, a table with fewer than two, bars on a logarithmic axis, or no number
        above 0 on one

    Accuracy: passed on as it is. A column that states the size of an error of the table is named in the legend as shown.
    """
    between = kind in ("band", "error bars")
    across = x or _name(table, 0)
    up = y or (_ending(table, " less error") if between else _name(table, 1))
    top = (upper or _ending(table, " and error")) if between else ""
    for name in (across, up, top) if between else (across, up):
        if name not in table.columns:
            raise ValueError(f"the table has no column {name!r}: it has {', '.join(table.columns)}")
        if table.columns[name].dtype.kind not in "fiub":
            raise ValueError(f"column {name!r} holds words: choose one of numbers")
    lost = _lost(table, kind, (across,) if x_scale == "logarithmic" else (), (up, top) if y_scale == "logarithmic" else ())
    quantities = {t.name: t.quantity for t in table.accuracy.terms}
    shows: tuple[Shown, ...] = ()
    if up in quantities:
        shows = (Shown(up, quantities[up], f"over {across}"),)
    if between:
        base, note = up.removesuffix(" less error"), "in the band" if kind == "band" else "in the bars"
        shows = tuple(Shown(t.name, t.quantity, note) for t in table.accuracy.select(base))
    look = ChartLook(kind=kind, x=across, y=up, upper=top, x_scale=x_scale, y_scale=y_scale, colour=colour)
    called = f"error of {up.removesuffix(' less error')}" if between else up
    words = title or ("" if shows else called[:1].upper() + called[1:])
    words = ", ".join(w for w in (words, f"{lost:,} of {table.rows:,} not above 0 and left out" if lost else "") if w)
    return Layer(shape=table, look=look, title=words, shows=shows, accuracy=table.accuracy)


def _lost(table: Table, kind: str, across: tuple[str, ...], up: tuple[str, ...]) -> int:
    """How many rows have no place on the logarithmic axes of these columns."""
    names = [name for name in (*across, *up) if name]
    if names and kind == "bars":
        raise ValueError("bars stand on 0, which a logarithmic axis does not have: choose a curve or a scatter")
    low = np.zeros(table.rows, bool)
    for name in names:
        column = np.asarray(table.columns[name], float)
        if not (column > 0).any():
            raise ValueError(f"column {name!r} has no number above 0: a logarithmic axis has no place for it")
        low |= column <= 0
    return int(low.sum())


def _ending(table: Table, words: str) -> str:
    """The first column whose name ends so."""
    found = next((name for name in table.columns if name.endswith(words)), "")
    if not found:
        raise ValueError(f"no column ends in{words!r}: name the two columns between which the error lies as y and upper")
    return found


def _name(table: Table, which: int) -> str:
    names = list(table.columns)
    if len(names) <= which:
        raise ValueError(f"a chart needs two columns; the table has {', '.join(names) or 'none'}")
    return names[which]
