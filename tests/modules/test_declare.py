"""What the decorator reads from a signature, and what it refuses with a sentence."""

from __future__ import annotations

import enum
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from modules import declare
from modules.accuracy_mappers.dust import dust
from modules.api import (
    EXACT,
    Accuracy,
    Annotated,
    Choice,
    Geometry,
    Layer,
    Literal,
    Model,
    NamedTuple,
    Progress,
    Range,
    Samples,
    Table,
    Value,
    mapper,
    modeller,
    reader,
    renderer,
)
from modules.declare import DeclarationError, record_of
from modules.mappers.contour import contour
from modules.parameters import Parameter, ParameterError


class Mode(enum.Enum):
    """Options by name."""

    FAST = 1
    GOOD = 2


class Two(NamedTuple):
    """Two outputs."""

    shape: Geometry
    table: Table


def peek(path: Path) -> dict[str, Any]:
    """Names in a file."""
    return {"names": ("a", "b")}


@reader("Numbers", aliases=("digits",), peek=peek)
def numbers(
    *, path: Path | None = None, name: Annotated[str, Choice(of="path.names")] = "a", mode: Mode = Mode.GOOD
) -> Samples:
    """Numbers from a file.

    Parameters
    ----------
    path : the file
    name : which of them
    mode : how, in which
        words

    Accuracy: exact.
    """
    return Samples.from_array([[1.0, 2.0]], accuracy=EXACT)


@mapper("Both", version=3, was=("mappers.old.both",), independent={"table": ("other",)})
def both(
    model: Model,
    other: Geometry | None = None,
    *,
    scale: Annotated[float, Range(0, 10)] = 1,
    levels: tuple[float, ...] | None = None,
) -> Two:
    """A shape, and a table of it.

    Accuracy: passes on
        what comes in.
    Source: a paper, (3.1).
    """
    shape = Geometry(points=[[0, 0, 0]], accuracy=EXACT)  # type: ignore[arg-type]  # lists are arrays too
    return Two(shape, Table(columns={}, accuracy=EXACT))


@renderer("Stack")
def stack(layers: list[Layer], accuracy: Accuracy | None = None) -> Layer:
    """Layers in one.

    Accuracy: passes on.
    """
    return layers[0]


def test_the_record_says_all_that_the_signature_says() -> None:
    record = record_of(both)
    assert (record.title, record.room, record.version, record.was) == ("Both", "mappers", 3, ("mappers.old.both",))
    assert [(p.name, p.type, p.optional, p.many) for p in record.ports] == [
        ("model", Model, False, False),
        ("other", Geometry, True, False),
    ]
    assert [(p.name, p.type, p.default, p.automatic) for p in record.parameters] == [
        ("scale", float, 1.0, False),
        ("levels", tuple[float, ...], None, True),
    ]
    assert [(o.name, o.type) for o in record.outputs] == [("shape", Geometry), ("table", Table)]
    assert record.accuracy == "passes on what comes in."
    assert record.source == "a paper, (3.1)."
    assert record.summary == "A shape, and a table of it."
    words = {p.name: p.words for p in record_of(numbers).parameters}
    assert words == {"path": "the file", "name": "which of them", "mode": "how, in which words"}
    assert record.output("shape:accuracy") == declare.Output("shape:accuracy", Accuracy)
    assert record.output("shape:nothing") is None
    assert record_of(stack).ports[0].many
    assert record_of(contour).id == "mappers.contour.contour"
    assert record_of(contour).progress == "progress"
    assert record_of(dust).outputs[0].name == "dust"


def test_the_function_is_still_the_function() -> None:
    assert numbers(name="b").values.shape == (1, 2)
    assert pickle.loads(pickle.dumps(numbers)) is numbers
    assert pickle.loads(pickle.dumps(record_of(both))) is record_of(both)
    named = record_of(both).call({"model": None}, {"scale": 1.0, "levels": None}, Progress())
    assert list(named) == ["shape", "table"]


