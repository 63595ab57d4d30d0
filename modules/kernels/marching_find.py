"""The first pass over a slab of layers: which cells the surface passes, and how much of it each layer holds.

The samples become bytes, eight of which are looked at together: where all are on one side nothing is done.
"""

import numpy as np
import numpy.typing as npt

from modules.kernels._jit import lean, lean_inlined, lean_part
from modules.kernels.marching_cases import Bytes, Floats, Integers, Masks, index, int64
from modules.kernels.marching_tables import EARLIER

LOW = np.uint64(0x0F0F0F0F0F0F0F0F)
HOLE = np.uint8(16)
"""Added to the byte of a sample that is not finite."""

HOLES = np.uint64(0xF0F0F0F0F0F0F0F0)
EMPTY, FULL, BYTE = np.uint64(0), np.uint64(0xFFFFFFFFFFFFFFFF), np.uint64(0xFF)
ONE, TWO, THREE, FOUR, EIGHT, REST_OF_WORD = (np.uint64(n) for n in (1, 2, 3, 4, 8, 56))

UPPER = (1 << 1) | (1 << 3) | (1 << 5) | (1 << 7) | (3 << 22)
"""Bits of the vertices in the upper plane of a cell."""

TOP, REST, TRIANGLES, SPECIAL = 0, 1, 2, 3
"""What is counted of a layer: vertices in its upper plane, other vertices, triangles, cells that need more thought."""

STEPS = np.array(EARLIER, np.int64)
Words = npt.NDArray[np.uint64]


def words(nx: int) -> int:
    """Words of eight bytes that a row of nodes takes, one more than it fills."""
    return (nx + 7) // 8 + 1


