"""Processes come through the same door as threads; a cluster's executor would."""

from __future__ import annotations

import multiprocessing
import pickle
from concurrent.futures import Executor, ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from app.engine import catalogue as catalogues
from app.engine.catalogue import Catalogue
from app.engine.errors import ModuleFailed, ProcessDied, Unaccounted
from app.engine.events import Failed, Finished
from app.engine.executor import Engine
from app.engine.firing import Call
from app.engine.network import Network
from modules.progress import Progress

HEAD = '''
import os
from modules.data.accuracy import EXACT, deviation
from modules.data.wires import Value
from modules.declare import reader, modeller

@reader("One")
def one() -> Value:
    """One.

    Accuracy: a standard deviation.
    """
    return Value(value={value}, accuracy=EXACT.add(deviation("stated", 0.5, 1)))

@modeller("Dies")
def dies(a: Value, *, code: int = 9) -> Value:
    """Takes its process with it.

    Accuracy: none.
    """
    os._exit(code)

@modeller("Fails")
def fails(a: Value) -> Value:
    """Fails.

    Accuracy: none.
    """
    raise KeyError("here")

@modeller("Twice")
def twice(a: Value) -> Value:
    """The same.

    Accuracy: unchanged.
    """
    return a
'''


def processes(catalogue: Catalogue, workers: int = 2) -> Executor:
    load, arguments = catalogue.initializer()
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(workers, mp_context=context, initializer=load, initargs=arguments)


def test_processes_give_what_threads_give(tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    path.write_text(HEAD.format(value=1.0))
    catalogue = Catalogue.of([], tmp_path)
    network = Network().add("one", catalogue).add("twice", catalogue).add("fails", catalogue).add("dies", catalogue)
    for target in ("twice-1", "fails-1", "dies-1"):
        network = network.connect("one-1", "value", target, "a", catalogue)
    with Engine(catalogue) as engine:
        engine.want(network, ["twice-1"])
        threads = {e.node: e for e in engine.events(once=True) if isinstance(e, Finished)}
    made: list[Executor] = []

    def make() -> Executor:
        made.append(processes(catalogue))
        return made[-1]

    with Engine(catalogue, pool=make, workers=2) as engine:
        engine.want(network, ["twice-1", "fails-1"])
        events = list(engine.events(once=True))
        finished = {e.node: e for e in events if isinstance(e, Finished)}
        for name, event in threads.items():
            assert finished[name].key == event.key
            mine, theirs = finished[name].outputs["value"], event.outputs["value"]
            assert mine.value == theirs.value
            assert [t.id for t in mine.accuracy.terms] == [t.id for t in theirs.accuracy.terms]
        error = next(e.error for e in events if isinstance(e, Failed))
        assert str(error) == "fails-1 (Fails): KeyError: 'here'" and "mine.py" in error.traceback

        engine.want(network, ["dies-1", "twice-1"])
        events = list(engine.events(once=True))
        error = next(e.error for e in events if isinstance(e, Failed))
        assert isinstance(error, ProcessDied) and "the process that ran it ended; fire it again" in str(error)
        assert len(made) == 3, "a broken pool is replaced, and the firing tried once more"

        path.write_text(HEAD.format(value=2.0))
        catalogue.reload()
        engine.want(network, ["twice-1"])
        values = [e.outputs["value"].value for e in engine.events(once=True) if isinstance(e, Finished)]
        assert values == [2.0, 2.0], "children read a changed file again"
    for pool in made:
        pool.shutdown()


def test_what_crosses_pickles(lab: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    for error in (ModuleFailed("s", node="n", port="p", title="T", traceback="t"), Unaccounted("s", node="n")):
        again = pickle.loads(pickle.dumps(error))
        assert (type(again), str(again), again.record()) == (type(error), str(error), error.record())
    run = lab.run(lab.network({"r": "ramp", "m": "between", "c": ("constant", {"sigma": 1})}, "r.samples -> m.samples"))
    for node in ("r", "m", "c"):
        again = pickle.loads(pickle.dumps(run.output(node)))
        assert [t.id for t in again.accuracy.terms] == [t.id for t in run.output(node).accuracy.terms]
    assert not pickle.loads(pickle.dumps(Progress(print)))._report
    monkeypatch.setattr(catalogues, "_mine", lab.catalogue.snapshot())
    call = Call("k", "n", lab.catalogue["user.fakes.zero"])
    assert pickle.loads(pickle.dumps(call)).module is call.module
    stale = partial(pickle.loads, pickle.dumps(call).replace(call.module.digest.encode(), b"0" * 32))
    with pytest.raises(Exception, match="differs between processes: its file changed while it ran; fire again"):
        stale()
