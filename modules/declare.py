"""A function becomes a module: its signature is read once into a frozen record, and nothing is said twice.

Positional arguments are ports, keyword-only ones are parameters, the return type is the output. The decorator returns
the function itself with the record attached; `record_of(function)` finds it. What is not understood is refused with a
sentence when the file is loaded.
"""

from __future__ import annotations

import inspect
import re
import types
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, ParamSpec, TypeVar, Union, get_args, get_origin, get_type_hints

from modules.data.accuracy import Accuracy
from modules.data.wires import ColourMap, Geometry, Layer, Model, Samples, Scene, Table, Value
from modules.parameters import Choice, Parameter, ParameterError, Position, Range, check_type
from modules.progress import Progress
from modules.records import FURTHER, RESERVED, ROOMS, WIRES, DeclarationError, Module, Output, Port, article, record_of

__all__ = [
    "ROOMS", "DeclarationError", "Module", "Output", "Port", "accuracy_mapper", "article", "mapper", "modeller", "reader",
    "record_of", "renderer",
]  # fmt: skip

P = ParamSpec("P")
F = TypeVar("F")
Wrong = Callable[[str], DeclarationError]

R = TypeVar("R", bound="Samples | Table | Geometry | Value | ColourMap | tuple[Any, ...]")
M = TypeVar("M", bound="Samples | Model | Table | Value | tuple[Any, ...]")
G = TypeVar("G", bound="Geometry | tuple[Any, ...]")
A = TypeVar("A", bound="Geometry | Table | tuple[Any, ...]")
L = TypeVar("L", bound="Layer | Scene | tuple[Any, ...]")


