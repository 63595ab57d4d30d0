"""Error times triangles of refined isosurfaces, relative to Marching Cubes in the same run.

`nonius bench refine`. The error is the root mean square of the distance from points spread evenly on the mesh to the
trilinear surface, in cells; the surface is a mesh that is proven to be within 1/500 of a cell of it (1/100 for random
values). Marching Cubes of k^3 times as many samples has error / k^2 with k^2 times as many triangles, a product of about 1:
what is below 1 is better than that. A second table tells how well numbers of a triangle rank its proven distance, a third
how the recursion at G stalls.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree
from scipy.stats import spearmanr

sys.path.insert(0, str(Path(__file__).parents[2]))

from modules.kernels import marching, mesh_centre, mesh_faces, mesh_refine, straight
from modules.kernels.mesh_proof import Field, reaches

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Case = tuple[Floats, float, float]
"""Values, level, and how near the surface that stands for the exact one is."""


def cases() -> dict[str, Case]:
    """The fields."""

    def lattice(n: int, half: float = 1.0) -> tuple[Floats, Floats, Floats]:
        axis = np.linspace(-half, half, n)
        z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
        return x, y, z

    x, y, z = lattice(10)
    sphere = 0.713 - np.sqrt(x * x + y * y + z * z)
    x, y, z = lattice(14)
    torus = 0.3 - np.hypot(np.hypot(x, y) - 0.55, z)
    centres = ((-0.3, 0, 0.1), (0.3, 0.1, 0), (0, 0.3, 0.3))
    balls = sum(np.exp(-8 * ((x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2)) for a, b, c in centres)
    x, y, z = lattice(16, np.pi)
    gyroid = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    x, y, z = lattice(31)
    waves = (1 - np.sin(np.pi * z / 2) + 0.25 * (1 + np.cos(12 * np.pi * np.cos(np.pi * np.hypot(x, y) / 2)))) / 2.5
    return {
        "sphere": (sphere, 0.0, 0.002), "torus": (torus, 0.0, 0.002), "gyroid": (gyroid, 0.1, 0.002),
        "metaballs": (np.asarray(balls), 0.4, 0.002), "random": (np.random.default_rng(5).normal(size=(10, 10, 10)), 0.0, 0.01),
        "Marschner-Lobb": (waves, 0.5, 0.01),
    }  # fmt: skip


def axes_of(values: Floats) -> tuple[Floats, Floats, Floats]:
    """Coordinates one apart."""
    nz, ny, nx = values.shape
    return np.arange(float(nx)), np.arange(float(ny)), np.arange(float(nz))


def spread(points: Floats, triangles: Ints, count: int) -> Floats:
    """Points spread evenly on a mesh, the same for the same mesh."""
    random = np.random.default_rng(7)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    which = random.choice(len(triangles), count, p=area / area.sum())
    u, v = random.random((2, count))
    u, v = np.where(u + v > 1, 1 - u, u)[:, None], np.where(u + v > 1, 1 - v, v)[:, None]
    return np.asarray(a[which] + u * (b - a)[which] + v * (c - a)[which])


def to_triangles(p: Floats, a: Floats, b: Floats, c: Floats) -> Floats:
    """Distances of points (n, 3) from triangles with corners (n, 3)."""

    def to_edge(s: Floats, t: Floats) -> Floats:
        d = t - s
        share = np.clip(((p - s) * d).sum(1) / np.maximum((d * d).sum(1), 1e-300), 0, 1)
        return np.asarray(np.linalg.norm(p - s - share[:, None] * d, axis=1))

    n = np.cross(b - a, c - a)
    inside = np.ones(len(p), bool)
    for s, t in ((a, b), (b, c), (c, a)):
        inside &= (np.cross(t - s, p - s) * n).sum(1) >= 0
    plane = np.abs(((p - a) * n).sum(1)) / np.maximum(np.linalg.norm(n, axis=1), 1e-300)
    return np.where(inside, plane, np.minimum(np.minimum(to_edge(a, b), to_edge(b, c)), to_edge(c, a)))


class Surface:
    """A mesh near enough to the trilinear surface to stand for it."""

    def __init__(self, points: Floats, triangles: Ints) -> None:
        self.corners = [points[triangles[:, k]] for k in range(3)]
        self.tree = cKDTree(sum(self.corners) / 3)

    def away(self, points: Floats) -> Floats:
        """Distances of points from it."""
        _, near = self.tree.query(points, k=min(12, self.tree.n))
        each = [to_triangles(points, *(corner[n] for corner in self.corners)) for n in near.T]
        return np.asarray(np.min(each, axis=0))


def rms(surface: Surface, points: Floats, triangles: Ints, count: int = 30_000) -> float:
    """Root mean square of the distance from a mesh to the surface."""
    return float(np.sqrt(np.mean(surface.away(spread(points, triangles, count)) ** 2)))


def products(names: Sequence[str], shares: Sequence[float]) -> None:
    """The first table."""
    print("Root mean square error times triangles, Marching Cubes = 1; tolerance in rms errors of Marching Cubes\n")
    print(f"{'field':>15} {'MC':>8} {'rms':>8} {'AMC':>8} {'Q':>5}   tolerance: triangles, Q, not proven, seconds")
    for name in names:
        values, level, fine = cases()[name]
        x, y, z = axes_of(values)
        field = Field(values, x, y, z, level)
        amc = marching.surface(values, x, y, z, level)
        mesh = amc.points, amc.triangles, amc.cell
        exact = mesh_refine.refined(field, *mesh, fine, merge=False)
        surface = Surface(exact.points, exact.triangles)
        points, triangles, _ = straight.surface(values, x, y, z, level, "classic")
        one = rms(surface, points, triangles)
        own = rms(surface, amc.points, amc.triangles) * len(amc.triangles) / (one * len(triangles))
        line = f"{name:>15} {len(triangles):>8} {one:>8.5f} {len(amc.triangles):>8} {own:>5.2f}  "
        for share in shares:
            start = time.perf_counter()
            made = mesh_refine.refined(field, *mesh, share * one)
            seconds = time.perf_counter() - start
            q = rms(surface, made.points, made.triangles) * len(made.triangles) / (one * len(triangles))
            left = int((made.reach > share * one).sum())
            line += f" {share:g}: {len(made.triangles)}, {q:.2f}, {left}, {seconds:.1f}s;"
        print(line, flush=True)


def ranks(names: Sequence[str]) -> None:
    """The second table: rank correlation of the thesis's numbers of a triangle with its proven distance."""
    print("\nRank correlation with the proven distance, triangles of Marching Cubes and of ours (proven ones)\n")
    print(f"{'field':>15} {'mesh':>5} {'own sides':>10} {'whole cell':>10} {'G':>6}   proven / G, median")
    for name in names:
        values, level, _ = cases()[name]
        axes = axes_of(values)
        field, amc = Field(values, *axes, level), marching.surface(values, *axes, level)
        meshes = straight.surface(values, *axes, level, "classic"), (amc.points, amc.triangles, amc.cell)
        for words, mesh in zip(("MC", "AMC"), meshes, strict=True):
            reach = reaches(field, *mesh, np.inf)
            sides, (_, away) = mesh_faces.areas(field, *mesh), mesh_centre.centres(field, *mesh)
            kept = np.isfinite(reach) & (away > 1e-9)
            numbers = [mesh_faces.of_triangles(sides, mesh[2], whole) for whole in (False, True)]
            own, whole, g = (spearmanr(reach[kept], number[kept]).statistic for number in (*numbers, away))
            ratio = np.median(reach[kept] / away[kept])
            print(f"{name:>15} {words:>5} {own:>10.2f} {whole:>10.2f} {g:>6.2f}   {ratio:.1f}", flush=True)


