"""The window. Qt lives here and nowhere else."""

from __future__ import annotations

import sys
from pathlib import Path


def main(network: str = "", theme: str = "") -> int:
    """Open the window and stay until it is closed.

    Parameters
    ----------
    network : a file, a picture, or the name of a packaged network; the first page without one
    theme : light, dark or system; as it was chosen before, without one
    """
    from PySide6.QtCore import QSettings, QTimer
    from PySide6.QtGui import QSurfaceFormat
    from PySide6.QtWidgets import QApplication

    QSurfaceFormat.setDefaultFormat(QSurfaceFormat.defaultFormat())
    app = QApplication.instance() or QApplication(sys.argv[:1])
    assert isinstance(app, QApplication)
    app.setApplicationName("Nonius Explorer")
    app.setOrganizationName("nonius")
    from app.gui import backends, icons, style
    from app.gui.main_window import MainWindow
    from app.gui.recovery import Log, lost
    from app.gui.session import Session
    from app.gui.warming import Warming

    settings = QSettings()
    style.choose(theme or str(settings.value("theme", "system")))
    app.setWindowIcon(icons.application())
    from app.engine.catalogue import mine

    left = lost()
    session = Session(mine(), workers=int(str(settings.value("threads", 0) or 0)), log=Log(mine()))
    bound = int(str(settings.value("cache", 0) or 0))
    if bound:
        session.runs.results.bound = bound << 20
    window = MainWindow(session, left)
    warming = Warming(window)
    warming.progress.connect(window.overall.tell)
    window.show()
    if network:
        QTimer.singleShot(0, lambda: window.commands.open_path(Path(network)))
    if not backends.in_window():  # two threads must not load what draws at once
        QTimer.singleShot(100, window.studio.start)
    QTimer.singleShot(1500, warming.begin)
    code = app.exec()
    warming.close()
    window.shut()
    return int(code)
