"""Polygons about the straight lines of the surface: tunnels, loop-back polygons, and how vertices join the inner points.

The sides of the hexagon of inflection points, and the parts of their lines that go on to the faces, lie exactly on the
surface. So the ends of the lines tell, around each polygon, which inner point the vertices between them belong to.

Source: Lopes 1999, sections 4.2.2.1 and 4.2.2.3; configuration 13 has tunnels too.
"""

import math
from importlib import import_module

from modules.kernels._jit import lean_part
from modules.kernels.marching_cases import INNER, Cell, Floats, Integers, int64
from modules.kernels.marching_inner import slot_of
from modules.kernels.marching_points import HEXAGON, put

SIX, TWELVE, FIRST_INNER = int64(6), int64(12), int64(INNER)
SAME = 1e-6
"""Of the cell: points that agree so far in two coordinates lie on one straight line of the surface."""


@lean_part
def vertex_around(cell: Cell, polygon: int, i: int) -> int:
    """The i-th vertex around a polygon: crossings and shoulder points by turns."""
    k = cell.start[polygon] + i // 2
    result: int = cell.loop[k] if i % 2 == 0 else 12 + 2 * cell.face[k] + cell.slot[k]
    return result


@lean_part
def add_triangle(cell: Cell, p: int, q: int, r: int) -> None:
    """One more triangle of the patch."""
    n = cell.count[1]
    cell.triangle[n, 0], cell.triangle[n, 1], cell.triangle[n, 2] = p, q, r
    cell.count[1] = n + 1


@lean_part
def hexagon_lines(cell: Cell) -> None:
    """The twelve ends, on faces, of the six straight lines through the hexagon."""
    for k in range(6):
        after = (k + 1) % 6
        axis = 0
        while HEXAGON[k, 1 + axis] == HEXAGON[after, 1 + axis]:
            axis += 1
        rising = cell.hexagon[k, axis] < cell.hexagon[after, axis]
        low, high = (k, after) if rising else (after, k)
        _end_line(cell, 2 * k, low, cell.hexagon[k], axis)
        _end_line(cell, 2 * k + 1, high, cell.hexagon[k], axis + 3)


@lean_part
def _end_line(cell: Cell, n: int, point: int, through: Floats, way: int) -> None:
    """The end of a line through a point, on a face: the low ones of the axes come first."""
    axis, side = way % 3, way // 3
    put(cell.ray_at[n], through)
    cell.ray_at[n, axis] = side
    cell.ray[n, 0], cell.ray[n, 1] = point, 2 * axis + side
    cell.ray[n, 2] = slot_of(cell, 2 * axis + side, cell.ray_at[n])


@lean_part
def owner(cell: Cell, n: int) -> int:
    """The polygon on which the n-th line ends; -1 if on none."""
    return cell.arc[cell.ray[n, 1], cell.ray[n, 2], 2] if cell.ray[n, 2] >= 0 else -1


@lean_part
def order_around(cell: Cell, polygon: int, size: int, lines: int) -> int:
    """Vertices and ends of lines in their order around a polygon, as tokens; their number."""
    n = 0
    for i in range(size):
        k = cell.start[polygon] + i
        face, slot = cell.face[k], cell.slot[k]
        p, q = cell.at[cell.arc[face, slot, 0]], cell.at[cell.arc[face, slot, 1]]
        cell.token[n, 0], cell.token[n, 1] = 0, 2 * i
        n += 1
        begin = n
        place = cell.spot
        for line in range(-1, lines):
            if line >= 0 and not (cell.ray[line, 1] == face and cell.ray[line, 2] == slot):
                continue
            at = cell.at[12 + 2 * face + slot] if line < 0 else cell.ray_at[line]
            along = (at[0] - p[0]) * (q[0] - p[0]) + (at[1] - p[1]) * (q[1] - p[1]) + (at[2] - p[2]) * (q[2] - p[2])
            m = n
            while m > begin and place[m - 1 - begin] > along:
                place[m - begin] = place[m - 1 - begin]
                cell.token[m, 0], cell.token[m, 1] = cell.token[m - 1, 0], cell.token[m - 1, 1]
                m -= 1
            place[m - begin] = along
            cell.token[m, 0] = 0 if line < 0 else 1
            cell.token[m, 1] = 2 * i + 1 if line < 0 else cell.ray[line, 0]
            n += 1
    return n


