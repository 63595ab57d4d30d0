"""Places by topological generation, and lining up."""

import pytest

from app.engine.network import Network, Node
from app.gui import layout


def network(*wires: str) -> Network:
    """Of wires "a>b"."""
    pairs = [w.split(">") for w in wires]
    names = sorted({n for pair in pairs for n in pair})
    ends = {(b, a, 0): (a, "out") for a, b in pairs}
    return Network({n: Node(n, "m") for n in names}, ends)


def test_columns_follow_the_data() -> None:
    places = layout.arrange(network("a>b", "b>c", "a>c", "x>c"))
    assert places["a"][0] < places["b"][0] < places["c"][0]
    assert places["x"][0] == places["b"][0]  # just before what uses it
    assert places["b"][0] - places["a"][0] >= layout.COLUMN - layout.SNAP


def test_a_line_is_straight() -> None:
    places = layout.arrange(network("a>b", "b>c", "c>d"))
    assert len({y for _, y in places.values()}) == 1


def test_nothing_overlaps_and_all_is_on_the_grid() -> None:
    net = network(*(f"a>b{i}" for i in range(6)), *(f"b{i}>c{i % 2}" for i in range(6)))
    sizes = {"b2": (200.0, 200.0)}
    places = layout.arrange(net, sizes=sizes)
    boxes = [(*places[n], *sizes.get(n, (layout.WIDTH, layout.HEIGHT))) for n in places]
    for i, (x, y, w, h) in enumerate(boxes):
        assert x % layout.SNAP == 0 and y % layout.SNAP == 0
        for u, v, p, q in boxes[i + 1 :]:
            assert x + w <= u or u + p <= x or y + h + layout.GAP <= v + 1 or v + q + layout.GAP <= y + 1


def test_crossings_are_undone() -> None:
    net = network("a>c", "b>d")
    places = layout.arrange(net)
    assert (places["a"][1] < places["b"][1]) == (places["c"][1] < places["d"][1])


def test_a_part_starts_where_it_was() -> None:
    places = layout.arrange(network("a>b", "b>c"), ["b", "c"], origin=(80.0, 160.0))
    assert places == {"b": (80.0, 160.0), "c": (304.0, 160.0)}
    assert layout.arrange(Network()) == {}


@pytest.mark.parametrize(
    ("how", "expected"),
    [
        ("left", {"a": (0, 0), "b": (0, 50), "c": (0, 400)}),
        ("right", {"a": (300, 0), "b": (300, 50), "c": (300, 400)}),
        ("top", {"a": (0, 0), "b": (100, 0), "c": (300, 0)}),
        ("bottom", {"a": (0, 400), "b": (100, 400), "c": (300, 400)}),
        ("across", {"a": (0, 0), "b": (152, 50), "c": (300, 400)}),
        ("down", {"a": (0, 0), "b": (100, 200), "c": (300, 400)}),
    ],
)
def test_align(how: str, expected: layout.Places) -> None:
    places = {"a": (0.0, 0.0), "b": (100.0, 50.0), "c": (300.0, 400.0)}
    assert layout.align(places, how, {}) == expected
