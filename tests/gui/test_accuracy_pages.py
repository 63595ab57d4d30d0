"""The pages of accuracy: where the error of a picture comes from, flags and worst places with zoom, what is not given."""

from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QSettings, Qt
from PySide6.QtTest import QTest

from app.engine.catalogue import mine
from app.gui import cameras, motion, stating, style, zooming
from app.gui.bars import ROW
from app.gui.main_window import MainWindow
from app.gui.session import Session
from app.gui.sources import overview_of
from modules.data.places import where


@pytest.fixture(autouse=True)
def own_settings(tmp_path: Path, qapp: Any) -> None:
    QSettings.setDefaultFormat(QSettings.Format.IniFormat)
    QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, str(tmp_path / "settings"))
    QSettings().setValue("motion", "reduced")


@pytest.fixture(scope="module")
def heights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    y, x = np.mgrid[-1:1:21j, -1:1:21j]
    file = tmp_path_factory.mktemp("data") / "heights.npz"
    np.savez(file, elevation=np.round(400 * np.exp(-3 * (x**2 + y**2))).astype(np.int16), spacing=np.array([30.0, 30.0]))
    return file


@pytest.fixture
def window(session_of: Callable[..., Session], qtbot: Any, heights: Path) -> Iterator[MainWindow]:
    style.choose("dark")
    session = session_of(mine())
    made = MainWindow(session)
    made.resize(1300, 900)
    made.show()
    network = session.network
    modules = ("readers.elevation.elevation", "modellers.interpolate.interpolate", "mappers.contour.contour",
               "renderers.lines.lines", "renderers.view.view")  # fmt: skip
    names = ("read", "model", "contour", "lines", "view")
    for i, (module, name) in enumerate(zip(modules, names, strict=True)):
        values = {"path": heights} if name == "read" else {"interval": 50.0} if name == "contour" else {}
        network = network.add(module, session.catalogue, id=name, parameters=values, view={"position": [226.0 * i, 0.0]})
    for source, target in pairwise(names):
        out, into = session.catalogue[network[source].module].outputs[0], session.catalogue[network[target].module].ports[0]
        network = network.connect(source, out.name, target, into.name, session.catalogue)
    session.edit("Build", network)
    qtbot.waitUntil(lambda: session.state("view").kind in ("clean", "cached"), timeout=60000)
    yield made
    session.history.saved()
    made.close()
    made.deleteLater()


def test_every_source_behind_a_picture_with_the_node_that_made_it(window: MainWindow, qtbot: Any) -> None:
    window.commands("overview")
    page = window.pages.overview
    assert window.pages.currentWidget() is page
    qtbot.waitUntil(lambda: bool(page.bars.rows), timeout=30000)
    rows = page.bars.rows
    known = [r for r in rows if r.rigour != "unknown"]
    assert [r.share for r in known] == sorted((r.share for r in known), reverse=True) and known[0].share == 1.0
    assert {r.node for r in rows if "Quantisation" in r.name} == {"read"}
    assert any(r.node == "contour" and r.made.startswith("mapping") for r in rows)
    assert rows[-1].sign == "?" and rows[-1].node == "read"
    assert page.total.accessibleName().endswith("+ ?")


def test_the_overview_is_that_of_the_layers(window: MainWindow) -> None:
    (scene,) = (window.session.outputs("view") or {}).values()
    overview = overview_of(scene, 2.0)
    total = overview.total("position")
    assert total is not None
    lines = (window.session.outputs("contour") or {})["lines"]
    assert total[0].value == pytest.approx(lines.accuracy.total(2.0, "position").max())
    assert {s.line.id for s in overview.shares("position")} == {t.id for t in lines.accuracy.select("position")}


def test_a_click_or_enter_on_a_source_goes_to_its_step(window: MainWindow, qtbot: Any) -> None:
    page = window.pages.overview
    window.show_page("overview")
    qtbot.waitUntil(lambda: bool(page.bars.rows), timeout=30000)
    at = next(i for i, r in enumerate(page.bars.rows) if r.node == "contour")
    QTest.mouseClick(page.bars, Qt.MouseButton.LeftButton, pos=QPoint(60, at * ROW + 8))
    assert window.session.selection == ("contour",)
    last = len(page.bars.rows) - 1
    page.bars.setFocus()
    for _ in range(last - at):
        QTest.keyClick(page.bars, Qt.Key.Key_Down)
    QTest.keyClick(page.bars, Qt.Key.Key_Return)
    assert window.session.selection == (page.bars.rows[last].node,)


def test_what_is_not_given_is_stated_in_one_undoable_edit(window: MainWindow, qtbot: Any) -> None:
    session, page = window.session, window.pages.budget
    session.select(["contour"])
    qtbot.waitUntil(lambda: bool(page.bars.buttons), timeout=30000)
    before = session.network
    QTest.mouseClick(page.bars.buttons[0], Qt.MouseButton.LeftButton)
    dialog = next(w for w in window.findChildren(stating.GiveError))
    QTest.keyClick(dialog.amount, Qt.Key.Key_Return)
    assert dialog.isVisible() and dialog.refused.text() and session.network is before
    QTest.keyClicks(dialog.amount, "3/2")
    QTest.keyClick(dialog.amount, Qt.Key.Key_Return)
    (fresh,) = session.selection
    wires = session.network.wires
    assert wires[fresh, "samples", 0] == ("read", "samples")
    assert wires["model", "samples", 0] == (fresh, "samples")
    assert session.network[fresh].parameters["amount"] == 1.5
    qtbot.waitUntil(lambda: (a := session.accuracy("contour", "lines")) is not None and not a.missing, timeout=60000)
    session.undo()
    assert session.network.wires == before.wires and fresh not in session.network.nodes


