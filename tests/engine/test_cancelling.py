"""How long work goes on after nobody waits for it."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest

from app.engine.events import Done, Started
from modules.data.accuracy import EXACT
from modules.data.wires import Value
from modules.declare import modeller
from modules.progress import Cancelled, Progress, Stop

vtk = pytest.importorskip("vtkmodules.vtkFiltersCore")


@modeller("Slabs of 20 ms that compute")
def busy(a: Value, progress: Progress, *, slabs: int = 200) -> Value:
    """Slabs in numpy.

    Accuracy: unchanged.
    """
    work = np.random.default_rng(0).random((200, 200))

    def slab(_: int) -> float:
        end = time.perf_counter() + 0.02
        total = 0.0
        while time.perf_counter() < end:
            total += float((work @ work).sum())
        return total

    return Value(value=sum(progress.map(slab, range(slabs))), accuracy=EXACT.end_from(a.accuracy, "a test"))


def test_slabs_stop_within_a_tenth_of_a_second(lab: Any) -> None:
    from app.engine.catalogue import Catalogue
    from app.engine.network import Network

    catalogue = Catalogue.of([lab.catalogue["user.fakes.zero"].function, busy])
    network = Network().add("zero", catalogue).add("busy", catalogue).connect("zero-1", "value", "busy-1", "a", catalogue)
    latencies = []
    for _ in range(5):
        with lab.engine(workers=2) as engine:
            engine.catalogue = catalogue
            engine.want(network)
            events = engine.events(once=True)
            for event in events:
                if isinstance(event, Started) and event.node == "busy-1":
                    break
            time.sleep(0.05)
            start = time.perf_counter()
            engine.cancel()
            outcomes = [e.outcome for e in events if isinstance(e, Done)]
            latencies.append(time.perf_counter() - start)
            assert outcomes == ["cancelled"] and not engine._running
    assert sorted(latencies)[2] < 0.1


def image(n: int) -> Any:
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData

    axis = np.linspace(0, 12, n, dtype=np.float32)
    values = np.sin(axis)[:, None, None] * np.sin(1.1 * axis)[:, None] + np.cos(0.9 * axis)
    data = vtkImageData()
    data.SetDimensions(n, n, n)
    data.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(values, np.float32).ravel(), deep=True))
    return data


def surfaces(data: Any) -> Any:
    algorithm = vtk.vtkMarchingCubes()
    algorithm.SetInputData(data)
    algorithm.ComputeNormalsOff()
    for i in range(4):
        algorithm.SetValue(i, -0.6 + i / 2.5)
    return algorithm


def test_a_vtk_filter_stops_within_a_few_per_cent_of_its_run() -> None:
    data = image(160)
    start = time.perf_counter()
    told: list[float] = []
    whole = Progress(told.append).run(surfaces(data))
    run = time.perf_counter() - start
    assert whole.GetNumberOfPoints() > 0 and told == sorted(told)

    import threading

    latencies = []
    for _ in range(3):
        stop, ended = Stop(), list[float]()
        outcome: list[object] = []

        def work(stop: Stop = stop, ended: list[float] = ended, outcome: list[object] = outcome) -> None:
            try:
                outcome.append(Progress(lambda _: None, stop).run(surfaces(data)))
            except Cancelled:
                outcome.append("cancelled")
            ended.append(time.perf_counter())

        thread = threading.Thread(target=work)
        thread.start()
        time.sleep(run / 4)
        asked = time.perf_counter()
        stop.set()
        thread.join()
        latencies.append(ended[0] - asked)
        assert outcome == ["cancelled"], "an aborted output is never given"
    assert min(latencies) < max(0.1, 0.04 * run), f"{latencies} of {run}"
