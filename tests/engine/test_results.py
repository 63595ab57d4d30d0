"""The store: bounded in bytes, shared buffers counted once, what is published is read-only."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array

from app.engine import machine
from app.engine.errors import ModuleFailed
from app.engine.results import Entry, Results, arrays


def entry(*values: Any) -> Entry:
    return Entry({str(i): v for i, v in enumerate(values)})


def test_the_least_recently_used_leave_first() -> None:
    results = Results(bound=3000)
    for name in "abc":
        results.put(name, entry(np.zeros(125)))
    assert results.get("a") is not None
    results.put("d", entry(np.zeros(125)))
    assert [k for k in "abcd" if k in results] == ["a", "c", "d"]
    assert results.bytes == 3000


def test_shared_buffers_count_once_and_stay_as_long_as_one_entry_holds_them() -> None:
    results, base = Results(bound=10_000), np.zeros(1000)
    results.put("a", entry(base))
    results.put("b", entry(base[::2], base.reshape(10, 100)))
    results.put("c", entry([{"x": base[10:]}], np.zeros(10)))
    assert results.bytes == 8080
    results.drop("a")
    results.drop("b")
    assert results.bytes == 8080
    results.drop("c")
    assert results.bytes == 0


@dataclass(frozen=True)
class Deep:
    inner: Any


def test_buffers_are_found_wherever_they_lie() -> None:
    sparse = csr_array(np.eye(4))
    deep = Deep((Deep([np.zeros(3)]), {"m": Deep(sparse)}, "text", None))
    assert entry(deep).bytes == 24 + sparse.data.nbytes + sparse.indices.nbytes + sparse.indptr.nbytes
    circle: list[Any] = [np.zeros(1)]
    circle.append(circle)
    assert len(arrays(circle)) == 1


def test_what_is_published_is_read_only_down_to_its_owner() -> None:
    base = np.zeros(10)
    again = pickle.loads(pickle.dumps(entry(Deep([base[::2]]))))
    assert not again.outputs["0"].inner[0].flags.writeable, "also what came from another process"
    with pytest.raises(ValueError, match="read-only"):
        base[0] = 1


def test_a_bound_of_zero_keeps_nothing_and_failures_stay_until_forgiven() -> None:
    results = Results(bound=0)
    results.put("a", entry(np.zeros(1)))
    results.put("b", entry())
    assert len(results) == 0 and results.bytes == 0
    results.fail("k", ModuleFailed("no"))
    results.clear()
    assert set(results.failures) == {"k"}
    results.forgive("k")
    assert not results.failures


@given(st.lists(st.tuples(st.sampled_from("abcdef"), st.integers(0, 4), st.integers(0, 4)), max_size=30), st.integers(0, 60))
def test_bytes_held_are_always_those_of_what_is_held(steps: list[tuple[str, int, int]], bound: int) -> None:
    pool = [np.zeros(n, "u1") for n in (1, 3, 7, 20, 50)]
    results = Results(bound=bound)
    for key, one, other in steps:
        results.put(key, entry(pool[one], pool[other][:1]))
        held = {o: n for k in "abcdef" if (e := results.get(k)) for o, n in e.buffers.items()}
        assert results.bytes == sum(held.values()) <= bound


def test_the_bound_is_a_quarter_of_what_the_container_allows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "CGROUPS", tmp_path)
    (tmp_path / "memory.max").write_text("max\n")
    whole = machine.memory()
    assert Results().bound == whole // 4
    (tmp_path / "memory.max").write_text(f"{1 << 30}\n")
    assert Results().bound == 1 << 28
    (tmp_path / "cpu.max").write_text("50000 100000\n")
    assert machine.cores() == 1
