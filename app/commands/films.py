"""The frames of a sequence as files: numbered pictures with their certificates, an index of them, and a film."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.commands.outbox import Outbox
from app.commands.pictures import Out, plain
from app.commands.wave import Outcome
from app.engine import certificate, pngtext
from app.engine.demands import Verdict
from modules.data.wires import Scene

FORMAT = "nonius-frames 1"


@dataclass(frozen=True)
class Frame:
    """What one value of a sequence gave.

    Parameters
    ----------
    values : "node.parameter" -> what it was set to
    outs : what was to be written
    captions : of the pictures, by file
    code : 0, or why not
    """

    values: Mapping[str, Any]
    outcome: Outcome
    verdicts: list[Verdict]
    outs: list[Out]
    captions: Mapping[Path, str]
    code: int


def numbered(path: Path, number: int, count: int) -> Path:
    """The file of one of `count` frames: sweep-007.png, so that names are in their order."""
    return path.with_name(f"{path.stem}-{number:0{max(3, len(str(count)))}d}{path.suffix}")


def put(frames: Sequence[Frame], outs: Iterable[Out], fps: int | None, outbox: Outbox) -> None:
    """Stage an index beside the pictures of each view, and a film of them if so many frames a second are given."""
    for out in outs:
        if out.type is not Scene:
            continue
        mine = [(f, numbered(out.path, i, len(frames))) for i, f in enumerate(frames, 1)]
        there = [(f.values, path) for f, path in mine if path in f.captions]
        index(out.path, [(v, path, outbox.staged(path)) for v, path in there], fps, outbox)


def index(target: Path, pictures: Sequence[tuple[Mapping[str, Any], Path, bytes]], fps: int | None, outbox: Outbox) -> None:
    """Stage sweep.frames.json and, as sweep.apng, the film: of each picture what was set, its file, digest and certificate."""
    listed = []
    for values, path, data in pictures:
        it = {"file": path.name, "sha256": certificate.digest(data), "certificate": certificate.beside(path).name}
        listed.append({"set": plain(dict(values)), **it})
    content: dict[str, Any] = {"frames": FORMAT, "pictures": listed}
    if fps and pictures:
        film = pngtext.animated([data for _, _, data in pictures], fps)
        place = target.with_suffix(".apng")
        outbox.put(place, film)
        content["film"] = {"file": place.name, "fps": fps, "sha256": certificate.digest(film)}
    outbox.put(target.with_suffix(".frames.json"), (json.dumps(content, ensure_ascii=False, indent=1) + "\n").encode())
