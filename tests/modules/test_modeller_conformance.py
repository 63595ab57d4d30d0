"""Every modeller of the catalogue keeps what it says of errors: those of its inputs and its own, on fields of known truth.

A new modeller is here as soon as it is in the catalogue. It is run with its defaults, with each choice of each setting, and
with what stands in SETTINGS. One that adds an error of its own states in TRUTH what it would give of the field itself.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest

from app.engine.catalogue import Catalogue
from modules.api import Accuracy, Identity, Model, Operator, Progress, Samples, regular, stencil
from modules.data.formula import Formula
from modules.records import Module
from tests.modules.manufactured import Field, Floats, Seen, Truth, faults, fields, untrue


def catalogue() -> list[Module]:
    """Our own modellers from samples or models to samples or models."""
    found = Catalogue()
    found._rooms = True
    found.reload()
    return [
        wired(record)
        for record in found
        if record.room == "modellers"
        and record.outputs[0].type in (Samples, Model)
        and any(p.type in (Samples, Model) and not p.optional for p in record.ports)
        and all(p.type in (Samples, Model) or p.optional for p in record.ports)
    ]


WIRED: Mapping[str, tuple[str, ...]] = {"calculator": ("b",)}
"""Modeller -> ports that may be left unwired, and are not here."""


SMALL: Mapping[str, dict[str, Any]] = {"grid_points": {"samples": (9,)}}
"""Modeller -> settings that keep what it makes small enough for draws."""


def wired(record: Module) -> Module:
    """With the ports that are wired here as ones that have to be."""
    names = WIRED.get(record.function.__name__, ())
    return replace(record, ports=tuple(replace(p, optional=p.optional and p.name not in names) for p in record.ports))


MODELLERS = catalogue()

SETTINGS: Mapping[str, list[dict[str, Any]]] = {
    "smooth": [{"passes": 3}, {"kernel": "gaussian", "width": 0.7}],
    "slice": [{"axis": "x", "position": 1.23}, {"axis": "y", "position": 1.71, "law": "cubic"}],
    "crop": [{"low": (0.9, 0.7), "high": (4.0, 3.1)}, {"low": (0.9, 0.7, 0.5), "high": (4.0, 3.1, 3.3)}],
    "subsample": [{"stride": (3,), "method": "mean"}, {"stride": (2, 1), "method": "mean"}],
    "resample": [{"samples": (31, 17)}, {"samples": (7, 9, 6), "low": (0.4, 0.7, 1.0), "high": (3.1, 2.6, 3.9)}],
    "transform": [{"scale": (-2.0, 3.0, 1.0), "shift": (5.0,), "factor": -4.0, "offset": 7.0, "lengths": "km", "unit": "ft"}],
    "threshold": [{"low": 2.0, "high": 3.5}],
    "quantise": [{"step": 0.37}],
    "calculator": [
        {"formula": "a - b"},
        {"formula": "a / 2 + 3 * b - x", "units": "ignored"},
        {"formula": "a * b"},
        {"formula": "exp(-(a / b)**2 / 9) * hypot(a, y)", "units": "ignored"},
        {"formula": "where(a > b, a, b) - min(a, 2 * b)"},
        {"formula": "a_y * b_z - a_z * b_y; a_z * b_x - a_x * b_z; a_x * b_y - a_y * b_x"},
        {"formula": "sqrt(a_x**2 + a_y**2 + a_z**2)", "unit": "km"},
    ],
}
"""Modeller -> settings to try beside the defaults and the choices."""


def within(field: Field, out: Seen, settings: Mapping[str, Any]) -> Floats:
    """The field itself."""
    return field.value(out.points)


def derivative(field: Field, out: Seen, settings: Mapping[str, Any]) -> Floats:
    axes, points = range(3), out.points
    parts = np.stack([field.value(points, a) for a in axes], axis=-1)
    return parts.reshape(len(points), -1)


def outflow(field: Field, out: Seen, settings: Mapping[str, Any]) -> Floats:
    return np.asarray(sum(field.value(out.points, a)[:, a] for a in range(3)))[:, None]


def turning(field: Field, out: Seen, settings: Mapping[str, Any]) -> Floats:
    def d(component: int, axis: int) -> Floats:
        return field.value(out.points, axis)[:, component]

    return np.stack([d(2, 1) - d(1, 2), d(0, 2) - d(2, 0), d(1, 0) - d(0, 1)], axis=-1)


def by_formula(field: Field, out: Seen, settings: Mapping[str, Any]) -> Floats:
    """Of both ports the field itself."""
    value = field.value(out.points)
    names = {3: ["a_x", "a_y", "a_z"], 1: ["a"]}[value.shape[1]]
    known = {**dict(zip(names, value.T, strict=True)), **dict(zip("xyz", out.points.T, strict=True))}
    known |= {"b" + name[1:]: one for name, one in known.items() if name[0] == "a"}
    parts = settings["formula"].split(";")
    if value.shape[1] == 3 and "_" not in parts[0]:
        parts = [re.sub(r"\b([ab])\b", rf"\1_{c}", parts[0]) for c in "xyz"]
    made = np.stack([Formula.parse(one, tuple(known)).value(known) for one in parts], axis=-1)
    return np.asarray(made * (1e-3 if settings.get("unit") == "km" else 1.0))


def on_plane(field: Field, out: Seen, settings: Mapping[str, Any]) -> Floats:
    axes = field.samples.grid.axes  # type: ignore[attr-defined]  # fields lie on regular and rectilinear grids
    held = "xyz".index(settings.get("axis", "z"))
    rest = [a for a in range(3) if a != held]
    points = np.zeros_like(out.points)
    points[:, rest] = out.points[:, :2]
    points[:, held] = settings.get("position") or axes[held][len(axes[held]) // 2]
    c = field.samples.components
    order = np.array([*rest, held])
    places = {1: [0], 3: order, 9: (3 * order[:, None] + order).ravel()}[c]
    return field.value(points)[:, places]


def steepness(field: Field, out: Seen, settings: Mapping[str, Any]) -> Floats:
    p, q = (field.value(out.points, a)[:, 0] for a in (0, 1))
    measure = settings.get("measure", "slope")
    if measure == "aspect":
        return np.asarray(np.degrees(np.arctan2(-p, -q)) % 360)
    return np.hypot(p, q) if measure == "grade" else np.degrees(np.arctan(np.hypot(p, q)))


def nothing(field: Field, out: Seen, settings: Mapping[str, Any]) -> Floats:
    """A field less itself."""
    return 0 * field.value(out.points)


TRUTH: Mapping[str, Truth] = {
    "state_accuracy": within,
    "interpolate": within,
    "smooth": within,
    "moving_average": within,
    "subsample": within,
    "resample": within,
    "slice": on_plane,
    "gradient": derivative,
    "divergence": outflow,
    "curl": turning,
    "slope": steepness,
    "quantise": within,
    "add_noise": within,
    "calculator": by_formula,
    "difference": nothing,
    "ensemble": within,
}
"""Modeller -> what it would give of the field itself, if it made no error of its own."""


def name_of(record: Module) -> str:
    return record.function.__name__


def cases(record: Module) -> Iterator[dict[str, Any]]:
    """The defaults, each choice of each setting, and what is listed."""
    base = SMALL.get(name_of(record), {})
    yield base
    for parameter in record.parameters:
        options = parameter.options or (("true", "false") if parameter.type is bool else ())
        for option in options:
            if parameter.coerce(option) != parameter.default:
                yield {**base, parameter.name: parameter.coerce(option)}
    yield from SETTINGS.get(name_of(record), [])


def looked_at(settings: Mapping[str, Any]) -> tuple[Field, ...]:
    """All fields with the defaults; with other settings a map and vectors in a volume, both uneven."""
    return fields() if not settings else tuple(f for f in fields() if f.name in FEWER)


FEWER = ("uneven map", "vectors in a volume")


def accepted(record: Module, settings: Mapping[str, Any]) -> list[Field]:
    """The fields that a modeller takes with these settings; it refuses others with a sentence."""
    found = []
    for field in looked_at(settings):
        try:
            wrong = faults(record.function, record, field, settings)
        except ValueError as refused:
            assert str(refused), f"{record.id} refuses without a sentence"
            continue
        assert not wrong, f"{record.id} {dict(settings)}, {field.name}: {'; '.join(wrong)}"
        found.append(field)
    return found


@pytest.mark.parametrize("record", MODELLERS, ids=name_of)
def test_errors_come_out_as_stated(record: Module) -> None:
    kinds = {field.name for settings in cases(record) for field in accepted(record, settings)}
    assert kinds, "it takes none of the fields"


@pytest.mark.parametrize("record", MODELLERS, ids=name_of)
def test_its_own_error_is_what_it_states(record: Module) -> None:
    truth = TRUTH.get(name_of(record))
    for settings in cases(record):
        for field in looked_at(settings):
            try:
                found = untrue(record.function, record, field, settings, truth)
            except ValueError:
                continue
            assert not found, f"{record.id} {settings}, {field.name}: {'; '.join(found)}"


def test_each_truth_and_each_setting_is_of_a_modeller() -> None:
    names = {name_of(record) for record in MODELLERS}
    assert set(TRUTH) | set(SETTINGS) <= names


# --- wrong rules are found ---------------------------------------------------------------------------------------


def record_named(name: str) -> Module:
    return next(record for record in MODELLERS if name_of(record) == name)


def given(name: str, *inputs: Any, **more: Any) -> Samples:
    """What a modeller makes of samples."""
    return cast(Samples, record_named(name).function(*inputs, **more))


def spacing_forgotten(samples: Samples) -> Samples:
    """A gradient whose values know the spacing and whose errors do not."""
    right = given("gradient", samples)
    wrong = given("gradient", replace(samples, grid=regular(samples.grid.shape)))
    return replace(right, accuracy=replace(wrong.accuracy, of=None))


def deviations_instead_of_operators(samples: Samples) -> Samples:
    """A gradient of a smoothing that hands on one deviation a sample, as if neighbours had nothing in common."""
    smooth = given("smooth", samples, Progress())
    flattened = [
        replace(t, value=np.abs(t.error()).ravel(), operator=Identity(t.operator.shape[0])) for t in smooth.accuracy.terms
    ]
    return given("gradient", replace(smooth, accuracy=Accuracy(tuple(flattened))))


def weights_squared(samples: Samples) -> Samples:
    """A smoothing that averages its errors a second time."""
    right = given("smooth", samples, Progress())
    return replace(right, accuracy=given("smooth", right, Progress()).accuracy)


def border_forgotten(samples: Samples) -> Samples:
    """A moving average whose errors know nothing of the window's cut at the border."""
    right = given("moving_average", samples, Progress())
    inside: Operator = Identity(samples.grid.count)
    for axis in range(len(samples.grid.shape)):
        inside = stencil(samples.grid.shape, axis, (-2, -1, 0, 1, 2), (0.2,) * 5).after(inside)
    return replace(right, accuracy=samples.accuracy.push(inside))


