"""`nonius run NETWORK`: run it, write what is asked for, say what is known of its accuracy."""

from __future__ import annotations

import argparse
import csv
import io
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from app import doctor, paths
from app.commands import films, nets, pictures, wave
from app.commands.console import Console, Usage
from app.commands.films import Frame, numbered
from app.commands.outbox import Outbox
from app.commands.pictures import Out, plain
from app.engine import check as legal
from app.engine import paths as files
from app.engine import scheduler, writing
from app.engine.catalogue import Catalogue
from app.engine.demands import Demand, Verdict
from app.engine.errors import NetworkError
from app.engine.network import Network
from app.engine.results import Results
from app.engine.sequence import Sequence, each, kept
from modules.data.wires import Geometry, Model, Samples, Scene, Table
from modules.declare import article

SUFFIXES: Mapping[type, tuple[str, ...]] = {
    Scene: (".png",),
    Geometry: (".vtp",),
    Samples: (".vti", ".vtr", ".vts", ".vtu"),
    Model: (".vti", ".vtr", ".vts", ".vtu"),
    Table: (".csv",),
}
"""What can be written, and as what."""

FAILED, UNMET = 1, 3


def run(options: argparse.Namespace, console: Console) -> int:
    """Run a network; the exit code says how it went."""
    demands = [Demand.of(text) for text in options.demands]
    catalogue = Catalogue.load()
    found = nets.edited(nets.find(options.network, catalogue), options.edits, catalogue)
    network = found.network
    for warning in found.warnings:
        console.complain(f"nonius: {warning}")
    for demand in demands:
        demand.against(network, catalogue)
    outs = [asked(text, network, catalogue) for text in options.outs] or default(network, found.name, catalogue)
    if found.kind == "picture":
        for line in nets.reads(network, catalogue):
            console.say(line)
    for path in [*(out.path for out in outs), *([Path(options.report)] if options.report else [])]:
        writable(path)
    if not _compiled():
        console.say("the kernels are compiled at their first use; the next run does not wait for it")
    drawer = doctor.Drawer(any(out.type is Scene for out in outs))
    sequences = [_sequence(text, network) for text in options.sequences]
    if options.film and not sequences:
        raise Usage("--film 10 makes a film of the frames of --for: name a parameter and its values there")
    frames = each(sequences, network, catalogue) if sequences else [({}, network)]
    settled = _Run(found, demands, drawer, catalogue, console, options, Results() if sequences else None)
    with Outbox() as outbox:
        done = [settled.frame(values, one, outs, (i, len(frames)), outbox) for i, (values, one) in enumerate(frames, 1)]
        codes = {frame.code for frame in done}
        code = FAILED if FAILED in codes else max(codes)
        if sequences:
            films.put(done, outs, options.film, outbox)
        if options.report:
            outbox.put(Path(options.report), _report(found, done, bool(sequences), code))
        written = outbox.commit()
    captions = {path: words for frame in done for path, words in frame.captions.items()}
    for path in written:
        console.say(f"wrote {path}")
        if path in captions:
            console.say(f"  {captions[path]}")
    return code


def _sequence(text: str, network: Network) -> Sequence:
    if text != "saved":
        return Sequence.of(text)
    if (one := kept(network.settings)) is None:
        raise Usage("--for saved: this network has no sequence; write it as NODE.PARAM=VALUES")
    return one


@dataclass(frozen=True)
class _Run:
    """What all frames of a run have in common."""

    found: nets.Found
    demands: list[Demand]
    drawer: doctor.Drawer
    catalogue: Catalogue
    console: Console
    options: argparse.Namespace
    results: Results | None

    def frame(
        self, values: dict[str, Any], network: Network, outs: list[Out], place: tuple[int, int], outbox: Outbox
    ) -> Frame:
        """Run once and stage what is asked for; what a sequence sets stands among the edits of its certificate."""
        console = self.console
        set_ = tuple(f"{name}={value}" for name, value in values.items())
        if values:
            console.say(f"{place[0]} of {place[1]}: {', '.join(set_)}")
            outs = [replace(out, path=numbered(out.path, *place)) for out in outs]
        found = replace(self.found, network=network, edits=(*self.found.edits, *set_))
        wanted = _wanted(network, outs, self.demands, bool(self.options.outs))
        outcome = wave.watch(network, wanted, self.catalogue, console, self.options.threads, self.results)
        identities = files.identities(network, self.catalogue) or {}
        outcome.keys = scheduler.keys(network, self.catalogue, identities) | outcome.keys  # also of what a frame before had
        for sentence in writing.changed_files(network, self.catalogue, identities):
            console.complain(f"nonius: {sentence}")
        verdicts = _judged(self.demands, outcome, network)
        drawn = drawable(outs, outcome, self.drawer, console)
        captions = _write(drawn, outcome, outbox, found, self.catalogue, console)
        for verdict in verdicts:
            (console.say if verdict.met else console.complain)(str(verdict) if verdict.met else f"nonius: {verdict}")
        failed = outcome.errors or outcome.blocked or drawn != outs
        code = FAILED if failed else UNMET if not all(v.met for v in verdicts) else 0
        return Frame(values, outcome, verdicts, drawn, captions, code)