def test_ports_say_why_a_wire_does_not_fit() -> None:
    model, other = record_of(both).ports
    samples = declare.Port("samples", Samples)
    assert samples.refuses(Model) == ""
    assert model.refuses(Model) == ""
    assert "interpolate" in model.refuses(Samples)
    assert other.refuses(Table) == "needs a Geometry, got a Table"
    assert "renderer" in declare.Port("layer", Layer).refuses(Geometry)


def refused(make: Callable[[], object]) -> str:
    with pytest.raises(DeclarationError) as caught:
        make()
    return str(caught.value)


DOC = "Words.\n\nAccuracy: exact.\n"


def make(signature: str, word: str = "def") -> Callable[..., Any]:
    """A function of that signature, as a user would write it in a file."""
    space: dict[str, Any] = {**globals(), "__name__": "nonius_user.tried", "Path": Path}
    exec(f"{word} tried{signature}:\n    '''{DOC}'''\n", space)
    function: Callable[..., Any] = space["tried"]
    return function


@pytest.mark.parametrize(
    ("signature", "words"),
    [
        ("(model) -> Geometry", "argument 'model' has no type"),
        ("(model: Model | Samples) -> Geometry", "may take one type"),
        ("(model: Model | None) -> Geometry", "write '= None'"),
        ("(model: Model = None) -> Geometry", "only '| None = None'"),
        ("(*models: Model) -> Geometry", "names each port"),
        ("(model: Model, **rest: float) -> Geometry", "names each port"),
        ("(model: Model, *, scale: float) -> Geometry", "has no default"),
        ("(model: Model, *, scale: float = None) -> Geometry", "None means automatic"),
        ("(model: Model, *, at: tuple[float, ...] = [1.0]) -> Geometry", "can change: use a tuple"),
        ("(model: Model, *, at: list[float] = ()) -> Geometry", "a list of numbers is a tuple"),
        ("(model: Model, *, scale: Annotated[float, Range(0, 1)] = 2.0) -> Geometry", "outside its Range"),
        ("(model: Model, *, scale: Annotated[float, Range] = 1.0) -> Geometry", "with brackets"),
        ("(model: Model, *, law: Literal['a', 'b'] = 'c') -> Geometry", "no option 'c'"),
        ("(model: Model, *, law: dict = None) -> Geometry", "use bool, int, float"),
        ("(model: Model, *, law: int | str = 1) -> Geometry", "not a choice of several"),
        ("(*, model: Model = None) -> Geometry", "data goes before the '*'"),
        ("(scale: float) -> Geometry", "put it after the '*'"),
        ("(thing: set) -> Geometry", "a port takes Samples"),
        ("(model: Modle) -> Geometry", "'Modle' is not defined"),
        ("(model: Model)", "no return type"),
        ("(model: Model) -> tuple[Geometry, Table]", "return a NamedTuple"),
        ("(model: Model) -> Layer", "may be Geometry; this is Layer"),
        ("(model: Model, *, id: int = 1) -> Geometry", "is taken"),
        ("(model: Model, *, scale: Annotated[float, Range(of='model.weight')] = 1.0) -> Geometry", "knows range"),
        ("(model: Model, *, scale: Annotated[float, Range(of='modl.range')] = 1.0) -> Geometry", "no port 'modl'"),
    ],
)
def test_what_is_not_understood_is_refused_with_a_sentence(signature: str, words: str) -> None:
    message = refused(lambda: mapper("Tried")(make(signature)))
    assert words in message
    assert "tried" in message