@lean_part
def _sides(
    values: Floats, level: float, nx: int, ny: int, k: int, row: int, plane: Bytes, wanted: Bytes, lines: int
) -> int:
    """A byte for each wanted sample of plane k: 1 where it is above, `HOLE` where it is not finite; how many are not."""
    holes, width, rows = 0, (nx + 7) // 8, (ny + 7) // 8
    for j in range(ny):
        begin, to, line = (k * ny + j) * nx, ((k % 3) * ny + j) * row, (k // 8) * rows + j // 8
        block, first = line * width, int64(0) if wanted[index(wanted.size - lines + line)] else width
        while first < width:
            last = first
            while last < width and wanted[index(block + last)]:
                last += 1
            a, b = 8 * first, min(8 * last, nx)
            samples, bytes_ = values[begin + a : begin + b], plane[to + a : to + b]
            for i in range(b - a):
                bytes_[i] = np.uint8(samples[i] >= level)
                holes += samples[i] - samples[i] != 0.0
            first = last + 1
    if holes:
        for j in range(ny):
            begin, to = (k * ny + j) * nx, ((k % 3) * ny + j) * row
            for i in range(nx):
                if values[begin + i] - values[begin + i] != 0.0:
                    plane[to + i] = HOLE
    return holes


@lean_inlined
def _exists(plane: Bytes, i: int, j: int, k: int, row: int, ny: int) -> bool:
    """Whether the cell has no corner that is not finite."""
    total = 0
    for c in range(8):
        total |= plane[(((k + (c & 1)) % 3) * ny + j + ((c >> 1) & 1)) * row + i + (c >> 2)]
    return bool(total < HOLE)


@lean_part
def _new_beside_holes(plane: Bytes, i: int, j: int, k: int, row: int, nx: int, ny: int, shared: Masks) -> int:
    """Bits of the vertices that no earlier neighbour has."""
    mask = (1 << 24) - 1
    for n in range(9):
        p, q, r = i + STEPS[n, 0], j + STEPS[n, 1], k + STEPS[n, 2]
        if 0 <= p < nx - 1 and 0 <= q < ny - 1 and r >= 0 and _exists(plane, p, q, r, row, ny):
            mask &= ~shared[n]
    return mask


@lean
def find(
    values: Floats, nx: int, ny: int, level: float, first: int, last: int, plane: Bytes, word: Words, active: Integers,
    row_start: Integers, special: Integers, counts: Integers,
    busy: Bytes, wanted: Bytes, used: Masks, shared: Masks, open_: Masks, ones: Bytes, sides: Bytes,
) -> int:
    """The cells of layers first to last - 1 that the surface passes; how many.

    Parameters
    ----------
    plane, word : bytes of three planes, rows of `words(nx)` words; the same memory as words
    active : gets the column of each cell << 32, bits of its new vertices << 8, its code
    row_start : ((last - first) (ny - 1) + 1,) gets where each row of cells starts there
    special : gets the first node of each cell that needs more thought
    busy, wanted : of each block of eight cells along each axis, whether the surface may pass; of nodes, whether they count;
        then of each line of blocks, whether any does
    counts : ((last - first), 4) gets what each layer holds, as far as the codes tell
    """
    width = (nx + 7) // 8 + 1
    row, found, strange, lines = 8 * width, 0, 0, busy.size // width
    below, here = 0, 0
    if first > 0:
        below = _sides(values, level, nx, ny, first - 1, row, plane, wanted, lines)
    here = _sides(values, level, nx, ny, first, row, plane, wanted, lines)
    for k in range(first, last):
        above = _sides(values, level, nx, ny, k + 1, row, plane, wanted, lines)
        holes = below + here + above
        below, here = here, above
        top, rest, triangles, before = 0, 0, 0, strange
        for j in range(ny - 1):
            row_start[(k - first) * (ny - 1) + j] = found
            line = (k // 8) * ((ny + 7) // 8) + j // 8
            w0, w1 = ((k % 3) * ny + j) * width, (((k + 1) % 3) * ny + j) * width
            a, b = word[w0 : w0 + width], word[w1 : w1 + width]
            c, d = word[w0 + width : w0 + 2 * width], word[w1 + width : w1 + 2 * width]
            four, block, runs = EMPTY, line * (width - 1), False
            for w in range((width - 1) * int64(busy[index(busy.size - lines + line)])):
                if not busy[index(block + w)]:
                    runs = False
                    continue
                if not runs:
                    four, runs = a[w] | (b[w] << ONE) | (c[w] << TWO) | (d[w] << THREE), True
                after = a[w + 1] | (b[w + 1] << ONE) | (c[w + 1] << TWO) | (d[w + 1] << THREE)
                following = (four >> EIGHT) | (after << REST_OF_WORD)
                eight = (four & LOW) | ((following & LOW) << FOUR)
                bad = (four | following) & HOLES if holes else EMPTY
                four = after
                if eight == EMPTY or eight == FULL:
                    continue
                for i in range(8 * w, min(8 * w + 8, nx - 1)):
                    code, hole = int64(eight & BYTE), bad & BYTE
                    eight, bad = eight >> EIGHT, bad >> EIGHT
                    if code == 0 or code == 255 or hole != EMPTY:
                        continue
                    if holes:
                        mask = used[code] & _new_beside_holes(plane, i, j, k, row, nx, ny, shared)
                    else:
                        mask = used[index(code)] & open_[(i == 0) | ((j == 0) << 1) | ((k == 0) << 2)]
                    active[index(found)] = (i << 32) | (mask << 8) | code
                    found += 1
                    upper = mask & UPPER
                    high = ones[index(upper & 4095)] + ones[index(upper >> 12)]
                    top += high
                    rest += ones[index(mask & 4095)] + ones[index(mask >> 12)] - high
                    if sides[index(code)]:
                        rest += 1
                        triangles += 2 * sides[index(code)]
                    else:
                        special[strange] = (k * ny + j) * nx + i
                        strange += 1
        n = 4 * (k - first)
        counts[n], counts[n + 1], counts[n + 2], counts[n + 3] = top, rest, triangles, strange - before
    row_start[(last - first) * (ny - 1)] = found
    return found
