"""The law of the budget: what came in goes on, or is ended with a reason; and who made what is new is signed.

Both go by identity and not by name. Equal firings make equal sources everywhere, since a new source is signed with the
key of its firing; a source that its maker named (a reader: by the content of its file) keeps its name.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from app.engine.errors import Unaccounted
from modules.data.accuracy import Accuracy, Missing, accuracies, replace_accuracies
from modules.declare import Module

RANDOM = "script:"
"""How the id of a source begins that nobody named."""


def carries_accuracy(value: Any) -> bool:
    """Whether a wire value can say something of accuracy; a colour map cannot."""
    return isinstance(value, Accuracy) or hasattr(value, "accuracy")


def sign(key: str, inputs: Mapping[str, Any], outputs: Mapping[str, Any]) -> dict[str, Any]:
    """The outputs, each source that no input had and nobody named called "<key>:<output>:<name>", carriers too."""
    names: dict[str, str] = {}
    used: set[str] = set()
    for output, value in outputs.items():
        for accuracy in accuracies(value):
            new = [(t.id, t.name) for t in accuracy.terms] + [(i, e.name) for i, e in accuracy.ended.items()]
            for one, name in new:
                if one.startswith(RANDOM) and one not in names:
                    names[one] = _free(f"{key}:{output}:{name}", used)
    if names:
        for old in {i for accuracy in accuracies(inputs) for i in accuracy.accounted()}:
            names.pop(old, None)
    return {
        output: replace_accuracies(value, partial(Accuracy.signed, names=names, carrier=f"{key}:{output}"))
        for output, value in outputs.items()
    }


def _free(name: str, used: set[str]) -> str:
    number = 1
    free = name
    while free in used:
        number += 1
        free = f"{name}:{number}"
    used.add(free)
    return free


def not_carried(outputs: Mapping[str, Any], missing: Iterable[Missing]) -> dict[str, Any]:
    """The outputs, with sources that the module could not see: those of a value wired to a parameter."""
    listed = tuple(missing)
    if not listed:
        return dict(outputs)

    def more(accuracy: Accuracy) -> Accuracy:
        return accuracy.miss(*listed)

    return {name: _outermost(value, more) if carries_accuracy(value) else value for name, value in outputs.items()}


def _outermost(value: Any, function: Any) -> Any:
    if isinstance(value, Accuracy):
        return function(value)
    return replace(value, accuracy=function(value.accuracy))


def check(module: Module, node: str, inputs: Mapping[str, Any], outputs: Mapping[str, Any]) -> None:
    """Whether each source of each input is in each output that carries accuracy, alive or ended.

    Raises
    ------
    Unaccounted : names the output, the port, the sources and the remedy
    """
    done = {
        output: frozenset().union(*(a.accounted() for a in accuracies(value)))
        for output, value in outputs.items()
        if carries_accuracy(value)
    }
    for port, value in inputs.items():
        need = {t.id: t.name for accuracy in accuracies(value) for t in accuracy.terms}
        for output, accounted in done.items():
            if port in module.independent.get(output, ()):
                continue
            lost = sorted({need[i] for i in need.keys() - accounted})
            if lost:
                raise Unaccounted(
                    f"the output {output!r} says nothing of {', '.join(map(repr, lost))}, which came in at {port!r}: "
                    f"pass it on, end it with .end(..., 'why') or .end_from(..., 'why'), or declare "
                    f"independent={{{output!r}: ({port!r},)}}",
                    node=node,
                    port=output,
                    title=module.title,
                )
