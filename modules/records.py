"""What engine, panel, command line, help and file format know of a module: a frozen record of its declaration."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from modules.data.accuracy import Accuracy
from modules.data.wires import ColourMap, Geometry, Layer, Model, Samples, Scene, Table, Value
from modules.parameters import Parameter
from modules.progress import Progress

Kind = type[Any]

WIRES: tuple[Kind, ...] = (Samples, Model, Geometry, Layer, Scene, Table, Value, ColourMap)
ROOMS: dict[str, tuple[type, ...]] = {
    "readers": (Samples, Table, Geometry, Value, ColourMap),
    "modellers": (Samples, Model, Table, Value),
    "mappers": (Geometry,),
    "accuracy_mappers": (Geometry, Table),
    "renderers": (Layer, Scene),
}
FURTHER: tuple[type, ...] = (Table, Value, Geometry)
RESERVED = frozenset({"self", "id", "module", "version", "view", "out", "accuracy_of", "progress"})


class DeclarationError(TypeError):
    """A function that cannot be a module; the message says which part, and what to write instead."""


@dataclass(frozen=True)
class Port:
    """An input: a wire type, `optional` (`| None = None`), `many` (`list[...]`, fan-in in slot order)."""

    name: str
    type: Kind
    optional: bool = False
    many: bool = False
    words: str = ""

    def refuses(self, offered: Kind) -> str:
        """Why a wire of type `offered` does not fit, and what to do; "" if it fits. Samples also take a Model."""
        if offered is self.type or (self.type is Samples and offered is Model):
            return ""
        if self.type is Model and offered is Samples:
            return "needs a Model, got Samples: put an 'interpolate' between them, so that the law between samples is stated"
        if self.type is Layer and offered is Geometry:
            return "needs a Layer, got a Geometry: put a renderer such as 'lines' or 'surface' between them"
        return f"needs {article(self.type)}, got {article(offered)}"


@dataclass(frozen=True)
class Output:
    """An output: its name and wire type. Its twin socket is `<name>:accuracy`."""

    name: str
    type: Kind


@dataclass(frozen=True, eq=False)
class Module:
    """What engine, panel, command line, help and file format know of a module.

    Parameters
    ----------
    id : "room.file.function", as saved in a network
    room : readers, modellers, mappers, accuracy_mappers or renderers
    version : raised by hand when the output for the same input changes
    was : former ids
    independent : output -> ports it does not depend on
    peek : for readers: path -> facts, cheap
    companions : for readers: path -> other files that are read with it
    progress : name of the argument that takes a `Progress`, "" if none
    digest : of the code, for user and plug-in modules; "" for ours
    """

    id: str
    title: str
    room: str
    version: int
    was: tuple[str, ...]
    aliases: tuple[str, ...]
    ports: tuple[Port, ...]
    parameters: tuple[Parameter, ...]
    outputs: tuple[Output, ...]
    independent: Mapping[str, tuple[str, ...]]
    function: Callable[..., Any]
    peek: Callable[[Path], Mapping[str, Any]] | None = None
    companions: Callable[[Path], Sequence[Path]] | None = None
    progress: str = ""
    several: bool = False
    summary: str = ""
    accuracy: str = ""
    source: str = ""
    digest: str = field(default="")

    def __reduce__(self) -> tuple[Callable[[Callable[..., Any]], Module], tuple[Callable[..., Any]]]:
        return record_of, (self.function,)

    def port(self, name: str) -> Port | None:
        """The port of that name, or None."""
        return next((p for p in self.ports if p.name == name), None)

    def parameter(self, name: str) -> Parameter | None:
        """The parameter of that name, or None."""
        return next((p for p in self.parameters if p.name == name), None)

    def output(self, name: str) -> Output | None:
        """The output of that name, its twin socket too; or None."""
        plain, _, twin = name.partition(":")
        found = next((o for o in self.outputs if o.name == plain), None)
        if twin and found:
            return Output(name, Accuracy) if twin == "accuracy" else None
        return found

    def call(self, inputs: Mapping[str, Any], parameters: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
        """Run the function and name its outputs.

        Raises
        ------
        TypeError : an output is not of its declared type
        """
        arguments = {p.name: inputs.get(p.name) for p in self.ports}
        arguments |= dict(parameters)
        if self.progress:
            arguments[self.progress] = progress
        result = self.function(**arguments)
        named = dict(zip((o.name for o in self.outputs), result if self.several else (result,), strict=True))
        for output in self.outputs:
            if not isinstance(named[output.name], output.type):
                got = article(type(named[output.name]))
                raise TypeError(f"{self.title} gave {got} as {output.name!r}; it declares {article(output.type)}")
        return named


def record_of(function: Callable[..., Any]) -> Module:
    """The record that the decorator attached.

    Raises
    ------
    DeclarationError : the function is not declared as a module
    """
    record = getattr(function, "__module_record__", None)
    if not isinstance(record, Module):
        raise DeclarationError(f"{getattr(function, '__qualname__', function)!r} is not a module: decorate it with its room")
    return record


def article(kind: type) -> str:
    """A wire type with its article."""
    name = kind.__name__
    return name if name in ("Samples", "Accuracy") else f"{'an' if name[0] in 'AEIOU' else 'a'} {name}"
