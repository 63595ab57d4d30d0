"""The kernels of the accuracy algebra, against dense matrices."""

import numpy as np
import numpy.typing as npt
import pytest

from modules.kernels import operators

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Gather = tuple[Integers, Floats, Floats]


def dense(index: Integers, weight: Floats, n_in: int) -> Floats:
    matrix = np.zeros((len(index), n_in))
    for i, (columns, weights) in enumerate(zip(index, weight, strict=True)):
        for j, w in zip(columns, weights, strict=True):
            matrix[i, j] += w
    return matrix


@pytest.fixture
def gather() -> Gather:
    random = np.random.default_rng(5)
    index = random.integers(0, 60, (200, 8))
    index[:50, 3] = index[:50, 1]  # doubled columns
    index[:20, 7] = index[:20, 1]
    weight = random.standard_normal((200, 8))
    weight[10, 3], weight[10, 7] = -weight[10, 1], 0.0  # which cancel
    return index, weight, random.standard_normal(60)


def test_fold_against_a_dense_matrix(gather: Gather) -> None:
    index, weight, value = gather
    for v in (value, np.float64(0.7)):
        rows = dense(index, weight, 60) * v
        expected: dict[operators.Kind, Floats] = {
            "linear": np.sqrt((rows**2).sum(1)),
            "bound": np.abs(rows).sum(1),
            "signed": rows.sum(1),
        }
        for kind, sizes in expected.items():
            assert operators.gather_fold(index, weight, v, kind) == pytest.approx(sizes, rel=1e-13, abs=1e-14)


def test_a_field_minus_itself_has_no_error() -> None:
    index, weight = np.array([[4, 4]]), np.array([[1.0, -1.0]])
    assert operators.gather_fold(index, weight, np.ones(9), "linear") == 0
    assert operators.gather_fold(index, weight, 1.0, "bound") == 0


def averaging(size: int, taps: list[float]) -> Floats:
    """Dense matrix of a stencil whose ends repeat the border sample."""
    matrix = np.zeros((size, size))
    for p in range(size):
        for offset, w in enumerate(taps, -(len(taps) // 2)):
            matrix[p, min(max(p + offset, 0), size - 1)] += w
    return matrix


def band_of(covariance: Floats, reach: int) -> Floats:
    size = len(covariance)
    band = np.full((size, 2 * reach + 1), np.nan)  # outside the lattice nothing may be read
    for p in range(size):
        for d in range(-reach, reach + 1):
            if 0 <= p + d < size:
                band[p, d + reach] = covariance[p, p + d]
    return band


@pytest.mark.parametrize("lattice", [(4, 5, 6), (1, 7, 3), (1, 1, 9), (2, 1, 1)])
def test_variance_of_a_gather_over_stencils_against_a_dense_matrix(lattice: tuple[int, int, int]) -> None:
    random = np.random.default_rng(6)
    taps = [[0.25, 0.5, 0.25], [-0.1, 0.2, 0.5, 0.3, 0.1], [-0.5, 0.0, 0.5]]
    stencils = [averaging(size, t) if size > 1 else np.eye(1) for size, t in zip(lattice, taps, strict=True)]
    bands = [band_of(s @ s.T, min(len(t) - 1, max(n - 1, 0))) for s, t, n in zip(stencils, taps, lattice, strict=True)]
    index = random.integers(0, np.prod(lattice), (100, 5))
    weight = random.standard_normal((100, 5))
    index[:30, 2] = index[:30, 0]
    whole = np.kron(np.kron(stencils[0], stencils[1]), stencils[2])
    expected = ((dense(index, weight, whole.shape[0]) @ whole) ** 2).sum(1)
    got = operators.stencil_gather_variance(index, weight, lattice, *bands)
    assert got == pytest.approx(expected, rel=1e-12, abs=1e-14)
    assert (got >= 0).all()


def test_what_does_not_fit_is_refused() -> None:
    index, weight, one = np.array([[0, 9]]), np.ones((1, 2)), np.ones((1, 1))
    with pytest.raises(IndexError, match="outside"):
        operators.gather_fold(index, weight, np.ones(9), "bound")
    with pytest.raises(IndexError, match="outside"):
        operators.gather_fold(-index, weight, 1.0, "bound")
    with pytest.raises(IndexError, match="outside"):
        operators.stencil_gather_variance(index, weight, (1, 1, 9), one, one, np.ones((9, 1)))
    with pytest.raises(ValueError, match="one gather"):
        operators.gather_fold(index, np.ones((2, 1)), 1.0, "bound")
    with pytest.raises(ValueError, match="band"):
        operators.stencil_gather_variance(index, weight, (1, 1, 10), one, one, np.ones((10, 2)))
    with pytest.raises(ValueError, match="kind"):
        operators.gather_fold(index, weight, 1.0, "members")  # type: ignore[arg-type]  # wrong on purpose


def test_read_only_and_other_types_are_welcome(gather: Gather) -> None:
    index, weight, value = gather
    value.flags.writeable = False
    got = operators.gather_fold(index.astype(np.int32), weight, value, "bound")
    assert (got == operators.gather_fold(index, weight, value.copy(), "bound")).all()
