"""What kinds of cells a surface passes: configurations, topological polygons, tunnels, and where simpler methods go wrong.

A polygon Pi/j has i sides and loop-back faces on j axes (two sides on one face); opposite loop-back faces count once.

Source: Lopes 1999, 4.1.1 (definitions 4.1.1.2 to 4.1.1.4) and tables 4.1 to 4.7.
"""

import functools
from collections import Counter
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from modules.kernels import straight, trilinear
from modules.kernels.marching_cases import EDGE_ENDS, FACE_CORNERS

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

INNER = {"P8/2": 2, "P9/3": 3, "P12/3": 6}
"""Inner points of the polygons that need more than one."""


@functools.cache
def bent_back(loop: tuple[int, ...]) -> frozenset[int]:
    """The faces on which a polygon has two sides."""
    faces = [straight.faces_of(e) & straight.faces_of(loop[(n + 1) % len(loop)]) for n, e in enumerate(loop)]
    flat = [face for common in faces for face in common]
    return frozenset(face for face in flat if flat.count(face) == 2)


@functools.cache
def polygon_name(loop: tuple[int, ...]) -> str:
    """The class Pi/j of a polygon."""
    return f"P{len(loop)}/{len({face // 2 for face in bent_back(loop)})}"


def triangles_of(name: str) -> int:
    """Triangles of a polygon that is a disc, cut with its shoulder points and inner points."""
    return 2 * _sides(name) + 2 * INNER.get(name, 1) - 2


def triangles_of_tunnel(names: tuple[str, ...]) -> int:
    """Triangles of polygons that a tunnel joins."""
    return sum(2 * _sides(name) + 6 for name in names)


def _sides(name: str) -> int:
    return int(name[1:].split("/")[0])


@functools.cache
def configuration(code: int) -> int:
    """The configuration 0 to 13 of a pattern of corners above, under rotation, reflection and complement."""
    few = code if code.bit_count() <= 4 else 255 - code
    corners = [c for c in range(8) if few >> c & 1]
    pairs = [(a, b) for a in corners for b in corners if a < b]
    near = [(a, b) for a, b in pairs if (a ^ b).bit_count() == 1]
    degree = Counter(c for pair in near for c in pair)
    match len(corners), len(near):
        case 2, 0:
            return 3 if (corners[0] ^ corners[1]).bit_count() == 2 else 4
        case 4, 3:
            return 9 if max(degree.values()) == 3 else 11
        case 4, 2:
            return 12 if max(degree.values()) == 2 else 10
        case n, edges:
            return {(0, 0): 0, (1, 0): 1, (2, 1): 2, (3, 2): 5, (3, 1): 6, (3, 0): 7, (4, 4): 8, (4, 0): 13}[n, edges]


@functools.cache
def parts(code: int, faces: int) -> tuple[int, int]:
    """Into how many parts the border of a cell falls above and below."""
    root = list(range(8))

    def find(c: int) -> int:
        while root[c] != c:
            c = root[c]
        return c

    pairs = [(int(a), int(b)) for a, b in EDGE_ENDS]
    for face in range(6):
        corner = [int(c) for c in FACE_CORNERS[face]]
        pairs.append((corner[0], corner[2]) if faces >> face & 1 else (corner[1], corner[3]))
    for n, (a, b) in enumerate(pairs):
        ambiguous = n < 12 or _is_ambiguous(code, n - 12)
        if ambiguous and (code >> a & 1) == (code >> b & 1):
            root[find(a)] = find(b)
    above = {find(c) for c in range(8) if code >> c & 1}
    return len(above), len({find(c) for c in range(8)} - above)


def _is_ambiguous(code: int, face: int) -> bool:
    side = [code >> int(c) & 1 for c in FACE_CORNERS[face]]
    return side[0] == side[2] != side[1] == side[3]


@functools.cache
def ambiguous_faces(code: int) -> int:
    """How many faces have corners above and below by turns."""
    return sum(_is_ambiguous(code, face) for face in range(6))


KNOWN = ("P3/0", "P4/0", "P5/0", "P6/0", "P6/1", "P7/1", "P8/1", "P8/2", "P9/3", "P12/3")
"""Every class of polygon, in the thesis's order."""

PAIRS = (("P3/0", "P3/0"), ("P3/0", "P4/0"), ("P3/0", "P5/0"), ("P3/0", "P6/0"), ("P4/0", "P4/0"))
"""Polygons that a tunnel may join (table 4.4)."""


class Cells(NamedTuple):
    """The cells that a surface passes, each with its kind.

    Attributes
    ----------
    active : the cells
    faces : (c,) bits of the ambiguous faces whose corners 0 and 2 are joined, by the asymptotic decider
    ambiguous : (c,) number of ambiguous faces
    tunnel : (c,) whether a tunnel goes through the cell
    third : (c,) whether a polygon P8/2 has a third inflection point within, which makes two more triangles
    classic_wrong : (c,) whether the table of 1987 joins a face otherwise, or there is a tunnel
    mean_wrong : (c,) whether the means of faces join otherwise, or there is a tunnel
    saddle_wrong : (c,) whether the test of the body saddle says another thing of the tunnel
    """

    active: straight.Active
    faces: Integers
    ambiguous: Integers
    tunnel: Bools
    third: Bools
    classic_wrong: Bools
    mean_wrong: Bools
    saddle_wrong: Bools


