"""`nonius doctor`: whether this machine can draw, and what to install."""

from __future__ import annotations

import argparse

from app import doctor
from app.commands.console import Console


def run(options: argparse.Namespace, console: Console) -> int:
    """Say what was found; 1 if something keeps the program from working."""
    well = True
    for finding in doctor.findings():
        console.write(f"{'ok ' if finding.well else 'no '} {finding.what}")
        if not finding.well:
            well = False
            if finding.remedy:
                console.write(f"    {finding.remedy}")
    return 0 if well else 1
