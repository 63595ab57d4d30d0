"""The canvas, with mouse and keys: wires, nodes, places, frames."""

import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QGuiApplication, QImage, QMouseEvent, QPainter, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMenu

from app.engine import document
from app.engine.catalogue import Catalogue
from app.engine.network import Network, Node, Origin, Socket
from app.gui import context, style
from app.gui.board import Board
from app.gui.canvas import Canvas
from app.gui.items import NodeItem
from app.gui.session import Session
from app.theme import THEMES

LEFT, MIDDLE = Qt.MouseButton.LeftButton, Qt.MouseButton.MiddleButton
SHIFT, CTRL, NONE = Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.NoModifier


@pytest.fixture(scope="session")
def catalogue() -> Catalogue:
    made = Catalogue()
    made._rooms = True
    made.reload()
    return made


@pytest.fixture
def canvas(qtbot: Any, catalogue: Catalogue) -> Iterator[Canvas]:
    """field, model, contour and lines in a row, all wired; nothing runs."""
    session = Session(catalogue)
    session.freeze(True)
    made = Canvas(session)
    qtbot.addWidget(made)
    made.resize(1000, 600)
    made.show()
    session.adopt(row(catalogue), None)
    made.set_zoom(1.0)
    yield made
    if made.popup is not None and not made.popup.isHidden():
        made.popup.close()
    session.close()


def row(catalogue: Catalogue) -> Network:
    network = Network()
    modules = {"field": "analytic", "model": "interpolate", "contour": "contour", "lines": "lines"}
    for i, (name, module) in enumerate(modules.items()):
        network = network.add(module, catalogue, id=name, view={"position": [226.0 * i, 0.0]})
    network = network.connect("field", "samples", "model", "samples", catalogue)
    network = network.connect("model", "model", "contour", "model", catalogue)
    return network.connect("contour", "lines", "lines", "geometry", catalogue)


def put(canvas: Canvas, module: str, x: float, y: float, name: str = "") -> str:
    """Add a node without the mouse."""
    session = canvas.session
    network = session.network.add(module, session.catalogue, id=name, view={"position": [x, y]})
    session.edit("Add", network)
    canvas.fit()
    return next(n for n in network.nodes if network.nodes[n].view["position"] == [x, y])


def socket(canvas: Canvas, node: str, name: str, out: bool, slot: int = 0) -> QPoint:
    item = canvas.board.nodes[node]
    plug = item.plug(name, out, slot)
    assert plug is not None
    return canvas.mapFromScene(item.where(plug))


def head(canvas: Canvas, node: str) -> QPoint:
    return canvas.mapFromScene(canvas.board.nodes[node].scenePos() + QPointF(60, 14))


def drag(canvas: Canvas, start: QPoint, end: QPoint, *, button: Qt.MouseButton = LEFT, let_go: bool = True) -> None:
    view = canvas.viewport()
    QTest.mousePress(view, button, NONE, start)
    for i in range(1, 6):
        QTest.mouseMove(view, start + (end - start) * i / 5)
        send_move(canvas, start + (end - start) * i / 5, button)
    if let_go:
        QTest.mouseRelease(view, button, NONE, end)


def send_move(canvas: Canvas, at: QPoint, button: Qt.MouseButton = LEFT) -> None:
    place = QPointF(at)
    far = QPointF(canvas.viewport().mapToGlobal(at))
    event = QMouseEvent(QMouseEvent.Type.MouseMove, place, far, Qt.MouseButton.NoButton, button, NONE)
    QApplication.sendEvent(canvas.viewport(), event)


def item(canvas: Canvas, node: str) -> NodeItem:
    return canvas.board.nodes[node]


# --- wires


