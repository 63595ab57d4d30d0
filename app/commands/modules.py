"""`nonius modules`: what there is, room by room, and what would not load."""

from __future__ import annotations

import argparse
import json
from typing import Any

from app.commands.console import Console, columns
from app.engine.catalogue import Catalogue
from modules.declare import ROOMS, Module
from modules.parameters import plain


def run(options: argparse.Namespace, console: Console) -> int:
    """List the catalogue; 0 even if a user's file would not load, which is said."""
    catalogue = Catalogue.load()
    if options.json:
        console.write(json.dumps(listing(catalogue), ensure_ascii=False, indent=1))
        return 0
    for room in ROOMS:
        console.write(f"\n{room.replace('_', ' ')}")
        rows = [(f"  {record.id}", record.summary or record.title) for record in catalogue.room(room)]
        console.write("\n".join(columns(rows)) or "  none")
    for broken in catalogue.broken.values():
        console.complain(f"did not load: {broken.where}: {broken.sentence}")
        console.detail(broken.traceback)
    console.write("\n`nonius describe MODULE` says more of one")
    return 0


def listing(catalogue: Catalogue) -> dict[str, Any]:
    """The catalogue as plain values."""
    return {
        "modules": [described(record) for record in catalogue],
        "broken": [{"where": b.where, "sentence": b.sentence} for b in catalogue.broken.values()],
    }


def described(record: Module) -> dict[str, Any]:
    """A module as plain values."""
    return {
        "id": record.id,
        "title": record.title,
        "room": record.room,
        "version": record.version,
        "was": list(record.was),
        "summary": record.summary,
        "accuracy": record.accuracy,
        "source": record.source,
        "ports": [
            {"name": p.name, "type": p.type.__name__, "optional": p.optional, "many": p.many, "words": p.words}
            for p in record.ports
        ],
        "parameters": [
            {
                "name": p.name,
                "takes": p.takes(),
                "default": plain(p.default),
                "unit": p.range.unit if p.range else "",
                "options": list(p.options),
                "words": p.words,
            }
            for p in record.parameters
        ],
        "outputs": [{"name": o.name, "type": o.type.__name__} for o in record.outputs],
    }
