"""The engine: a mailbox in, events out. Each wave is one pull plan; a node fires at most once in it.

    want(network, wanted)   a final edit stops what is stale, keeps what is still wanted
    want(..., interim=True) a held slider: what runs may finish, the newest edit waits in one slot
    cancel(), fire(node), close()

All may be called from any thread. One thread iterates `events()`; the command line and tests use `execute`.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial

from app.engine import paths, scheduler
from app.engine.catalogue import Catalogue, mine
from app.engine.errors import ModuleFailed, ProcessDied
from app.engine.events import Blocked, Done, Event, Failed, Finished, Progressed, Reused, Started
from app.engine.firing import Call, Carrying, failure, fire
from app.engine.machine import cores
from app.engine.network import Network
from app.engine.results import Entry, Results
from app.engine.wave import Want, Wave
from modules.progress import Cancelled, Progress, Stop

__all__ = ["Blocked", "Done", "Engine", "Event", "Failed", "Finished", "Progressed", "Reused", "Started", "execute"]

TELL = 0.05
"""Seconds between two words of progress of one node."""


@dataclass(eq=False)
class Job:
    """A firing that runs, or waits in the pool. `stale`: nobody takes what it gives, since it is to be fired anew."""

    call: Call
    stop: Stop = field(default_factory=Stop)
    tries: int = 1
    pool: Executor | None = None
    future: Future[Entry] | None = None
    stale: bool = False

    @property
    def key(self) -> str:
        """Of its result."""
        return self.call.key

    def cancel(self) -> None:
        """Let it end soon."""
        self.stop.set()
        if self.future:
            self.future.cancel()


@dataclass(frozen=True, eq=False)
class _Cancel:
    pass


@dataclass(frozen=True, eq=False)
class _Close:
    pass


@dataclass(frozen=True, eq=False)
class _Fire:
    node: str


@dataclass(frozen=True, eq=False)
class _Landed:
    job: Job
    future: Future[Entry]


@dataclass(frozen=True, eq=False)
class _Told:
    key: str
    node: str
    fraction: float


@dataclass(frozen=True, eq=False)
class _Identified:
    want: Want
    stop: Stop
    found: paths.Identities


Letter = Want | _Cancel | _Close | _Fire | _Landed | _Told | _Identified


class Engine:
    """Runs networks.

    Parameters
    ----------
    catalogue : the modules; everything installed by default
    results : store of results, shared by documents; a new one by default
    pool : executor for nodes and their slabs, or a function that makes one (then a broken one is replaced);
        threads, one per core, by default
    workers : firings at once; as many as cores by default
    """

    def __init__(
        self,
        catalogue: Catalogue | None = None,
        results: Results | None = None,
        pool: Executor | Callable[[], Executor] | None = None,
        workers: int | None = None,
    ) -> None:
        self.catalogue = mine() if catalogue is None else catalogue
        self.results = Results() if results is None else results
        self.workers = max(1, workers or cores())
        self._owns = not isinstance(pool, Executor)
        self._make = pool if callable(pool) else partial(ThreadPoolExecutor, self.workers, "nonius")
        self._pool = pool if isinstance(pool, Executor) else self._make()
        self._mail: queue.SimpleQueue[Letter] = queue.SimpleQueue()
        self._running: dict[str, Job] = {}
        self._digesting: Stop | None = None
        self._wave: Wave | None = None
        self._latest: Want | None = None
        self._before: list[Wave] = []
        self._out: list[Event] = []
        self._waiting: Want | None = None
        self._waves = 0
        self._closed = threading.Event()

    def __enter__(self) -> Engine:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # --- from any thread

    def want(self, network: Network, wanted: Iterable[str] | None = None, interim: bool = False) -> None:
        """Ask for results of nodes; of all on which no other hangs, if none are named.

        Raises
        ------
        UnknownName : a wanted node is not in the network
        """
        names = network.sinks() if wanted is None else tuple(dict.fromkeys(network[n].id for n in wanted))
        self._mail.put(Want(network.around, names, interim))

    def cancel(self) -> None:
        """Stop the wave; what has been computed is kept."""
        self._mail.put(_Cancel())

    def fire(self, node: str) -> None:
        """Fire a node of the network last asked for, also one that failed or has a result."""
        self._mail.put(_Fire(node))

    def close(self) -> None:
        """Stop everything; `events` ends."""
        self._closed.set()
        self._mail.put(_Close())
        self._stop_all()
        if self._owns:
            self._pool.shutdown(wait=False, cancel_futures=True)

    # --- one thread

    @property
    def wave(self) -> Wave | None:
        """The wave that is on, or was the last; for the thread that iterates `events`."""
        return self._wave

    @property
    def firing(self) -> int:
        """How many firings run or end, wanted or not."""
        return len(self._running)

    def events(self, once: bool = False) -> Iterator[Event]:
        """What happens, as it happens. Who leaves and comes back goes on where it was; `close` stops the work.

        Parameters
        ----------
        once : end when nothing is left to do
        """
        while not self._closed.is_set():
            self._step()
            yield from self._say()
            if self._may_begin():
                continue
            if once and self._idle():
                return
            letters = [self._mail.get()]
            while not self._mail.empty():
                letters.append(self._mail.get())
            for letter in letters:
                self._read(letter)

    def _step(self) -> None:
        """Begin the waiting wave if it may, and fire what is ready."""
        if self._may_begin():
            self._begin()
        wave = self._wave
        while wave and len(self._running) < self.workers and (key := wave.next()):
            job = self._running.get(key)
            if job is None:
                wave.started(key)
                self._submit(Job(wave.call(key)))
        if wave and wave.settled:
            wave.end("settled")

    def _say(self) -> Iterator[Event]:
        for wave in (*self._before, *([self._wave] if self._wave else [])):
            yield from wave.say()
        self._before = []
        while self._out:
            yield self._out.pop(0)

    def _may_begin(self) -> bool:
        """A final edit at once; an interim one when the wave before has settled."""
        want = self._waiting
        if want is None:
            return False
        return not want.interim or not (self._digesting or (self._wave and not self._wave.settled))

    def _idle(self) -> bool:
        busy = self._waiting or self._digesting or self._running or not self._mail.empty()
        return not busy and (self._wave is None or self._wave.done)

    def _read(self, letter: Letter) -> None:
        match letter:
            case Want():
                held = self._waiting
                interim = letter.interim and (held is None or held.interim)
                self._waiting = Want(letter.network, letter.wanted, interim)
            case _Cancel():
                self._cancelled()
            case _Fire():
                self._refire(letter.node)
            case _Landed():
                self._land(letter.job, letter.future)
            case _Told(key="") if self._digesting:
                self._out.append(Progressed(wave=self._waves + 1, node=letter.node, fraction=letter.fraction))
            case _Told() if self._wave:
                self._wave.told(letter.key, letter.fraction)
            case _Identified() if letter.stop is self._digesting:
                self._digesting = None
                self._plan(letter.want, letter.found)

    # --- a wave

    def _begin(self) -> None:
        """Plan the waiting wave; first digest files that are new, in a thread of their own."""
        want, self._waiting = self._waiting, None
        if want is None:
            return
        self._latest = want
        if self._digesting:
            self._digesting.set()
            self._digesting = None
        needed = frozenset(scheduler.upstream(want.network, want.wanted))
        found = paths.identities(want.network, self.catalogue, only=needed, quick=True)
        if found is not None:
            self._plan(want, found)
            return
        stop = self._digesting = Stop()

        def digest() -> None:
            try:
                found = paths.identities(want.network, self.catalogue, lambda n: self._progress("", n, stop), only=needed)
            except Cancelled:
                return
            self._mail.put(_Identified(want, stop, found or {}))

        threading.Thread(target=digest, name="nonius-files", daemon=True).start()

    def _plan(self, want: Want, identities: paths.Identities) -> None:
        if self._wave:
            self._wave.end("overtaken")
            self._before.append(self._wave)
        self._waves += 1
        going = [key for key, job in self._running.items() if not job.stop.is_set()]
        wave = self._wave = Wave(self._waves, want, self.catalogue.snapshot(), identities, self.results, going)
        for key, job in self._running.items():
            if not wave.wants(key):
                job.cancel()

    def _refire(self, node: str) -> None:
        want = self._waiting or self._latest
        if want is None or node not in want.network.nodes:
            return
        if self._wave and (key := self._wave.keys.get(node)):
            self.results.forgive(key)
            self.results.drop(key)
            if (job := self._running.get(key)) and job.stop.is_set():
                job.stale = True
        self._waiting = Want(want.network, tuple(dict.fromkeys((*want.wanted, node))))

    def _cancelled(self) -> None:
        self._waiting = None
        if self._digesting:
            self._waves += 1
            self._out.append(Done(wave=self._waves, outcome="cancelled"))
        self._stop_all()
        if self._wave:
            self._wave.end("cancelled")

    # --- a firing

    def _submit(self, job: Job) -> None:
        self._running[job.key] = job
        progress = self._progress(job.key, job.call.node, job.stop)
        job.pool = self._pool
        try:
            future = self._pool.submit(fire, job.call, progress)
        except (BrokenExecutor, RuntimeError) as error:
            future = Future()
            future.set_exception(error)
        job.future = future
        future.add_done_callback(lambda done: self._mail.put(_Landed(job, done)))

    def _progress(self, key: str, node: str, stop: Stop) -> Progress:
        last = 0.0

        def report(fraction: float) -> None:
            nonlocal last
            now = time.monotonic()
            if now - last >= TELL:
                last = now
                self._mail.put(_Told(key, node, fraction))

        pool = Carrying(self._pool) if isinstance(self._pool, ThreadPoolExecutor) else None
        return Progress(report, stop, pool, self.workers)

    def _land(self, job: Job, future: Future[Entry]) -> None:
        del self._running[job.key]
        wanted = self._wave is not None and self._wave.wants(job.key)
        error = None if future.cancelled() else future.exception()
        if job.stale or (job.stop.is_set() and (future.cancelled() or isinstance(error, Cancelled))):
            if wanted and self._wave:
                self._wave.again(job.key)
        elif error is None and not future.cancelled():
            entry = future.result()
            self.results.put(job.key, entry)
            if wanted and self._wave:
                self._wave.finish(job.key, entry)
        elif self._made_room(job, error) and wanted and job.tries == 1:
            self._submit(replace(job, tries=2, stop=Stop()))
        else:
            self._failed(job, error)

    def _made_room(self, job: Job, error: BaseException | None) -> bool:
        """Whether what failed may be tried once more: memory was freed, or a broken pool replaced."""
        if isinstance(error, MemoryError):
            self.results.clear()
            return True
        if isinstance(error, BrokenExecutor) and self._owns:
            if job.pool is self._pool:
                self._pool.shutdown(wait=False)
                self._pool = self._make()
            return True
        return False

    def _failed(self, job: Job, error: BaseException | None) -> None:
        node, title = job.call.node, job.call.module.title
        if isinstance(error, BrokenExecutor):
            failed: ModuleFailed = ProcessDied("the process that ran it ended; fire it again", node=node, title=title)
        elif isinstance(error, MemoryError):
            sentence = "there is not enough memory: take a part of the data, or a coarser step"
            failed = ModuleFailed(sentence, node=node, title=title)
        elif error is None or isinstance(error, Cancelled):
            failed = ModuleFailed("it stopped by itself and gave nothing", node=node, title=title)
        else:
            failed = failure(error, node, title)
        failed.forget()
        if failed.keep:
            self.results.fail(job.key, failed)
        if self._wave and self._wave.wants(job.key):
            self._wave.fail(job.key, failed)

    def _stop_all(self) -> None:
        if self._digesting:
            self._digesting.set()
            self._digesting = None
        for job in list(self._running.values()):
            job.cancel()


def execute(
    network: Network,
    results: Results | None = None,
    wanted: Iterable[str] | None = None,
    *,
    catalogue: Catalogue | None = None,
    pool: Executor | Callable[[], Executor] | None = None,
    workers: int | None = None,
) -> Iterator[Event]:
    """One wave: run what is wanted (all on which no other node hangs, by default) and yield the events.

    Closing the iterator cancels.
    """
    with Engine(catalogue, results, pool, workers) as engine:
        engine.want(network, wanted)
        yield from engine.events(once=True)
