"""How a node is, as the window tells it; and which nodes an edit leaves out of date."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from app.engine.errors import ModuleFailed
from app.engine.network import Network, Node

Kind = Literal["clean", "dirty", "queued", "running", "cached", "failed", "blocked", "held", "disabled", "bypassed", "missing"]


@dataclass(frozen=True)
class NodeState:
    """How a node is.

    Parameters
    ----------
    kind : the badge
    progress : of a running node, in [0, 1]; None if it does not say
    seconds : that the last run took
    sentence : why it failed or waits, and what to do
    error : what failed, with its traceback
    reused : the result was there already
    """

    kind: Kind = "dirty"
    progress: float | None = None
    seconds: float = 0.0
    sentence: str = ""
    error: ModuleFailed | None = None
    reused: bool = False


def changed(before: Network, after: Network) -> set[str]:
    """Nodes whose result an edit may have changed, with all that hangs on them; moving one changes nothing."""
    if before is after:
        return set()
    roots = {n for n, node in after.nodes.items() if not _equal(before.nodes.get(n), node)}
    if before.wires is not after.wires and before.wires != after.wires:
        ends = before.wires.items() ^ after.wires.items()
        roots |= {target for (target, _, _), _ in ends if target in after.nodes}
    return with_descendants(after, roots)


def with_descendants(network: Network, roots: Iterable[str]) -> set[str]:
    """Nodes and all that hangs on them."""
    found = set(roots)
    stack = list(found)
    while stack:
        for below in network.graph.successors(stack.pop()):
            if below not in found:
                found.add(below)
                stack.append(below)
    return found


def _equal(old: Node | None, new: Node) -> bool:
    if old is new:
        return True
    if old is None:
        return False
    same = old.parameters is new.parameters or old.parameters == new.parameters
    return same and (old.module, old.version, old.disabled, old.bypass) == (new.module, new.version, new.disabled, new.bypass)