def test_functions_that_cannot_be_modules_are_refused() -> None:
    def local(model: Model) -> Geometry:
        """Words.

        Accuracy: exact.
        """
        return Geometry(points=[], accuracy=EXACT)  # type: ignore[arg-type]  # never called

    assert "top of a file" in refused(lambda: mapper("Local")(local))
    silent = make("(model: Model) -> Geometry")
    silent.__doc__ = None
    assert "no docstring" in refused(lambda: mapper("Silent")(silent))
    vague = make("(model: Model) -> Geometry")
    vague.__doc__ = "Words."
    assert "no 'Accuracy:' line" in refused(lambda: mapper("Vague")(vague))
    lost = make("(model: Model) -> Geometry")
    lost.__module__ = "modules.readers.lost"
    assert "lies in 'readers'" in refused(lambda: mapper("Lost")(lost))
    assert "not async" in refused(lambda: mapper("Later")(make("(model: Model) -> Geometry", "async def")))
    assert "is not a module" in refused(lambda: record_of(test_the_function_is_still_the_function))
    assert "does not have" in refused(lambda: modeller("M", independent={"x": ("y",)})(make("(samples: Samples) -> Samples")))


def test_a_module_that_gives_another_type_is_told() -> None:
    wrong = mapper("Wrong")(make("(model: Model) -> Geometry"))
    with pytest.raises(TypeError, match="Wrong gave a NoneType as 'geometry'; it declares a Geometry"):
        record_of(wrong).call({"model": None}, {}, Progress())


@pytest.mark.parametrize(
    ("kind", "given", "result"),
    [
        (float, 1, 1.0),
        (float, "1e-3", 1e-3),
        (float, -0.0, 0.0),
        (int, 3.0, 3),
        (int, "12345678901234567890", 12345678901234567890),
        (bool, "yes", True),
        (str, "x", "x"),
        (Path, "a/b", Path("a/b")),
        (Mode, "FAST", Mode.FAST),
        (Literal["a", "b"], "b", "b"),
        (tuple[float, ...], [1, 2], (1.0, 2.0)),
        (tuple[float, ...], "1, 2.5", (1.0, 2.5)),
        (tuple[int, int], (1, 2), (1, 2)),
    ],
)
def test_values_are_brought_to_their_declared_type(kind: Any, given: Any, result: Any) -> None:
    coerced = Parameter("p", kind, result).coerce(given)
    assert coerced == result
    assert type(coerced) is type(result)


@pytest.mark.parametrize(
    ("kind", "given", "words"),
    [
        (float, "one", "p takes a number, not 'one'"),
        (float, True, "p takes a number, not True"),
        (float, float("nan"), "leave it empty for 'automatic'"),
        (int, 1.5, "p takes a whole number"),
        (bool, "perhaps", "true or false"),
        (str, 3, "p takes text"),
        (Path, 3, "p takes a file"),
        (Literal["linear", "nearest"], "linaer", "did you mean 'linear'?"),
        (Mode, "BEST", "it takes FAST, GOOD"),
        (tuple[float, float], (1.0,), "2 values, each a number, not 1 of them"),
        (float, None, "not nothing"),
    ],
)
def test_values_that_do_not_fit_are_refused_with_what_does(kind: Any, given: Any, words: str) -> None:
    with pytest.raises(ParameterError, match="p") as caught:
        Parameter("p", kind, 1.0 if given is None else given).coerce(given)
    assert words in str(caught.value)


def test_a_range_takes_its_ends_from_a_fact() -> None:
    assert Range(of="model.range").ends({"model": {"range": (3, 9)}}) == (3.0, 9.0)
    assert Range(low=0, of="model.range").ends({"model": {"range": (3, 9)}}) == (0.0, 9.0)
    assert Range(0, 5).ends({}) == (0.0, 5.0)
    assert Range(of="model.range").ends({}) is None
    strict = Parameter("p", float, 1.0, range=Range(0, 1, strict=True, unit="m"))
    with pytest.raises(ParameterError, match="p = 2 is outside 0 to 1 m"):
        strict.coerce(2)
    assert Parameter("p", float, 1.0, range=Range(0, 1)).coerce(2) == 2.0


def test_a_value_of_a_wire_is_an_output_too() -> None:
    given = modeller("Largest")(make("(samples: Samples) -> Value"))
    assert record_of(given).outputs == (declare.Output("value", Value),)
