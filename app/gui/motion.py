"""Motion: short, only where it helps the eye to follow, and none where the user or the system wants none."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Final

from PySide6.QtCore import QEasingCurve, QObject, QSettings, Qt, QVariantAnimation
from PySide6.QtWidgets import QApplication

CHOICES: Final = {"short": "Short, where it helps to follow", "reduced": "None"}
ZOOM: Final = 300
"""Milliseconds of a flight to a place."""
CANVAS: Final = 200


def reduced() -> bool:
    """Whether nothing shall move by itself: the user says so, or Windows does (other systems do not tell Qt)."""
    if QSettings().value("motion", "short") == "reduced":
        return True
    return sys.platform == "win32" and not QApplication.isEffectEnabled(Qt.UIEffect.UI_General)


def glide(parent: QObject, milliseconds: int, step: Callable[[float], object]) -> QVariantAnimation | None:
    """Call `step` with 0 < t <= 1 until it is 1, easing out; once with 1 where motion is reduced.

    Parameters
    ----------
    parent : with it the motion ends
    """
    if reduced():
        step(1.0)
        return None
    run = QVariantAnimation(parent)
    run.setStartValue(0.0)
    run.setEndValue(1.0)
    run.setDuration(milliseconds)
    run.setEasingCurve(QEasingCurve.Type.OutCubic)
    run.valueChanged.connect(lambda t: step(float(t)) if float(t) > 0 else None)
    run.start(QVariantAnimation.DeletionPolicy.DeleteWhenStopped)
    return run
