"""Links of one parameter to another in the window: whom it may follow, the menu, letting go."""

from __future__ import annotations

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu

from app.engine import following
from app.engine.catalogue import Catalogue
from app.engine.errors import NoniusError
from app.engine.following import End
from app.engine.network import Network
from app.gui.session import Session

MOST = 24
"""Parameters that the menu offers; those of the same name come first."""


def led_by(network: Network, node: str, name: str) -> tuple[str, ...]:
    """The parameters that follow one."""
    return tuple(".".join(end) for end in following.followers(network, node, name))


def offered(network: Network, node: str, name: str, catalogue: Catalogue) -> list[End]:
    """Parameters of other nodes of the same type that it may follow: of the same name first, then those set by hand."""
    record = catalogue.get(network[node].module)
    own = record.parameter(name) if record else None
    if own is None or network.incoming.get(node, {}).get(name):
        return []
    ranked: list[tuple[bool, bool, End]] = []
    for other, there in network.nodes.items():
        found = catalogue.get(there.module)
        for parameter in found.parameters if found and other != node else ():
            end = (other, parameter.name)
            alike = (parameter.type, parameter.options) == (own.type, own.options)
            wired = network.incoming.get(other, {}).get(parameter.name)
            if alike and not wired and (node, name) not in following.chain(network.nodes, end):
                ranked.append((parameter.name != name, parameter.name not in there.parameters, end))
    return [end for _, _, end in sorted(ranked)[:MOST]]


def follow(session: Session, node: str, name: str, led: End) -> None:
    """Let a parameter follow another: one edit; a refusal is said."""
    try:
        network = following.follow(session.network, node, name, led, session.catalogue)
    except NoniusError as error:
        session.message.emit("warning", str(error))
        return
    session.edit(f"Link {name.replace('_', ' ')} of {node} to {led[0]}", network)


def let_go(session: Session, node: str, name: str) -> None:
    """Let a parameter stand alone; its value stays."""
    network = following.let_go(session.network, node, name)
    if network is not session.network:
        session.edit(f"Let {name.replace('_', ' ')} of {node} go", network)


def fill(session: Session, node: str, name: str, menu: QMenu) -> None:
    """Put in whom a parameter may follow, or how to let it go."""
    network = session.network
    menu.addSeparator()
    if led := network[node].follows.get(name):
        gone = QAction(f"Follow {led} no longer", menu)
        gone.triggered.connect(lambda: let_go(session, node, name))
        menu.addAction(gone)
        return
    ends = offered(network, node, name, session.catalogue)
    inner = menu.addMenu("Follow")
    inner.setEnabled(bool(ends))
    for end in ends:
        value = following.value_of(network, end, session.catalogue)
        words = "automatic" if value is None else str(getattr(value, "name", value))[:40]
        action = QAction(f"{'.'.join(end)}   {words}", inner)
        action.triggered.connect(lambda _=False, end=end: follow(session, node, name, end))
        inner.addAction(action)