def test_dragging_from_an_output_to_a_port_connects_in_one_step(canvas: Canvas) -> None:
    points = put(canvas, "points", 678, 200)
    before = canvas.session.network
    drag(canvas, socket(canvas, "contour", "lines", True), socket(canvas, points, "geometry", False))
    assert canvas.session.network.wires[points, "geometry", 0] == ("contour", "lines")
    assert canvas.session.history.undo_label == "Connect"
    canvas.session.undo()
    assert canvas.session.network.wires == before.wires


def test_dragging_from_an_input_to_an_output_connects_too(canvas: Canvas) -> None:
    points = put(canvas, "points", 678, 200)
    drag(canvas, socket(canvas, points, "geometry", False), socket(canvas, "contour", "lines", True))
    assert canvas.session.network.wires[points, "geometry", 0] == ("contour", "lines")


def test_what_fits_grows_and_what_does_not_fades_and_says_why(canvas: Canvas, qtbot: Any) -> None:
    image = put(canvas, "image", 226, 200)
    target = socket(canvas, "lines", "geometry", False)
    drag(canvas, socket(canvas, "model", "model", True), target, let_go=False)
    verdicts = item(canvas, "contour").verdicts
    assert verdicts is not None and verdicts["model", False].fits
    assert (found := item(canvas, image).verdicts) is not None and found["samples", False].fits  # Samples also take a Model
    lines = item(canvas, "lines").verdicts
    assert lines is not None and not lines["geometry", False].fits
    qtbot.waitUntil(canvas.bubble.isVisible, timeout=1000)
    assert "needs a Geometry, got a Model" in canvas.bubble.title and "such as Contour" in canvas.bubble.text
    QTest.mouseRelease(canvas.viewport(), LEFT, NONE, target)
    assert canvas.session.network.wires["lines", "geometry", 0] == ("contour", "lines")
    assert item(canvas, "contour").verdicts is None and not canvas.bubble.isVisible()


def test_a_wire_that_would_close_a_circle_says_so(canvas: Canvas) -> None:
    drag(canvas, socket(canvas, "contour", "lines", True), socket(canvas, "model", "samples", False), let_go=False)
    verdicts = item(canvas, "model").verdicts
    assert verdicts is not None and "circle" in verdicts["samples", False].why
    QTest.keyClick(canvas, Qt.Key.Key_Escape)
    assert canvas.gesture is None and item(canvas, "model").verdicts is None


@pytest.mark.parametrize(
    ("source", "output", "target", "port", "between"),
    [("field", "samples", "contour-1", "model", "interpolate-1"), ("contour", "lines", "view-1", "layers", "lines-1")],
)
def test_a_converter_goes_between_on_release(
    canvas: Canvas, source: str, output: str, target: str, port: str, between: str
) -> None:
    assert put(canvas, target.split("-")[0], 678, 240) == target
    steps = canvas.session.history.place
    drag(canvas, socket(canvas, source, output, True), socket(canvas, target, port, False), let_go=False)
    over = canvas.gesture.over  # type: ignore[union-attr]
    assert over[2].converters[0] == between.split("-")[0] and canvas.gesture.loose.dotted  # type: ignore[union-attr]
    QTest.mouseRelease(canvas.viewport(), LEFT, NONE, socket(canvas, target, port, False))
    network = canvas.session.network
    assert network.wires[target, port, 0][0] == between and canvas.session.history.place == steps + 1


def test_a_port_that_has_a_wire_takes_the_new_one(canvas: Canvas) -> None:
    other = put(canvas, "interpolate", 226, 200)
    drag(canvas, socket(canvas, other, "model", True), socket(canvas, "contour", "model", False))
    assert canvas.session.network.wires["contour", "model", 0] == (other, "model")