def term_dropped(samples: Samples) -> Samples:
    """A step that forgets one of the errors."""
    return replace(samples, accuracy=Accuracy(samples.accuracy.terms[1:]))


def bound_too_small(samples: Samples) -> Samples:
    """A rounding that claims a quarter of a step."""
    right = given("quantise", samples, step=0.5)
    terms = [t if t.name != "Rounding to steps" else replace(t, value=t.value / 2) for t in right.accuracy.terms]
    return replace(right, accuracy=Accuracy(tuple(terms)))


def wrong_sign(samples: Samples) -> Samples:
    """A smoothing that states its bias the wrong way round."""
    right = given("smooth", samples, Progress())
    terms = [t if t.name != "Smoothing" else replace(t, value=-t.value) for t in right.accuracy.terms]
    return replace(right, accuracy=Accuracy(tuple(terms)))


def bias_of_half_the_size(samples: Samples) -> Samples:
    """A gradient that forgets a factor of its error."""
    right = given("gradient", samples)
    terms = [t if t.kind != "signed" else replace(t, value=t.value / 3) for t in right.accuracy.terms]
    return replace(right, accuracy=Accuracy(tuple(terms)))


PLANTED = [
    (spacing_forgotten, "gradient", "come out otherwise"),
    (deviations_instead_of_operators, "gradient", "come out otherwise"),
    (weights_squared, "smooth", "come out otherwise"),
    (border_forgotten, "moving_average", "come out otherwise"),
    (term_dropped, "crop", "vanishes without a reason"),
    (bound_too_small, "quantise", "bound of its own is exceeded"),
    (wrong_sign, "smooth", "signed estimate leaves"),
    (bias_of_half_the_size, "gradient", "signed estimate leaves"),
]


@pytest.mark.parametrize(("wrong", "name", "sentence"), PLANTED, ids=lambda one: getattr(one, "__name__", ""))
def test_a_wrong_rule_is_found(wrong: Callable[..., Samples], name: str, sentence: str) -> None:
    record = replace(record_named(name), function=wrong, progress="", parameters=())
    found = []
    for field in fields()[:3]:
        found += faults(wrong, record, field, {}) + untrue(wrong, record, field, {}, TRUTH.get(name))
    assert any(sentence in one for one in found), found

