"""Truth about the topology of a trilinear isosurface, and a judge of meshes; nothing of the method's tables is used.

The truth of a cell: the trilinear polynomial on k^3 boxes of Freudenthal tetrahedra. Counting the simplices whose corners
lie on both sides gives the Euler characteristic, labelling the corners the regions on each side; a cell's surface has one
piece less than regions (Alexander's duality: it has no closed pieces). k grows until mesh and truth agree, or to `FINEST`;
then a lattice that is dense about saddles and inflection points has the last word.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from scipy.ndimage import label
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from modules.kernels import trilinear

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

STEPS = [np.array(s) for s in itertools.product((0, 1), repeat=3) if any(s)]
UNIT = list(np.eye(3, dtype=int))
NEIGHBOURS = np.zeros((3, 3, 3), bool)
NEIGHBOURS[1, 1, 1] = True
for step in STEPS:
    NEIGHBOURS[tuple(1 + step)] = NEIGHBOURS[tuple(1 - step)] = True

FINEST = 64
BLOCK = 1 << 24
CLEAR = 1e-14
"""Six times the volume of a tetrahedron, in cells, from which on its sign is believed."""


@dataclass
class Verdict:
    """What is wrong with a mesh: how many of each."""

    wrong: dict[str, int] = field(default_factory=dict)
    cells: int = 0
    tunnels: int = 0
    triangles: int = 0
    finest: int = 0
    examples: list[Floats] = field(default_factory=list)
    """Corners 000, 001, ... 111 of xyz of the cells of another topology."""

    @property
    def right(self) -> bool:
        return not any(self.wrong.values())

    def __str__(self) -> str:
        return ", ".join(f"{n} {name}" for name, n in self.wrong.items() if n) or "right"


# ------------------------------------------------------------------ truth
def refined(corner: Floats, k: int) -> Floats:
    """(m, k+1, k+1, k+1) the trilinear polynomials of cells (m, 2, 2, 2)."""
    t = np.arange(k + 1) / k
    for axis in (1, 2, 3):
        w = t.reshape([-1 if a == axis else 1 for a in range(4)])
        low, high = np.take(corner, [0], axis), np.take(corner, [1], axis)
        corner = np.where(w == 0, low, np.where(w == 1, high, (1 - w) * low + w * high))
    return corner


def crossed(above: Bools, steps: list[npt.NDArray[np.int_]]) -> Ints:
    """For each cell, how many simplices from a node along the sums of some steps have ends on both sides."""
    corners = [np.zeros(3, int), *np.cumsum(steps, axis=0)]
    size = np.array(above.shape[1:]) - corners[-1]
    parts = [above[(slice(None), *(slice(c, c + n) for c, n in zip(corner, size, strict=True)))] for corner in corners]
    some, every = parts[0].copy(), parts[0].copy()
    for part in parts[1:]:
        some |= part
        every &= part
    return np.asarray((some & ~every).sum(axis=(1, 2, 3)), np.int64)


def characteristic(above: Bools) -> Ints:
    """Euler characteristic of the surface in each cell."""
    edges = sum(crossed(above, [s]) for s in STEPS)
    faces = sum(crossed(above, [p, q]) for p in STEPS for q in STEPS if (p + q).max() == 1)
    cells = sum(crossed(above, [UNIT[a] for a in order]) for order in itertools.permutations(range(3)))
    return np.asarray(edges - faces + cells, np.int64)


def regions(above: Bools) -> Ints:
    """Number of connected regions above and below in each cell."""
    m, n = above.shape[0], above.shape[1]
    total = np.zeros(m, np.int64)
    apart = np.zeros((m, n + 1, n, n), bool)  # a layer of nothing between two cells
    for side in (above, ~above):
        apart[:, :n] = side
        marks, number = label(apart.reshape(m * (n + 1), n, n), NEIGHBOURS)
        first = np.full(number + 1, -1)
        where = np.flatnonzero(marks)
        first[marks.ravel()[where]] = where // ((n + 1) * n * n)
        total += np.bincount(first[1:], minlength=m)
    return total


def truth(corner: Floats, level: float, k: int) -> tuple[Ints, Ints]:
    """Euler characteristic and pieces of the surface in cells (m, 2, 2, 2)."""
    block = max(1, BLOCK // (k + 1) ** 3)
    found = [
        (characteristic(above), regions(above) - 1)
        for start in range(0, len(corner), block)
        for above in [refined(corner[start : start + block], k) >= level]
    ]
    chi, pieces = (np.concatenate(part) for part in zip(*found, strict=True)) if found else (np.zeros(0, int),) * 2
    return np.asarray(chi, np.int64), np.asarray(pieces, np.int64)


def sharp_truth(corner: Floats, level: float) -> tuple[int, int]:
    """As `truth`, of one cell (2, 2, 2), on a lattice that is dense about its critical coordinates, for thin parts."""
    f = (corner - level).transpose(2, 1, 0).reshape(1, 8)
    with np.errstate(all="ignore"):
        special = [trilinear.inflections(f).reshape(-1, 3), trilinear.body_saddles(f).reshape(-1, 3)]
    for axis in range(3):
        face = np.moveaxis(corner - level, 2 - axis, 0)  # two faces across the axis; the other axes descend
        low, high = [a for a in range(3) if a != axis]
        for g in face:
            twist = g[0, 0] + g[1, 1] - g[0, 1] - g[1, 0]
            if twist != 0:
                at = np.full((1, 3), np.nan)
                at[0, low], at[0, high] = (g[0, 0] - g[1, 0]) / twist, (g[0, 0] - g[0, 1]) / twist
                special.append(at)
    steps = np.concatenate([[0.0], 10.0 ** np.arange(-9, -1.4, 0.5)])
    axes = []
    for axis in range(3):
        c = np.concatenate(special)[:, axis]
        near = c[np.isfinite(c)][:, None] + np.concatenate([-steps, steps])
        axes.append(np.unique(np.concatenate([np.linspace(0, 1, 33), near[(near > 0) & (near < 1)]])))
    values = (corner - level)[None]
    for axis, t in enumerate(reversed(axes), start=1):
        w = t.reshape([-1 if a == axis else 1 for a in range(4)])
        low_side, high_side = np.take(values, [0], axis), np.take(values, [1], axis)
        values = (1 - w) * low_side + w * high_side
    above = values >= 0
    parts = label(above[0], NEIGHBOURS)[1] + label(~above[0], NEIGHBOURS)[1]
    return int(characteristic(above)[0]), parts - 1


# ------------------------------------------------------------------ the mesh
def ends_of(triangles: Ints) -> Ints:
    return triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)


def per_cell(points: int, triangles: Ints, cell: Ints) -> tuple[Ints, Ints, Ints]:
    """Cells with triangles, and Euler characteristic and pieces of the patch of each."""
    which, own = np.unique(cell, return_inverse=True)
    vertex = np.unique(np.repeat(own, 3) * points + triangles.ravel())
    low, high = np.sort(ends_of(triangles), axis=1).T
    edge = np.unique(np.stack([np.repeat(own, 3), low, high]), axis=1)
    chi = np.bincount(vertex // points, minlength=len(which)) - np.bincount(edge[0], minlength=len(which))
    chi += np.bincount(own, minlength=len(which))
    ids = [np.searchsorted(vertex, edge[0] * points + edge[n]) for n in (1, 2)]
    graph = coo_array((np.ones(len(ids[0])), (ids[0], ids[1])), shape=(len(vertex), len(vertex)))
    _, part = connected_components(graph, directed=False)
    _, first = np.unique(part, return_index=True)
    return which, chi, np.bincount(vertex[first] // points, minlength=len(which))


def euler(points: int, triangles: Ints) -> int:
    edges = np.unique(np.sort(ends_of(triangles), axis=1), axis=0)
    return points - len(edges) + len(triangles)


def components(points: int, triangles: Ints) -> int:
    i, j = ends_of(triangles).T
    return int(connected_components(coo_array((np.ones(len(i)), (i, j)), shape=(points, points)), directed=False)[0])


def boundary_loops(points: int, triangles: Ints) -> int:
    """Closed curves of edges with one triangle."""
    ends = ends_of(triangles)
    key, back = ends @ np.array([points, 1]), ends[:, ::-1] @ np.array([points, 1])
    i, j = ends[~np.isin(key, back)].T
    used = np.unique(i)
    if not len(used):
        return 0
    i, j = np.searchsorted(used, i), np.searchsorted(used, j)
    n = len(used)
    return int(connected_components(coo_array((np.ones(len(i)), (i, j)), shape=(n, n)), directed=False)[0])


def faults(
    points: Floats, triangles: Ints, cell: Ints, axes: tuple[Floats, Floats, Floats], finite: bool = True
) -> dict[str, int]:
    """Counts of what no mesh should have.

    Parameters
    ----------
    finite : whether all samples are known, so that the surface may be open only on the border
    """
    n, ends = len(points), ends_of(triangles)
    there, back = ends @ np.array([n, 1]), ends[:, ::-1] @ np.array([n, 1])
    undirected, count = np.unique(np.sort(ends, axis=1) @ np.array([n, 1]), return_counts=True)
    single = ends[~np.isin(there, back)]
    p, q = points[single[:, 0]], points[single[:, 1]]
    low, high = np.array([a[0] for a in axes]), np.array([a[-1] for a in axes])
    border = (((p == low) & (q == low)) | ((p == high) & (q == high))).any(axis=1)
    corner = points[triangles]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    same = (corner == corner[:, :1]).all(axis=1)
    flat = np.zeros(len(triangles), bool)
    for axis in range(3):
        flat |= same[:, axis] & np.isin(corner[:, 0, axis], axes[axis])
    return {
        "open edges": int((~border).sum()) if finite else 0,
        "edges of three triangles": int((count > 2).sum()),
        "edges of two triangles of one sense": len(there) - len(np.unique(there)) if len(undirected) else 0,
        "vertices of two fans": _pinched(n, triangles),
        "triangles without area": int((area == 0).sum()),
        "triangles in a face": int(flat.sum()),
        "doubled triangles": len(triangles) - len(np.unique(np.sort(triangles, axis=1), axis=0)),
        "unused points": n - len(np.unique(triangles)),
        "self-intersections": self_intersections(points, triangles, cell),
    }


def _pinched(points: int, triangles: Ints) -> int:
    """Vertices whose triangles form more than one fan: join the triangles about a vertex that share an edge there."""
    m = len(triangles)
    if not m:
        return 0
    ends = ends_of(triangles)
    key, triangle = np.sort(ends, axis=1) @ np.array([points, 1]), np.repeat(np.arange(m), 3)
    order = np.argsort(key, kind="stable")
    together = np.flatnonzero(key[order][1:] == key[order][:-1])
    one, two = triangle[order[together]], triangle[order[together + 1]]
    links = []
    for vertex in np.sort(ends, axis=1)[order[together]].T:  # corner 3 t + c of each triangle at this end of the edge
        links.append([3 * t + np.argmax(triangles[t] == vertex[:, None], axis=1) for t in (one, two)])
    i, j = (np.concatenate([pair[k] for pair in links]) for k in (0, 1))
    fans = connected_components(coo_array((np.ones(len(i)), (i, j)), shape=(3 * m, 3 * m)), directed=False)[0]
    return int(fans - len(np.unique(triangles)))


def self_intersections(points: Floats, triangles: Ints, cell: Ints) -> int:
    """Pairs of an edge and a triangle of one cell, without a common point, that cross."""
    order = np.argsort(cell, kind="stable")
    start = np.flatnonzero(np.diff(cell[order], prepend=-1))
    size = np.diff(np.append(start, len(order)))
    found = 0
    for n in np.unique(size):
        rows = order[start[size == n][:, None] + np.arange(n)]
        block = max(1, BLOCK // (8 * n * n))
        for part in range(0, len(rows), block):
            found += _crossings(points, triangles, rows[part : part + block], n)
    return found


def _crossings(points: Floats, triangles: Ints, rows: Ints, n: int) -> int:
    one, two = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n)))
    t = triangles[rows]
    found = 0
    for k in range(3):
        edge, face = t[:, one][:, :, [k, (k + 1) % 3]], t[:, two]
        apart = ~(edge[..., :, None] == face[..., None, :]).any(axis=(2, 3))
        e, f = edge[apart], face[apart]
        e, f = e[e[:, 0] < e[:, 1]], f[e[:, 0] < e[:, 1]]
        p, q = points[e[:, 0]], points[e[:, 1]]
        a, b, c = (points[f[:, i]] for i in range(3))
        across = np.stack([_turn(p, a, b, c), -_turn(q, a, b, c)])
        within = np.stack([_turn(p, q, a, b), _turn(p, q, b, c), _turn(p, q, c, a)])
        sure = (np.abs(across) > CLEAR).all(axis=0) & (np.abs(within) > CLEAR).all(axis=0)
        through = (np.abs(np.sign(across).sum(axis=0)) == 2) & (np.abs(np.sign(within).sum(axis=0)) == 3)
        found += int((sure & through).sum())
    return found


def _turn(p: Floats, q: Floats, r: Floats, s: Floats) -> Floats:
    return np.asarray(np.einsum("ij,ij->i", q - p, np.cross(r - p, s - p)))


# ------------------------------------------------------------------ the judge
def cells_of(values: Floats, level: float) -> tuple[Ints, Floats]:
    """Numbers and corners (m, 2, 2, 2) of the cells with finite corners on both sides."""
    corner = np.lib.stride_tricks.sliding_window_view(values, (2, 2, 2))
    above = (corner >= level).sum(axis=(3, 4, 5))
    active = (above > 0) & (above < 8) & np.isfinite(corner).all(axis=(3, 4, 5))
    return np.flatnonzero(active), np.ascontiguousarray(corner[active])


def judged(
    values: Floats, axes: tuple[Floats, Floats, Floats], level: float, mesh: tuple[Floats, Ints, Ints], *, ties: bool = False
) -> Verdict:
    """A mesh (points, triangles, cells) held against the trilinear model.

    Parameters
    ----------
    ties : values lie exactly on the level, where the surface is only a limit: no truth by subdivision is asked for
    """
    points, triangles, cell = mesh
    verdict = Verdict(faults(points, triangles, cell, axes, bool(np.isfinite(values).all())), triangles=len(triangles))
    number, corner = cells_of(values, level)
    verdict.cells = len(number)
    which, chi, pieces = per_cell(len(points), triangles, cell) if len(triangles) else (np.zeros(0, int),) * 3
    if ties:
        return verdict
    verdict.wrong["cells without a patch"] = len(number) - len(np.intersect1d(number, which))
    verdict.wrong["patches outside the cells"] = len(which) - len(np.intersect1d(number, which))
    mine = np.stack([chi, pieces])[:, np.searchsorted(which, np.intersect1d(number, which))]
    left, corner = np.arange(mine.shape[1]), corner[np.isin(number, which)]
    k = 4
    while len(left) and k <= FINEST:
        told = np.stack(truth(corner[left], level, k))
        left = left[(told != mine[:, left]).any(axis=0)]
        verdict.finest, k = k, 2 * k
    left = np.array([n for n in left if sharp_truth(corner[n], level) != tuple(mine[:, n])], int)
    verdict.wrong["cells of another topology"] = len(left)
    verdict.examples = list(corner[left].transpose(0, 3, 2, 1).reshape(-1, 8))
    verdict.tunnels = int((mine[0] < mine[1]).sum())
    return verdict


def whole(values: Floats, level: float, k: int) -> tuple[int, int]:
    """Euler characteristic of the whole surface, and regions above and below, of a grid as one."""
    for axis in range(3):
        n = values.shape[axis]
        t = np.arange((n - 1) * k + 1)
        i = np.minimum(t // k, n - 2)
        w = ((t - i * k) / k).reshape([-1 if a == axis else 1 for a in range(3)])
        low, high = np.take(values, i, axis), np.take(values, i + 1, axis)
        values = np.where(w == 0, low, np.where(w == 1, high, (1 - w) * low + w * high))
    above = (values >= level)[None]
    return int(characteristic(above)[0]), label(above[0], NEIGHBOURS)[1] + label(~above[0], NEIGHBOURS)[1]


def grids(kind: str, count: int, seed: int) -> Iterator[Floats]:
    """Random grids: normal, log-normal, padded (by a constant layer), or ties (integers from -2 to 2, every other padded)."""
    random = np.random.default_rng(seed)
    for n in range(count):
        shape = random.integers(4, 8, 3)
        if kind == "ties":
            values = random.integers(-2, 3, shape).astype(float)
            yield np.pad(values, 1, constant_values=-1.0) if n % 2 else values
            continue
        values = random.normal(size=shape)
        if kind == "log-normal":
            values = np.sign(values) * np.exp(2 * random.normal(size=shape))
        yield np.pad(values, 1, constant_values=-1.0) if kind == "padded" else values
