"""A node and its wires: anatomy, states, the words of accuracy."""

from itertools import pairwise
from typing import Any, get_args

import pytest
from PySide6.QtCore import QPointF
from PySide6.QtGui import QImage, QPainter

from app.engine.catalogue import Catalogue
from app.engine.network import Node
from app.gui import badges, glyphs, summary
from app.gui.badges import Known
from app.gui.budgets import Budget, Total
from app.gui.glyphs import Look
from app.gui.items import NodeItem
from app.gui.state import Kind, NodeState
from app.gui.wires import WireItem, beside, curve
from modules.data.terms import Missing

pytestmark = pytest.mark.usefixtures("qapp")


@pytest.fixture(scope="module")
def catalogue() -> Catalogue:
    made = Catalogue()
    made._rooms = True
    made.reload()
    return made


def node(catalogue: Catalogue, module: str, state: NodeState | None = None, **parameters: Any) -> NodeItem:
    record = catalogue.find(module)
    how = state or NodeState("clean", seconds=0.038)
    return NodeItem(Node(f"{module}-1", record.id, 1, parameters), record, Look("dark"), how, {})


def drawn(*paint: Any) -> QImage:
    image = QImage(400, 300, QImage.Format.Format_RGB32)
    image.fill(Look("dark")["canvas"])
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.translate(60, 60)
    for one in paint:
        one(painter)
    painter.end()
    return image


def test_anatomy_is_that_of_the_style(catalogue: Catalogue) -> None:
    item = node(catalogue, "contour", interval=100.0)
    into, out, twin = item.plug("model", False), item.plug("lines", True), item.plug("lines:accuracy", True)
    assert into and out and twin
    assert (into.x, into.y) == (0, 44) and (out.x, out.y) == (150, 44) and twin.y == 59
    assert (into.kind, out.kind, twin.kind) == ("Model", "Geometry", "Accuracy")
    assert item.rect.width() == 150 and item.rect.height() == 76
    assert "100" in item.first and "shoulder" in item.first
    assert item.plug_at(QPointF(3, 50)) is into and item.plug_at(QPointF(75, 40)) is None


def test_ports_stand_apart(catalogue: Catalogue) -> None:
    item = node(catalogue, "cell")
    for side in (True, False):
        heights = sorted(p.y for p in item.plugs if p.out is side)
        assert all(b - a >= 14 for a, b in pairwise(heights))
    assert item.size[1] > max(p.y for p in item.plugs)


def test_settings_have_sockets_on_demand(catalogue: Catalogue) -> None:
    item = node(catalogue, "contour")
    assert not any(p.kind == "Value" for p in item.plugs)
    item.show_settings(True)
    plug = next(p for p in item.plugs if p.name == "interval")
    assert plug.kind == "Value" and plug.free
    item.show_settings(False)
    item.set_wired({"interval": 1, "model": 1}, ())
    assert item.plug("interval", False) and not item.plug("levels", False)


def test_a_failure_is_told_inside_the_node(catalogue: Catalogue) -> None:
    state = NodeState("failed", sentence="No level lies in 682 to 2543 m: choose levels between them, or leave them empty.")
    item = node(catalogue, "contour", state)
    assert item.size[0] == 264 and item.sentence.bottom() == item.size[1] and item.sentence.height() > 30
    assert item.set_state(NodeState("clean"), {}) and item.size == (150, 76)


@pytest.mark.parametrize("kind", get_args(Kind))
def test_each_state_has_its_own_shape(catalogue: Catalogue, kind: Kind) -> None:
    look = Look("light")
    others = [k for k in get_args(Kind) if k != kind]
    mine = drawn(lambda p: glyphs.state(p, kind, QPointF(), look, 0.4))
    assert all(drawn(lambda p, k=k: glyphs.state(p, k, QPointF(), look, 0.4)) != mine for k in others)


