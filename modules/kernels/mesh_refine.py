"""An isosurface with few triangles, each proven to be within a tolerance of the trilinear surface.

In turn: triangles that lie one above another are straightened, those that are too far are cut, until all are proven; then
points are merged as long as that stays so. What cannot be proven after some rounds is left as it is.

Source: Lopes 1999, 4.4 and 4.5, with a proof where the thesis has an estimate.
"""

from collections.abc import Callable

import numpy as np

from modules.kernels import mesh_merge, mesh_split
from modules.kernels.marching_cases import Floats, Integers
from modules.kernels.mesh_proof import Field, Slabs, reaches
from modules.kernels.mesh_split import Mesh

ROUNDS = 10
"""Of two cuts: edges are then a thirtieth of what they were."""

PATIENCE = 3
"""Rounds after which a cell with unproven triangles is left."""

MOST = 20_000_000
"""Triangles, if the caller names no limit."""


def refined(
    field: Field, points: Floats, triangles: Integers, cell: Integers, tolerance: float, *, merge: bool = True,
    most: int = MOST, slabs: Slabs | None = None, check: Callable[[float], None] = lambda fraction: None,
) -> Mesh:  # fmt: skip
    """A mesh within a tolerance of the surface, made of one whose triangles lie in cells and whose points lie on it.

    Parameters
    ----------
    points, triangles, cell : (n, 3), (m, 3), (m,), as of `marching.surface`
    tolerance : distance
    merge : whether points are merged where the tolerance allows; else triangles are only cut
    most : triangles
    slabs : shares the work, as `Progress.map` does
    check : called with the fraction done; what it raises ends the work

    Returns
    -------
    Mesh
        Its reach is proven, rounding included; infinite where nothing could be proven.

    Raises
    ------
    ValueError : the tolerance is not above what rounding may do, or there would be too many triangles
    """
    asked = field.asked(tolerance)
    if not asked > 0:
        least = field.place * 2.0**-45
        raise ValueError(f"the tolerance {tolerance:g} is below {least:.1g}: less cannot be proven with these coordinates")
    reach = reaches(field, points, triangles, cell, np.inf, slabs=slabs)
    mesh = mesh_merge.unfolded(field, Mesh(points, triangles, cell, reach))
    far = np.flatnonzero(mesh.reach > asked)
    mesh.reach[far] = reaches(field, mesh.points, mesh.triangles, mesh.cell, asked, which=far, slabs=slabs)
    left = np.zeros(0, np.int64)
    for n in range(ROUNDS):
        check(0.1 + 0.6 * n / ROUNDS)
        before = len(mesh.triangles)
        mesh = mesh_split.cut(field, mesh, asked, most, left=left, slabs=slabs)
        if (mesh.reach <= asked).all() or len(mesh.triangles) == before:
            break
        mesh = mesh_merge.unfolded(field, mesh)
        if n + 1 >= PATIENCE:
            left = np.unique(np.append(left, mesh.cell[np.isinf(mesh.reach)]))
    check(0.7)
    if merge:
        mesh = mesh_merge.merged(field, mesh, asked)
    far = np.flatnonzero(mesh.reach > asked)
    mesh.reach[far] = reaches(field, mesh.points, mesh.triangles, mesh.cell, np.inf, which=far, slabs=slabs)
    check(1.0)
    return mesh._replace(reach=field.surely(mesh.reach))


def warm() -> None:
    """The kernels of this file are those of the files it is made of."""
