"""What the window costs: opening a large network, a held slider, a minute of dragging, many documents one after the other.

    nonius bench window

Runs on the display that is there, or off screen. Ratios are to the mapper's own time, measured in the same run.
"""

from __future__ import annotations

import os
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))
if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    os.environ.setdefault("QT_LOGGING_RULES", "qt.qpa.*=false;default.warning=false")

from PySide6.QtCore import QSettings, QTimer  # noqa: E402  run as a script, the path comes first
from PySide6.QtWidgets import QApplication  # noqa: E402  the same

from app.engine.catalogue import mine  # noqa: E402  the same
from app.engine.network import Network, Node, Origin, Socket  # noqa: E402  the same
from app.gui import style  # noqa: E402  the same
from app.gui.main_window import MainWindow  # noqa: E402  the same
from app.gui.session import Session  # noqa: E402  the same

CHAIN = (
    ("field", "readers.analytic.analytic", ()),
    ("model", "modellers.interpolate.interpolate", ("field",)),
    ("contour", "mappers.contour.contour", ("model",)),
    ("lines", "renderers.lines.lines", ("contour",)),
    ("grid", "mappers.grid_lines.grid_lines", ("model",)),
    ("net", "renderers.lines.lines", ("grid",)),
    ("heights", "mappers.elevation.elevation", ("model",)),
    ("surface", "renderers.surface.surface", ("heights",)),
    ("view", "renderers.view.view", ("lines", "net", "surface")),
)
"""Stem, module, and what its first port takes; a view also takes the layers of its neighbours."""


