"""Two columns of a table as a curve, bars or a scatter."""

from __future__ import annotations

from modules.api import Annotated, ChartLook, Choice, Layer, Literal, Shown, Table, renderer


@renderer("Chart", aliases=("graph", "plot", "curve", "histogram", "error over time"), output="layer")
def chart(
    table: Table,
    *,
    kind: Literal["curve", "bars", "scatter"] = "curve",
    x: Annotated[str, Choice(of="table.names")] = "",
    y: Annotated[str, Choice(of="table.names")] = "",
    colour: str = "line",
    title: str = "",
) -> Layer:
    """A column of a table over another one. Several charts in one view share their axes, named after the first.

    Parameters
    ----------
    kind : curve (a gap where a number is missing), bars or scatter
    x, y : columns; automatic: the first and the second
    colour : a role or "#rrggbb"
    title : for the legend; automatic: the column, and nothing where the error itself stands there

    Raises
    ------
    ValueError : no such column, a column of words, or a table with fewer than two

    Accuracy: passed on as it is. A column that states the size of an error of the table is named in the legend as shown.
    """
    across, up = x or _name(table, 0), y or _name(table, 1)
    for name in (across, up):
        if name not in table.columns:
            raise ValueError(f"the table has no column {name!r}: it has {', '.join(table.columns)}")
        if table.columns[name].dtype.kind not in "fiub":
            raise ValueError(f"column {name!r} holds words: choose one of numbers")
    quantities = {t.name: t.quantity for t in table.accuracy.terms}
    shows: tuple[Shown, ...] = ()
    if up in quantities:
        shows = (Shown(up, quantities[up], f"over {across}"),)
    look = ChartLook(kind=kind, x=across, y=up, colour=colour)
    words = title or ("" if shows else up[:1].upper() + up[1:])
    return Layer(shape=table, look=look, title=words, shows=shows, accuracy=table.accuracy)


def _name(table: Table, which: int) -> str:
    names = list(table.columns)
    if len(names) <= which:
        raise ValueError(f"a chart needs two columns; the table has {', '.join(names) or 'none'}")
    return names[which]