@lean_part
def assign_hexagon(cell: Cell, tokens: int) -> None:
    """To each vertex around a polygon the point of the hexagon that it sees between the lines around it."""
    for i in range(tokens):
        if cell.token[i, 0]:
            continue
        before, after = (i - 1) % tokens, (i + 1) % tokens
        while not cell.token[before, 0]:
            before = (before - 1) % tokens
        while not cell.token[after, 0]:
            after = (after + 1) % tokens
        here = cell.token[before, 1]
        step = (cell.token[after, 1] - here) % 6
        if step == 2:
            here = (here + 1) % 6
        elif step == 4:
            here = (here - 1) % 6
        cell.ring[cell.token[i, 1]] = here


@lean_part
def zip_ring(cell: Cell, polygon: int, size: int, base: int, points: int) -> int:
    """Triangles between a polygon and a ring of inner points, from `base` on; how many points it goes round."""
    n, turns = 2 * size, 0
    for i in range(n):
        j = (i + 1) % n
        this, that = vertex_around(cell, polygon, i), vertex_around(cell, polygon, j)
        here = cell.ring[i]
        add_triangle(cell, this, that, base + here)
        step = (cell.ring[j] - here) % points
        if points > 2 and 2 * step > points:
            step -= points
        while step != 0:
            s = 1 if step > 0 else -1
            there = (here + s) % points
            add_triangle(cell, that, base + there, base + here)
            here = there
            step -= s
            turns += s
    return turns


@lean_part
def hexagon_patch(cell: Cell, polygons: int) -> int:
    """The patch of the polygons that the six straight lines meet: a tunnel between two, or a disc; a bit for each.

    0, and no triangle, where rounding spoils the order of the lines: the polygons are then taken one by one.
    """
    hexagon_lines(cell)
    met = 0
    for n in range(12):
        polygon = owner(cell, n)
        if polygon < 0:
            return 0
        met |= 1 << polygon
    number, total, turned = 0, 0, 0
    for polygon in range(polygons):
        if (met >> polygon) & 1:
            size = cell.start[polygon + 1] - cell.start[polygon]
            assign_hexagon(cell, order_around(cell, polygon, size, TWELVE))
            turns = zip_ring(cell, polygon, size, FIRST_INNER, SIX)
            number, total, turned = number + 1, total + turns, turned + abs(turns)
    if not ((number == 1 and turned == 6) or (number == 2 and turned == 12 and total == 0)):
        cell.count[1] = 0
        return 0
    if number == 1:  # one polygon all around: the hexagon itself is part of the surface
        s = 1 if total > 0 else 5
        for n in range(3):
            corner = INNER + 2 * n * s % 6
            add_triangle(cell, corner, INNER + (2 * n + 1) * s % 6, INNER + (2 * n + 2) * s % 6)
        add_triangle(cell, FIRST_INNER, INNER + 2 * s % 6, INNER + 4 * s % 6)
    for n in range(6):
        put(cell.at[INNER + n], cell.hexagon[n])
    cell.count[0] = 6
    return met


@lean_part
def loop_back_patch(cell: Cell, polygon: int, size: int, axes: int) -> bool:
    """A polygon with loop-back faces: about the inflection point of their axis, or a chain of two or three."""
    base, chain = cell.count[0], cell.chain
    single = axes == 1 or axes == 2 or axes == 4
    points = _gather_chain(cell, axes if single else int64(7), chain, cell.kind)
    if single:
        if points != 1:
            return False
        put(cell.at[INNER + base], chain[0])
        cell.count[0] = base + 1
        fan(cell, polygon, size, INNER + base)
        return True
    if not 2 <= points <= 3:
        return False
    lines = _chain_lines(cell, polygon, chain, cell.kind, points)
    if lines < 0:
        return False
    _assign_chain(cell, polygon, order_around(cell, polygon, size, lines), chain)
    return _close_chain(cell, polygon, size, chain, points)


