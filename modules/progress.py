"""How a module says how far it is, is cancelled, and shares the work of its slabs."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from concurrent.futures import Executor, Future
from typing import Any, TypeVar

S = TypeVar("S")
T = TypeVar("T")


class Cancelled(Exception):
    """The work is no longer wanted. Raised by `Progress` inside a module; a module lets it pass."""


class Stop:
    """A flag that can be raised from any thread, and calls whoever waits for it (a VTK filter, say)."""

    def __init__(self) -> None:
        self._raised = threading.Event()
        self._lock = threading.Lock()
        self._callbacks: list[Callable[[], object]] = []

    def set(self) -> None:
        """Raise the flag once; run the callbacks in the caller's thread."""
        with self._lock:
            if self._raised.is_set():
                return
            self._raised.set()
            callbacks = list(self._callbacks)
        for callback in callbacks:
            callback()

    def is_set(self) -> bool:
        """Whether the work should end."""
        return self._raised.is_set()

    def watch(self, callback: Callable[[], object]) -> None:
        """Call `callback` when the flag is raised; at once if it is raised already."""
        with self._lock:
            raised = self._raised.is_set()
            if not raised:
                self._callbacks.append(callback)
        if raised:
            callback()

    def forget(self, callback: Callable[[], object]) -> None:
        """No longer call `callback`."""
        with self._lock:
            if callback in self._callbacks:
                self._callbacks.remove(callback)


class Progress:
    """Reports a fraction, raises `Cancelled` when the work is no longer wanted, and runs slabs on a shared pool.

    A module asks for it by type (`progress: Progress`); the engine injects it. A script passes `Progress()`,
    which is silent, never cancels and works in the caller's thread. It pickles to such a silent one.

    Parameters
    ----------
    report : called with a fraction in [0, 1]
    stop : flag polled by `check`
    pool, workers : where helpers of `map` run, and how many may work at once (the caller is one of them)
    """

    def __init__(
        self,
        report: Callable[[float], object] | None = None,
        stop: Stop | None = None,
        pool: Executor | None = None,
        workers: int = 1,
    ) -> None:
        self._report = report
        self._stop = stop or Stop()
        self._pool = pool
        self._workers = workers

    def __reduce__(self) -> tuple[type[Progress], tuple[()]]:
        return Progress, ()

    def __call__(self, fraction: float) -> None:
        """Say how far the work is, and raise `Cancelled` if nobody waits for it."""
        self.check()
        if self._report:
            self._report(min(1.0, max(0.0, fraction)))

    def check(self) -> None:
        """Raise `Cancelled` if nobody waits for the work. Costs a flag read: call it between slabs."""
        if self._stop.is_set():
            raise Cancelled

    def part(self, start: float, end: float) -> Progress:
        """A progress whose 0..1 is start..end of this one."""
        return Progress(lambda f: self(start + f * (end - start)), self._stop, self._pool, self._workers)

    def map(self, function: Callable[[S], T], slabs: Iterable[S]) -> list[T]:
        """`[function(s) for s in slabs]`, shared with idle threads of the pool; cancel is polled between slabs.

        The caller works too, so a full pool cannot deadlock. A slab should take at most about 20 ms.

        Raises
        ------
        Cancelled : between two slabs, when the work is no longer wanted
        """
        items = list(slabs)
        results: list[Any] = [None] * len(items)
        todo, lock, failures = iter(range(len(items))), threading.Lock(), list[BaseException]()
        done = 0

        def work() -> None:
            nonlocal done
            while not failures:
                with lock:
                    i = next(todo, None)
                if i is None:
                    return
                try:
                    self.check()
                    results[i] = function(items[i])
                    with lock:
                        done += 1
                        if self._report:
                            self._report(done / len(items))
                except BaseException as error:
                    failures.append(error)

        helpers = [self._pool.submit(work) for _ in range(min(self._workers, len(items)) - 1)] if self._pool else []
        work()
        for helper in helpers:
            _settle(helper)
        if failures:
            raise failures[0]
        return results

    def run(self, algorithm: Any) -> Any:
        """Execute a VTK algorithm so that cancelling aborts it, and return its output.

        An aborted output is never returned.

        Raises
        ------
        Cancelled : when the work is no longer wanted
        """
        self.check()
        aborted = threading.Event()

        def abort() -> None:
            aborted.set()
            algorithm.SetAbortExecuteAndUpdateTime()

        observer = algorithm.AddObserver("ProgressEvent", lambda *_: self._tell(algorithm.GetProgress()))
        self._stop.watch(abort)
        try:
            algorithm.Update()
        finally:
            self._stop.forget(abort)
            algorithm.RemoveObserver(observer)
        if aborted.is_set() or self._stop.is_set():
            raise Cancelled
        return algorithm.GetOutput()

    def _tell(self, fraction: float) -> None:
        if self._report:
            self._report(fraction)


def _settle(helper: Future[None]) -> None:
    if not helper.cancel():
        helper.result()
