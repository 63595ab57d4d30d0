"""What a killed process loses: a script of edits, killed at random moments, many times; nothing older than a second may go.

    nonius bench recovery

The script adds, wires, sets, removes, undoes and redoes, saves and opens, in a small network and in one of 1,000 nodes. Each
state is told by its text before the next edit; what the log (or the file, right after a save) gives back must be one of the
states of the last second.
"""

from __future__ import annotations

import hashlib
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

from app.engine import document  # noqa: E402  run as a script, the path comes first
from app.engine.catalogue import Catalogue, mine  # noqa: E402  the same
from app.engine.network import Network  # noqa: E402  the same
from app.gui.recovery import Log, lost  # noqa: E402  the same
from app.gui.session import Session  # noqa: E402  the same

SMALL, LARGE = 32, 6
SECOND = 1.0


def name_of(network: Network, catalogue: Catalogue) -> str:
    """A short name of what a network holds."""
    return hashlib.blake2b(document.dumps(network, catalogue).encode(), digest_size=8).hexdigest()


# --- the process that is killed


def edits(session: Session, rng: random.Random, file: Path) -> Iterator[None]:
    """One edit after the other, for ever."""
    catalogue = session.catalogue
    while True:
        network, names = session.network, sorted(session.network.nodes)
        fields = [n for n in names if network.nodes[n].module == "readers.analytic.analytic"]
        match rng.choices(("add", "set", "move", "remove", "undo", "redo", "save", "open"), (6, 20, 10, 3, 4, 2, 1, 1))[0]:
            case "add":
                grown = network.add("readers.analytic.analytic", catalogue).add("interpolate", catalogue)
                field, model = sorted(set(grown.nodes) - set(names))
                session.edit("Add", grown.connect(field, "samples", model, "samples", catalogue))
            case "set" if fields:
                value = round(rng.random(), 6)
                changed = network.set(rng.choice(fields), "noise", value, catalogue)
                session.edit("Set noise", changed, merge="noise", interim=True)
            case "move" if names:
                session.edit("Move", network.move({rng.choice(names): (rng.random() * 900, rng.random() * 900)}))
            case "remove" if names:
                session.edit("Delete", network.remove(rng.choice(names)))
            case "undo":
                session.undo()
            case "redo":
                session.redo()
            case "save":
                session.save(file)
            case "open" if file.exists() and not session.modified:
                session.open(file)
            case _:
                continue
        yield


def child(seed: int, folder: Path, large: bool) -> None:
    """Edit until killed; a line for each state: when it was, its name."""
    from PySide6.QtCore import QCoreApplication

    app = QCoreApplication([])
    rng, catalogue = random.Random(seed), mine()
    session = Session(catalogue, log=Log(catalogue))
    session.freeze(True)
    network = Network()
    for _ in range(500 if large else 1):
        network = network.add("readers.analytic.analytic", catalogue).add("interpolate", catalogue)
    session.edit("Add", network)
    for _ in edits(session, rng, folder / "mine.json"):
        print(time.time(), name_of(session.network, catalogue), flush=True)
        app.processEvents()
        time.sleep(rng.choice((0.0, 0.01, 0.05)))


# --- the process that kills


def trial(seed: int, large: bool) -> tuple[bool, float]:
    """(whether it held, the age in seconds of what was found)."""
    rng, catalogue = random.Random(seed), mine()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        env = {**os.environ, "NONIUS_STATE": str(folder / "state"), "QT_QPA_PLATFORM": "offscreen"}
        told = folder / "told.txt"
        words = [sys.executable, __file__, "--child", str(seed), str(folder), *(["large"] if large else [])]
        with told.open("w") as out:
            process = subprocess.Popen(words, stdout=out, env=env)
        while told.stat().st_size == 0:
            time.sleep(0.01)
        time.sleep(rng.uniform(0.0, 3.0))
        process.send_signal(signal.SIGKILL)
        killed = time.time()
        process.wait()
        states = [(float(at), state) for at, state in (line.split() for line in whole(told))]
        found = lost(folder / "state" / "recovery")
        if found:
            state = name_of(found[0].network(catalogue), catalogue)
        elif (folder / "mine.json").exists():
            state = name_of(document.load(folder / "mine.json", catalogue), catalogue)
        else:
            state = ""
        last = [i for i, (_, known) in enumerate(states) if known == state]
        if not last:  # the very last edit, not yet told; or killed before there was anything older than a second
            return killed - states[0][0] < SECOND or (bool(found) and found[0].at >= states[-1][0] - SECOND), 0.0
        after = states[last[-1] + 1][0] if last[-1] + 1 < len(states) else killed
        return killed - after < SECOND, killed - after


def whole(file: Path) -> list[str]:
    """Lines that end."""
    return file.read_text().rpartition("\n")[0].splitlines()


def main() -> None:
    """Measure and print."""
    for words, number, large in (("a small network", SMALL, False), ("1,000 nodes", LARGE, True)):
        results = [trial(1000 * large + seed, large) for seed in range(number)]
        held, ages = [ok for ok, _ in results], [age for _, age in results]
        print(f"  {words}, killed {number} times: {sum(held)} times nothing older than a second was lost;"
              f" the oldest lost edit was {max(ages):.2f} s old")
        if not all(held):
            raise SystemExit(f"lost more with the seeds {[i for i, ok in enumerate(held) if not ok]}")


if __name__ == "__main__":
    if "--child" in sys.argv:
        child(int(sys.argv[2]), Path(sys.argv[3]), "large" in sys.argv[4:])
    else:
        main()
