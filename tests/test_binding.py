"""The Qt binding: PySide6 6.12.0 loses a reference to None in every void call and ends Python before 3.12."""

import sys

import pytest


def test_binding_keeps_none_alive() -> None:
    core = pytest.importorskip("PySide6.QtCore")
    thing = core.QObject()
    before = sys.getrefcount(None)
    for _ in range(1000):
        thing.setObjectName("a")
    assert abs(sys.getrefcount(None) - before) < 100