def cells(values: Floats, level: float) -> Cells:
    """The cells that the surface F = level passes, told apart.

    Parameters
    ----------
    values : (nz, ny, nx)

    Accuracy: faces exactly; tunnels by inflection points in double precision.
    """
    found = straight.active(values, level)
    faces = straight.joined(found, level, "decider")
    count = np.array([ambiguous_faces(code) for code in range(256)])
    ambiguous = count[found.code]
    kind, which = np.unique(found.code * 64 + faces, return_inverse=True)
    polygons = np.array([len(straight.loops(k // 64, k % 64)) for k in kind.tolist()], np.int64)[which.ravel()]
    tunnel = np.zeros(len(faces), bool)
    predicted, third = np.zeros(len(faces), bool), np.zeros(len(faces), bool)
    several = np.flatnonzero(polygons > 1)
    if len(several):
        f = found.value[several] - level
        tunnel[several] = trilinear.inner_inflections(f).all(axis=(1, 2))
        predicted[several] = by_body_saddle(f, found.code[several], faces[several])
    names = [[polygon_name(loop) for loop in straight.loops(k // 64, k % 64)] for k in kind.tolist()]
    bent = np.flatnonzero(np.array(["P8/2" in some for some in names], bool)[which.ravel()])
    if len(bent):
        third[bent] = trilinear.inner_inflections(found.value[bent] - level).sum(axis=(1, 2)) == 3
    classic = straight.joined(found, level, "classic") != faces
    mean = straight.joined(found, level, "four_triangles") != faces
    return Cells(found, faces, ambiguous, tunnel, third, classic | tunnel, mean | tunnel, predicted != tunnel)


def by_body_saddle(f: Floats, code: Integers, faces: Integers) -> Bools:
    """(m,) whether the body saddle says that parts of one side are joined through the cell.

    It does where a saddle lies in the cell on the side that falls into two or more parts on the cell's border.

    Source: Natarajan 1994.
    """
    saddle = trilinear.body_saddles(f)
    at = trilinear.value(f, saddle)
    number = np.array([parts(c, j) for c, j in zip(code.tolist(), faces.tolist(), strict=True)])
    several = np.where(at >= 0, number[:, :1], number[:, 1:]) > 1
    return np.asarray((trilinear.inside(saddle) & several).any(axis=1))


def count(known: Cells) -> tuple[Counter[str], Counter[tuple[str, ...]], int]:
    """Polygons that are discs, those that tunnels join, and the number of triangles of the accurate method."""
    discs, tunnels = Counter[str](), Counter[tuple[str, ...]]()
    kind = (known.active.code * 64 + known.faces) * 2 + known.tunnel
    for packed, number in zip(*(a.tolist() for a in np.unique(kind, return_counts=True)), strict=True):
        names = sorted((polygon_name(loop) for loop in straight.loops(packed // 128, packed // 2 % 64)), key=_sides)
        if packed % 2:
            joined = (names[0], names[-1])  # of three polygons, one with three sides stays alone
            tunnels[joined] += number
            names = names[1:-1]
        for name in names:
            discs[name] += number
    triangles = sum(n * triangles_of(name) for name, n in discs.items())
    triangles += sum(n * triangles_of_tunnel(pair) for pair, n in tunnels.items())
    return discs, tunnels, triangles + 2 * int(known.third.sum())


class Kind(NamedTuple):
    """A subcase: the same configuration and polygons.

    Attributes
    ----------
    configuration : 1 to 13
    polygons : their classes, in order
    ambiguous : ambiguous faces
    tunnel : whether random cells of it had tunnels
    patterns : of corners and faces that are of this kind
    """

    configuration: int
    polygons: tuple[str, ...]
    ambiguous: int
    tunnel: bool
    patterns: int


TUNNEL_OF_13 = (16.1, -9.9, -15.6, 5.6, -19.6, 13.4, 20.0, -11.7)
"""A cell of configuration 13 with a wide tunnel; the thesis thought that there is none."""


@functools.cache
def kinds(cells_each: int = 2000) -> tuple[Kind, ...]:
    """Every subcase that random trilinear cells have, found by looking at so many of each configuration.

    A tenth of those of configuration 13 lie about one with a tunnel, which is rare there.
    """
    random = np.random.default_rng(20)
    seen: dict[tuple[int, tuple[str, ...], int], tuple[bool, int]] = {}
    for code in range(1, 255):
        several = 4 if configuration(code) == 13 else 1
        value = np.exp(1.5 * random.normal(size=(several * cells_each // 8 + 8, 8)))
        if several > 1:
            value[: len(value) // 10] = np.abs(TUNNEL_OF_13) * (1 + 0.02 * random.normal(size=(len(value) // 10, 8)))
        value[:, [c for c in range(8) if not code >> c & 1]] *= -1
        found = straight.Active(np.arange(len(value)), np.zeros((len(value), 8), np.int64), value, np.full(len(value), code))
        faces = straight.joined(found, 0.0, "decider")
        joins = np.asarray(trilinear.inner_inflections(value).all(axis=(1, 2)))
        for packed in np.unique(faces).tolist():
            loops = straight.loops(code, packed)
            names = tuple(sorted((polygon_name(loop) for loop in loops), key=lambda n: (_sides(n), n)))
            key = (configuration(code), names, ambiguous_faces(code))
            tunnel = len(loops) > 1 and bool(joins[faces == packed].any())
            before = seen.get(key, (False, 0))
            seen[key] = (before[0] or tunnel, before[1] + 1)
    return tuple(Kind(*key, *told) for key, told in sorted(seen.items()))