def large(chains: int = 112) -> Network:
    """About 1,000 nodes and 1,500 wires."""
    nodes: dict[str, Node] = {}
    wires: dict[Socket, Origin] = {}
    catalogue = mine()
    for i in range(chains):
        for j, (stem, module, origins) in enumerate(CHAIN):
            record = catalogue[module]
            name = f"{stem}-{i}"
            place = [226.0 * (j % 5) + 1300 * (i % 10), 420.0 * (i // 10) + 180.0 * (j // 5)]
            nodes[name] = Node(name, module, record.version, view={"position": place})
            from_where = [f"{origin}-{i}" for origin in origins]
            if stem == "view":
                beside = ((1, "lines"), (1, "net"), (1, "surface"), (2, "lines"))
                from_where += [f"{origin}-{(i + k) % chains}" for k, origin in beside]
            for slot, origin in enumerate(from_where):
                made = catalogue[next(m for s, m, _ in CHAIN if s == origin.partition("-")[0])]
                wires[name, record.ports[0].name, slot] = (origin, made.outputs[0].name)
    return Network(nodes, wires)


def pump(app: QApplication, until: Callable[[], bool], seconds: float = 120.0) -> float:
    """Let the event loop run until something holds; the seconds it took."""
    start = time.perf_counter()
    while not until():
        app.processEvents()
        time.sleep(0.0005)
        if time.perf_counter() - start > seconds:
            raise TimeoutError(f"nothing after {seconds:g} s")
    return time.perf_counter() - start


def wait(app: QApplication, end: float) -> None:
    """Let the event loop run until a time."""
    pump(app, lambda: time.perf_counter() > end)


@contextmanager
def loop(app: QApplication) -> Iterator[list[float]]:
    """The gaps between ticks of a timer of 1 ms."""
    gaps: list[float] = []
    last = [time.perf_counter()]

    def tick() -> None:
        now = time.perf_counter()
        gaps.append(now - last[0])
        last[0] = now

    timer = QTimer(interval=1)
    timer.timeout.connect(tick)
    timer.start()
    try:
        yield gaps
    finally:
        timer.stop()


def memory() -> float:
    """MiB that the process holds."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def opening(app: QApplication, window: MainWindow) -> None:
    """A large network opened, and one node dragged with all in view."""
    network = large()
    window.session.freeze(True)
    start = time.thread_time()
    window.session.adopt(network, None, frozen=True)
    app.processEvents()
    window.canvas.grab()
    opened = time.thread_time() - start
    frames = []
    for i in range(60):
        start = time.thread_time()
        window.session.amend(window.session.network.move({"contour-80": (452.0 + 4 * i, 1040.0 + 2 * i)}))
        window.canvas.viewport().repaint()
        app.processEvents()
        frames.append(time.thread_time() - start)
    frames.sort()
    print(f"  {len(network.nodes)} nodes, {len(network.wires)} wires: open and drawn in {opened:.2f} s of the window's thread")
    print(f"  one of them dragged, all in view: a frame in {frames[30] * 1e3:.0f} ms (95 %: {frames[57] * 1e3:.0f} ms)")
    window.session.history.saved()


def settled(window: MainWindow) -> bool:
    """Whether every view shows the present network."""
    session = window.session
    return bool(session.views()) and all(session.outputs(v) and not session.stale(v) for v in session.views())


def slider(app: QApplication, window: MainWindow, seconds: float = 6.0) -> None:
    """The level of the main network's contour swept at 60 Hz; then let go."""
    session = window.session
    window.commands.open_path(ROOT / "networks" / "jacksboro.json")
    pump(app, lambda: settled(window))
    contour = next(n for n, node in session.network.nodes.items() if node.module == "mappers.contour.contour")
    (view,) = session.views()
    shown: list[float] = []
    for value in (41.0, 42.0):  # kernels are compiled, files are read
        session.edit("Set interval", session.network.set(contour, "interval", value, session.catalogue))
        pump(app, lambda: settled(window))
        pump(app, lambda: not session.runs.busy)
    session.resultChanged.connect(lambda node: shown.append(time.perf_counter()) if node == view else None)
    begin = time.perf_counter()
    sent = 0
    while time.perf_counter() - begin < seconds:
        value = 40.0 + 20.0 * (sent % 97) / 97
        network = session.network.set(contour, "interval", value, session.catalogue)
        session.edit("Set interval", network, merge="s", interim=True)
        sent += 1
        wait(app, begin + sent / 60)
    held = [t for t in shown if t > begin]
    own = session.state(contour).seconds or 0.0
    below = sum(session.state(n).seconds or 0.0 for n in session.network.nodes if n != contour and not is_reader(session, n))
    last = time.perf_counter()
    session.edit("Set interval", session.network.set(contour, "interval", 33.0, session.catalogue), merge="s")
    pump(app, lambda: settled(window))
    late = time.perf_counter() - last
    gaps = [b - a for a, b in zip([begin, *held], held, strict=False)]
    print(f"  slider held {seconds:g} s, {sent} events: {len(held)} pictures, one in {statistics.median(gaps) * 1e3:.0f} ms"
          f" (worst {max(gaps) * 1e3:.0f} ms); the mapper takes {own * 1e3:.0f} ms, what follows it {below * 1e3:.0f} ms")
    print(f"  last event to new layers: {late / max(own + below, 1e-9):.2f} of the modules' own time ({late * 1e3:.0f} ms)")
    session.history.saved()


def is_reader(session: Session, node: str) -> bool:
    """Whether a node does not hang on the slider."""
    return not session.network.nodes[node].module.startswith(("mappers.", "renderers.", "accuracy_mappers."))


def drag(app: QApplication, window: MainWindow, seconds: float) -> None:
    """A node dragged at 60 Hz for a minute while its network is shown, with all in view."""
    session = window.session
    name = next(iter(session.network.nodes))
    pump(app, lambda: not session.runs.busy)
    before, begin, sent = memory(), time.perf_counter(), 0
    with loop(app) as gaps:
        while time.perf_counter() - begin < seconds:
            session.amend(session.network.move({name: (300 + 100 * (sent % 120) / 120, 200.0 + sent % 50)}))
            sent += 1
            wait(app, begin + sent / 60)
    late = sorted(gaps)[int(0.99 * len(gaps))]
    print(f"  {seconds:g} s of dragging at 60 Hz, {len(session.network.nodes)} nodes: {sent} moves, gaps of the event loop"
          f" {late * 1e3:.0f} ms (99 %), {max(gaps) * 1e3:.0f} ms (longest), memory +{memory() - before:.1f} MiB")
    session.history.saved()


def rounds(app: QApplication, window: MainWindow, number: int) -> None:
    """One document after the other in one window: opened, run, drawn, closed."""
    held = {}
    for i in range(1, number + 1):
        window.commands.open_path(ROOT / "networks" / ("thesis-3-03-a.json" if i % 2 else "thesis-3-04.json"))
        pump(app, lambda: settled(window) and window.views.panes[0].back.tag is not None)
        window.session.history.saved()
        window.commands.new()
        pump(app, lambda: not window.session.runs.busy)
        if i in (number // 2, number):
            app.processEvents()
            held[i] = memory()
    early, late = held[number // 2], held[number]
    growth = 100 * (late / early - 1)
    print(f"  rounds {number // 2} to {number} of open, run, close: {early:.0f} to {late:.0f} MiB, {growth:+.2f} %")


def main() -> None:
    """Measure and print."""
    quick = "--quick" in sys.argv
    with tempfile.TemporaryDirectory() as folder:
        os.environ["NONIUS_STATE"] = folder
        QSettings.setDefaultFormat(QSettings.Format.IniFormat)
        QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, folder)
        app = QApplication.instance() or QApplication(sys.argv[:1])
        assert isinstance(app, QApplication)
        style.choose("dark")
        window = MainWindow(Session(mine()))
        window.resize(1600, 1000)
        window.show()
        print(f"  platform {app.platformName()}")
        try:
            opening(app, window)
            drag(app, window, 5.0 if quick else 60.0)
            slider(app, window)
            drag(app, window, 5.0 if quick else 60.0)
            rounds(app, window, 20 if quick else 200)
        finally:
            window.session.history.saved()
            window.shut()
            window.close()


if __name__ == "__main__":
    main()
