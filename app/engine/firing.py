"""One firing, in whatever thread or process it runs: inputs gathered, the function called, its outputs signed and checked."""

from __future__ import annotations

import linecache
import threading
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from contextvars import ContextVar, copy_context
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np

from app.engine import catalogue as catalogues
from app.engine import law
from app.engine.errors import FileChanged, ModuleFailed, NoniusError
from app.engine.paths import Identity
from app.engine.results import Entry
from modules.data.accuracy import Accuracy, Missing
from modules.data.wires import Model, Samples, Value
from modules.declare import Module
from modules.parameters import ParameterError
from modules.progress import Cancelled, Progress

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Wired:
    """A value wired to a parameter: what came, from which output of which module."""

    value: Value
    origin: str


@dataclass(frozen=True, eq=False)
class Call:
    """All that a firing needs. Between processes the module goes by its id and code digest.

    Parameters
    ----------
    inputs : port -> wire value, list of them, or None
    parameters : effective values; a path leads to its file
    wired : parameter -> value from a wire, in place of its own
    identities : of the files it reads
    """

    key: str
    node: str
    module: Module
    inputs: Mapping[str, Any] = field(default_factory=dict)
    parameters: Mapping[str, Any] = field(default_factory=dict)
    wired: Mapping[str, Wired] = field(default_factory=dict)
    identities: tuple[Identity, ...] = ()

    def __reduce__(self) -> tuple[Callable[..., Call], tuple[Any, ...]]:
        m = self.module
        rest = (self.key, self.node, dict(self.inputs), dict(self.parameters), dict(self.wired), self.identities)
        return _here, (m.id, m.digest, *rest)


def _here(module: str, digest: str, key: str, node: str, *rest: Any) -> Call:
    return Call(key, node, catalogues.mine().by_name(module, digest), *rest)


def fire(call: Call, progress: Progress) -> Entry:
    """Run a module on its inputs.

    Raises
    ------
    ModuleFailed : with one sentence and the traceback
    Cancelled : nobody waits for it
    MemoryError : for the engine, which makes room and tries once more
    """
    start = time.perf_counter()
    try:
        with heard() as said:
            outputs = _run(call, progress)
            facts = {name: dict(value.facts()) for name, value in outputs.items() if hasattr(value, "facts")}
    except (Cancelled, MemoryError, ModuleFailed):
        raise
    except (Exception, SystemExit) as error:
        raise failure(error, call.node, call.module.title) from None
    return Entry(outputs, facts, tuple(dict.fromkeys(said)), time.perf_counter() - start)


def _run(call: Call, progress: Progress) -> dict[str, Any]:
    module = call.module
    parameters = dict(call.parameters)
    for name, wired in call.wired.items():
        parameters[name] = _plain(call, name, wired)
    _unchanged(call)
    outputs = module.call(call.inputs, parameters, progress)
    _unchanged(call)
    inputs = {**call.inputs, **dict.fromkeys(call.wired)}
    outputs = law.sign(call.key, inputs, outputs)
    law.check(module, call.node, inputs, outputs)
    return law.not_carried(outputs, [m for name, wired in call.wired.items() for m in _lost(name, wired)])


def _plain(call: Call, name: str, wired: Wired) -> Any:
    parameter = call.module.parameter(name)
    value = wired.value.value
    if isinstance(value, np.ndarray | np.generic):
        value = value.item() if np.ndim(value) == 0 else value.tolist()
    try:
        return parameter.coerce(value) if parameter else value
    except ParameterError as error:
        sentence = f"{error}; that came from {wired.origin}"
        raise ModuleFailed(sentence, node=call.node, port=name, title=call.module.title) from None


def _lost(name: str, wired: Wired) -> Iterator[Missing]:
    """The uncertainty that a plain number cannot carry. The origin is named by its module, as equal keys share the result."""
    accuracy = wired.value.accuracy
    if accuracy.terms or accuracy.missing:
        why = "a setting is a plain value; take it at a port to carry it on"
        yield Missing(f"{name}: uncertainty of {wired.origin} not carried", why)


