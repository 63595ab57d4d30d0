"""The budget view: total first, sources sorted, what is not known last and full length."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QRectF
from PySide6.QtGui import QImage, QPainter

from app.gui import style
from app.gui.bars import draw_bar
from app.gui.budget_view import BudgetView
from app.gui.budgets import budget_of
from app.gui.session import Session
from modules.data.accuracy import Accuracy, Missing
from modules.data.operators import Identity
from modules.data.terms import Source, Term


def term(name: str, size: float, rigour: str = "proven", kind: str = "bound", quantity: str = "position", n: int = 4) -> Term:
    return Term(Source(name, "mapping", rigour, "a rule"), kind, quantity, "m", np.asarray(size), Identity(n))  # type: ignore[arg-type]


def test_bounds_add_and_deviations_add_in_squares() -> None:
    spread = term("c", 3.0, "estimated", "linear"), term("d", 4.0, "estimated", "linear")
    accuracy = Accuracy((term("a", 1.0), term("b", 2.0), *spread))
    budget = budget_of(accuracy, 2.0)
    (total,) = budget.totals
    assert total.value == pytest.approx(3.0 + 2 * 5.0)
    assert total.bounds == pytest.approx(3.0)
    assert total.spread == pytest.approx(10.0)
    assert (total.sign, total.count, total.looked) == ("~", 4, 4)


def test_an_error_beyond_the_shape_does_not_drown_the_rest() -> None:
    size = np.ones(1000)
    size[:3] = 1e17
    wild = Term(Source("wild", "model", "estimated", ""), "bound", "position", "m", size, Identity(1000))
    budget = budget_of(Accuracy((wild,)), 2.0, reach=100.0)
    assert budget.totals[0].value == 1.0
    assert "no bound at 3 of 1000 points" in budget.totals[0].note
    assert budget.size(budget.lines[0]) == 1.0


def test_a_glance_says_how_many_it_looked_at() -> None:
    (total,) = budget_of(Accuracy((term("a", 1.0, n=50_000),)), 2.0).totals
    assert (total.looked, total.count) == (2000, 50_000)


def test_no_error_is_exact_and_a_missing_one_is_not() -> None:
    assert budget_of(Accuracy(()), 2.0).exact
    assert not budget_of(Accuracy((), missing=(Missing("survey", "not given"),)), 2.0).exact


def width(rigour: str, share: float) -> int:
    """Columns of the middle of a bar in which something is drawn."""
    image = QImage(200, 20, QImage.Format.Format_RGB32)
    image.fill(style.colour("panel"))
    painter = QPainter(image)
    draw_bar(painter, QRectF(0, 4, 200, 12), share, rigour)
    painter.end()
    ground = style.colour("panel").rgb()
    return sum(any(image.pixel(x, y) != ground for y in range(4, 16)) for x in range(200))


@pytest.mark.parametrize(("rigour", "share", "low", "high"), [
    ("proven", 0.5, 98, 102), ("estimated", 0.5, 98, 102), ("sampled", 0.5, 98, 102), ("exact", 0.0, 1, 3),
    ("unknown", 0.0, 180, 200),
])  # fmt: skip
def test_the_length_of_a_bar_in_each_pattern(qapp: Any, rigour: str, share: float, low: int, high: int) -> None:
    assert low <= width(rigour, share) <= high


def test_the_budget_of_the_chosen_node_is_shown(session_of: Callable[..., Session], qtbot: Any) -> None:
    from app.engine.catalogue import mine

    session = session_of(mine())
    view = BudgetView(session)
    qtbot.addWidget(view)
    network = session.network.add("readers.analytic.analytic", mine(), id="field", parameters={"noise": 0.01})
    session.edit("Add", network)
    session.select(["field"])
    qtbot.waitUntil(lambda: view.budget is not None, timeout=30000)
    rows = view.bars.rows
    assert rows
    shares = [r.share for r in rows if r.rigour != "unknown"]
    assert shares == sorted(shares, reverse=True)
    assert view.total.accessibleName()
