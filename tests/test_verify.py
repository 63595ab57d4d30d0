"""`nonius verify`: rules that are wrong are found, rules that are right are left alone."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.engine import document
from app.engine.catalogue import Catalogue
from app.verify.findings import Report
from app.verify.study import verify
from modules.api import Geometry, Identity, Progress, Samples, regular
from modules.progress import Cancelled, Stop
from tests.conftest import Said, network, node

FIELD = node("field", "readers.analytic.analytic", formula="sin(3*x)*cos(2*y)", samples=[25, 22], noise=0.004)
SMOOTH = node("smooth", "modellers.smooth.smooth")
GRADIENT = node("gradient", "modellers.gradient.gradient")
STEPS = node("steps", "modellers.quantise.quantise", step=0.05)
MODEL = node("model", "modellers.interpolate.interpolate")
CONTOUR = node("contour", "mappers.contour.contour", levels=[-0.3, 0.2])

SLOPES = network(FIELD, SMOOTH, GRADIENT, wires=("field.samples -> smooth.samples", "smooth.samples -> gradient.samples"))
LINES = network(
    FIELD, STEPS, MODEL, CONTOUR,
    wires=("field.samples -> steps.samples", "steps.samples -> model.samples", "model.model -> contour.model"),
)  # fmt: skip
PLAIN_LINES = network(FIELD, MODEL, CONTOUR, wires=("field.samples -> model.samples", "model.model -> contour.model"))


def catalogue(**wrong: Callable[..., Callable[..., Any]]) -> Catalogue:
    """Our modules, some with a wrong rule: tail of the id -> (right function -> wrong one)."""
    found = Catalogue()
    found._rooms = True
    found.reload()
    for tail, planted in wrong.items():
        record = found.find(tail)
        found._modules = {**found._modules, record.id: replace(record, function=planted(record.function))}
    return found


def judged(text: str, modules: Catalogue, runs: int = 5) -> Report:
    return verify(document.loads(text, modules).network, modules, runs=runs)


def terms(value: Any, change: Callable[[Any], Any]) -> Any:
    """A wire value with other terms."""
    accuracy = value.accuracy
    return replace(value, accuracy=replace(accuracy, terms=tuple(map(change, accuracy.terms))))


@pytest.mark.parametrize("text", [SLOPES, LINES, PLAIN_LINES], ids=["slopes", "lines of steps", "lines"])
def test_right_rules_are_left_alone(text: str) -> None:
    report = judged(text, catalogue())
    assert report.judged >= 8
    assert not report.wrong, [str(f) for f in report.wrong]


# --- wrong rules are found ---------------------------------------------------------------------------------------


def spacing_forgotten(right: Callable[..., Samples]) -> Callable[..., Samples]:
    """A gradient whose errors know nothing of the spacing."""

    def wrong(samples: Samples, **settings: Any) -> Samples:
        unit_cells = right(replace(samples, grid=regular(samples.grid.shape)), **settings)
        return replace(right(samples, **settings), accuracy=replace(unit_cells.accuracy, of=None))

    return wrong


def deviations_instead_of_operators(right: Callable[..., Samples]) -> Callable[..., Samples]:
    """A gradient that takes neighbours of a smoothed field to have nothing in common."""

    def flat(term: Any) -> Any:
        if term.kind != "linear":
            return term
        return replace(term, value=np.abs(term.error()).ravel(), operator=Identity(term.operator.shape[0]))

    return lambda samples, **settings: right(terms(samples, flat), **settings)


def wrong_sign(right: Callable[..., Samples]) -> Callable[..., Samples]:
    """A smoothing that states its bias the wrong way round."""

    def turned(term: Any) -> Any:
        return replace(term, value=-term.value) if term.name == "Smoothing" else term

    return lambda samples, progress, **settings: terms(right(samples, progress, **settings), turned)


def bound_too_small(right: Callable[..., Samples]) -> Callable[..., Samples]:
    """A rounding that claims an eighth of a step."""

    def less(term: Any) -> Any:
        return replace(term, value=term.value / 4) if term.name == "Rounding to steps" else term

    return lambda samples, **settings: terms(right(samples, **settings), less)


def half_the_noise(right: Callable[..., Samples]) -> Callable[..., Samples]:
    """A smoothing that averages the noise a second time."""

    def wrong(samples: Samples, progress: Progress, **settings: Any) -> Samples:
        once = right(samples, progress, **settings)
        return replace(once, accuracy=right(once, progress, **settings).accuracy)

    return wrong


def of_contour(change: Callable[[Any], Any]) -> Callable[[Callable[..., Geometry]], Callable[..., Geometry]]:
    def planted(right: Callable[..., Geometry]) -> Callable[..., Geometry]:
        return lambda model, progress, **settings: terms(right(model, progress, **settings), change)

    return planted


def triangle_for_arc(term: Any) -> Any:
    """The area of the triangle under an arc's farthest point, three quarters of the area of the arc."""
    return replace(term, value=term.value * 0.75) if term.quantity == "area" else term


