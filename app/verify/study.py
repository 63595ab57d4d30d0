"""`verify`: a network run on manufactured data, many times, and what its terms state held against what happens.

plain      the field without errors, on the lattice of the data
half       the same on cells half as large, for orders of convergence
truth      on cells a quarter as large: what the network would give if its own errors were a sixteenth
small      each term come true a thousandth as large: to first order there is nothing else
drawn      each term come true as stated, many times; and all of them together
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from app.engine.catalogue import Catalogue
from app.engine.network import Network
from app.verify import checks
from app.verify.drawing import drawing
from app.verify.draws import Birth, births, draw, laid
from app.verify.fields import Manufactured
from app.verify.findings import Finding, Report
from app.verify.observe import View, view
from app.verify.runs import Bench, Outputs, Run
from modules.data.accuracy import Missing
from modules.data.wires import Samples
from modules.progress import Progress

Floats = NDArray[np.float64]

SMALL = 1e-3
"""Of the stated size: errors so small that first order is all there is."""
FEWEST_RUNS = 4
HALF, QUARTER = 2, 4
"""Cuts of a cell along each axis."""


def verify(
    network: Network, catalogue: Catalogue, progress: Progress | None = None, *, runs: int = 20, seed: int = 0
) -> Report:
    """Whether what a network states of its errors is so.

    Parameters
    ----------
    runs : realisations of each term of the data, and of all together
    seed : of the fields and the errors

    Raises
    ------
    ValueError : fewer than 4 runs
    Cancelled : through the progress
    """
    if runs < FEWEST_RUNS:
        raise ValueError(f"runs = {runs}: at least {FEWEST_RUNS} are needed to tell a spread")
    begin, progress = time.perf_counter(), progress or Progress()
    bench = Bench.of(network, catalogue)
    real = bench.run({}, progress.part(0.0, 0.05))
    fields = _fields(bench, real, seed)
    failed = [Finding(n, "", "", "run", "not judged", f"it gives no result: {e.sentence}") for n, e in real.failed.items()]
    if not fields:
        return Report(tuple(failed), runs, ("no reader of this network gives samples",), time.perf_counter() - begin)
    study = Study(bench, real, fields, seed, runs)
    found = [*failed, *study.findings(progress.part(0.05, 1.0))]
    return Report(tuple(found), runs, study.notes(), time.perf_counter() - begin)


Fields = Mapping[tuple[str, str], Manufactured]


def _fields(bench: Bench, real: Run, seed: int) -> Fields:
    return {
        (node, name): Manufactured.of(value, seed)
        for node in bench.sources
        for name, value in real.outputs.get(node, {}).items()
        if isinstance(value, Samples) and value.grid.count > 1
    }


class Study:
    """The runs of one verification."""

    def __init__(self, bench: Bench, real: Run, fields: Fields, seed: int, runs: int) -> None:
        self.bench, self.real, self.fields, self.seed, self.runs = bench, real, fields, seed, runs
        self.given: frozenset[Missing] = frozenset(
            m for (node, name) in fields for m in real.outputs[node][name].accuracy.missing
        )

    def notes(self) -> tuple[str, ...]:
        """What stands in place of the data."""
        said = []
        for (node, name), field in self.fields.items():
            shape = " × ".join(map(str, reversed(field.base.shape)))
            thin = f", thinned from {' × '.join(map(str, reversed(field.real.grid.shape)))}" if field.thinner else ""
            said.append(f"{node}.{name}: a smooth field of known truth on {shape} samples{thin}, in the range of the data")
        return tuple(said)

    def source(self, times: int) -> dict[str, Outputs]:
        """What the readers would give of the fields, on the lattice of the data or a finer one."""
        outputs: dict[str, Outputs] = {}
        for (node, name), field in self.fields.items():
            here = outputs.get(node, self.real.outputs[node])
            outputs[node] = {**here, name: field.samples(times if field.refines else 1)}
        return outputs

    def findings(self, progress: Progress) -> Iterator[Finding]:
        """All of them, in the order of the walk."""
        plain = self.bench.run(self.source(1), progress.part(0.0, 0.05))
        entering = births(self.bench, plain)
        fine = self._finer(plain, progress.part(0.05, 0.25))
        drawn = self._drawn(plain, entering, progress.part(0.25, 0.95))
        for node in self.bench.wanted:
            if node in self.bench.sources:
                continue
            progress.check()
            if node not in plain.outputs:
                why = plain.failed[node].sentence if node in plain.failed else "what it hangs on gives nothing"
                if node in self.real.outputs:
                    yield Finding(node, "", "", "run", "not judged", f"it gives nothing of the manufactured data: {why}")
                continue
            for name in plain.outputs[node]:
                yield from named(self._of(node, name, plain, fine, drawn, entering), node, name)
        progress(1.0)

    def _finer(self, plain: Run, progress: Progress) -> tuple[Run, Run] | None:
        if not all(field.refines for field in self.fields.values()):
            return None
        return (
            self.bench.run(self.source(HALF), progress.part(0.0, 0.3)),
            self.bench.run(self.source(QUARTER), progress.part(0.3, 1.0)),
        )

    def _drawn(self, plain: Run, entering: list[Birth], progress: Progress) -> checks.Drawn:
        """Each term come true: a little, and as stated; then all together."""
        random = np.random.default_rng([self.seed, 7])
        jobs: list[tuple[str, float, bool]] = [
            (b.term.id, size, corner)
            for b in entering
            for size, corner in [(SMALL, False), *((1.0, i % 2 == 1) for i in range(self._times(b)))]
        ]
        jobs += [("", 1.0, False)] * (self.runs if len(entering) > 1 else 0)
        done: dict[str, list[tuple[Mapping[str, Floats], Run]]] = {}
        small: dict[str, tuple[Floats, Run]] = {}
        for i, (id, size, corner) in enumerate(jobs):
            share = progress.part(i / len(jobs), (i + 1) / len(jobs))
            made = {b.term.id: size * draw(b.term, random, corner) for b in entering if id in ("", b.term.id)}
            run = self.bench.run(laid(plain, made, entering), share, plain)
            if size == SMALL:
                small[id] = made[id], run
            else:
                done.setdefault(id, []).append((made, run))
            share(1.0)
        if len(entering) == 1:
            done[""] = done[entering[0].term.id]
        return checks.Drawn(small, done)

    def _times(self, birth: Birth) -> int:
        return self.runs if birth.term.kind != "bound" else max(4, self.runs // 4)

    def _of(
        self, node: str, name: str, plain: Run, fine: tuple[Run, Run] | None, drawn: checks.Drawn, entering: list[Birth]
    ) -> Iterator[Finding]:
        here = view(self.bench, plain, node, name)
        if isinstance(here, str):
            yield Finding("", "", "", "truth", "not judged", here)
            return
        ids, unknown = [b.term.id for b in entering], self._open(here)
        again = {id(run): self._again(run, node, name) for runs in drawn.done.values() for _, run in runs}
        for one in ids:
            if any(t.id == one for t in here.terms):
                made, run = drawn.small[one]
                yield from checks.propagation(self._again(run, node, name), one, made, plain)
                runs = [(m[one], again[id(r)]) for m, r in drawn.done[one]]
                told = checks.drawn(one, runs, plain, self.bench.network.k)
                yield from (checks.unless(unknown, finding) for finding in told)
        yield from self._own(node, name, here, fine, frozenset(ids))
        if drawn.done.get("") and fine and node in fine[1].outputs:
            views = [again[id(run)] for _, run in drawn.done[""]]
            yield from checks.total(views, here, fine[1], self.bench.network.k, self._open(here))
        yield from drawing(self.bench, plain, node, name)

    def _own(
        self, node: str, name: str, here: View, fine: tuple[Run, Run] | None, of_data: frozenset[str]
    ) -> Iterator[Finding]:
        if fine is None or name not in fine[0].outputs.get(node, {}) or name not in fine[1].outputs.get(node, {}):
            return
        half = view(self.bench, fine[0], node, name)
        if not isinstance(half, str):
            yield from checks.own(here, half, fine[1], of_data, self._open(here))

    def _again(self, run: Run, node: str, name: str) -> View | None:
        if name not in run.outputs.get(node, {}):
            return None
        found = view(self.bench, run, node, name)
        return None if isinstance(found, str) else found

    def _open(self, here: View) -> tuple[Missing, ...]:
        """Sources that nobody gave, without those of the real data that the manufactured do not have."""
        return tuple(m for m in here.accuracy.missing if m not in self.given)


def named(found: Iterator[Finding], node: str, output: str) -> Iterator[Finding]:
    """Findings told of an output."""
    return (replace(one, node=node, output=output) for one in found)
