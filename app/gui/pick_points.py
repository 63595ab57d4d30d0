"""Positions that modules take, as a view can set them: which there are, and the edit that moves one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.engine.scheduler import upstream
from app.gui.session import Session

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Spot:
    """A parameter that is a position.

    Parameters
    ----------
    node, name : whose it is
    port : in whose frame and bounds it lies
    title : of the module, for people
    """

    node: str
    name: str
    port: str
    title: str

    @property
    def words(self) -> str:
        """It in a sentence."""
        return f"{self.name} of {self.title.lower()} ({self.node})"


def spots(session: Session, view: str) -> tuple[Spot, ...]:
    """The positions that nodes above a view take."""
    network, catalogue = session.network, session.catalogue
    if view not in network.nodes:
        return ()
    found = []
    for node in sorted(upstream(network, [view])):
        record = catalogue.get(network[node].module)
        wired = network.incoming.get(node, {})
        for one in record.parameters if record else ():
            if one.position is not None and one.name not in wired:
                title = str(network[node].view.get("title") or (record.title if record else ""))
                found.append(Spot(node, one.name, one.position.of, title))
    return tuple(found)


def value(session: Session, spot: Spot) -> Floats | None:
    """(3,) where it is; None while the module chooses."""
    given = session.network[spot.node].parameters.get(spot.name)
    if not isinstance(given, list | tuple) or len(given) < 2:
        return None
    at = np.zeros(3)
    at[: len(given)] = given[:3]
    return at


def put(session: Session, spot: Spot, at: Floats, interim: bool = False) -> None:
    """Set it: an edit of its node; dragged places are one step of undo."""
    bounds = session.input_facts(spot.node).get(spot.port, {}).get("bounds")
    place = np.asarray(at, float)
    count = 3
    if bounds is not None:
        ends = np.asarray(bounds, float).reshape(3, 2)
        place = np.clip(place, ends[:, 0], ends[:, 1])
        count = 2 if ends[2, 0] == ends[2, 1] else 3
    told = tuple(float(v) for v in place[:count])
    network = session.network.set(spot.node, spot.name, told, session.catalogue)
    session.edit(f"Move {spot.name} of {spot.node}", network, merge=("set", spot.node, spot.name), interim=interim)
