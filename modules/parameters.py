"""Parameters of a module: their types, ends and choices, and how a value is brought to its declared type."""

from __future__ import annotations

import difflib
import enum
import math
import types
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePath
from typing import Any, Literal, Union, get_args, get_origin


class ParameterError(ValueError):
    """A value that a parameter cannot take; the message names the parameter and what it takes."""


@dataclass(frozen=True)
class Range:
    """Ends of a slider, never limits of validity unless `strict`.

    Parameters
    ----------
    low, high : ends, in the unit of the parameter
    of : "port.fact", e.g. "model.range": ends taken from an input when it is known
    unit : what the number means; "" for a plain number
    log : whether a slider moves in powers
    strict : a value outside is refused
    """

    low: float | None = None
    high: float | None = None
    of: str = ""
    unit: str = ""
    log: bool = False
    strict: bool = False

    def ends(self, facts: Mapping[str, Mapping[str, Any]]) -> tuple[float, float] | None:
        """The ends to show: static ones first, else those of the input's fact; None if neither is known."""
        port, _, fact = self.of.partition(".")
        known = facts.get(port, {}).get(fact) if self.of else None
        low = self.low if self.low is not None else (known[0] if known is not None else None)
        high = self.high if self.high is not None else (known[1] if known is not None else None)
        return None if low is None or high is None else (float(low), float(high))


@dataclass(frozen=True)
class Choice:
    """Options of a text parameter taken from a fact of an input ("samples.names"), or of a reader's file ("path.names")."""

    of: str


@dataclass(frozen=True)
class Position:
    """Coordinates in the frame of an input: a view shows them as a handle that can be dragged, and sets them by a pick.

    Parameters
    ----------
    of : the port whose frame and bounds they are in
    """

    of: str


PLAIN: dict[type, str] = {bool: "true or false", int: "a whole number", float: "a number", str: "text", Path: "a file"}


@dataclass(frozen=True)
class Parameter:
    """One setting of a module.

    Parameters
    ----------
    name : as written in the function, the file and on the command line
    type : bool, int, float, str, Path, a Literal, an Enum, or a tuple of these
    default : value used when none is given; None means automatic
    automatic : whether None is allowed
    range, choice, position : hints of the declaration
    words : one sentence from the docstring
    """

    name: str
    type: Any
    default: Any
    automatic: bool = False
    range: Range | None = None
    choice: Choice | None = None
    words: str = ""
    position: Position | None = None

    @property
    def is_path(self) -> bool:
        """Whether the value names a file."""
        return self.type is Path

    @property
    def options(self) -> tuple[str, ...]:
        """The values of a Literal or Enum, as text; empty for others."""
        if get_origin(self.type) is Literal:
            return tuple(str(v) for v in get_args(self.type))
        if isinstance(self.type, type) and issubclass(self.type, enum.Enum):
            return tuple(member.name for member in self.type)
        return ()

    def coerce(self, value: Any) -> Any:
        """The value in the declared type: 1 -> 1.0 for a float, a list -> a tuple, text as typed on a command line.

        Raises
        ------
        ParameterError : the value is not of the type; the sentence says what the parameter takes
        """
        if value is None or (value == "automatic" and self.automatic and self.type is not str):
            if self.automatic or self.default is None:
                return None
            raise ParameterError(f"{self.name} takes {self.takes()}, not nothing")
        result = _coerce(self.name, self.type, value, self.takes())
        if self.range and self.range.strict:
            for number in result if isinstance(result, tuple) else (result,):
                _inside(self.name, number, self.range)
        return result

    def takes(self) -> str:
        """What may be given, in words."""
        words = _words(self.type)
        return f"{words}, or nothing for automatic" if self.automatic else words

    def plain(self, value: Any) -> Any:
        """The value as JSON holds it."""
        return plain(value)


def plain(value: Any) -> Any:
    """A parameter value as JSON holds it: tuples as lists, enums by name, paths with '/'."""
    if isinstance(value, enum.Enum):
        return value.name
    if isinstance(value, PurePath):
        return value.as_posix()
    if isinstance(value, tuple | list):
        return [plain(v) for v in value]
    return value


def check_type(name: str, annotation: Any) -> tuple[Any, bool]:
    """(type, automatic) of a parameter's annotation; TypeError with a sentence if it cannot be one."""
    automatic = False
    if get_origin(annotation) in (Union, types.UnionType):
        rest = [a for a in get_args(annotation) if a is not type(None)]
        automatic = len(rest) < len(get_args(annotation))
        if len(rest) != 1:
            raise TypeError(f"parameter {name!r} may be one type, or that type and None; not a choice of several types")
        annotation = rest[0]
    if not _allowed(annotation):
        raise TypeError(
            f"parameter {name!r} is {_name(annotation)}: use bool, int, float, str, Path, a Literal, an Enum, "
            "or a tuple of these (several files are one Path with a pattern: slices/*.png)"
        )
    return annotation, automatic


