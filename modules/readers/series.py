"""Many files that belong together: steps of time, of which one is read, or members of an ensemble, read together."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from modules.api import Accuracy, Choice, Identity, Missing, Progress, Range, Samples, Source, Term, reader
from modules.readers import _containers, _vtk, dataset, elevation, gridded
from modules.readers._files import NotReadHere, ReadError, digest, memory, problem, unreadable

Read = Callable[..., Samples]


def peek(path: Path) -> Mapping[str, Any]:
    """Names in the first file, its shape, and how many files there are."""
    try:
        found = files(path)
        facts = dict(_kind(found[0])[1](found[0]))
        return {**facts, "steps": (0, len(found) - 1), "files": tuple(f.name for f in found)}
    except ReadError as error:
        return problem(error)


def files(path: Path | None) -> list[Path]:
    """The files that fit a pattern, in the order of the numbers in their names.

    Raises
    ------
    ReadError : none fits, or it is no pattern
    """
    if path is None or path.as_posix() in ("", "."):
        raise ReadError("no files are chosen: set 'path' to a pattern, as velocity_*.vti")
    if not any(c in path.name for c in "*?["):
        raise NotReadHere(f"{path.name!r} is one file: write * for the number in its name, or read it with another reader")
    found = sorted((p for p in path.parent.glob(path.name) if p.is_file()), key=natural)
    if not found:
        raise ReadError(f"no file fits {path.name!r} in {path.parent.as_posix()!r}: set another path")
    return found


def natural(path: Path) -> tuple[tuple[int, int | str], ...]:
    """Order of names in which 10 comes after 9."""
    return tuple((0, int(part)) if part.isdecimal() else (1, part.lower()) for part in re.split(r"(\d+)", path.name) if part)


def _kind(path: Path) -> tuple[Read, Callable[[Path], Mapping[str, Any]]]:
    suffix = path.suffix.lower()
    if suffix in _containers.SUFFIXES:
        return gridded.gridded, gridded.peek
    if suffix in elevation.FORMATS:
        return elevation.elevation, elevation.peek
    if suffix in _vtk.SUFFIXES:
        return dataset.dataset, dataset.peek
    raise unreadable(path, (*_containers.SUFFIXES, *elevation.FORMATS, *_vtk.SUFFIXES))


@reader("Read series", output="samples", peek=peek, aliases=("time steps", "ensemble", "members", "animation", "sequence"))
def series(
    progress: Progress,
    *,
    path: Path | None = None,
    files_are: Literal["steps", "members"] = "steps",
    step: Annotated[int, Range(of="path.steps")] = 0,
    name: Annotated[str | None, Choice(of="path.names")] = None,
    interval: float | None = None,
) -> Samples:
    """One step of a series of files, or the mean of an ensemble whose members are files, with their spread.

    Reads what 'Read data set', 'Read elevation' and 'Read gridded data' read.

    Parameters
    ----------
    path : a pattern with * for what differs in the names, as velocity_*.vti; files come in the order of their numbers
    files_are : steps of time, or members of an ensemble
    step : which file, from 0
    name : which array or variable; automatic takes the first
    interval : time between two files, for files that state no time; automatic leaves it out

    Accuracy: of a step, what its file states. Of members, their spread about the mean (sampled), the rounding of stored
    numbers as a proven bound, and that what is wrong in all of them alike is missing.
    """
    found = files(path)
    if files_are == "steps":
        if not 0 <= step < len(found):
            raise ReadError(f"step = {step} is not there: {len(found)} files fit, from 0 to {len(found) - 1}")
        wire = _kind(found[step])[0](path=found[step], name=name)
        return wire if interval is None or wire.time is not None else replace(wire, time=step * interval)
    if len(found) < 2:
        raise ReadError(f"one file fits {path.name if path else ''!r}: an ensemble has two members or more")
    return _ensemble(found, name, progress)


def _ensemble(found: Sequence[Path], name: str | None, progress: Progress) -> Samples:
    first = _kind(found[0])[0](path=found[0], name=name)
    if first.values.size * 8 * len(found) > memory() / 2:
        size = f"{len(found)} members of {first.values.size} numbers"
        raise ReadError(f"{size} take more than half of the memory here: name fewer files")
    members = np.empty((len(found), first.values.size))
    half = 0.0
    for i, file in enumerate(found):
        one = first if i == 0 else _kind(file)[0](path=file, name=name)
        if one.values.shape != first.values.shape or not one.grid.same_place(first.grid):
            raise ReadError(f"{file.name!r} lies on another grid than {found[0].name!r}: leave it out of the pattern")
        if one.unit != first.unit:
            raise ReadError(f"{file.name!r} is in {one.unit!r}, {found[0].name!r} in {first.unit!r}: convert one of them")
        members[i] = one.values.ravel()
        half = max(half, *(float(t.value.max(initial=0.0)) for t in one.accuracy.terms if t.id.endswith("/quantisation")))
        progress((i + 1) / len(found))
    mean = members.mean(axis=0)
    content = sha256(" ".join(digest(f) for f in found).encode()).hexdigest()
    rule = "largest rounding of a number in any of the files (rounding of stored numbers/1)"
    bits = Source("Quantisation", "data", "proven", rule)
    rule = f"{len(found)} files about their mean (ensemble members/1)"
    spread = Source(f"Spread of {len(found)} members", "data", "sampled", rule)
    here, c, what = Identity(mean.size), first.components, f"{content}/{first.name}"
    errors = np.nan_to_num(members - mean, nan=0.0)
    terms = (
        Term(bits, "bound", "value", first.unit, np.asarray(half), here, components=c, id=f"{what}/quantisation"),
        Term(spread, "members", "value", first.unit, errors, here, components=c, id=f"{what}/members"),
    )
    missing = (Missing("Error common to all members", "members tell of random differences only"),)
    return replace(first, values=mean.reshape(first.values.shape), accuracy=Accuracy(terms, missing))
