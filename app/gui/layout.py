"""Places for nodes, left to right by topological generation: columns 226 apart, wires as straight as rows allow."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final

import networkx

from app.engine.network import Network

COLUMN: Final = 226.0
GAP: Final = 18.0
HEIGHT: Final = 76.0
WIDTH: Final = 150.0
SNAP: Final = 8.0

Places = dict[str, tuple[float, float]]


def snap(value: float) -> float:
    """The nearest line of the grid."""
    return round(value / SNAP) * SNAP


def generations(network: Network, nodes: Iterable[str]) -> list[list[str]]:
    """Nodes by the longest way to them from a source; a source stands just before what first uses it."""
    part = network.graph.subgraph(nodes)
    level: dict[str, int] = {}
    for node in networkx.lexicographical_topological_sort(part):
        level[node] = max((level[p] + 1 for p in part.predecessors(node)), default=0)
    for node in reversed(list(networkx.lexicographical_topological_sort(part))):
        after = [level[s] for s in part.successors(node)]
        if after and not list(part.predecessors(node)):
            level[node] = min(after) - 1
    found: list[list[str]] = [[] for _ in range(max(level.values(), default=-1) + 1)]
    for node, at in level.items():
        found[at].append(node)
    return found


def arrange(
    network: Network,
    nodes: Iterable[str] | None = None,
    *,
    sizes: Mapping[str, tuple[float, float]] | None = None,
    origin: tuple[float, float] = (0.0, 0.0),
) -> Places:
    """Places of nodes (all by default), the upper left one at `origin`.

    Parameters
    ----------
    sizes : node -> (width, height) where it is not the plain one
    """
    wanted = list(network.nodes if nodes is None else nodes)
    if not wanted:
        return {}
    columns = generations(network, wanted)
    sizes = sizes or {}
    places: Places = {}
    x = origin[0]
    for column in _ordered(network, columns):
        _stack(network, column, x, origin[1], places, sizes)
        widest = max((sizes.get(n, (WIDTH, HEIGHT))[0] for n in column), default=WIDTH)
        x = snap(x + max(COLUMN, widest + COLUMN - WIDTH))
    top = min(y for _, y in places.values())
    return {n: (px, snap(py - top + origin[1])) for n, (px, py) in places.items()}


def _ordered(network: Network, columns: list[list[str]]) -> list[list[str]]:
    """Columns with fewer crossings: sorted by the mean rank of what each node hangs on, then of what hangs on it."""
    graph = network.graph
    inside = {n for column in columns for n in column}
    slots = {(t, s): (port, slot) for (t, port, slot), (s, _) in network.wires.items()}
    for _ in range(4):
        for forward in (True, False):
            rank = {n: i - len(column) / 2 for column in columns for i, n in enumerate(column)}
            near = graph.predecessors if forward else graph.successors
            for column in columns:
                mean = {}
                for node in column:
                    others = [rank[o] + (0.01 * slots[o, node][1] if not forward else 0) for o in near(node) if o in inside]
                    mean[node] = sum(others) / len(others) if others else rank[node]
                column.sort(key=lambda n, m=mean: (m[n], n))  # type: ignore[misc]
    return columns


def _stack(
    network: Network, column: list[str], x: float, top: float, places: Places, sizes: Mapping[str, tuple[float, float]]
) -> None:
    """Place a column: each node beside the mean of its inputs, pushed down where it would overlap, the whole then centred."""
    wish = {}
    for node in column:
        before = [places[o][1] for o in network.graph.predecessors(node) if o in places]
        wish[node] = sum(before) / len(before) if before else top
    at: list[float] = []
    low = float("-inf")
    for node in column:
        y = max(wish[node], low)
        at.append(y)
        low = y + sizes.get(node, (WIDTH, HEIGHT))[1] + GAP + SNAP
    shift = sum(wish[n] - y for n, y in zip(column, at, strict=True)) / len(column)
    if not any(wish[n] != top for n in column):
        shift = 0.0
    for node, y in zip(column, at, strict=True):
        places[node] = (snap(x), snap(y + shift))


def align(places: Mapping[str, tuple[float, float]], how: str, sizes: Mapping[str, tuple[float, float]]) -> Places:
    """Places in a line: left, right, top, bottom, or spread evenly: across, down."""
    box = {n: (x, y, *sizes.get(n, (WIDTH, HEIGHT))) for n, (x, y) in places.items()}
    if how == "left":
        return {n: (min(b[0] for b in box.values()), b[1]) for n, b in box.items()}
    if how == "right":
        edge = max(b[0] + b[2] for b in box.values())
        return {n: (edge - b[2], b[1]) for n, b in box.items()}
    if how == "top":
        return {n: (b[0], min(b[1] for b in box.values())) for n, b in box.items()}
    if how == "bottom":
        edge = max(b[1] + b[3] for b in box.values())
        return {n: (b[0], edge - b[3]) for n, b in box.items()}
    axis = 0 if how == "across" else 1
    row = sorted(box, key=lambda n: box[n][axis])
    if len(row) < 3:
        return dict(places)
    first, last = box[row[0]][axis], box[row[-1]][axis]
    found = dict(places)
    for i, name in enumerate(row[1:-1], 1):
        value = snap(first + (last - first) * i / (len(row) - 1))
        found[name] = (value, box[name][1]) if axis == 0 else (box[name][0], value)
    return found