def reader(
    title: str,
    *,
    version: int = 1,
    was: tuple[str, ...] = (),
    aliases: tuple[str, ...] = (),
    output: str = "",
    peek: Callable[[Path], Mapping[str, Any]] | None = None,
    companions: Callable[[Path], Sequence[Path]] | None = None,
) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Declare a reader: (nothing) -> Samples, Table, Geometry, Value or ColourMap."""

    def declare(function: Callable[P, R]) -> Callable[P, R]:
        return _attach(function, "readers", title, version, was, aliases, output, {}, peek, companions)

    return declare


def modeller(
    title: str,
    *,
    version: int = 1,
    was: tuple[str, ...] = (),
    aliases: tuple[str, ...] = (),
    output: str = "",
    independent: Mapping[str, tuple[str, ...]] | None = None,
) -> Callable[[Callable[P, M]], Callable[P, M]]:
    """Declare a modeller: Samples, Model, Table or Value -> one of these."""

    def declare(function: Callable[P, M]) -> Callable[P, M]:
        return _attach(function, "modellers", title, version, was, aliases, output, independent or {})

    return declare


def mapper(
    title: str,
    *,
    version: int = 1,
    was: tuple[str, ...] = (),
    aliases: tuple[str, ...] = (),
    output: str = "",
    independent: Mapping[str, tuple[str, ...]] | None = None,
) -> Callable[[Callable[P, G]], Callable[P, G]]:
    """Declare a mapper: its first output is a Geometry."""

    def declare(function: Callable[P, G]) -> Callable[P, G]:
        return _attach(function, "mappers", title, version, was, aliases, output, independent or {})

    return declare


def accuracy_mapper(
    title: str,
    *,
    version: int = 1,
    was: tuple[str, ...] = (),
    aliases: tuple[str, ...] = (),
    output: str = "",
    independent: Mapping[str, tuple[str, ...]] | None = None,
) -> Callable[[Callable[P, A]], Callable[P, A]]:
    """Declare an accuracy mapper: its first output is a Geometry or a Table that shows an error."""

    def declare(function: Callable[P, A]) -> Callable[P, A]:
        return _attach(function, "accuracy_mappers", title, version, was, aliases, output, independent or {})

    return declare


def renderer(
    title: str,
    *,
    version: int = 1,
    was: tuple[str, ...] = (),
    aliases: tuple[str, ...] = (),
    output: str = "",
    independent: Mapping[str, tuple[str, ...]] | None = None,
) -> Callable[[Callable[P, L]], Callable[P, L]]:
    """Declare a renderer: its first output is a Layer, or the Scene of a view."""

    def declare(function: Callable[P, L]) -> Callable[P, L]:
        return _attach(function, "renderers", title, version, was, aliases, output, independent or {})

    return declare


# --- reading a signature -----------------------------------------------------------------------------------------


def _attach(
    function: Callable[P, F],
    room: str,
    title: str,
    version: int,
    was: tuple[str, ...],
    aliases: tuple[str, ...],
    output: str,
    independent: Mapping[str, tuple[str, ...]],
    peek: Callable[[Path], Mapping[str, Any]] | None = None,
    companions: Callable[[Path], Sequence[Path]] | None = None,
) -> Callable[P, F]:
    name = getattr(function, "__qualname__", repr(function))

    def wrong(sentence: str) -> DeclarationError:
        return DeclarationError(f"module {name!r} in {getattr(function, '__module__', '?')}: {sentence}")

    _check_function(function, room, wrong)
    hints = _hints(function, wrong)
    text = inspect.getdoc(function) or ""
    ports, parameters, progress = _arguments(function, hints, _parameter_words(text), wrong)
    outputs, several = _outputs(hints.get("return"), room, output, wrong)
    _check_bindings(ports, parameters, room, peek is not None, wrong)
    _check_independent(independent, ports, outputs, wrong)
    record = Module(
        id=_identity(function), title=title, room=room, version=version, was=was, aliases=aliases,
        ports=ports, parameters=parameters, outputs=outputs, several=several, independent=independent,
        function=function, peek=peek, companions=companions, progress=progress,
        summary=text.split("\n\n")[0].replace("\n", " ").strip(),
        accuracy=_line(text, "Accuracy"), source=_line(text, "Source"),
    )  # fmt: skip
    if not record.accuracy:
        raise wrong("its docstring has no 'Accuracy:' line: say what it does to the accuracy of its inputs")
    function.__module_record__ = record  # type: ignore[attr-defined]  # a function takes attributes; typing has no word for it
    return function


def _identity(function: Callable[..., Any]) -> str:
    place = function.__module__
    for prefix, instead in (("modules.", ""), ("nonius_user.", "user.")):
        if place.startswith(prefix):
            place = instead + place.removeprefix(prefix)
    return f"{place}.{function.__name__}"


def _check_function(function: Callable[..., Any], room: str, wrong: Wrong) -> None:
    if not inspect.isfunction(function):
        raise wrong("a module is a function")
    if function.__name__ == "<lambda>" or "<locals>" in function.__qualname__:
        raise wrong("a module is a function at the top of a file, so that other processes find it by name")
    if inspect.iscoroutinefunction(function) or inspect.isgeneratorfunction(function) or inspect.isasyncgenfunction(function):
        raise wrong("a module is a plain function, not async and not a generator; report progress through a Progress argument")
    if not inspect.getdoc(function):
        raise wrong("it has no docstring: its first sentence is what the librarian shows")
    folder = function.__module__.split(".")
    if folder[0] == "modules" and len(folder) > 1 and folder[1] in ROOMS and folder[1] != room:
        raise wrong(f"it is declared for the room {room!r} and lies in {folder[1]!r}: move it, or use the other decorator")


def _hints(function: Callable[..., Any], wrong: Wrong) -> dict[str, Any]:
    for parameter in inspect.signature(function).parameters.values():
        if parameter.annotation is inspect.Parameter.empty:
            raise wrong(f"argument {parameter.name!r} has no type")
    try:
        return get_type_hints(function, include_extras=True)
    except NameError as error:
        raise wrong(f"its types cannot be read: {error}; import them at run time, not under TYPE_CHECKING") from error
    except TypeError as error:
        raise wrong(f"its types cannot be read: {error}") from error


def _arguments(
    function: Callable[..., Any], hints: Mapping[str, Any], words: Mapping[str, str], wrong: Wrong
) -> tuple[tuple[Port, ...], tuple[Parameter, ...], str]:
    ports: list[Port] = []
    parameters: list[Parameter] = []
    progress = ""
    for argument in inspect.signature(function).parameters.values():
        name, hint = argument.name, hints[argument.name]
        if argument.kind in (argument.VAR_POSITIONAL, argument.VAR_KEYWORD):
            raise wrong(f"*{name}: a module names each port and parameter")
        if hint is Progress:
            progress = name
        elif name in RESERVED:
            raise wrong(f"the name {name!r} is taken by the network file: choose another")
        elif argument.kind is argument.KEYWORD_ONLY:
            parameters.append(_parameter(argument, hint, words.get(name, ""), wrong))
        else:
            ports.append(_port(argument, hint, words.get(name, ""), wrong))
    return tuple(ports), tuple(parameters), progress


def _port(argument: inspect.Parameter, hint: Any, words: str, wrong: Wrong) -> Port:
    name, optional, many = argument.name, False, False
    if get_origin(hint) in (Union, types.UnionType):
        rest = [a for a in get_args(hint) if a is not type(None)]
        if len(rest) != 1:
            raise wrong(f"port {name!r} may take one type, not a choice of several: make two ports, or take the wider type")
        if argument.default is not None:
            raise wrong(f"port {name!r} may be left unwired (| None): write '= None'")
        hint, optional = rest[0], True
    if get_origin(hint) is list:
        (hint,), many = get_args(hint), True
    if get_origin(hint) is Annotated:
        raise wrong(f"port {name!r} has hints; these are for parameters, after the '*'")
    if hint not in (*WIRES, Accuracy):
        if hint in (bool, int, float, str, Path):
            raise wrong(f"{name!r} is a setting: put it after the '*'")
        raise wrong(f"port {name!r} is {hint}: a port takes {', '.join(t.__name__ for t in WIRES)} or Accuracy")
    if argument.default is not inspect.Parameter.empty and not optional:
        raise wrong(f"port {name!r} has a default; only '| None = None' is a default that a port can have")
    return Port(name, hint, optional, many, words)


def _parameter(argument: inspect.Parameter, hint: Any, words: str, wrong: Wrong) -> Parameter:
    name, default = argument.name, argument.default
    notes: tuple[Any, ...] = ()
    if get_origin(hint) is Annotated:
        hint, *rest = get_args(hint)
        notes = tuple(rest)
    if default is inspect.Parameter.empty:
        raise wrong(f"parameter {name!r} has no default: every module runs as it is added")
    if any(isinstance(note, type) and note in (Range, Choice, Position) for note in notes):
        raise wrong(f"parameter {name!r}: write Range(), Choice(of=...) or Position(of=...), with brackets")
    if hint in WIRES or get_origin(hint) is list:
        raise wrong(f"{name!r} is data, or a list: data goes before the '*' as a port, a list of numbers is a tuple")
    if isinstance(default, list | dict | set):
        raise wrong(f"parameter {name!r} has a default that can change: use a tuple")
    try:
        kind, automatic = check_type(name, hint)
    except TypeError as error:
        raise wrong(str(error)) from None
    if default is None and not automatic:
        raise wrong(f"parameter {name!r} is None by default: declare it '| None' (None means automatic)")
    limits = next((n for n in notes if isinstance(n, Range)), None)
    choice = next((n for n in notes if isinstance(n, Choice)), None)
    position = next((n for n in notes if isinstance(n, Position)), None)
    parameter = Parameter(name, kind, default, automatic, limits, choice, words, position)
    if default is not None:
        try:
            coerced = parameter.coerce(default)
        except ParameterError as error:
            raise wrong(f"the default of {name!r} does not fit: {error}") from None
        if limits and isinstance(coerced, float | int) and not isinstance(coerced, bool):
            low, high = limits.low, limits.high
            if (low is not None and coerced < low) or (high is not None and coerced > high):
                raise wrong(f"the default {coerced:g} of {name!r} is outside its Range")
        parameter = replace(parameter, default=coerced)
    return parameter


def _outputs(hint: Any, room: str, name: str, wrong: Wrong) -> tuple[tuple[Output, ...], bool]:
    if hint is None or hint is type(None):
        raise wrong("it has no return type: say what it gives")
    several = isinstance(hint, type) and issubclass(hint, tuple) and hasattr(hint, "_fields")
    if several:
        outputs = tuple(Output(n, t) for n, t in get_type_hints(hint).items())
    elif get_origin(hint) is tuple or hint is tuple:
        raise wrong("several outputs need names: return a NamedTuple")
    else:
        outputs = (Output(name or getattr(hint, "__name__", "").lower(), hint),)
    for i, output in enumerate(outputs):
        allowed = ROOMS[room] if i == 0 else FURTHER
        if output.type not in allowed:
            names = ", ".join(t.__name__ for t in allowed)
            which = "first output" if i == 0 else f"output {output.name!r}"
            got = getattr(output.type, "__name__", output.type)
            raise wrong(f"the {which} of a module in {room} may be {names}; this is {got}")
    return outputs, several


def _check_bindings(
    ports: Sequence[Port], parameters: Sequence[Parameter], room: str, peeks: bool, wrong: Wrong
) -> None:
    kinds = {p.name: p.type for p in ports}
    for parameter in parameters:
        _check_position(parameter, kinds, wrong)
        for note in (parameter.range, parameter.choice):
            if note is None or not note.of:
                continue
            port, _, fact = note.of.partition(".")
            if port in kinds:
                known = getattr(kinds[port], "FACTS", ())
                if fact not in known:
                    raise wrong(f"{parameter.name!r}: a {kinds[port].__name__} knows {', '.join(known)}; not {fact!r}")
            elif not (room == "readers" and peeks and any(p.name == port and p.is_path for p in parameters)):
                raise wrong(f"{parameter.name!r}: there is no port {port!r}")


def _check_position(parameter: Parameter, ports: Mapping[str, Any], wrong: Wrong) -> None:
    if parameter.position is None:
        return
    if parameter.position.of not in ports:
        raise wrong(f"{parameter.name!r}: there is no port {parameter.position.of!r}")
    if get_origin(parameter.type) is not tuple or set(get_args(parameter.type)) - {float, Ellipsis}:
        raise wrong(f"parameter {parameter.name!r} has a Position: coordinates are a tuple of floats")


def _check_independent(
    independent: Mapping[str, tuple[str, ...]], ports: Sequence[Port], outputs: Sequence[Output], wrong: Wrong
) -> None:
    for out, names in independent.items():
        if out not in {o.name for o in outputs} or not set(names) <= {p.name for p in ports}:
            raise wrong(f"independent={{{out!r}: {names}}} names an output or a port that it does not have")


def _line(text: str, word: str) -> str:
    found = re.search(rf"^{word}:\s*(.+?)(?=\n\s*\n|\n[A-Z][a-z]+:|\Z)", text, re.MULTILINE | re.DOTALL)
    return " ".join(found.group(1).split()) if found else ""


def _parameter_words(text: str) -> dict[str, str]:
    """Sentences of the numpy docstring's Parameters section, by name."""
    section = re.search(r"^Parameters\n-+\n(.*?)(?=\n\S[^\n]*\n-+\n|\n[A-Z]\w+:|\Z)", text, re.MULTILINE | re.DOTALL)
    words: dict[str, str] = {}
    current: list[str] = []
    for line in (section.group(1) if section else "").splitlines():
        head = re.match(r"^(\w+(?:, \w+)*) : (.*)$", line)
        if head:
            current = head.group(1).split(", ")
            words.update(dict.fromkeys(current, head.group(2).strip()))
        elif line.strip():
            words.update({name: f"{words[name]} {line.strip()}".strip() for name in current})
    return words
