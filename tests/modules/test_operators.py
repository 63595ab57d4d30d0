"""Operators give rows, apply as a whole, and fold to sizes; each is judged by a dense matrix made on its own."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.sparse import csr_array

from modules.data.fold import Kind, fold
from modules.data.operators import (
    Chain,
    Gather,
    Identity,
    Interleave,
    Matrix,
    Operator,
    Spread,
    Stencil,
    Sum,
    along,
    fixed,
    scaling,
    select,
    stencil,
    uniform,
)
from modules.data.separable import folded

Floats = NDArray[np.float64]
LATTICES = [(7,), (5, 6), (4, 5, 6)]


def dense(operator: Operator) -> Floats:
    """The matrix, column by column, through `apply` of unit vectors."""
    n_out, n_in = operator.shape
    return np.stack([operator.apply(e) for e in np.eye(n_in)], axis=1).reshape(n_out, n_in)


def smoothing(lattice: tuple[int, ...]) -> Operator:
    operator: Operator = Identity(int(np.prod(lattice)))
    for axis in range(len(lattice)):
        operator = stencil(lattice, axis, (-1, 0, 1), (0.25, 0.5, 0.25)).after(operator)
    return operator


def gather(n_out: int, n_in: int, k: int, seed: int = 0) -> Gather:
    random = np.random.default_rng(seed)
    return Gather(random.integers(0, n_in, (n_out, k)), random.normal(size=(n_out, k)), n_in)


def every_operator() -> list[Operator]:
    lattice = (4, 5, 6)
    n = 120
    smooth = smoothing(lattice)
    few = gather(30, n, 4)
    return [
        Identity(n),
        Spread(17),
        few,
        select(np.array([3, 3, 7]), n),
        scaling(np.linspace(-1, 1, n)),
        stencil(lattice, 1, (-2, 0, 1), (1.0, -3.0, 2.0)),
        smooth,
        few.after(smooth),
        Sum((few, gather(30, n, 2, 1))),
        Matrix(fixed(few.index, few.weight, n)),
        scaling(np.linspace(1, 2, 30)).after(few.after(smooth)),
        Chain(Sum((smooth, smooth)), few),
        few.after(Spread(n)),
        Interleave((smooth, stencil(lattice, 0, (-1, 1), (-0.5, 0.5)), uniform(lattice, -2.0))),
        Interleave((smooth, uniform(lattice, -2.0))).after(smooth),
        gather(30, 2 * n, 4).after(Interleave((Identity(n), smooth))),
        along(lattice, 2, np.diag(np.arange(6.0))[1:5, ::-1]),
    ]


@pytest.mark.parametrize("operator", every_operator(), ids=lambda o: type(o).__name__)
def test_rows_equal_the_whole(operator: Operator) -> None:
    matrix = dense(operator)
    wanted = np.array([operator.shape[0] - 1, 0, operator.shape[0] // 2, 0])
    assert np.allclose(operator.rows(wanted).toarray(), matrix[wanted], atol=1e-14)
    assert matrix.shape == operator.shape


@pytest.mark.parametrize("operator", every_operator(), ids=lambda o: type(o).__name__)
@pytest.mark.parametrize("one_for_all", [True, False])
def test_fold_equals_the_dense_matrix(operator: Operator, one_for_all: bool) -> None:
    matrix = dense(operator)
    random = np.random.default_rng(3)
    primitive = np.asarray(0.7) if one_for_all else random.uniform(0.1, 2, operator.shape[1])
    value = np.broadcast_to(primitive, operator.shape[1])
    assert np.allclose(fold("linear", primitive, operator), np.sqrt(matrix**2 @ value**2), rtol=1e-12, atol=1e-14)
    assert np.allclose(fold("bound", primitive, operator), np.abs(matrix) @ value, rtol=1e-12, atol=1e-14)
    assert np.allclose(fold("signed", primitive, operator), matrix @ value, rtol=1e-12, atol=1e-12)
    members = random.normal(size=(5, operator.shape[1]))
    assert np.allclose(fold("members", members, operator), (members @ matrix.T).std(axis=0, ddof=1), rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("lattice", LATTICES, ids=str)
def test_one_sigma_through_stencils_is_exact_at_the_borders_too(lattice: tuple[int, ...]) -> None:
    n = int(np.prod(lattice))
    twice = smoothing(lattice).after(smoothing(lattice))
    for operator in (twice, gather(40, n, 5).after(twice), stencil(lattice, 0, (-1, 1), (-0.5, 0.5)).after(twice)):
        general = np.sqrt((dense(operator) ** 2).sum(axis=1)) * 0.3
        assert np.allclose(fold("linear", np.asarray(0.3), operator), general, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("kind", ["linear", "bound", "signed"])
def test_many_rows_fold_like_few(kind: Kind) -> None:
    operator = gather(30_000, 50, 4)
    value = np.random.default_rng(1).uniform(0.1, 1, 50)
    few = np.concatenate([fold(kind, value, operator, np.arange(a, a + 1000)) for a in range(0, 30_000, 1000)])
    assert np.allclose(fold(kind, value, operator), few, rtol=1e-12, atol=1e-14)


def test_a_stencil_may_change_the_length_of_its_axis() -> None:
    columns, weights = np.array([[0, 1], [2, 3]]), np.full((2, 2), 0.5)
    halved = Stencil((3, 4), 1, columns, weights)
    assert halved.shape == (6, 12)
    assert np.array_equal(halved.apply(np.arange(12.0)), [0.5, 2.5, 4.5, 6.5, 8.5, 10.5])
    assert np.allclose(dense(halved), halved.rows(np.arange(6)).toarray())


def test_an_entry_of_weight_zero_is_not_touched() -> None:
    operator = Gather(np.array([[0, 1]]), np.array([[1.0, 0.0]]), 2)
    assert operator.apply(np.array([2.0, np.nan])) == 2.0


@settings(max_examples=60, derandomize=True, deadline=None)
@given(st.lists(st.sampled_from(["smooth", "scale", "gather", "sum", "select"]), min_size=1, max_size=5), st.integers(0, 99))
def test_any_chain_folds_like_its_matrix(words: list[str], seed: int) -> None:
    lattice, n = (3, 4), 12
    random = np.random.default_rng(seed)
    operator: Operator = Identity(n)
    matrix = np.eye(n)
    for word in words:
        step: Operator = smoothing(lattice)
        if word == "scale":
            step = scaling(random.normal(size=n))
        elif word == "gather":
            step = gather(n, n, 3, int(random.integers(99)))
        elif word == "sum":
            step = Sum((Identity(n), scaling(np.full(n, -0.5))))
        elif word == "select":
            step = select(random.integers(0, n, n), n)
        operator, matrix = step.after(operator), dense(step) @ matrix
    assert np.allclose(fold("linear", np.asarray(1.0), operator), np.sqrt((matrix**2).sum(axis=1)), rtol=1e-10, atol=1e-12)
    assert np.allclose(fold("bound", np.asarray(1.0), operator), np.abs(matrix).sum(axis=1), rtol=1e-10, atol=1e-12)


def test_a_chain_of_the_wrong_lengths_is_refused() -> None:
    with pytest.raises(ValueError, match="5 inputs cannot follow one of 4"):
        Identity(5).after(Identity(4))


def test_constants_pickle_to_almost_nothing() -> None:
    smooth = smoothing((64, 64, 64))
    assert len(pickle.dumps(Identity(10**9))) < 200
    assert len(pickle.dumps(smooth)) < 20_000


def test_cancel_is_polled_while_folding() -> None:
    class Enough(Exception):
        pass

    def check(fraction: float) -> None:
        if fraction > 0.4:
            raise Enough

    with pytest.raises(Enough):
        fold("bound", np.asarray(1.0), gather(200_000, 10, 2), check=check)


@pytest.mark.parametrize("kind", ["linear", "bound", "signed", "members"])
def test_many_rows_of_one_entry_are_folded_once_and_are_the_same(kind: Kind) -> None:
    """The points of a glyph all have the error of the point that it stands for."""
    random = np.random.default_rng(0)
    inner = Matrix(csr_array(random.standard_normal((6, 5))))
    index, weight = random.integers(0, 6, 40), random.standard_normal(40)
    operator = Gather(index[:, None], weight[:, None], 6).after(inner)
    value = random.random((4, 5) if kind == "members" else 5)
    seen: list[int] = []
    got = fold(kind, value, operator, None, lambda _: seen.append(1))
    assert len(seen) == 1
    assert got == pytest.approx(np.concatenate([fold(kind, value, operator, np.array([i])) for i in range(40)]))
    some = np.array([3, 3, 3, 8, 8, 3])
    assert fold(kind, value, operator, some) == pytest.approx(got[some])


@pytest.mark.parametrize("lattice", LATTICES)
@pytest.mark.parametrize("uneven", [False, True])
def test_one_source_by_several_ways_of_stencils_is_folded_along_the_axes(lattice: tuple[int, ...], uneven: bool) -> None:
    random = np.random.default_rng(len(lattice))
    n = int(np.prod(lattice))
    smooth: Operator = Identity(n)
    for axis in range(len(lattice)):
        smooth = stencil(lattice, axis, (-1, 0, 2), (0.3, 0.5, 0.2)).after(smooth)
    ways = Sum((Identity(n), uniform(lattice, -0.8).after(smooth), stencil(lattice, 0, (-1, 1), (-0.5, 0.5))))
    value = random.uniform(0.5, 2, n) if uneven else np.asarray(1.5)
    wanted = np.sqrt((dense(ways) ** 2) @ np.broadcast_to(value, (n,)) ** 2)
    assert fold("linear", value, ways) == pytest.approx(wanted, rel=1e-9)
    assert folded("linear", value, ways, None) is not None
    some = np.arange(0, n, 2)
    assert fold("linear", value, ways, some) == pytest.approx(wanted[some], rel=1e-9)
    nothing = Sum((smooth, uniform(lattice, -1.0).after(smooth)))
    assert not fold("linear", value, nothing).any()