def stalls(names: Sequence[str]) -> None:
    """The third table: triangles and rms error after each round of the recursion at G."""
    print("\nOne triangle becomes three at G, again and again: triangles and rms error\n")
    for name in names:
        values, level, fine = cases()[name]
        axes = axes_of(values)
        field = Field(values, *axes, level)
        amc = marching.surface(values, *axes, level)
        exact = mesh_refine.refined(field, amc.points, amc.triangles, amc.cell, fine, merge=False)
        surface = Surface(exact.points, exact.triangles)
        words = [f"{name:>15}"]
        for rounds in range(6):
            made = mesh_centre.recursed(field, amc.points, amc.triangles, amc.cell, 2 * fine, rounds, 3_000_000)
            words.append(f"{len(made.triangles)}: {rms(surface, made.points, made.triangles):.5f}")
        print("  ".join(words), flush=True)


def main(argv: Sequence[str] | None = None) -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fields", nargs="*", default=list(cases()))
    parser.add_argument("--shares", nargs="*", type=float, default=[3.0, 1.5, 0.75])
    options = parser.parse_args([] if argv is None else argv)
    products(options.fields, options.shares)
    ranks(options.fields)
    stalls([name for name in options.fields if name in ("sphere", "gyroid")])


if __name__ == "__main__":
    main(sys.argv[1:])