def test_a_list_offers_one_more_place(canvas: Canvas) -> None:
    view = put(canvas, "view", 904, 0)
    drag(canvas, socket(canvas, "lines", "layer", True), socket(canvas, view, "layers", False))
    points = put(canvas, "points", 678, 200)
    free = item(canvas, view).plug("layers", False, 1)
    assert free is not None and free.free
    drag(canvas, socket(canvas, points, "layer", True), socket(canvas, view, "layers", False, 1))
    wires = canvas.session.network.incoming[view]["layers"]
    assert wires == (("lines", "layer"), (points, "layer"))
    drag(canvas, socket(canvas, view, "layers", False, 0), QPoint(400, 500))
    assert canvas.session.network.incoming[view]["layers"] == ((points, "layer"),)


def test_pulling_a_wire_off_disconnects_or_moves_it(canvas: Canvas) -> None:
    other = put(canvas, "contour", 452, 200)
    drag(canvas, socket(canvas, "contour", "model", False), socket(canvas, other, "model", False))
    assert canvas.session.network.wires.get((other, "model", 0)) == ("model", "model")
    assert ("contour", "model", 0) not in canvas.session.network.wires
    assert canvas.session.history.undo_label == "Move wire"
    drag(canvas, socket(canvas, other, "model", False), QPoint(300, 560))
    assert (other, "model", 0) not in canvas.session.network.wires and canvas.session.history.undo_label == "Disconnect"


def test_the_twin_socket_goes_to_an_accuracy_mapper(canvas: Canvas) -> None:
    dust = put(canvas, "dust", 678, 200)
    drag(canvas, socket(canvas, "contour", "lines:accuracy", True), socket(canvas, dust, "accuracy", False))
    assert canvas.session.network.wires[dust, "accuracy", 0] == ("contour", "lines:accuracy")


def test_a_click_on_a_wire_selects_it_and_asks_for_its_budget(canvas: Canvas, qtbot: Any) -> None:
    middle = canvas.mapFromScene(canvas.board.lines["contour", "model", 0].path.pointAtPercent(0.5))
    with qtbot.waitSignal(canvas.wireSelected) as said:
        QTest.mouseClick(canvas.viewport(), LEFT, NONE, middle)
    assert said.args == ["model", "model"] and canvas.wire == ("contour", "model", 0)
    QTest.keyClick(canvas, Qt.Key.Key_Delete)
    assert ("contour", "model", 0) not in canvas.session.network.wires


def test_a_node_dropped_on_a_wire_goes_between(canvas: Canvas) -> None:
    stated = put(canvas, "state_accuracy", 120, 200)
    target = canvas.board.lines["model", "samples", 0].path.pointAtPercent(0.5)
    center = item(canvas, stated).scene_rect().center()
    drag(canvas, head(canvas, stated), head(canvas, stated) + canvas.mapFromScene(target) - canvas.mapFromScene(center))
    network = canvas.session.network
    assert network.wires[stated, "samples", 0] == ("field", "samples")
    assert network.wires["model", "samples", 0] == (stated, "samples")
    assert canvas.session.history.undo_label == "Insert into wire"


def test_a_double_click_bends_a_wire_and_the_dot_can_be_dragged(canvas: Canvas) -> None:
    session, end = canvas.session, ("contour", "model", 0)
    middle = canvas.mapFromScene(canvas.board.lines[end].path.pointAtPercent(0.5))
    QTest.mouseDClick(canvas.viewport(), LEFT, NONE, middle)
    (dot,) = canvas.board.lines[end].dots
    at = canvas.mapFromScene(QPointF(*dot))
    drag(canvas, at, at + QPoint(0, 120))
    assert canvas.board.lines[end].dots == ((dot[0], dot[1] + 120),)
    back = document.loads(document.dumps(session.network, session.catalogue), session.catalogue).network
    assert back.extras["canvas"]["bends"] == {"model.model -> contour.model": [[dot[0], dot[1] + 120]]}
    session.undo()
    assert canvas.board.lines[end].dots == (dot,)
    QTest.mouseDClick(canvas.viewport(), LEFT, NONE, at)
    assert canvas.board.lines[end].dots == () and "canvas" not in session.network.extras


# --- nodes


