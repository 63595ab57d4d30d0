"""Progress: slabs on a shared pool without a deadlock, cancel between slabs and inside VTK filters."""

from __future__ import annotations

import pickle
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from modules.progress import Cancelled, Progress, Stop


def test_a_script_gets_a_silent_one() -> None:
    progress = Progress()
    progress(0.5)
    assert progress.map(lambda n: n * n, range(5)) == [0, 1, 4, 9, 16]
    assert progress.map(lambda n: n, []) == []
    assert isinstance(pickle.loads(pickle.dumps(Progress(print))), Progress)


def test_slabs_are_shared_in_order_and_reported() -> None:
    told: list[float] = []
    with ThreadPoolExecutor(3) as pool:
        result = Progress(told.append, pool=pool, workers=3).map(lambda n: (n, threading.get_ident()), range(60))
    assert [n for n, _ in result] == list(range(60))
    assert max(told) == 1.0


def test_a_full_pool_does_not_deadlock() -> None:
    with ThreadPoolExecutor(2) as pool:
        progress = Progress(pool=pool, workers=2)

        def node(n: int) -> int:
            return sum(progress.map(lambda k: k + n, range(20)))

        nodes = [pool.submit(node, n) for n in range(6)]
        assert [f.result(timeout=20) for f in nodes] == [190 + 20 * n for n in range(6)]


def test_the_first_failure_ends_the_rest() -> None:
    done: list[int] = []

    def work(n: int) -> None:
        if n == 3:
            raise ZeroDivisionError
        done.append(n)

    with pytest.raises(ZeroDivisionError):
        Progress().map(work, range(100))
    assert done == [0, 1, 2]


def test_cancel_is_heard_between_slabs_and_in_parts() -> None:
    stop = Stop()
    seen: list[int] = []

    def work(n: int) -> None:
        seen.append(n)
        if n == 2:
            stop.set()

    with pytest.raises(Cancelled):
        Progress(stop=stop).part(0.2, 0.4).map(work, range(100))
    assert seen == [0, 1, 2]
    with pytest.raises(Cancelled):
        Progress(stop=stop)(0.1)


def test_a_part_is_a_share_of_the_whole() -> None:
    told: list[float] = []
    part = Progress(told.append).part(0.5, 1.0)
    part(0.0)
    part(0.5)
    assert told == [0.5, 0.75]


def test_watchers_are_called_once_and_at_once_when_late() -> None:
    stop, calls = Stop(), list[str]()
    stop.watch(lambda: calls.append("early"))
    stop.set()
    stop.set()
    stop.watch(lambda: calls.append("late"))
    assert calls == ["early", "late"]


def test_a_vtk_filter_is_aborted_and_its_output_never_seen() -> None:
    """Within the larger of 100 ms and 4 % of its run."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkFiltersCore import vtkContourFilter

    n = 160
    t = np.linspace(0, 12, n)
    field = np.sin(t)[:, None, None] * np.sin(t)[None, :, None] + np.sin(t)[None, None, :]
    image = vtkImageData()
    image.SetDimensions(n, n, n)
    image.GetPointData().SetScalars(numpy_to_vtk(field.ravel(), deep=True))

    def filter_of(levels: int) -> vtkContourFilter:
        contour = vtkContourFilter()
        contour.SetInputData(image)
        contour.GenerateValues(levels, -0.9, 0.9)
        return contour

    start = time.perf_counter()
    assert Progress().run(filter_of(3)).GetNumberOfPoints() > 1000
    whole = (time.perf_counter() - start) * 5
    stop, raised = Stop(), list[float]()

    def cancel() -> None:
        raised.append(time.perf_counter())
        stop.set()

    timer = threading.Timer(0.25 * whole, cancel)
    timer.start()
    with pytest.raises(Cancelled):
        Progress(stop=stop).run(filter_of(15))
    assert time.perf_counter() - raised[0] < max(0.1, 0.04 * whole)