def asked(text: str, network: Network, catalogue: Catalogue) -> Out:
    """One `--out NODE[.OUTPUT]=FILE`.

    Raises
    ------
    NetworkError : no such node or output, or a file it cannot be written to
    """
    name, equals, file = text.partition("=")
    node, _, output = name.strip().partition(".")
    if not equals or not file.strip():
        raise Usage(f"--out {text!r}: write it as NODE=FILE or NODE.OUTPUT=FILE, such as view-1=picture.png")
    record = legal.known(network[node].module, node, catalogue)
    kind = legal.offered(node, record, output or record.outputs[0].name)
    out = Out(node, kind.name, kind.type, Path(file.strip()).expanduser())
    suffixes = SUFFIXES.get(kind.type)
    if suffixes is None:
        raise Usage(f"--out {text!r}: no file holds {article(kind.type)}: name a view, a shape, samples or a table")
    if out.path.suffix.lower() not in suffixes:
        took = out.path.suffix or "without a suffix"
        raise Usage(f"--out {text!r}: {article(kind.type)} goes to {' or '.join(suffixes)}, not {took}")
    return out


def default(network: Network, name: str, catalogue: Catalogue) -> list[Out]:
    """Each view to a picture in the current folder."""
    views = [
        (node, output)
        for node in sorted(network.nodes)
        if (record := catalogue.get(network.nodes[node].module))
        for output in record.outputs
        if output.type is Scene
    ]
    single = len(views) == 1
    return [Out(n, o.name, o.type, Path(f"{name}.png" if single else f"{name}-{n}.png")) for n, o in views]


def writable(path: Path) -> None:
    """Complain before the work, not after it."""
    if path.is_dir():
        raise Usage(f"{str(path)!r} is a folder: name a file in it")
    if not path.parent.is_dir():
        raise Usage(f"there is no folder {str(path.parent)!r} to write {path.name!r} to: make it first")


def _compiled() -> bool:
    """Whether some kernel was compiled and kept before."""
    from modules.kernels import _jit

    folder = _jit.cache_folder()
    return folder is not None and any(folder.iterdir())


def drawable(outs: list[Out], outcome: wave.Outcome, drawer: doctor.Drawer, console: Console) -> list[Out]:
    """The outputs without the pictures, if there are some and this machine cannot draw."""
    if not any(out.type is Scene and out.node in outcome.entries for out in outs):
        return outs
    try:
        drawer.prepare()
    except doctor.NoOpenGL as error:
        console.complain(f"nonius: {error}")
        return [out for out in outs if out.type is not Scene]
    return outs


def _wanted(network: Network, outs: list[Out], demands: list[Demand], only: bool) -> list[str]:
    ends = [] if only else list(network.sinks())
    return list(dict.fromkeys([*(o.node for o in outs), *(d.node for d in demands), *ends]))


def _judged(demands: list[Demand], outcome: wave.Outcome, network: Network) -> list[Verdict]:
    verdicts = []
    for demand in demands:
        entry = outcome.entries.get(demand.node)
        if entry is None:
            verdicts.append(Verdict(demand.text, False, float("nan"), "", f"{demand.node} gave no result"))
        else:
            verdicts.append(demand.judge(wave.output(entry, demand.output), network.k))
    return verdicts


def _write(
    outs: list[Out], outcome: wave.Outcome, outbox: Outbox, found: nets.Found, catalogue: Catalogue, console: Console
) -> dict[Path, str]:
    """Stage all that has a result; captions of the pictures."""
    captions = {}
    for out in outs:
        entry = outcome.entries.get(out.node)
        if entry is None:
            continue
        value = entry.outputs[out.output]
        if isinstance(value, Scene):
            console.progress(f"drawing {out.path.name}", 0.0)
            tell = partial(console.progress, f"certifying {out.path.name}")
            captions[out.path] = pictures.write(value, out, outbox, found, outcome.keys, catalogue, tell)
        elif isinstance(value, Table):
            outbox.put(out.path, table(value))
        else:
            _save(value, out, outbox)
    return captions


def _save(value: Any, out: Out, outbox: Outbox) -> None:
    from modules.data import exchange

    place = outbox.place(out.path)
    try:
        exchange.save(value.samples if isinstance(value, Model) else value, place)
    except ValueError as error:
        sentence = str(error).replace(place.stem, out.path.stem)
        raise Usage(f"--out {out.node}.{out.output}={out.path}: {sentence}") from None


def table(value: Table) -> bytes:
    """A table as CSV: a header with units, numbers in full, UTF-8."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    units = value.units
    writer.writerow([f"{name} [{units[name]}]" if units.get(name) else name for name in value.columns])
    for row in zip(*(column.tolist() for column in value.columns.values()), strict=True):
        writer.writerow([repr(cell) if isinstance(cell, float) else cell for cell in row])
    return text.getvalue().encode()


def _report(found: nets.Found, frames: list[Frame], several: bool, code: int) -> bytes:
    """What happened, of a sequence frame by frame."""
    told = [_told(frame) for frame in frames]
    content: dict[str, Any] = {"report": 1, "network": found.name, "k": found.network.k, "exit": code}
    if several:
        ways = zip(frames, told, strict=True)
        content["frames"] = [{"set": plain(f.values), "exit": f.code, **t} for f, t in ways]
    else:
        content |= told[0]
    content["versions"] = paths.versions()
    try:
        return (json.dumps(content, ensure_ascii=False, allow_nan=False, indent=1) + "\n").encode()
    except ValueError as error:
        raise NetworkError(f"the report cannot be written: {error}") from None


def _told(frame: Frame) -> dict[str, Any]:
    there = [o for o in frame.outs if o.node in frame.outcome.entries]
    return {
        "nodes": frame.outcome.nodes,
        "demands": [v.record() for v in frame.verdicts],
        "written": [{"node": o.node, "output": o.output, "file": o.path.as_posix()} for o in there],
    }