def test_a_source_that_no_statement_answers_has_no_button(window: MainWindow) -> None:
    assert stating.gap(window.session, "contour", "Integration") is None
    found = stating.gap(window.session, "contour", "Measurement error")
    assert found is not None and (found.node, found.output) == ("read", "samples")


def test_the_worst_places_are_listed_and_zoomed_to(window: MainWindow, qtbot: Any) -> None:
    page = window.pages.worst
    window.commands("worst")
    qtbot.waitUntil(lambda: page.list.topLevelItemCount() > 3, timeout=60000)
    back = window.views.panes[0].back
    qtbot.waitUntil(lambda: back.camera is not None, timeout=60000)
    assert back.camera is not None
    before = cameras.seen(back.camera)
    page.list.setFocus()
    QTest.keyClick(page.list, Qt.Key.Key_Down)
    QTest.keyClick(page.list, Qt.Key.Key_Return)
    assert page.row == 1 and page.table is not None
    assert back.camera["focal"][:2] == pytest.approx([page.table["x"][1], page.table["y"][1]])
    assert cameras.seen(back.camera) < before
    assert back.findChildren(zooming.Ring)[0].isVisible()
    assert window.session.network["view"].view["camera"]["focal"][:2] == pytest.approx(back.camera["focal"][:2])
    page.add()
    (fresh,) = window.session.selection
    assert window.session.network.wires[fresh, "geometry", 0] == ("contour", "lines")


def test_flags_are_stepped_through(window: MainWindow, qtbot: Any) -> None:
    page = window.pages.flags
    window.commands("flags")
    assert page.count and page.list.topLevelItemCount() == page.count
    at = next((i for i in range(page.count) if page.flags[i][2].items is not None and page.flags[i][2].count > 1), None)
    assert at is not None
    page.choose(at)
    told: list[Any] = []
    page.zoomAsked.connect(told.append)
    for _ in range(2):
        window.commands("next_place")
    node, output, flag = page.flags[at]
    assert flag.items is not None
    value = (window.session.outputs(node) or {})[output]
    expected = where(value, flag.place, flag.items[:2])
    assert expected is not None
    assert [spot.point for spot in told] == [pytest.approx(tuple(p)) for p in expected]
    assert page.place.text().startswith("Place 2 of")


# --- places and cameras


@pytest.mark.parametrize("place", ["point", "cell"])
def test_places_of_a_grid_are_those_of_its_points(place: str) -> None:
    from modules.api import EXACT, Samples

    samples = Samples.from_array(np.zeros((3, 4, 5)), spacing=(1.0, 2.0, 3.0), origin=(5.0, 0.0, 0.0), accuracy=EXACT)
    points = samples.grid.points().reshape(3, 4, 5, 3)
    if place == "cell":
        corners = [points[k : 2 + k, j : 3 + j, i : 4 + i] for k in (0, 1) for j in (0, 1) for i in (0, 1)]
        points = sum(corners) / 8  # type: ignore[assignment]  # a sum of arrays
    items = np.array([0, 7, 23])
    found = where(samples, place, items)  # type: ignore[arg-type]
    assert found == pytest.approx(points.reshape(-1, 3)[items])


@pytest.mark.parametrize("parallel", [True, False])
def test_a_camera_looks_at_a_place_from_the_same_side(parallel: bool) -> None:
    start = {"position": [3.0, -4.0, 5.0], "focal": [0.0, 0.0, 0.0], "up": [0.0, 0.0, 1.0], "angle": 30.0, "height": 6.0,
             "parallel": parallel}  # fmt: skip
    end = cameras.looking_at(start, (1.0, 2.0, 0.5), 0.25)
    assert cameras.seen(end) == pytest.approx(0.25)
    assert cameras.directions(end)[0] == pytest.approx(cameras.directions(start)[0])
    half = cameras.between(start, end, 0.5)
    assert half["focal"] == pytest.approx([0.5, 1.0, 0.25])
    assert cameras.between(start, end, 1.0)["position"] == pytest.approx(end["position"])


def test_motion_ends_and_can_be_reduced(qapp: Any, qtbot: Any) -> None:
    from PySide6.QtCore import QObject

    told: list[float] = []
    assert motion.glide(QObject(), 100, told.append) is None and told == [1.0]
    QSettings().setValue("motion", "short")
    told.clear()
    parent = QObject()
    motion.glide(parent, 60, told.append)
    qtbot.waitUntil(lambda: bool(told) and told[-1] == 1.0, timeout=3000)
    assert told == sorted(told) and len(told) > 1
