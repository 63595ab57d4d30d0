"""`nonius verify NETWORK`: run it on data whose truth is known, and hold what it states of its errors against that."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from app.commands import nets
from app.commands.console import Console, Usage
from app.commands.run import writable
from app.engine.catalogue import Catalogue
from app.verify.findings import Report
from app.verify.study import FEWEST_RUNS, verify
from modules.progress import Cancelled, Progress

WRONG = 3


def run(options: argparse.Namespace, console: Console) -> int:
    """Verify a network; the exit code is 3 if a claim is wrong."""
    if options.runs < FEWEST_RUNS:
        raise Usage(f"--runs {options.runs}: at least {FEWEST_RUNS} are needed to tell a spread")
    catalogue = Catalogue.load()
    found = nets.edited(nets.find(options.network, catalogue), options.edits, catalogue)
    for warning in found.warnings:
        console.complain(f"nonius: {warning}")
    if options.report:
        writable(Path(options.report))
    tell = Progress(lambda fraction: console.progress(f"verifying {found.name}", fraction))
    try:
        report = verify(found.network, catalogue, tell, runs=options.runs, seed=options.seed)
    except Cancelled:
        raise KeyboardInterrupt("cancelled; nothing was written") from None
    told(report, console)
    if options.report:
        text = json.dumps({"network": found.name, **report.record()}, ensure_ascii=False, allow_nan=False, indent=1)
        Path(options.report).write_text(text + "\n", encoding="utf-8")
        console.say(f"wrote {options.report}")
    return WRONG if report.wrong else 0


def told(report: Report, console: Console) -> None:
    """The findings by output; wrong ones also when quiet."""
    for note in report.notes:
        console.say(note)
    for where, findings in report.nodes():
        console.say(where.rstrip("."))
        for one in findings:
            if one.verdict == "wrong":
                console.complain(f"  {one}")
            else:
                console.say(f"  {one}")
    (console.complain if report.wrong else console.say)(report.verdict)