def test_a_drag_is_one_edit_on_the_grid(canvas: Canvas) -> None:
    steps, start = canvas.session.history.place, head(canvas, "contour")
    drag(canvas, start, start + QPoint(37, 61), let_go=False)
    assert canvas.session.history.place == steps
    line = canvas.board.lines["lines", "geometry", 0]
    assert line.path.pointAtPercent(0).y() == pytest.approx(44 + item(canvas, "contour").y())
    QTest.mouseRelease(canvas.viewport(), LEFT, NONE, start + QPoint(37, 61))
    x, y = canvas.session.network["contour"].view["position"]
    assert (x, y) == (488, 64)  # 452 + 37 and 61 on the grid of 8
    assert canvas.session.history.place == steps + 1
    canvas.session.undo()
    assert item(canvas, "contour").pos() == QPointF(452, 0)


def test_escape_puts_a_drag_back(canvas: Canvas) -> None:
    network, start = canvas.session.network, head(canvas, "contour")
    drag(canvas, start, start + QPoint(80, 80), let_go=False)
    QTest.keyClick(canvas, Qt.Key.Key_Escape)
    assert item(canvas, "contour").pos() == QPointF(452, 0) and canvas.session.network is network


def test_selecting_by_click_shift_and_band(canvas: Canvas) -> None:
    session = canvas.session
    clicks = [(NONE, "field", ["field"]), (SHIFT, "model", ["field", "model"]), (CTRL, "field", ["model"])]
    for keys, name, expected in clicks:
        QTest.mouseClick(canvas.viewport(), LEFT, keys, head(canvas, name))
        assert list(session.selection) == expected and item(canvas, name).chosen == (name in expected)
    corner = canvas.mapFromScene(QPointF(440, -40))
    drag(canvas, corner, canvas.mapFromScene(QPointF(840, 120)))
    assert set(session.selection) == {"contour", "lines"} and canvas.band.isNull()
    QTest.mouseClick(canvas.viewport(), LEFT, NONE, QPoint(500, 20))
    assert session.selection == ()
    QTest.keyClick(canvas, Qt.Key.Key_A, CTRL)
    assert len(session.selection) == 4


def test_arrow_keys_nudge_and_move_the_view(canvas: Canvas) -> None:
    canvas.session.select(["contour", "lines"])
    QTest.keyClick(canvas, Qt.Key.Key_Down)
    QTest.keyClick(canvas, Qt.Key.Key_Right, SHIFT)
    assert canvas.session.network["lines"].view["position"] == [678 + 32, 8]
    canvas.hands.align("left")
    assert canvas.session.network["lines"].view["position"][0] == canvas.session.network["contour"].view["position"][0]


def test_alt_and_arrows_go_from_node_to_node(canvas: Canvas) -> None:
    alt = Qt.KeyboardModifier.AltModifier
    for key, expected in ((Qt.Key.Key_Right, "field"), (Qt.Key.Key_Right, "model"), (Qt.Key.Key_Left, "field")):
        QTest.keyClick(canvas, key, alt)
        assert canvas.session.selection == (expected,)
    QTest.keyClick(canvas, Qt.Key.Key_Up, alt)
    assert canvas.session.selection == ("field",)


def test_delete_copy_paste_duplicate(canvas: Canvas) -> None:
    session = canvas.session
    session.select(["contour"])
    QTest.keyClick(canvas, Qt.Key.Key_D, CTRL)
    (twin,) = session.selection
    assert session.network.wires[twin, "model", 0] == ("model", "model")
    QTest.keyClick(canvas, Qt.Key.Key_Delete)
    assert twin not in session.network.nodes
    session.select(["contour", "lines"])
    QTest.keyClick(canvas, Qt.Key.Key_X, CTRL)
    assert set(session.network.nodes) == {"field", "model"}
    assert '"nonius-network"' in QGuiApplication.clipboard().text()
    QTest.keyClick(canvas, Qt.Key.Key_V, CTRL)
    assert ("contour", "model", 0) not in session.network.wires and ("lines", "geometry", 0) in session.network.wires
    session.undo()
    QTest.keyClick(canvas, Qt.Key.Key_V, CTRL | SHIFT)
    assert session.network.wires["contour", "model", 0] == ("model", "model")


