"""The painted viewport: frames come from a thread, the newest wins, the mouse turns and moves, two dimensions are locked."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from app.gui import cameras
from app.gui.viewport_widget import Views

CAMERA: dict[str, Any] = {"position": [0.0, -10.0, 0.0], "focal": [0.0, 0.0, 0.0], "up": [0.0, 0.0, 1.0],
          "angle": 30.0, "height": 4.0, "parallel": False}  # fmt: skip


def test_a_view_shows_its_picture_with_its_legend(seen: Views, qtbot: Any) -> None:
    pane = seen.panes[0]
    qtbot.waitUntil(lambda: pane.legend.legend is not None, timeout=20000)
    assert pane.legend.isVisible()
    image = pane.back.grab().toImage()
    colours = {image.pixel(x, y) for x in range(0, image.width(), 7) for y in range(0, image.height(), 7)}
    assert len(colours) > 20
    assert pane.words.isHidden()


def test_turning_asks_for_frames_and_fires_nothing(seen: Views, qtbot: Any) -> None:
    pane, session = seen.panes[0], seen.session
    before, network = dict(pane.back.camera or {}), session.network
    QTest.mousePress(pane.back, Qt.MouseButton.LeftButton, pos=QPoint(200, 150))
    for x in range(200, 260, 10):
        QTest.mouseMove(pane.back, QPoint(x, 160))
    QTest.mouseRelease(pane.back, Qt.MouseButton.LeftButton, pos=QPoint(260, 160))
    qtbot.waitUntil(lambda: session.network["view"].view.get("camera") is not None, timeout=10000)
    assert session.network["view"].view["camera"]["position"] != before["position"]
    assert session.network is not network
    assert session.history.undo_label == "Add"
    assert session.state("view").kind in ("clean", "cached")


def test_the_previous_picture_stays_with_a_note(seen: Views, qtbot: Any) -> None:
    pane, session = seen.panes[0], seen.session
    scene = pane.scene()
    session.freeze(True)
    session.edit("Set", session.network.set("field", "samples", (21, 21), session.catalogue))
    assert pane.scene() is scene
    assert pane.note.isVisible() and "previous picture" in pane.note.text()
    session.freeze(False)
    qtbot.waitUntil(lambda: pane.note.isHidden(), timeout=20000)
    assert pane.scene() is not scene


def test_two_dimensions_cannot_be_turned(seen: Views, qtbot: Any) -> None:
    pane, session = seen.panes[0], seen.session
    session.edit("Set", session.network.set("view", "dimensions", "2", session.catalogue))
    qtbot.waitUntil(lambda: pane.back.flat and bool((pane.back.camera or {}).get("parallel")), timeout=20000)
    camera = dict(pane.back.camera or {})
    QTest.mousePress(pane.back, Qt.MouseButton.LeftButton, pos=QPoint(200, 150))
    QTest.mouseMove(pane.back, QPoint(240, 150))
    QTest.mouseRelease(pane.back, Qt.MouseButton.LeftButton, pos=QPoint(240, 150))
    now = pane.back.camera or {}
    assert np.allclose(np.subtract(now["position"], now["focal"])[:2], 0, atol=1e-6)
    assert now["focal"] != camera["focal"]


def test_the_picture_that_is_saved_carries_network_and_certificate(seen: Views, qtbot: Any, tmp_path: Path) -> None:
    from app.engine import certificate, pngtext
    from app.gui import pictures

    pane, session = seen.panes[0], seen.session
    target = tmp_path / "view.png"
    scene = pane.scene()
    assert scene is not None
    job = lambda: pictures.write(scene, "view", "scene", target, session.network, None, session.catalogue)  # noqa: E731
    with qtbot.waitSignal(seen.studio.did, timeout=60000) as done:
        seen.studio.do("it", job)
    assert not isinstance(done.args[1], Exception), done.args[1]
    texts = pngtext.texts(target.read_bytes())
    assert certificate.NETWORK in texts and certificate.ACCURACY in texts
    assert certificate.beside(target).exists()


def test_drawing_does_not_stop_the_window(seen: Views, qtbot: Any, stalls: Any) -> None:
    pane = seen.panes[0]
    with stalls() as worst:
        for _ in range(30):
            camera = pane.back.camera
            assert camera is not None
            pane.back.set_camera(cameras.turned(camera, 0.05, 0.0))
            qtbot.wait(15)
    assert worst() < 0.1


def test_without_a_view_the_page_says_what_to_do(views: Views) -> None:
    assert views.empty.isVisible() and "Space" in views.empty.text()


def test_turning_keeps_the_distance_and_moving_keeps_the_direction() -> None:
    turned = cameras.turned(dict(CAMERA), 0.3, 0.2)
    assert np.linalg.norm(turned["position"]) == pytest.approx(10)
    moved = cameras.moved(dict(CAMERA), 10, 0, 100)
    assert np.allclose(np.subtract(moved["position"], moved["focal"]), [0, -10, 0])
    assert moved["focal"][0] < 0


def test_zooming_to_the_pointer_keeps_what_lies_under_it() -> None:
    flat = {**CAMERA, "position": [0.0, 0.0, 10.0], "up": [0.0, 1.0, 0.0], "parallel": True}
    at, aspect = (0.5, -0.25), 1.5
    def under(camera: dict[str, Any]) -> tuple[float, float]:
        half = camera["height"] / 2
        return camera["focal"][0] + at[0] * half * aspect, camera["focal"][1] + at[1] * half
    assert under(cameras.nearer(flat, 2.0, at, aspect)) == pytest.approx(under(flat))


def test_parallel_and_back_keeps_the_size() -> None:
    back = cameras.parallel(cameras.parallel(dict(CAMERA), True), False)
    assert np.allclose(back["position"], CAMERA["position"])