@lean_part
def _gather_chain(cell: Cell, axes: int, chain: Floats, kind: Integers) -> int:
    """The inflection points of some axes, and their axis; their number."""
    points = 0
    for n in range(6):
        if not math.isnan(cell.bend[n, 0]) and (axes >> (n // 2)) & 1:
            put(chain[points], cell.bend[n])
            kind[points] = n // 2
            points += 1
    return points


@lean_part
def fan(cell: Cell, polygon: int, size: int, centre: int) -> None:
    """A triangle from each side of a polygon to an inner point."""
    for i in range(2 * size):
        j = (i + 1) % (2 * size)
        add_triangle(cell, vertex_around(cell, polygon, i), vertex_around(cell, polygon, j), centre)


@lean_part
def _chain_lines(cell: Cell, polygon: int, chain: Floats, kind: Integers, points: int) -> int:
    """The ends, on arcs of the polygon, of the lines through the points of a chain; -1 if some point has none."""
    lines, seen = int64(0), 0
    for n in range(points):
        for axis in range(3):
            if axis == kind[n]:
                continue  # an inflection point lies on lines along the two other axes
            for side in range(2):
                free = True
                for m in range(points):
                    same = m != n and kind[m] != axis
                    for other in range(3):
                        same = same and (other == axis or abs(chain[m, other] - chain[n, other]) < SAME)
                    if same and (chain[m, axis] > chain[n, axis]) == (side == 1):
                        free = False  # this way lies a neighbour, not a face
                if free and lines < 12:
                    _end_line(cell, lines, n, chain[n], axis + 3 * side)
                    if owner(cell, lines) == polygon:
                        lines += 1
                        seen |= 1 << n
    result: int = lines if seen == (1 << points) - 1 else -1
    return result


@lean_part
def _assign_chain(cell: Cell, polygon: int, tokens: int, chain: Floats) -> None:
    """To each vertex around a polygon a point of the chain; where two may do, those before a cut get the first."""
    for i in range(tokens):
        if cell.token[i, 0] == 0:
            continue
        gap, j = 0, (i + 1) % tokens
        while cell.token[j, 0] == 0:
            gap, j = gap + 1, (j + 1) % tokens
        here, there = cell.token[i, 1], cell.token[j, 1]
        best, cut = math.inf, gap
        for trial in range(gap + 1):
            if here == there:
                break
            total = 0.0
            for k in range(gap):
                at = cell.at[vertex_around(cell, polygon, cell.token[(i + 1 + k) % tokens, 1])]
                point = chain[here] if k < trial else chain[there]
                total += (at[0] - point[0]) ** 2 + (at[1] - point[1]) ** 2 + (at[2] - point[2]) ** 2
            if total < best:
                best, cut = total, trial
        for k in range(gap):
            cell.ring[cell.token[(i + 1 + k) % tokens, 1]] = here if k < cut else there


@lean_part
def _close_chain(cell: Cell, polygon: int, size: int, chain: Floats, points: int) -> bool:
    """Triangles between a polygon and its chain, if the polygon meets each point of it once."""
    base, n, order, met = INNER + cell.count[0], 2 * size, cell.order, 0
    for i in range(n):
        if cell.ring[i] != cell.ring[(i - 1) % n]:
            order[met] = cell.ring[i]
            met += 1
    if met != points:
        return False
    zip_ring(cell, polygon, size, base, points)
    if points == 3:
        add_triangle(cell, base + order[0], base + order[1], base + order[2])
    for m in range(points):
        put(cell.at[base + m], chain[m])
    cell.count[0] += points
    return True


def warm() -> None:
    """Compile the kernels of this file, which those of `marching` are made of."""
    import_module("modules.kernels.marching").warm()
