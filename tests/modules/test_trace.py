"""The mapper `trace`, through its public door: traces, their terms, and what it refuses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator
from scipy.sparse.linalg import spsolve

from modules.api import EXACT, Curvilinear, Geometry, Model, Progress, Rectilinear, Regular, Samples, Unstructured
from modules.data.grid import lattice_of
from modules.data.laws import Linear
from modules.mappers._trace_answers import answers_along
from modules.mappers._trace_field import located, medium
from modules.mappers._trace_run import answers, follow
from modules.mappers.compare_traces import compare_traces
from modules.mappers.seeds import seeds
from modules.mappers.trace import trace
from modules.modellers.interpolate import interpolate
from modules.progress import Cancelled, Stop
from modules.readers.analytic import analytic
from tests.oracles.traces import exact

ABC = "1.7320508*sin(z)+cos(y);1.4142136*sin(x)+1.7320508*cos(z);sin(y)+1.4142136*cos(x)"


def abc(noise: float = 0.0, seed: int = 1) -> Model:
    box: dict[str, Any] = {"low": (0, 0, 0), "high": (2 * np.pi,) * 3, "samples": (11, 11, 11)}
    return interpolate(analytic(formula=ABC, unit="m/s", lengths="m", noise=noise, seed=seed, **box))


def some(model: Model, count: int = 6) -> Geometry:
    return seeds(model, arrangement="random", count=count, first=(2, 2, 2), last=(4, 4, 4))


def term(traces: Geometry, name: str) -> Any:
    (found,) = [t for t in traces.accuracy.terms if t.name == name]
    return found


def test_lines_with_times_and_how_they_end() -> None:
    model = abc()
    traces, ends = trace(model, some(model), Progress(), interval=0.1, end_time=0.55)
    assert len(traces.polylines()) == 6 and len(ends.columns["reason"]) == 6
    times = traces.values["time"].values.reshape(6, -1)
    assert times[0] == pytest.approx([0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.55])
    assert traces.values["time"].unit == "s"
    assert set(ends.columns["reason"]) == {"end time"}
    at, _ = model.at(traces.points)
    assert traces.values["velocity"].values == pytest.approx(at, abs=1e-9)


def test_both_directions_are_one_line_through_the_seed() -> None:
    model = abc()
    start = some(model, 3)
    traces, ends = trace(model, start, Progress(), interval=0.1, end_time=0.3, direction="both")
    for line, seed, times in zip(
        traces.polylines(), start.points, traces.values["time"].values.reshape(3, -1), strict=True
    ):
        assert times == pytest.approx(np.arange(-3, 4) * 0.1)
        assert line[3] == pytest.approx(seed)
    assert len(ends.columns["seed"]) == 6
    error = term(traces, "Integration").size().reshape(3, -1)
    assert (error[:, 3] == 0).all() and (error[:, [0, -1]] > 0).all()


def test_the_estimate_is_the_error_either_way() -> None:
    model = abc()
    start = some(model, 20)
    common: dict[str, Any] = {"interval": 0.1, "end_time": 0.5}
    fine = trace(model, start, Progress(), tolerance=1e-12, carry=False, **common).traces
    for kind in ("half steps", "re-integration"):
        coarse = trace(model, start, Progress(), tolerance=1e-4, estimate=kind, **common).traces
        assert coarse.counts == fine.counts
        true = np.linalg.norm(coarse.points - fine.points, axis=1)
        late = true > 1e-9
        assert np.median(term(coarse, "Integration").size()[late] / true[late]) == pytest.approx(1.0, abs=0.1)


def test_noise_of_the_samples_is_carried_as_it_does() -> None:
    sigma, base = 0.03, abc(0.03)
    start = some(base, 4)
    common: dict[str, Any] = {"interval": 0.25, "end_time": 0.5}
    stated = term(trace(base, start, Progress(), **common).traces, "Added noise").error()
    clean = analytic(formula=ABC, low=(0, 0, 0), high=(2 * np.pi,) * 3, samples=(11, 11, 11))
    random = np.random.default_rng(0)
    runs = []
    for _ in range(150):
        values = clean.values + sigma * random.standard_normal(clean.values.shape)
        noisy = interpolate(Samples(grid=clean.grid, values=values, accuracy=EXACT))
        runs.append(trace(noisy, start, Progress(), carry=False, estimate="none", **common).traces.points)
    spread = np.std(runs, axis=0, ddof=1)
    late = spread > 1e-9
    assert late.sum() == 24
    assert np.median(stated[late] / spread[late]) == pytest.approx(1.0, abs=0.08)


def test_the_model_knows_how_far_its_traces_are_off() -> None:
    """Signed, so it tells the direction: taking it off leaves a fraction."""
    model = abc()
    start = some(model, 10)
    traces = trace(model, start, Progress(), interval=0.5, end_time=0.5, tolerance=1e-9).traces
    fine = interpolate(analytic(formula=ABC, low=(0, 0, 0), high=(2 * np.pi,) * 3, samples=(81, 81, 81)))
    true = trace(fine, start, Progress(), interval=0.5, end_time=0.5, tolerance=1e-9, carry=False).traces
    off = (traces.points - true.points)[1::2]
    told = term(traces, "Interpolation between samples").error()[1::2]
    assert np.linalg.norm(off - told, axis=1).max() < 0.5 * np.linalg.norm(off, axis=1).max()
    assert np.median(np.linalg.norm(told, axis=1) / np.linalg.norm(off, axis=1)) == pytest.approx(1.0, abs=0.25)


def test_what_is_not_carried_says_so() -> None:
    model = abc(0.01)
    start = some(model, 2)
    traces, ends = trace(model, start, Progress(), end_time=0.2, carry=False, estimate="none")
    assert {m.name for m in traces.accuracy.missing} == {"Errors of data and model", "Integration"}
    told = {t.id for t in (*model.accuracy.terms, *start.accuracy.terms)}
    for output in (traces, ends):
        assert told <= output.accuracy.accounted()
    assert traces.accuracy.rigour("position") == "unknown"


def test_a_seed_outside_and_a_map() -> None:
    model = interpolate(analytic(formula="-y;x", samples=(9, 9)))
    start = Geometry(points=np.array([[0.5, 0, 0], [5.0, 0, 0]]), accuracy=EXACT)
    traces, ends = trace(model, start, Progress(), end_time=np.pi)
    assert ends.columns["reason"].tolist() == ["end time", "began outside"]
    assert len(traces.lines) == 1 and (traces.points[:, 2] == 0).all()
    assert traces.points[-1] == pytest.approx([-0.5, 0, 0], abs=1e-4)


def test_without_restarts_what_is_not_credible_is_flagged() -> None:
    model = abc()
    traces = trace(model, some(model), Progress(), restarts=False, end_time=2.0, carry=False).traces
    (flag,) = traces.accuracy.flags
    assert flag.name == "no assessment" and "RKSUITE" in flag.words and flag.count > 0


def test_what_does_not_fit_is_refused() -> None:
    model = abc()
    with pytest.raises(ValueError, match="give an interval"):
        trace(model, some(model), Progress(), estimate="re-integration")
    with pytest.raises(ValueError, match="no error estimate"):
        trace(model, some(model), Progress(), pair="RK4")
    with pytest.raises(ValueError, match="vectors"):
        trace(interpolate(analytic(samples=(5, 5))), some(model), Progress())
    with pytest.raises(ValueError, match="subsidiary"):
        trace(model, some(model), Progress(), estimate="none", report="subsidiary")
    with pytest.raises(ValueError, match="safety"):
        trace(model, some(model), Progress(), safety=0.5)
    bent = interpolate(analytic(formula=ABC, low=(0, 0, 0), high=(1, 1, 1), samples=(6, 6, 6), grid="curvilinear"))
    with pytest.raises(ValueError, match="keep the restarts"):
        trace(bent, some(bent), Progress(), restarts=False)


def test_it_is_cancelled_between_slabs() -> None:
    model, stop = abc(), Stop()
    stop.set()
    with pytest.raises(Cancelled):
        trace(model, some(model), Progress(stop=stop))


SPIN = "-y; x; 0.1 + 0*z"


def spun(start: Any, time: float) -> Any:
    """Where a rotation about the z axis takes positions."""
    c, s = np.cos(time), np.sin(time)
    x, y, z = start.T
    return np.column_stack([c * x - s * y, s * x + c * y, z + 0.1 * time])


def box(grid: Any = "regular", n: int = 7) -> Model:
    return interpolate(analytic(formula=SPIN, low=(-1, -1, -1), high=(1, 1, 1), samples=(n, n, n), grid=grid))


def tetrahedra(n: int = 6) -> Model:
    """A rotation in hexahedra and tetrahedra of an unstructured grid."""
    regular = analytic(formula=SPIN, low=(-1, -1, -1), high=(1, 1, 1), samples=(n, n, n))
    node = np.arange(n**3).reshape(n, n, n)
    corner = [node[k : n - 1 + k, j : n - 1 + j, i : n - 1 + i].ravel() for k in (0, 1) for j in (0, 1) for i in (0, 1)]
    hexahedra = np.column_stack([corner[c] for c in (0, 1, 3, 2, 4, 5, 7, 6)])
    count = len(hexahedra)
    grid = Unstructured(
        regular.grid.points(), np.arange(count + 1) * 8, hexahedra.ravel().astype(np.int64), np.full(count, 12, np.int64)
    )
    return Model.between(Samples(grid=grid, values=regular.values.reshape(-1, 3), accuracy=regular.accuracy))


@pytest.mark.parametrize("model", [box(), box("rectilinear"), box("curvilinear"), tetrahedra()], ids=lambda m: m.grid.kind)
def test_a_rotation_is_followed_on_every_kind_of_grid(model: Model) -> None:
    """Linear in space, so exact between the samples of each grid: nothing but the integration is off, and told."""
    low, high = np.asarray(model.grid.bounds).reshape(3, 2).T
    middle, span = (low + high) / 2, high - low
    start = Geometry(points=middle + span * np.array([[0.05, 0.02, -0.2], [-0.1, 0.1, -0.1]]), accuracy=EXACT)
    traces, ends = trace(model, start, Progress(), end_time=0.5, interval=0.5, tolerance=1e-7)
    assert set(ends.columns["reason"]) == {"end time"}
    off = traces.points[1::2] - spun(start.points, 0.5)
    told = term(traces, "Integration").error()[1::2]
    assert np.abs(off).max() < 1e-6
    assert told == pytest.approx(off, abs=max(1e-13, 0.1 * np.abs(off).max()))


def test_seeds_are_found_in_a_bent_lattice() -> None:
    model = interpolate(analytic(formula=SPIN, low=(0, 0, 0), high=(1, 1, 1), samples=(9, 8, 7), grid="curvilinear"))
    grid = model.grid
    assert isinstance(grid, Curvilinear)
    lattice = np.random.default_rng(5).uniform(0, 1, (50, 3)) * [8, 7, 6]
    weights = Linear().weights(lattice_of(grid), lattice)
    points = np.column_stack([weights.apply(grid.points()[:, m]) for m in range(3)])
    assert located(grid, points) == pytest.approx(lattice, abs=1e-9)
    assert np.isnan(located(grid, points + 100)).all()


def test_computational_space_is_another_flow_and_its_error_is_shown() -> None:
    model = box("curvilinear", 9)
    low, high = np.asarray(model.grid.bounds).reshape(3, 2).T
    start = Geometry(points=((low + high) / 2 + 0.1 * (high - low))[None], accuracy=EXACT)
    rules: dict[str, Any] = {"end_time": 0.5, "interval": 0.5, "tolerance": 1e-8}
    exact = trace(model, start, Progress(), **rules).traces
    other = trace(model, start, Progress(), space="computational", **rules).traces
    off = np.linalg.norm(other.points[-1] - spun(start.points, 0.5)[0])
    assert 1e-6 < off < 0.05
    shown = term(compare_traces(other, exact, meaning="model"), "Difference of models").size()[-1]
    assert shown == pytest.approx(off, rel=1e-3)


def test_the_laws_between_samples_are_those_of_the_model() -> None:
    for law in ("nearest", "cubic"):
        model = interpolate(abc().samples, law=law)
        traces = trace(model, some(model), Progress(), end_time=0.3, tolerance=1e-9).traces
        assert traces.values["velocity"].values == pytest.approx(model.at(traces.points)[0], abs=1e-6 if law == "cubic" else 9)
    smooth = trace(model, some(model), Progress(), end_time=0.5, interval=0.5, tolerance=1e-8, restarts=False).traces
    told, fine = term(smooth, "Integration").size()[1::2], trace(
        model, some(model), Progress(), end_time=0.5, interval=0.5, tolerance=1e-12
    ).traces
    off = np.linalg.norm(smooth.points - fine.points, axis=1)[1::2]
    assert np.median(told / off) == pytest.approx(1.0, abs=0.3)


def test_the_subsidiary_trace_is_better_than_what_it_states() -> None:
    model = abc()
    rules: dict[str, Any] = {"end_time": 0.5, "interval": 0.1, "carry": False}
    start = some(model, 20)
    fine = trace(model, start, Progress(), tolerance=1e-12, **rules).traces.points
    main, other = (
        trace(model, start, Progress(), tolerance=1e-3, report=r, **rules).traces for r in ("primary", "subsidiary")
    )
    off = [np.linalg.norm(t.points - fine, axis=1) for t in (main, other)]
    assert np.median(off[1]) < 0.2 * np.median(off[0])
    stated = term(other, "Integration, of the primary trace")
    assert "subsidiary trace is drawn" in stated.source.rule
    assert (stated.size() >= off[1] - 1e-12).mean() > 0.95


def test_a_declared_safety_factor_covers() -> None:
    model, rules = abc(), {"end_time": 0.5, "interval": 0.1, "carry": False}
    start = some(model, 40)
    fine = trace(model, start, Progress(), tolerance=1e-12, **rules).traces.points  # type: ignore[arg-type]  # mixed
    coarse = trace(model, start, Progress(), tolerance=1e-4, safety=2.0, **rules).traces  # type: ignore[arg-type]  # mixed
    stated = term(coarse, "Integration")
    assert "2 times as safety" in stated.source.rule
    assert (stated.size() >= np.linalg.norm(coarse.points - fine, axis=1) - 1e-12).mean() >= 0.95


def test_stretching_is_the_growth_of_a_displacement() -> None:
    model = interpolate(analytic(formula="x; -y; 0*z", low=(-9, -9, -1), high=(9, 9, 1), samples=(5, 5, 3)))
    start = Geometry(points=np.array([[0.5, 0.5, 0.0]]), accuracy=EXACT)
    traces = trace(model, start, Progress(), end_time=1.0, interval=1.0).traces
    assert traces.values["stretching"].values == pytest.approx([1.0, np.e], rel=1e-6)


@pytest.mark.parametrize("direction", ["forward", "both"])
def test_the_proven_tube_holds_the_exact_path(direction: Any) -> None:
    model = abc()
    start = some(model, 4)
    rules: dict[str, Any] = {"interval": 0.1, "end_time": 0.5, "carry": False, "direction": direction}
    traces = trace(model, start, Progress(), tolerance=1e-4, proof=True, **rules).traces
    tube = term(traces, "Proven tube of the integration")
    assert (tube.kind, tube.source.rigour, tube.components) == ("bound", "proven", 3)
    radius = tube.value.reshape(-1, 3)[:, 0]
    assert isinstance(model.grid, Regular)
    values, axes = np.asarray(model.samples.values, float), model.grid.axes
    for line, seed in zip(traces.polylines(), start.points, strict=True):
        half = len(line) // 2 if direction == "both" else 0
        for sign, part in ((1, slice(half, None)), (-1, slice(half, None, -1))):
            true = exact(sign * values, axes, seed[None], np.arange(6) * 0.1).points[0]
            if sign > 0 or direction == "both":
                rows = [int(np.flatnonzero((traces.points == p).all(axis=1))[0]) for p in line[part]]
                off = np.linalg.norm(line[part] - true[: len(rows)], axis=1)
                assert (off <= radius[rows]).all() and radius[rows].max() < 1e-3
    assert radius.max() < 20 * term(traces, "Integration").size().max()


def test_where_nothing_can_be_proven_it_says_so() -> None:
    model = abc()
    for rules in ({"restarts": False}, {"report": "subsidiary"}):
        told: Any = trace(model, some(model, 1), Progress(), end_time=0.2, carry=False, proof=True, **rules)
        assert "Proven tube of the integration" in {m.name for m in told.traces.accuracy.missing}


def test_a_better_model_makes_the_velocity_residual_that_of_the_first() -> None:
    model, start = abc(), some(abc(), 5)
    fine = interpolate(analytic(formula=ABC, low=(0, 0, 0), high=(2 * np.pi,) * 3, samples=(41, 41, 41), noise=0.01))
    traces, ends = trace(model, start, Progress(), better=fine, end_time=0.3, interval=0.1, tolerance=1e-9, carry=False)
    told = term(traces, "Velocity residual, of another model").error()
    assert told == pytest.approx(model.at(traces.points)[0] - fine.at(traces.points)[0], abs=1e-6)
    assert fine.accuracy.terms[0].id in traces.accuracy.accounted() & ends.accuracy.accounted()
    small = interpolate(analytic(formula=ABC, low=(0, 0, 0), high=(1, 1, 1), samples=(5, 5, 5)))
    beyond = trace(model, start, Progress(), better=small, end_time=0.1, carry=False).traces
    assert np.isinf(term(beyond, "Velocity residual, of another model").error()).all()


def test_a_not_a_knot_spline_is_followed_and_differs_from_the_other_laws_as_a_model_error() -> None:
    model = abc()
    start = some(model, 5)
    rules: dict[str, Any] = {"end_time": 0.5, "interval": 0.1, "tolerance": 1e-9, "carry": False}
    samples = model.samples
    spline = trace(model, start, Progress(), law="not-a-knot spline", restarts=False, **rules).traces
    assert isinstance(samples.grid, Regular)
    values, places = np.asarray(samples.values, float), tuple(reversed(samples.grid.axes))
    judge = RegularGridInterpolator(places, values, method="cubic", solver=spsolve)  # its own solver stops at 1e-6
    assert spline.values["velocity"].values == pytest.approx(judge(spline.points[:, ::-1]), abs=1e-9)
    fine = interpolate(analytic(formula=ABC, low=(0, 0, 0), high=(2 * np.pi,) * 3, samples=(81, 81, 81)))
    true = trace(fine, start, Progress(), **rules).traces.points
    off = {"spline": np.linalg.norm(spline.points - true, axis=1).max()}
    for law in ("linear", "cubic", "nearest"):
        other = trace(interpolate(samples, law=law), start, Progress(), **rules).traces
        off[law] = np.linalg.norm(other.points - true, axis=1).max()
        differs = term(compare_traces(other, spline, meaning="model"), "Difference of models").size()
        assert differs.max() == pytest.approx(off[law], rel=0.35)
    assert off["spline"] < 0.5 * off["cubic"] < 0.5 * off["linear"] < 0.5 * off["nearest"]


def test_a_spline_on_uneven_and_short_axes_and_what_it_refuses() -> None:
    x, y = np.array([-1.0, -0.6, 0.1, 0.3, 1.0]), np.array([-1.0, 0.2, 1.0])
    yy, xx = np.meshgrid(y, x, indexing="ij")
    values = np.stack([-yy, xx + 0 * yy, 0 * xx], axis=-1)
    flat = interpolate(Samples(grid=Rectilinear((x, y)), values=values, accuracy=EXACT))
    start = Geometry(points=np.array([[0.7, 0.0, 0.0]]), accuracy=EXACT)
    traces = trace(flat, start, Progress(), law="not-a-knot spline", end_time=2 * np.pi, tolerance=1e-9, carry=False).traces
    assert traces.points[-1] == pytest.approx([0.7, 0.0, 0.0], abs=1e-6)
    holed = values.copy()
    holed[0, 0, 0] = np.nan
    with pytest.raises(ValueError, match="fill them"):
        broken = interpolate(Samples(grid=Rectilinear((x, y)), values=holed, accuracy=EXACT))
        trace(broken, start, Progress(), law="not-a-knot spline")
    with pytest.raises(ValueError, match="regular or rectilinear"):
        trace(box("curvilinear"), start, Progress(), law="not-a-knot spline")


def test_answers_by_the_laws_weights_are_those_of_the_compiled_way() -> None:
    model = abc(0.03)
    field = medium([model], 1, some(model, 3).points)
    rules: dict[str, Any] = {"end": 0.5, "interval": 0.25, "tolerance": 1e-6, "faces": True}
    run = follow(field, 1, "Dormand-Prince 5(4)", rules, Progress())
    one, other = answers(model, run, Progress()), answers_along(model, run, "Dormand-Prince 5(4)", rules, Progress())
    assert one is not None and other is not None and one.drift is not None and other.drift is not None
    assert abs(one.samples - other.samples).max() < 1e-3 * abs(one.samples).max()
    assert other.growth == pytest.approx(one.growth, rel=1e-2, abs=1e-3)
    assert other.drift == pytest.approx(one.drift, rel=0.02, abs=2e-4)


@pytest.mark.parametrize("kind", ["cubic", "curvilinear"])
def test_noise_is_carried_through_cubic_laws_and_on_bent_lattices(kind: Any) -> None:
    law: Any = "cubic" if kind == "cubic" else "linear"
    grid: Any = "regular" if kind == "cubic" else kind
    made: dict[str, Any] = {"formula": SPIN, "low": (-1, -1, -1), "high": (1, 1, 1), "samples": (5, 5, 5), "grid": grid}
    sigma, base = 0.02, interpolate(analytic(noise=0.02, seed=1, **made), law=law)
    low, high = np.asarray(base.grid.bounds).reshape(3, 2).T
    start = Geometry(points=((low + high) / 2 + 0.1 * (high - low))[None], accuracy=EXACT)
    common: dict[str, Any] = {"interval": 0.5, "end_time": 1.0, "restarts": kind != "cubic"}
    stated = term(trace(base, start, Progress(), **common).traces, "Added noise").error()
    clean, random, runs = analytic(**made), np.random.default_rng(0), []
    for _ in range(60):
        values = clean.values + sigma * random.standard_normal(clean.values.shape)
        noisy = Model.between(Samples(grid=clean.grid, values=values, accuracy=EXACT), law)
        runs.append(trace(noisy, start, Progress(), carry=False, estimate="none", **common).traces.points)
    spread = np.std(runs, axis=0, ddof=1)
    assert stated[1:] / spread[1:] == pytest.approx(1.0, abs=0.4)
    assert np.median(stated[1:] / spread[1:]) == pytest.approx(1.0, abs=0.2)
