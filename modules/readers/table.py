"""A table of numbers, from text: to be drawn as a chart, with the errors that its columns state."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from modules.api import Accuracy, Missing, Table, reader
from modules.data.companions import is_companion
from modules.readers import _columns
from modules.readers._files import ReadError, digest, problem, reading


def peek(path: Path) -> Mapping[str, Any]:
    """Names of the columns."""
    try:
        return _columns.peek(_columns.file_of(path))
    except ReadError as error:
        return problem(error)


@reader("Read table", output="table", peek=peek, aliases=("csv", "tsv", "spreadsheet", "columns"))
def table(*, path: Path | None = None) -> Table:
    """The columns of a text file (.csv, .tsv, .txt, .xyz, .dat), each with what is known of its errors.

    Parameters
    ----------
    path : the file; names of columns stand in its first line, units in brackets behind them; columns of words are left out

    Raises
    ------
    ReadError : no numbers, a word among them, or lines of different length

    Accuracy: of each column, the rounding of its printed digits as a proven bound, and what columns beside it state
    (name_std, name_lo with name_hi, ...); errors of measurement that the file does not state are listed as missing.
    """
    found = _columns.file_of(path)
    with reading(found):
        read = _columns.read(found)
    content = digest(found)
    shown = [name for name in read.values if not is_companion(name, read.values)]
    parts = {name: read.accuracy(name, slice(None), content, name, read.units[name]) for name in shown}
    bare = [name for name, part in parts.items() if part.missing]
    accuracy = Accuracy(tuple(t for part in parts.values() for t in part.terms))
    if bare:
        accuracy = accuracy.miss(Missing("Measurement error", f"the file states none of {', '.join(bare)}"))
    units = {name: read.units[name] for name in shown if read.units[name]}
    return Table(columns={name: read.values[name] for name in shown}, units=units, name=found.stem, accuracy=accuracy)
