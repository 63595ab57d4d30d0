"""`nonius gallery`: every packaged network run, its pictures and certificates written, and a page that shows them."""

from __future__ import annotations

import argparse
import html
from dataclasses import dataclass
from pathlib import Path

from app import doctor, paths
from app.commands import nets, pictures, wave
from app.commands.console import Console, Usage
from app.commands.outbox import Outbox
from app.commands.run import FAILED, default
from app.engine.catalogue import Catalogue

PAGE = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>Nonius Explorer: gallery</title>
<style>
body {{ font: 16px/1.5 system-ui, sans-serif; max-width: 72rem; margin: 2rem auto; padding: 0 1rem }}
body {{ color: #1a1e24; background: #fff }}
figure {{ margin: 2rem 0 }} img {{ max-width: 100%; height: auto; border: 1px solid #d0d6dd }}
figcaption {{ max-width: 48rem }} code {{ background: #f1f3f5; padding: 0 .3em }}
</style>
<h1>Gallery</h1>
<p>Each picture is drawn by <code>nonius gallery</code>, carries its network, and has a certificate beside it.</p>
{figures}
</html>
"""

FIGURE = """<figure>
<a href="{file}"><img src="{file}" alt="{caption}" loading="lazy"></a>
<figcaption><h2>{title}</h2><p>{caption}</p>
<p><code>nonius run {name}</code> &middot; <a href="{certificate}">certificate</a></p></figcaption>
</figure>"""


@dataclass(frozen=True)
class Shown:
    """A picture of the gallery."""

    name: str
    title: str
    file: str
    caption: str


def run(options: argparse.Namespace, console: Console) -> int:
    """Run all packaged networks; 1 if one fails, the others are shown."""
    folder = Path(options.to) if options.to else _folder()
    if folder.exists() and not folder.is_dir():
        raise Usage(f"{str(folder)!r} is a file: name a folder")
    folder.mkdir(parents=True, exist_ok=True)
    catalogue = Catalogue.load()
    shown: list[Shown] = []
    failed = False
    doctor.Drawer().prepare()
    for name in paths.networks():
        console.say(f"\n{name}")
        found = nets.find(name, catalogue)
        outs = default(found.network, name, catalogue)
        outcome = wave.watch(found.network, [o.node for o in outs], catalogue, console, options.threads)
        failed |= bool(outcome.errors or outcome.blocked)
        with Outbox() as outbox:
            for out in outs:
                if out.node in outcome.entries:
                    here = pictures.Out(out.node, out.output, out.type, folder / out.path)
                    scene = outcome.entries[out.node].outputs[out.output]
                    caption = pictures.write(scene, here, outbox, found, outcome.keys, catalogue)
                    title = scene.look.title or found.network.settings.get("title") or name
                    shown.append(Shown(name, title, here.path.name, caption))
            outbox.commit()
    with Outbox() as outbox:
        outbox.put(folder / "index.html", page(shown).encode())
        outbox.commit()
    console.say(f"\nwrote {len(shown)} pictures and index.html to {folder}")
    return FAILED if failed else 0


def _folder() -> Path:
    return paths.data("resources") / "gallery" if paths.checkout() else Path("gallery")


def page(shown: list[Shown]) -> str:
    """The page of some pictures."""
    figures = [
        FIGURE.format(
            file=html.escape(one.file), caption=html.escape(one.caption), title=html.escape(one.title),
            name=html.escape(one.name), certificate=html.escape(Path(one.file).stem + ".accuracy.json"),
        )
        for one in shown
    ]  # fmt: skip
    return PAGE.format(figures="\n".join(figures))
