"""A view as a file: the full picture with its network and its certificate, as the command line writes it."""

from __future__ import annotations

import tempfile
from pathlib import Path

from app.commands import pictures
from app.commands.nets import Found
from app.commands.outbox import Outbox
from app.commands.pictures import PAGE, Sheet
from app.engine import document, paths, scheduler
from app.engine.catalogue import Catalogue
from app.engine.network import Network
from modules.data.scene import Scene


def write(
    scene: Scene, node: str, output: str, target: Path, network: Network, path: Path | None, catalogue: Catalogue,
    sheet: Sheet = PAGE,
) -> tuple[Path, str]:  # fmt: skip
    """Write the picture and its certificate; (where, its caption). It draws: call it in the studio.

    Raises
    ------
    NoniusError, OSError, ValueError
    """
    keys = scheduler.keys(network, catalogue, paths.identities(network, catalogue) or {})
    with tempfile.TemporaryDirectory() as folder:
        found = _found(network, path, Path(folder), catalogue)
        out = pictures.Out(node, output, Scene, target.absolute())
        with Outbox() as outbox:
            caption = pictures.write(scene, out, outbox, found, keys, catalogue, sheet=sheet)
            outbox.commit()
    return target, caption


def _found(network: Network, path: Path | None, folder: Path, catalogue: Catalogue) -> Found:
    """The network with its file; with one that is taken away again if it has none, or was changed."""
    if path is not None and path.is_file():
        return Found(network, "file", path, path.stem)
    passing = folder / "unsaved.json"
    passing.write_text(document.dumps(network, catalogue), "utf-8")
    return Found(network, "file", passing, "unsaved")