def test_each_type_has_its_own_shape() -> None:
    kinds = ("Samples", "Model", "Geometry", "Layer", "Scene", "Table", "Value", "ColourMap", "Accuracy")
    grey = Look("dark")
    grey.port = lambda kind: grey["text"]  # type: ignore[method-assign]
    pictures = [drawn(lambda p, k=k: glyphs.port(p, k, QPointF(), grey, scale=2)) for k in kinds]
    assert all(a != b for i, a in enumerate(pictures) for b in pictures[i + 1 :])


def test_two_lines_say_what_and_how(catalogue: Catalogue) -> None:
    record = catalogue.find("readers.elevation.elevation")
    assert summary.does(Node("r", record.id, 1, {"path": "data/SainteHelens.dem"}), record).startswith("SainteHelens.dem")
    assert summary.went(NodeState("clean", seconds=0.038), {"lines": {"shape": (467, 327)}}) == "38\u00a0ms · 327 × 467"
    assert summary.went(NodeState("running", progress=0.43), {}) == "43 %"
    assert summary.went(NodeState("cached", reused=True), {}) == "cached"
    assert summary.elapsed(75) == "1 min 15 s" and summary.elapsed(2.04) == "2.0\u00a0s"
    assert summary.title(Node("r", record.id, view={"title": "Survey"}), record) == "Survey"
    for one in catalogue:
        assert summary.does(Node("n", one.id), one)


def total(rigour: str, value: float = 0.5) -> Total:
    return Total("value", "m", "", rigour, "0.5 m", value, value, 0.0, 1, 1, "point")


@pytest.mark.parametrize(
    ("totals", "missing", "expected"),
    [
        ((), (), Known("exact")),
        ((), (Missing("survey"),), Known("unknown")),
        ((total("exact", 0.0),), (), Known("exact")),
        ((total("proven"),), (), Known("proven", "0.5 m")),
        ((total("estimated"),), (Missing("survey"),), Known("estimated", "0.5 m", True)),
        ((total("sampled"),), (), Known("sampled", "0.5 m")),
    ],
)
def test_a_badge_never_leaves_out_what_is_missing(totals: Any, missing: Any, expected: Known) -> None:
    assert badges.known(Budget((), totals, missing, (), 2.0)) == expected
    assert badges.known(None) is None


def test_the_five_words_draw_five_wires() -> None:
    look = Look("dark")
    pens = {w: badges.second_line(w, look) for w in ("exact", "proven", "estimated", "sampled", "unknown")}
    assert pens["exact"] is None
    patterns = [(p.dashPattern(), p.color().name(), p.widthF()) for p in pens.values() if p]
    assert len({str(p) for p in patterns}) == 4
    pictures = [drawn(lambda p, w=w: badges.badge(p, Known(w, "1 m"), QPointF(60, 20), look)) for w in pens]
    assert all(a != b for i, a in enumerate(pictures) for b in pictures[i + 1 :])
    assert badges.width(Known("proven", "1 m", True)) > badges.width(Known("proven", "1 m"))


def test_the_second_line_lies_five_pixels_under() -> None:
    level = curve(QPointF(0, 0), QPointF(100, 0))
    assert beside(level).pointAtPercent(0.5) == QPointF(50, 5)
    bent = curve(QPointF(0, 0), QPointF(200, 120))
    under = beside(bent)
    for t in (0.1, 0.5):
        spot = under.pointAtPercent(t)
        assert 3 < min((spot - bent.pointAtPercent(s / 100)).manhattanLength() for s in range(101)) < 8


def test_a_short_wire_carries_its_badge_above() -> None:
    wire = WireItem(("b", "in", 0), ("a", "out"), "Model", Look("dark"))
    wire.known = Known("proven", "1 m")
    wire.route(QPointF(0, 0), QPointF(76, 0))
    assert wire.badge_at() == QPointF(38, -17)
    wire.route(QPointF(0, 0), QPointF(20, 0))
    assert wire.badge_at().y() < -44
    wire.route(QPointF(0, 0), QPointF(300, 0))
    assert wire.badge_at() == QPointF(150, 0)
    assert wire.shape().contains(QPointF(150, 4)) and not wire.shape().contains(QPointF(150, 12))