def _allowed(kind: Any) -> bool:
    if kind in PLAIN or get_origin(kind) is Literal:
        return True
    if isinstance(kind, type) and issubclass(kind, enum.Enum):
        return True
    if get_origin(kind) is tuple:
        return bool(get_args(kind)) and all(a is Ellipsis or (_allowed(a) and a is not Path) for a in get_args(kind))
    return False


def _coerce(name: str, kind: Any, value: Any, takes: str) -> Any:
    if get_origin(kind) is tuple:
        return _coerce_tuple(name, kind, value, takes)
    if get_origin(kind) is Literal:
        return _nearest(name, value, {str(option): option for option in get_args(kind)})
    if isinstance(kind, type) and issubclass(kind, enum.Enum):
        return value if isinstance(value, kind) else _nearest(name, value, dict(kind.__members__))
    wrong = ParameterError(f"{name} takes {takes}, not {value!r}")
    if kind is bool:
        if isinstance(value, bool):
            return value
        if str(value).lower() in ("true", "yes", "on", "1", "false", "no", "off", "0"):
            return str(value).lower() in ("true", "yes", "on", "1")
        raise wrong
    if kind is Path:
        if isinstance(value, str | PurePath):
            return Path(value)
        raise wrong
    if kind is str:
        if isinstance(value, str):
            return value
        raise wrong
    return _coerce_number(kind, value, wrong)


def _coerce_number(kind: type, value: Any, wrong: ParameterError) -> Any:
    if isinstance(value, bool):
        raise wrong
    try:
        number = float(value)
        if kind is int:
            if number != int(number):
                raise wrong
            return int(value) if isinstance(value, str) else int(number)
    except (TypeError, ValueError, OverflowError):
        raise wrong from None
    if math.isnan(number):
        raise ParameterError(f"{wrong}; leave it empty for 'automatic'")
    return number + 0.0


def _coerce_tuple(name: str, kind: Any, value: Any, takes: str) -> tuple[Any, ...]:
    items: Sequence[Any]
    if isinstance(value, str):
        items = [part.strip() for part in value.strip("()[] ").split(",") if part.strip()]
    elif isinstance(value, Sequence):
        items = value
    elif hasattr(value, "__iter__"):
        items = list(value)
    else:
        items = [value]
    kinds = get_args(kind)
    if len(kinds) == 2 and kinds[1] is Ellipsis:
        return tuple(_coerce(name, kinds[0], item, takes) for item in items)
    if len(items) != len(kinds):
        raise ParameterError(f"{name} takes {takes}, not {len(items)} of them")
    return tuple(_coerce(name, k, item, takes) for k, item in zip(kinds, items, strict=True))


def _nearest(name: str, value: Any, options: Mapping[str, Any]) -> Any:
    if str(value) in options:
        return options[str(value)]
    close = difflib.get_close_matches(str(value), options, n=1, cutoff=0.5)
    hint = f"; did you mean {close[0]!r}?" if close else ""
    raise ParameterError(f"{name} has no option {str(value)!r}: it takes {', '.join(options)}{hint}")


def _inside(name: str, number: Any, ends: Range) -> None:
    if number is None:
        return
    below = ends.low is not None and number < ends.low
    above = ends.high is not None and number > ends.high
    if below or above:
        low = "any" if ends.low is None else f"{ends.low:g}"
        high = "any" if ends.high is None else f"{ends.high:g}"
        raise ParameterError(f"{name} = {number:g} is outside {low} to {high}{' ' + ends.unit if ends.unit else ''}")


def _words(kind: Any) -> str:
    if get_origin(kind) is tuple:
        kinds = get_args(kind)
        if len(kinds) == 2 and kinds[1] is Ellipsis:
            return f"a list, each {_words(kinds[0])}"
        return f"{len(kinds)} values, each {_words(kinds[0])}"
    if get_origin(kind) is Literal:
        return "one of " + ", ".join(str(v) for v in get_args(kind))
    if isinstance(kind, type) and issubclass(kind, enum.Enum):
        return "one of " + ", ".join(m.name for m in kind)
    return PLAIN.get(kind, _name(kind))


def _name(kind: Any) -> str:
    return getattr(kind, "__name__", str(kind))