def test_deleting_a_node_in_a_line_closes_the_line(canvas: Canvas) -> None:
    test_a_node_dropped_on_a_wire_goes_between(canvas)
    stated = next(n for n in canvas.session.network.nodes if n.startswith("state"))
    canvas.session.select([stated])
    canvas.hands.remove()
    assert canvas.session.network.wires["model", "samples", 0] == ("field", "samples")


def test_rename_by_f2_and_back(canvas: Canvas) -> None:
    canvas.session.select(["contour"])
    QTest.keyClick(canvas, Qt.Key.Key_F2)
    assert canvas.line.isVisible() and canvas.line.text() == "Contour"
    QTest.keyClicks(canvas.line, "Heights")
    QTest.keyClick(canvas.line, Qt.Key.Key_Return)
    assert item(canvas, "contour").title == "Heights" and canvas.session.history.undo_label == "Rename"
    canvas.rename()
    QTest.keyClicks(canvas.line, "other")
    QTest.keyClick(canvas.line, Qt.Key.Key_Escape)
    assert item(canvas, "contour").title == "Heights"
    canvas.hands.rename("contour", "")
    assert item(canvas, "contour").title == "Contour"


# --- frames and notes


def test_a_frame_is_saved_undone_and_takes_its_nodes_along(canvas: Canvas) -> None:
    session = canvas.session
    session.select(["contour", "lines"])
    QTest.keyClick(canvas, Qt.Key.Key_G, CTRL)
    QTest.keyClicks(canvas.line, "Drawing")
    QTest.keyClick(canvas.line, Qt.Key.Key_Return)
    back = document.loads(document.dumps(session.network, session.catalogue), session.catalogue).network
    assert back.extras["canvas"]["frames"][0]["title"] == "Drawing"
    (mark,) = canvas.board.marks
    title = canvas.mapFromScene(mark.scene_rect().topLeft() + QPointF(100, 10))
    drag(canvas, title, title + QPoint(0, 80))
    assert session.network["lines"].view["position"] == [678, 80]
    assert canvas.board.marks[0].pos().y() == -44 + 80
    for _ in range(3):
        session.undo()
    assert not canvas.board.marks and session.network["lines"].view["position"] == [678, 0]


def test_a_note_is_written_and_deleted(canvas: Canvas) -> None:
    canvas.hands.note(QPointF(0, 200))
    QTest.keyClicks(canvas.line, "Levels from the survey")
    QTest.keyClick(canvas.line, Qt.Key.Key_Return)
    assert canvas.board.marks[0].text == "Levels from the survey"
    QTest.mouseClick(canvas.viewport(), LEFT, NONE, canvas.mapFromScene(QPointF(60, 220)))
    QTest.keyClick(canvas, Qt.Key.Key_Delete)
    assert not canvas.board.marks and "canvas" not in canvas.session.network.extras


# --- looking


def wheel(canvas: Canvas, at: QPoint, turn: int) -> None:
    far = QPointF(canvas.viewport().mapToGlobal(at))
    event = QWheelEvent(
        QPointF(at), far, QPoint(), QPoint(0, turn), Qt.MouseButton.NoButton, NONE, Qt.ScrollPhase.NoScrollPhase, False
    )
    QApplication.sendEvent(canvas.viewport(), event)


