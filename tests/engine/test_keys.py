"""Canonical values and keys: equal exactly if what they stand for is."""

from __future__ import annotations

import enum
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.engine import scheduler
from app.engine.keys import FORMAT, canonical, digest, too_large


class Colour(enum.Enum):
    RED = 1
    ROSSO = 2


SAME: list[tuple[Any, Any]] = [
    (-0.0, 0.0),
    ([1, 2], (1, 2)),
    ("e\u0301", "\u00e9"),
    (np.float64(2.5), 2.5),
    (np.int32(3), 3),
    (np.arange(3, dtype=">f8"), np.arange(3, dtype="<f8")),
    (np.arange(6.0)[::2], np.array([0.0, 2.0, 4.0])),
    (np.array([-0.0]), np.array([0.0])),
    ({"a": 1, "b": 2}, {"b": 2, "a": 1}),
    ({3, 1}, {1, 3}),
]
DIFFERENT: list[tuple[Any, Any]] = [
    (1, 1.0),
    (True, 1),
    (0, False),
    (None, 0),
    ("1", 1),
    (("a", "bc"), ("ab", "c")),
    (((1,), 2), ((1, 2),)),
    (np.zeros(2, "f4"), np.zeros(2, "f8")),
    (np.zeros((2, 3)), np.zeros((3, 2))),
    (np.zeros(2), (0.0, 0.0)),
    (Colour.RED, "RED"),
    (Colour.RED, Colour.ROSSO),
    ({}, ()),
    (math.inf, -math.inf),
]


@pytest.mark.parametrize(("one", "other"), SAME)
def test_equal_values_have_equal_bytes(one: Any, other: Any) -> None:
    assert canonical(one) == canonical(other)


@pytest.mark.parametrize(("one", "other"), DIFFERENT)
def test_other_values_have_other_bytes(one: Any, other: Any) -> None:
    assert canonical(one) != canonical(other)


def test_what_cannot_be_a_parameter_is_refused() -> None:
    with pytest.raises(ValueError, match="leave it empty for 'automatic'"):
        canonical((1.0, math.nan))
    with pytest.raises(TypeError, match="identity of its file"):
        canonical(Path("a"))
    with pytest.raises(TypeError, match="object cannot be a parameter"):
        canonical(object())
    assert "make it a data file" in too_large(b"x" * 70_000)
    assert not too_large(b"x" * 60_000)


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=8,
)


def shape(value: Any) -> Any:
    """A value with its types, so that Python's == tells what `canonical` must."""
    if isinstance(value, list):
        return ("l", [shape(v) for v in value])
    if isinstance(value, dict):
        return ("m", {k: shape(v) for k, v in value.items()})
    return (type(value).__name__, value)


@given(values, values)
def test_bytes_are_equal_exactly_if_values_are(one: Any, other: Any) -> None:
    import unicodedata

    def normal(v: Any) -> Any:
        if isinstance(v, str):
            return unicodedata.normalize("NFC", v)
        if isinstance(v, list):
            return [normal(w) for w in v]
        if isinstance(v, dict):
            return {normal(k): normal(w) for k, w in v.items()}
        return v

    one, other = normal(one), normal(other)
    assert (canonical(one) == canonical(other)) == (shape(one) == shape(other))


def test_a_key_is_the_digest_of_all_that_decides_a_result(lab: Any) -> None:
    network = lab.network({"c": ("constant", {"number": 2}), "t": "total"}, "c.value -> t.values", "c.value -> t.values")
    keys = scheduler.keys(network, lab.catalogue)
    module = lab.catalogue["user.fakes.constant"]
    whole: tuple[Any, ...] = (FORMAT, module.id, 1, module.digest, [("number", 2.0), ("sigma", 0.0)], [])
    assert keys["c"] == digest(canonical(whole))
    ends = [("values", 0, "value", keys["c"]), ("values", 1, "value", keys["c"])]
    assert keys["t"] == digest(canonical((FORMAT, "user.fakes.total", 1, module.digest, [], ends)))


def test_keys_do_not_know_ids_views_settings_defaults_or_the_order_of_edits(lab: Any) -> None:
    one = lab.network({"c": "constant", "n": "negate"}, "c.value -> n.a")
    other = lab.network({"zz": "negate", "aa": ("constant", {"number": 1, "sigma": 0})}, "aa.value -> zz.a")
    other = other.look("aa", camera=[1, 2]).move({"zz": (3, 4)}).settle(k=3.0, title="other")
    assert sorted(scheduler.keys(one, lab.catalogue).values()) == sorted(scheduler.keys(other, lab.catalogue).values())
    changed = one.set("c", "number", 2, lab.catalogue)
    before, after = scheduler.keys(one, lab.catalogue), scheduler.keys(changed, lab.catalogue)
    assert before["c"] != after["c"] and before["n"] != after["n"]


def test_the_order_of_a_list_and_the_output_enter_the_key(lab: Any) -> None:
    nodes = {"a": "constant", "b": "zero", "o": "ordered"}
    one = lab.network(nodes, "a.value -> o.values", "b.value -> o.values")
    other = lab.network(nodes, "b.value -> o.values", "a.value -> o.values")
    keys = scheduler.keys(one, lab.catalogue), scheduler.keys(other, lab.catalogue)
    assert keys[0]["o"] != keys[1]["o"]
    twin = lab.network({"a": "constant", "u": "uncertainty"}, "a.value:accuracy -> u.accuracy")
    assert scheduler.keys(twin, lab.catalogue)["u"] != keys[0]["o"]


def test_a_wired_parameter_takes_the_place_of_its_value(lab: Any) -> None:
    nodes = {"l": ("constant", {"number": 3}), "c": ("constant", {"number": 5})}
    plain, wired = lab.network(nodes), lab.network(nodes, "l.value -> c.number")
    other = wired.set("c", "number", 7, lab.catalogue)
    keys = [scheduler.keys(n, lab.catalogue)["c"] for n in (plain, wired, other)]
    assert keys[0] != keys[1] == keys[2]


def test_the_same_network_has_the_same_keys_in_another_process_and_folder(lab: Any, tmp_path: Path) -> None:
    script = (
        "import sys, pathlib; from app.engine.catalogue import Catalogue; from app.engine import document, scheduler, paths\n"
        "c = Catalogue.of([], pathlib.Path(sys.argv[1])); n = document.load(sys.argv[2], c)\n"
        "print(sorted(scheduler.keys(n, c, paths.identities(n, c)).items()))"
    )
    from app.engine import document, paths

    found = []
    for place in ("here", "there"):
        folder = tmp_path / place
        folder.mkdir()
        (folder / "n.txt").write_text("4")
        network = lab.network({"f": ("number_file", {"path": "n.txt"}), "m": "negate"}, "f.value -> m.a", folder=folder)
        document.save(network, folder / "net.json", lab.catalogue)
        keys = scheduler.keys(network, lab.catalogue, paths.identities(network, lab.catalogue))
        found.append(str(sorted(keys.items())))
    root = Path(__file__).parents[2]
    environment = {**os.environ, "PYTHONPATH": str(root), "PYTHONHASHSEED": "7"}
    command = [sys.executable, "-c", script, str(lab.folder), str(tmp_path / "there" / "net.json")]
    out = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert found[0] == found[1] == out.stdout.strip()