def _unchanged(call: Call) -> None:
    for identity in call.identities:
        if path := identity.changed():
            sentence = f"the file {path!r} changed while it was read: run again"
            raise FileChanged(sentence, node=call.node, title=call.module.title)


def fits(port_type: type, value: Any) -> Any:
    """A wire value as a port takes it: of a Model, a port of Samples gets the samples."""
    return value.samples if port_type is Samples and isinstance(value, Model) else value


def socket(outputs: Mapping[str, Any], output: str) -> Any:
    """An output, or what is known of its accuracy for "<output>:accuracy"."""
    plain, _, twin = output.partition(":")
    value = outputs[plain]
    if not twin:
        return value
    return value.accuracy if hasattr(value, "accuracy") else Accuracy(missing=(Missing("accuracy", f"{plain} carries none"),))


def failure(error: BaseException, node: str, title: str) -> ModuleFailed:
    """What a module raised, as one sentence and a traceback from the module on."""
    if isinstance(error, ModuleFailed):
        return error.at(node)
    words = str(error).strip()
    first = words.splitlines()[0] if words else ""
    speaks = isinstance(error, ValueError | NoniusError) or (isinstance(error, TypeError | OSError) and first)
    sentence = first if speaks and first else f"{type(error).__name__}: {first}" if first else type(error).__name__
    linecache.checkcache()
    trace = traceback.TracebackException.from_exception(error)
    ours = [i for i, frame in enumerate(trace.stack) if frame.filename == Module.call.__code__.co_filename]
    if ours and ours[-1] + 1 < len(trace.stack):
        trace.stack = traceback.StackSummary.from_list(list(trace.stack)[ours[-1] + 1 :])
    return ModuleFailed(sentence, node=node, title=title, traceback="".join(trace.format()))


# --- warnings, each to the firing that raised it ------------------------------------------------------------------

_said: ContextVar[list[str] | None] = ContextVar("said", default=None)
_guard = threading.Lock()
_inside = 0
_filters: warnings.catch_warnings[None] | None = None
_show: Callable[..., None] = warnings.showwarning


@contextmanager
def heard() -> Iterator[list[str]]:
    """Collect the warnings of this firing, also those that Python shows but once, also from its slabs' threads.

    Filters of warnings belong to the whole process, so they are changed when the first firing begins and put back when
    the last one ends; in between each warning goes to the firing it belongs to, or where it would have gone.
    """
    said: list[str] = []
    token = _said.set(said)
    _open()
    try:
        yield said
    finally:
        _close()
        _said.reset(token)


def _open() -> None:
    global _inside, _filters, _show
    with _guard:
        _inside += 1
        if _inside == 1:
            if warnings.showwarning is not _route:  # a module's own catch_warnings may have left ours behind
                _show = warnings.showwarning
            _filters = warnings.catch_warnings()
            _filters.__enter__()
            warnings.simplefilter("always")
            warnings.showwarning = _route


def _close() -> None:
    global _inside, _filters
    with _guard:
        _inside -= 1
        if _inside == 0 and _filters is not None:
            _filters.__exit__(None, None, None)
            _filters = None


def _route(message: Warning | str, category: type[Warning], *rest: Any, **more: Any) -> None:
    said = _said.get()
    if said is None:
        _show(message, category, *rest, **more)
    else:
        said.append(f"{category.__name__}: {message}" if category is not UserWarning else str(message))


class Carrying(Executor):
    """A pool whose helpers belong to the firing that asked for them."""

    def __init__(self, pool: Executor) -> None:
        self._pool = pool

    def submit(self, function: Callable[..., T], /, *arguments: Any, **named: Any) -> Future[T]:
        """As the pool's, in the caller's context."""
        return self._pool.submit(copy_context().run, function, *arguments, **named)
