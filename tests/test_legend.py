"""What a picture says: what is drawn, what is not, what nobody gave, and never more than is known."""

import json
from typing import Any

import numpy as np
import pytest

from app.draw import numbers
from app.legend import legend
from modules.api import (
    EXACT,
    Accuracy,
    Cells,
    Field,
    Flag,
    Geometry,
    Identity,
    Layer,
    LineLook,
    Missing,
    PointLook,
    Scene,
    SceneLook,
    Shown,
    Source,
    SurfaceLook,
    Term,
    deviation,
)
from modules.renderers.surface import surface
from modules.renderers.view import view

N = 200


def term(name: str, values: Any, **given: Any) -> Term:
    more = {"kind": "bound", "rigour": "proven", "quantity": "position", **given}
    source = Source(name, "mapping", more.pop("rigour"))
    return Term(source, more.pop("kind"), more.pop("quantity"), "m", np.asarray(values, float), Identity(N), **more)


def line(accuracy: Accuracy = EXACT, *, origin: Any = None, **more: Any) -> Layer:
    points = np.column_stack([np.linspace(0, 1000, N), np.zeros(N), np.zeros(N)])
    shape = Geometry(
        points=points,
        lines=Cells.of([list(range(N))]) if origin is None else Cells.of([]),
        vertices=Cells.of([]) if origin is None else Cells.of(np.arange(N)[:, None]),
        origin=origin,
        accuracy=accuracy,
    )
    given = {"look": LineLook(), "title": "Contour lines every 100 m", **more}
    return Layer(shape=shape, accuracy=shape.accuracy, **given)


def scene(*layers: Any, **look: Any) -> Any:
    return Scene(layers=layers, look=SceneLook(**look), accuracy=EXACT)


def entries(*layers: Any, **more: Any) -> Any:
    told = legend(scene(*layers), **more)
    return {e.words: e for e in (*(e for b in told.drawn for e in b.entries), *told.not_drawn)}


def test_every_term_stands_with_its_sign_and_number() -> None:
    told = entries(
        line(
            Accuracy(
                terms=(
                    term("Chord", np.linspace(0, 0.0941, N)),
                    term("Interpolation", 5.71, rigour="estimated"),
                    deviation("Sensor", 0.04, N, quantity="position", unit="m"),
                    term("Joining", 0.0, rigour="exact"),
                    term("Draws", np.zeros(N), rigour="sampled"),
                )
            )
        )
    )
    assert {w: (e.sign, e.number) for w, e in told.items()} == {
        "Chord": ("≤", "0.095\u00a0m"),
        "Interpolation": ("~", "5.7\u00a0m"),
        "Sensor": ("~", "±0.08\u00a0m"),
        "Joining": ("=", "0"),
        "Draws": ("n=", "0"),
    }


def test_a_missing_source_stands_with_a_question_mark_and_no_number() -> None:
    told = entries(line(Accuracy(missing=(Missing("Survey error"), Missing("Datum", "older than the map")))))
    assert told["Survey error not given"].sign == told["Datum: older than the map"].sign == "?"
    assert told["Survey error not given"].number == ""


def test_standard_deviations_are_told_times_k_and_bounds_are_not() -> None:
    accuracy = Accuracy(terms=(deviation("Sensor", 1.0, N, quantity="position", unit="m"), term("Chord", 1.0)))
    told = entries(line(accuracy), k=3.0)
    assert told["Sensor"].number == "±3\u00a0m"
    assert told["Chord"].number == "1\u00a0m"
    assert "k = 3" in legend(scene(line(accuracy)), k=3.0).footer


def test_a_proven_bound_is_rounded_up_so_that_it_stays_one() -> None:
    assert numbers.significant(0.0941, up=True) == "0.095"
    assert numbers.significant(0.0941) == "0.094"
    assert numbers.significant(0.1 + 0.2, up=True) == "0.3"
    assert numbers.significant(99.1, up=True) == "100"
    assert numbers.significant(1234.0, up=True) == "1300"
    assert numbers.significant(3.2e7) == "3.2\u2009×\u200910⁷"
    assert numbers.quantity(3.31e6, "m²") == "3.3\u00a0km²"


def test_what_is_shown_stands_with_the_layer_and_the_rest_under_not_drawn() -> None:
    accuracy = Accuracy(terms=(term("Chord", 1.0), term("Interpolation", 2.0, rigour="estimated")))
    told = legend(scene(line(accuracy, shows=(Shown("Chord", "position", "1 point = 34 m²"),))))
    (block,) = told.drawn
    assert [e.words for e in block.entries] == ["Chord"]
    assert block.entries[0].notes[-1] == "1 point = 34 m²"
    assert [e.words for e in told.not_drawn] == ["Interpolation"]


@pytest.mark.parametrize(("factor", "boxes"), [(1.0, ()), (10.0, ("errors ×10",)), (2.5, ("errors ×2.5",))])
def test_an_exaggeration_stands_in_a_box_whenever_it_is_not_one(factor: Any, boxes: Any) -> None:
    told = legend(scene(line(Accuracy(terms=(term("Chord", 1.0),)), shows=(Shown("Chord", "position", "", factor),))))
    assert told.drawn[0].boxes == boxes
    assert all(box in told.caption for box in boxes)


def test_exaggerated_heights_stand_in_a_box_too() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 1]], float)
    shape = Geometry(points=corners, polygons=Cells.of([[0, 1, 2]]), accuracy=EXACT)
    told = legend(view([surface(shape)], exaggeration=5.0))
    assert ("heights ×5",) in [b.boxes for b in told.drawn]


def test_the_same_source_on_two_layers_is_told_once() -> None:
    shared = term("Chord", 1.0)
    told = legend(scene(line(Accuracy(terms=(shared,))), line(Accuracy(terms=(shared,)), title="Again")))
    assert [e.words for e in told.not_drawn] == ["Chord"]