def test_the_wheel_zooms_at_the_pointer(canvas: Canvas) -> None:
    at = head(canvas, "contour")
    spot = canvas.mapToScene(at)
    wheel(canvas, at, 240)
    assert canvas.zoom > 1.3 and canvas.zoom_box.scale.text() == f"{round(100 * canvas.zoom)} %"
    moved = canvas.mapToScene(at) - spot
    assert abs(moved.x()) < 2 and abs(moved.y()) < 2
    QTest.keyClick(canvas, Qt.Key.Key_Period)
    seen = canvas.mapToScene(canvas.viewport().rect()).boundingRect()
    assert seen.contains(canvas.board.bounds())


def test_panning_by_middle_button_and_by_space(canvas: Canvas) -> None:
    before = canvas.middle()
    drag(canvas, QPoint(500, 500), QPoint(400, 450), button=MIDDLE)
    assert canvas.middle().x() == pytest.approx(before.x() + 100, abs=2)
    QTest.keyPress(canvas, Qt.Key.Key_Space)
    drag(canvas, QPoint(500, 500), QPoint(600, 550))
    QTest.keyRelease(canvas, Qt.Key.Key_Space)
    assert canvas.middle().x() == pytest.approx(before.x(), abs=2) and canvas.popup is None


def test_find_goes_from_node_to_node(canvas: Canvas) -> None:
    QTest.keyClick(canvas, Qt.Key.Key_F, CTRL)
    QTest.keyClicks(canvas.finder.field, "l")
    assert canvas.finder.isVisible() and canvas.session.selection == ("field",)
    QTest.keyClick(canvas.finder.field, Qt.Key.Key_Return)
    assert canvas.session.selection == ("model",)
    QTest.keyClick(canvas.finder.field, Qt.Key.Key_Escape)
    assert not canvas.finder.isVisible()


def test_the_map_goes_where_it_is_clicked(canvas: Canvas) -> None:
    before = canvas.middle().x()
    QTest.mouseClick(canvas.minimap, LEFT, NONE, QPoint(4, 36))
    assert canvas.middle().x() < before - 50


def test_the_menu_of_a_node_holds_and_disables(canvas: Canvas) -> None:
    menu = QMenu()
    context.fill(menu, canvas, item(canvas, "contour"), None, QPoint())
    acts: dict[str, Callable[[], None]] = {a.text(): a.trigger for a in menu.actions() if a.text()}
    assert {"Fire", "Hold", "Disable", "Run to here", "Help"} <= set(acts)
    acts["Disable"]()
    assert canvas.session.network["contour"].disabled and item(canvas, "contour").kind == "disabled"
    asked: list[str] = []
    canvas.helpRequested.connect(asked.append)
    acts["Help"]()
    assert asked == ["mappers.contour.contour"]


# --- keeping equal to the network


def test_sync_touches_only_what_changed(canvas: Canvas) -> None:
    items = dict(canvas.board.nodes)
    session = canvas.session
    network = session.network.set("contour", "interval", 5.0, session.catalogue)
    assert canvas.board.sync(network) == 1
    assert canvas.board.sync(network) == 0
    assert all(canvas.board.nodes[n] is i for n, i in items.items()) and "5" in item(canvas, "contour").first


def test_a_module_that_is_not_here_keeps_its_wires(canvas: Canvas) -> None:
    session = canvas.session
    nodes = {**session.network.nodes, "surfer": Node("surfer", "acme.surfer", view={"position": [452, 200]})}
    wires = {**session.network.wires, ("surfer", "field", 0): ("model", "model"), ("lines", "colours", 0): ("surfer", "map")}
    session.edit("Load", Network(nodes, wires))
    surfer = item(canvas, "surfer")
    assert surfer.kind == "missing" and surfer.plug("field", False) and surfer.plug("map", True)
    assert picture(canvas).width() > 0


def picture(canvas: Canvas) -> QImage:
    image = QImage(canvas.size(), QImage.Format.Format_RGB32)
    painter = QPainter(image)
    canvas.render(painter)
    painter.end()
    return image


