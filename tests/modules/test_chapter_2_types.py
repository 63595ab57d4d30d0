"""What chapter 2's later modules need is in the types now: a fake module for each family, declared and run.

Each is real enough to be declared, to be checked by the law of the budget, and to pass a wire between processes.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from modules.api import (
    EXACT,
    Accuracy,
    Cells,
    ChartLook,
    Colouring,
    ColourMap,
    Curvilinear,
    Field,
    Gather,
    Geometry,
    Identity,
    LabelLook,
    Layer,
    Missing,
    Model,
    NamedTuple,
    Primitive,
    Progress,
    Samples,
    Scene,
    SceneLook,
    Shown,
    Source,
    Spread,
    SurfaceLook,
    Table,
    Term,
    Text,
    Unstructured,
    Value,
    VolumeLook,
    accuracy_mapper,
    bound,
    deviation,
    mapper,
    modeller,
    reader,
    renderer,
    select,
    stencil,
)
from modules.data.accuracy import accuracies
from modules.declare import record_of

GREY = ColourMap("grey", np.array([[0.2, 0.2, 0.2], [0.9, 0.9, 0.9]]))


@reader("Wind")
def wind(*, seed: int = 0) -> Samples:
    """A vector field with a scanner's bias and noise (2.5).

    Accuracy: noise of each component, and one bias for all.
    """
    shape = (4, 5, 6, 3)
    values = np.random.default_rng(seed).normal(size=shape)
    noise = Term(Source("noise", "data", "estimated"), "linear", "value", "m/s", np.asarray(0.1), Identity(360), "point", 3)
    bias = Term(Source("bias", "data", "estimated"), "linear", "value", "m/s", np.asarray(0.2), Spread(360), "point", 3)
    return Samples.from_array(values, unit="m/s", name="wind", accuracy=EXACT.add(noise, bias).miss(Missing("drift")))


@reader("Bent grid")
def bent(*, n: int = 4) -> Samples:
    """Curvilinear samples (2.2).

    Accuracy: exact.
    """
    r, a = np.meshgrid(np.linspace(1, 2, n), np.linspace(0, 1, n + 1), indexing="xy")
    nodes = np.stack([r * np.cos(a), r * np.sin(a), 0 * r], axis=-1)
    return Samples(grid=Curvilinear(nodes), values=r, accuracy=EXACT)


@reader("Triangles")
def triangles(*, n: int = 4) -> Samples:
    """Unstructured samples (2.2).

    Accuracy: exact.
    """
    nodes = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    grid = Unstructured(nodes, np.array([0, 3, 6]), np.array([0, 1, 2, 1, 3, 2]), np.array([5, 5]))
    return Samples(grid=grid, values=np.arange(4.0), accuracy=EXACT.add(bound("b", 0.5, 4)))


@reader("Share prices")
def prices(*, days: int = 5) -> Table:
    """A table with a column of errors (figure 2.6).

    Accuracy: rounding of the price.
    """
    columns = {"day": np.arange(days), "price": np.linspace(1, 2, days)}
    return Table(columns=columns, units={"price": "£"}, accuracy=EXACT.add(bound("rounding", 0.005, days, quantity="price")))


@modeller("Velocity gradient")
def tensor(samples: Samples) -> Samples:
    """A tensor field, nine components a sample (2.6).

    Accuracy: differences of the samples' errors.
    """
    parts = [np.gradient(samples.values, axis=d) for d in (2, 1, 0)]
    n = samples.grid.count
    x = stencil((*samples.grid.shape, 3), 2, (-1, 0, 1), (-0.5, 0, 0.5))
    rows = Gather(np.repeat(np.arange(3 * n), 3)[:, None], np.asarray(1.0), 3 * n)
    accuracy = samples.accuracy.push(rows.after(x), components=9, unit="1/s")
    return Samples(grid=samples.grid, values=np.stack(parts, axis=-1), unit="1/s", accuracy=accuracy)


@modeller("Mean")
def mean(samples: Samples) -> Value:
    """One number with its error (2.4.1).

    Accuracy: noise averages out, a bias does not.
    """
    n = samples.values.size
    accuracy = samples.accuracy.push(Gather(np.arange(n)[None, :], np.full((1, n), 1 / n), n), components=1)
    return Value(value=float(samples.values.mean()), unit=samples.unit, accuracy=accuracy)


@mapper("Particle traces")
def traces(samples: Samples) -> Geometry:
    """Polylines with a time at each point, and an error that lives on its own points (2.5.2, 5.11).

    Accuracy: a local error at each step.
    """
    points = np.cumsum(np.ones((6, 3)), axis=0)
    own = Term(
        Source("global error", "mapping", "estimated"), "signed", "position", "m", np.zeros(6), Identity(6), "own", 3,
        points=points[:2],
    )  # fmt: skip
    return Geometry(
        points=points,
        lines=Cells.of([[0, 1, 2], [3, 4, 5]]),
        values={"time": Field(np.arange(6.0), "point", "s"), "velocity": Field(np.ones((6, 3)), "point", "m/s")},
        origin=np.array([0, 1]),
        time=0.5,
        accuracy=EXACT.add(own).end_from(samples.accuracy, "a fake").miss(*samples.accuracy.missing),
    )


class Fitted(NamedTuple):
    """A sphere, and how well it fits."""

    sphere: Geometry
    residuals: Table


@mapper("Fit a sphere")
def fit_sphere(samples: Samples) -> Fitted:
    """A sphere whose centre and radius carry their own errors (2.3.1).

    Accuracy: of centre and radius, from the residuals.
    """
    centre = Term(Source("fit", "mapping", "estimated"), "linear", "centre", "m", np.asarray(0.1), Identity(3), "point", 3)
    accuracy = EXACT.add(centre, bound("dr", 0.2, 1, quantity="radius", unit="m"))
    accuracy = accuracy.end_from(samples.accuracy, "entered through the residuals").miss(*samples.accuracy.missing)
    sphere = Primitive(kind="sphere", values={"centre": np.zeros(3), "radius": np.ones(1)}, accuracy=accuracy)
    shape = Geometry(points=np.zeros((0, 3)), primitives=(sphere,), accuracy=EXACT)
    table = Table(columns={"r": np.zeros(3)}, accuracy=EXACT.end_from(samples.accuracy, "a fake"))
    return Fitted(shape, table)


@mapper("LIC on a plane")
def lic(samples: Samples) -> Geometry:
    """A textured quadrilateral (2.5.5).

    Accuracy: ends here.
    """
    return Geometry(
        points=np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]),
        polygons=Cells.of([[0, 1, 2, 3]]),
        texture=np.zeros((8, 8, 3), np.uint8),
        texture_at=np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]),
        accuracy=EXACT.end_from(samples.accuracy, "a texture of noise").miss(*samples.accuracy.missing),
    )


@accuracy_mapper("Cuboids")
def cuboids(traces: Geometry, accuracy: Accuracy | None = None) -> Geometry:
    """A glyph at each second point, each knowing its origin (5.2.5).

    Accuracy: shows the position error; it goes on to the glyphs.
    """
    items = np.array([0, 2, 4])
    shown = traces.accept(accuracy)
    return Geometry(
        points=traces.points[items],
        vertices=Cells.of(np.arange(3)[:, None]),
        origin=items,
        shows=(Shown("global error", "position", factor=30.0),),
        accuracy=shown.end(None, "glyphs show it"),
    )


@renderer("Volume")
def volume(samples: Samples, colours: ColourMap | None = None) -> Layer:
    """A volume by its transfer function (2.4.6).

    Accuracy: as it comes.
    """
    look = VolumeLook(colouring=Colouring(by="", map=colours or GREY), opacity=(0.0, 0.2, 1.0))
    return Layer(shape=samples, look=look, accuracy=samples.accuracy)


@renderer("Curve")
def curve(table: Table) -> Layer:
    """A graph with its error (2.4.1).

    Accuracy: as it comes.
    """
    return Layer(shape=table, look=ChartLook(x="day", y="price"), accuracy=table.accuracy)


@renderer("Notes")
def notes(*, words: str = "a") -> Layer:
    """Words in a corner.

    Accuracy: none to speak of.
    """
    return Layer(shape=Text((words,), corner="top left"), look=LabelLook(), accuracy=EXACT)


@renderer("Sheet")
def sheet(shape: Geometry) -> Layer:
    """A surface.

    Accuracy: as it comes.
    """
    return Layer(shape=shape, look=SurfaceLook(), accuracy=shape.accuracy)


@renderer("All")
def all_layers(layers: list[Layer]) -> Scene:
    """A scene.

    Accuracy: of its layers.
    """
    return Scene(layers=tuple(layers), look=SceneLook(dimensions=3), accuracy=EXACT)


def run(function: Callable[..., Any], **inputs: Any) -> Any:
    record = record_of(function)
    outputs = record.call(inputs, {p.name: p.default for p in record.parameters}, Progress())
    for output in outputs.values():
        same = pickle.loads(pickle.dumps(output))
        assert [t.id for a in accuracies(same) for t in a.terms] == [t.id for a in accuracies(output) for t in a.terms]
    needed = {t.id for a in accuracies(inputs) for t in a.terms}
    for output in outputs.values():
        assert needed <= {i for a in accuracies(output) for i in a.accounted()}
    return outputs


def test_every_family_of_chapter_2_fits_the_types() -> None:
    field = run(wind)["samples"]
    assert field.components == 3
    gradients = run(tensor, samples=field)["samples"]
    assert (gradients.components, gradients.values.shape[-2:]) == (9, (3, 3))
    assert gradients.accuracy.terms[0].error().shape == (120, 9)
    average = run(mean, samples=field)["value"]
    assert average.accuracy.terms[0].size() == pytest.approx(0.1 / np.sqrt(360))
    assert average.accuracy.terms[1].size() == pytest.approx(0.2)
    lines = run(traces, samples=field)["geometry"]
    fitted = run(fit_sphere, samples=field)
    assert set(fitted) == {"sphere", "residuals"}
    texture = run(lic, samples=field)["geometry"]
    glyphs = run(cuboids, traces=lines)["geometry"]
    assert glyphs.origin.tolist() == [0, 2, 4]
    layers = [
        run(volume, samples=field)["layer"],
        run(curve, table=run(prices)["table"])["layer"],
        run(notes)["layer"],
        *[run(sheet, shape=g)["layer"] for g in (fitted["sphere"], texture, glyphs)],
    ]
    scene = run(all_layers, layers=layers)["scene"]
    assert scene.facts()["layers"] == 6
    assert {m.name for a in accuracies(scene) for m in a.missing} == {"drift"}


def test_bent_and_loose_grids_travel_but_are_not_sampled_yet() -> None:
    for samples, rigour in ((run(bent)["samples"], "estimated"), (run(triangles)["samples"], "unknown")):
        model = Model.between(samples)
        assert model.accuracy.rigour() == rigour
        with pytest.raises(ValueError, match="resample it to a regular grid first"):
            model.at([[0, 0, 0]])


def test_a_crop_to_nothing_keeps_the_terms() -> None:
    shape = run(traces, samples=run(wind)["samples"])["geometry"]
    nothing = select(np.zeros(0, np.int64), 4)
    accuracy = EXACT.add(deviation("s", 1.0, 4)).push(nothing)
    assert accuracy.terms[0].count == 0
    assert accuracy.total(2, "value").shape == (0,)
    assert accuracy.budget()[0].max == 0.0
    assert shape.accuracy.accounted()