def test_a_total_over_segments_is_not_taken_from_the_dust_that_shows_it() -> None:
    area = Term(Source("Area", "mapping", "exact"), "metric", "area", "m²", np.full(N - 1, 2.0), Identity(N - 1), "segment")
    dust = Term(area.source, "metric", "area", "m²", np.full(N, 2.0), Identity(N), "point", id=area.id)
    shown = (Shown("Area", "area", "1 point = 1 m²"),)
    lines = line(Accuracy(terms=(area,)))
    cloud = line(Accuracy(terms=(dust,)), title="", shows=shown, look=PointLook(), origin=np.zeros(N, int))
    for layers in ((lines, cloud), (cloud, lines)):
        told = legend(scene(*layers))
        (block,) = [b for b in told.drawn if b.entries]
        assert block.title == lines.title
        assert (block.entries[0].number, block.entries[0].statistic) == ("400\u00a0m²", "in all")
        assert block.entries[0].swatch is not None and block.entries[0].swatch.kind == "dust"
    alone = legend(scene(cloud)).drawn[0].entries[0]
    assert (alone.number, alone.statistic) == ("2\u00a0m²", "largest")


def test_an_error_beyond_the_picture_is_told_by_its_95_per_cent_and_where_it_fails() -> None:
    size = np.full(N, 3.0)
    size[:4] = 1e150
    told = entries(line(Accuracy(terms=(term("Interpolation", size, rigour="estimated"),))))["Interpolation"]
    assert (told.number, told.statistic, told.beyond, told.value) == ("3\u00a0m", "95 %", 4, None)
    assert told.notes == ("on 95 %; leaves the picture at 4 of 200 points",)
    everywhere = entries(line(Accuracy(terms=(term("Interpolation", np.full(N, 1e150)),))))["Interpolation"]
    assert everywhere.number == "∞"


def test_a_few_large_errors_do_not_stand_for_all() -> None:
    size = np.full(N, 0.031)
    size[0] = 0.139
    assert entries(line(Accuracy(terms=(term("Chord", size),))))["Chord"].notes == ("0.031\u00a0m on 95 % of the points",)


def test_equal_names_are_told_apart_by_their_quantity() -> None:
    accuracy = Accuracy(terms=(term("Rounding", 0.5, id="a"), term("Rounding", 5.0, quantity="value", id="b")))
    assert set(entries(line(accuracy))) == {"Rounding, in position", "Rounding, in the value"}


def test_flags_are_counted_and_the_same_one_on_two_layers_counts_once() -> None:
    risk = Flag("saddle close to a level", "a sentence", "point", np.arange(24))
    whole = Flag("unproven", "a sentence")
    one, two = line(Accuracy(flags=(risk, whole))), line(Accuracy(flags=(risk,)))
    assert legend(scene(one, two)).flags == ("a sentence", "saddle close to a level: 24 places")
    long = Flag("assumed", "what is on the whole is told in its own words (set 'lengths'); " + "and details are left out " * 5)
    assert legend(scene(line(Accuracy(flags=(long,))))).flags == ("what is on the whole is told in its own words",)


def test_a_combined_error_that_is_shown_covers_its_terms() -> None:
    accuracy = Accuracy(terms=(term("Chord", 1.0), deviation("Sensor", 1.0, N, quantity="position", unit="m")))
    told = legend(scene(line(accuracy, shows=(Shown("Total error", "position"),))))
    assert (told.drawn[0].entries[0].number, told.not_drawn) == ("3\u00a0m", ())


def test_colours_are_told_by_a_bar_with_a_plus_where_they_are_cut_off() -> None:
    shape = Geometry(
        points=np.array([[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0]], float),
        polygons=Cells.of([[0, 1, 2], [0, 2, 3]]),
        values={"error": Field(np.array([0.01, 0.2]), "cell", "cell")},
        accuracy=EXACT,
    )
    bar = legend(view([surface(shape, colour_by="error", map="errors", high=0.08)])).drawn[0].bar
    assert bar is not None
    assert (bar.low, bar.high, bar.over, bar.under, bar.unit) == (0.0, 0.08, True, False, "cell")


def test_the_caption_says_it_in_at_most_three_sentences() -> None:
    accuracy = Accuracy(
        terms=(term("Chord", 0.09), term("Interpolation", 5.7, rigour="estimated")), missing=(Missing("Survey error"),)
    )
    caption = legend(scene(line(accuracy, shows=(Shown("Chord", "position", "", 10.0),)), title="Mount")).caption
    assert caption.count(". ") + 1 <= 3
    for words in ("at most 0.09", "errors ×10", "about 5.7", "Survey error not given", "may be larger"):
        assert words in caption


def test_a_layer_that_knows_nothing_does_not_look_exact() -> None:
    surfaces = line(Accuracy(missing=(Missing("accuracy", "the file says nothing"),)), look=SurfaceLook())
    assert [e.sign for e in legend(scene(surfaces)).not_drawn] == ["?"]


def test_the_legend_is_plain_data() -> None:
    told = legend(scene(line(Accuracy(terms=(term("Chord", np.full(N, 1e200)),)))))
    assert json.loads(json.dumps(told.plain(), allow_nan=False))["not_drawn"][0]["value"] is None
    assert "≤ ∞ Chord" in told.lines()


def test_evaluation_reports_and_can_be_stopped() -> None:
    class Enough(Exception):
        pass

    def stop(fraction: Any) -> None:
        assert 0 <= fraction <= 1
        raise Enough

    with pytest.raises(Enough):
        legend(scene(line(Accuracy(terms=(term("Chord", 1.0),)))), check=stop)