@pytest.mark.parametrize("zoom", [1.5, 0.5, 0.2])
def test_it_draws_at_every_zoom_in_both_themes(canvas: Canvas, zoom: float) -> None:
    canvas.set_zoom(zoom)
    before = picture(canvas)
    style.watch().theme = THEMES["light"]
    style.watch().changed.emit()
    after = picture(canvas)
    style.watch().theme = THEMES["dark"]
    style.watch().changed.emit()
    assert before.pixelColor(3, 3).lightness() < 60 < 200 < after.pixelColor(3, 3).lightness()


def test_an_empty_canvas_says_what_to_do_and_fits_what_comes(canvas: Canvas) -> None:
    network = canvas.session.network
    canvas.session.new()
    assert not canvas.board.nodes and picture(canvas).width()
    canvas.session.adopt(network, None)
    assert canvas.mapToScene(canvas.viewport().rect()).boundingRect().contains(canvas.board.bounds())


def test_a_thousand_nodes(canvas: Canvas, catalogue: Catalogue) -> None:
    nodes: dict[str, Node] = {}
    wires: dict[Socket, Origin] = {}
    before = ("", "")
    for i in range(250):
        for j, (stem, module, port, output) in enumerate((
            ("field", "readers.analytic.analytic", "", "samples"),
            ("model", "modellers.interpolate.interpolate", "samples", "model"),
            ("contour", "mappers.contour.contour", "model", "lines"),
            ("lines", "renderers.lines.lines", "geometry", "layer"),
        )):  # fmt: skip
            name = f"{stem}-{i}"
            nodes[name] = Node(name, module, view={"position": [226.0 * j + 1000 * (i % 10), 100.0 * (i // 10)]})
            if port:
                wires[name, port, 0] = before
            before = (name, output)
    many = Network(nodes, wires)
    board = Board(canvas.session, canvas.look)
    built = spent(lambda: board.sync(many))
    moved = min(spent(lambda i=i: board.sync(many.move({"contour-7": (0.0, float(i))}))) for i in range(5))  # type: ignore[misc]
    assert len(board.nodes) == 1000 and built < 2.0 and moved < built / 10


def spent(work: Callable[[], object]) -> float:
    """Seconds of this thread."""
    start = time.thread_time()
    work()
    return time.thread_time() - start


# --- guides


def test_a_node_that_is_dragged_is_attracted_by_edges_and_straight_wires(canvas: Canvas) -> None:
    session = canvas.session
    session.edit("Move", session.network.move({"lines": (700.0, 200.0)}))
    canvas.set_zoom(1.0)
    canvas.centerOn(600, 100)
    item, above = canvas.board.nodes["lines"], canvas.board.nodes["contour"]
    start = head(canvas, "lines")
    goal = QPointF(above.pos().x() + 3, 200 + 64) - item.pos()
    drag(canvas, start, start + goal.toPoint(), let_go=False)
    assert item.pos().x() == above.pos().x(), "left edges in line"
    assert any(line.x1() == line.x2() == above.pos().x() for line in canvas.guides)
    QTest.mouseRelease(canvas.viewport(), LEFT, NONE, start + goal.toPoint())
    assert not canvas.guides and session.network["lines"].view["position"][0] == above.pos().x()
    socket_at = above.plug("lines", True)
    mine = item.plug("geometry", False)
    assert socket_at is not None and mine is not None
    start = head(canvas, "lines")
    up = above.pos().y() + socket_at.y - mine.y - item.pos().y()
    drag(canvas, start, start + QPoint(250, round(up) + 3))
    assert item.where(mine).y() == above.where(socket_at).y(), "the wire is straight"


def test_far_from_any_guide_the_grid_holds(canvas: Canvas) -> None:
    item = canvas.board.nodes["lines"]
    start = head(canvas, "lines")
    drag(canvas, start, start + QPoint(57, 309))
    assert (item.pos().x() % 8, item.pos().y() % 8) == (0.0, 0.0)
