"""Each state that a person meets comes about with mouse and keyboard, and shows something: off screen, and on a display."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QSettings
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QWidget

from app.gui import style
from tests.gui import showcase


@pytest.fixture(autouse=True)
def own_settings(tmp_path: Path, qapp: Any) -> Iterator[None]:
    QSettings.setDefaultFormat(QSettings.Format.IniFormat)
    QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, str(tmp_path / "settings"))
    yield
    style.choose("dark")


def pixels(image: QImage) -> Any:
    plain = image.convertToFormat(QImage.Format.Format_RGB32)
    return np.array(plain.constBits()).view(np.uint32).reshape(plain.height(), -1)[:, : plain.width()]


@pytest.mark.parametrize("name", showcase.STATES)
def test_a_state_of_the_window(name: str) -> None:
    window = showcase.make(name, "light" if name in ("first", "network") else "dark")
    try:
        image = pixels(showcase.picture(window))
        ratio = window.devicePixelRatioF()
        assert image.shape == (int(showcase.SIZE[1] * ratio), int(showcase.SIZE[0] * ratio))
        assert len(np.unique(image)) > 100, "there is something to see"
    finally:
        showcase.close(window)


def test_the_platform_is_the_one_that_was_asked_for(qapp: Any) -> None:
    """Where a display is promised, these tests ran on it and not off screen."""
    assert qapp.platformName() == os.environ.get("QT_QPA_PLATFORM", qapp.platformName())


def test_no_settings_are_cut_off_at_the_side() -> None:
    window = showcase.make("error", "dark")
    try:
        panel = window.panel
        inside = [w for w in panel.findChildren(QWidget) if w.isVisible() and w.minimumSizeHint().width() > panel.width()]
        assert not inside
    finally:
        showcase.close(window)