def chord_too_near(term: Any) -> Any:
    """A farthest distance of the chords of half the size."""
    return replace(term, value=term.value / 2) if term.name == "Two chords a cell" else term


def slope_forgotten(term: Any) -> Any:
    """Errors of values handed on as errors of position."""
    return replace(term, operator=term.operator.first) if term.kind == "linear" and hasattr(term.operator, "first") else term


PLANTED: list[tuple[str, str, Callable[..., Any], str]] = [
    (SLOPES, "gradient", spacing_forgotten, "propagation"),
    (SLOPES, "gradient", deviations_instead_of_operators, "propagation"),
    (SLOPES, "smooth", wrong_sign, "estimate"),
    (SLOPES, "smooth", half_the_noise, "spread"),
    (LINES, "quantise", bound_too_small, "total"),
    (PLAIN_LINES, "contour", of_contour(triangle_for_arc), "area"),
    (PLAIN_LINES, "contour", of_contour(chord_too_near), "distance"),
    (PLAIN_LINES, "contour", of_contour(slope_forgotten), "propagation"),
]


@pytest.mark.parametrize(("text", "module", "wrong", "check"), PLANTED)
def test_a_wrong_rule_is_found(text: str, module: str, wrong: Callable[..., Any], check: str) -> None:
    report = judged(text, catalogue(**{module: wrong}), runs=4)
    first = report.wrong[0] if report.wrong else None
    assert first is not None and first.node in {"quantise": ("steps", "model")}.get(module, (module,)), report.verdict
    assert check in {f.check for f in report.wrong}, [str(f) for f in report.wrong]


# --- the command -------------------------------------------------------------------------------------------------


def test_the_command_says_what_holds_and_writes_it(nonius: Callable[..., Said], tmp_path: Path) -> None:
    file = tmp_path / "lines.json"
    file.write_text(PLAIN_LINES)
    said = nonius("verify", file, "--runs", "4", "--report", tmp_path / "report.json")
    assert said.code == 0, said.err
    assert "none of them wrong" in said.out
    written = json.loads((tmp_path / "report.json").read_text())
    assert written["wrong"] == 0 and written["judged"] >= 8


def test_too_few_runs_are_refused(nonius: Callable[..., Said], tmp_path: Path) -> None:
    file = tmp_path / "lines.json"
    file.write_text(PLAIN_LINES)
    assert nonius("verify", file, "--runs", "2").code == 2


def test_it_can_be_cancelled() -> None:
    stop, modules = Stop(), catalogue()
    stop.set()
    with pytest.raises(Cancelled):
        verify(document.loads(SLOPES, modules).network, modules, Progress(stop=stop), runs=4)


def test_a_network_without_data_judges_nothing() -> None:
    modules = catalogue()
    report = verify(document.loads(network(), modules).network, modules)
    assert not report.judged and not report.wrong and "Nothing could be judged" in report.verdict


