"""To say what a file does not: how large an error is that is known to exist, put in where the data come in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QComboBox, QDialog, QFormLayout, QHBoxLayout, QLineEdit, QVBoxLayout, QWidget

from app.engine.errors import NoniusError
from app.engine.network import Network
from app.gui import edits, style
from app.gui.session import Session
from app.gui.sources import accuracies
from app.gui.widgets.number import number_of
from app.gui.widgets.parts import button
from modules.data.formula import FormulaError
from modules.data.wires import Samples

MODULE: Final = "modellers.state_accuracy.state_accuracy"
KINDS: Final = {"standard deviation": "Standard deviation", "bound": "Bound, never exceeded"}


@dataclass(frozen=True)
class Gap:
    """A source that is not given, and the output at which its size can be stated."""

    name: str
    node: str
    output: str
    unit: str


@dataclass(frozen=True)
class Said:
    """What someone says of an error."""

    amount: float
    kind: str = "standard deviation"
    who: str = "the user"


def gap(session: Session, node: str, name: str) -> Gap | None:
    """Where the size of a missing source can be stated: at the first samples that lack it; None if there are none."""
    if session.catalogue.get(MODULE) is None or node not in session.network.nodes:
        return None
    for source, output, accuracy in accuracies(session.network, node, session.outputs):
        value = (session.outputs(source) or {}).get(output)
        if isinstance(value, Samples) and any(m.name == name for m in accuracy.missing):
            return Gap(name, source, output, value.unit)
    return None


def stated(session: Session, one: Gap, said: Said) -> tuple[Network, str]:
    """The network with the statement put into all wires of that output, and the id of the new node.

    Raises
    ------
    NoniusError : the size is refused
    """
    network, catalogue = session.network, session.catalogue
    fresh = network.fresh_id(MODULE)
    x, y = edits.after(network, one.node)
    values = {"amount": said.amount, "kind": said.kind, "who": said.who, "error": one.name, "answers": one.name}
    grown = network.add(MODULE, catalogue, id=fresh, parameters=values, view={"position": [x, y]})
    grown = grown.connect(one.node, one.output, fresh, "samples", catalogue)
    for (target, port, slot), origin in network.wires.items():
        if origin == (one.node, one.output):
            grown = edits.join(grown, edits.Held(fresh, "samples", "", True), target, port, catalogue, slot)
    return grown, fresh


def words(name: str) -> str:
    """What the button says."""
    return f"Give a {name[:1].lower()}{name[1:]}…"


class GiveError(QDialog):
    """Asks how large an error is, of which kind, and who says so. Nothing is put in until it is said."""

    def __init__(self, session: Session, one: Gap, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.session, self.gap = session, one
        self.setWindowTitle(words(one.name).rstrip("…"))
        self.amount = QLineEdit(placeholderText=f"a number{f' in {one.unit}' if one.unit else ''}")
        self.amount.setAccessibleName("Size")
        self.kind = QComboBox()
        self.kind.setAccessibleName("Kind")
        for kind, said in KINDS.items():
            self.kind.addItem(said, kind)
        self.who = QLineEdit("the user")
        self.who.setAccessibleName("Who says so")
        self.refused = style.labelled("", "failed")
        self.refused.setWordWrap(True)
        self.refused.hide()
        form = QFormLayout()
        form.setVerticalSpacing(10)
        form.addRow(f"Size{f' ({one.unit})' if one.unit else ''}", self.amount)
        form.addRow("Kind", self.kind)
        form.addRow("Who says so", self.who)
        about = style.labelled(
            f"{one.name} of {one.node} is not given. What you say goes into a step of its own after it, "
            "signed with who says so; its other settings stand in its panel.", "quiet")  # fmt: skip
        about.setWordWrap(True)
        buttons = QHBoxLayout()
        buttons.addStretch(1)
        buttons.addWidget(button("Cancel", self.reject))
        self.done_ = button("State it", self.accept, primary=True)
        self.done_.setDefault(True)
        buttons.addWidget(self.done_)
        column = QVBoxLayout(self)
        column.setContentsMargins(20, 18, 20, 16)
        column.setSpacing(14)
        for part in (about, form, self.refused, buttons):
            column.addWidget(part) if isinstance(part, QWidget) else column.addLayout(part)
        self.setMinimumWidth(380)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.amount.setFocus()

    def accept(self) -> None:
        """Put it in, or say why not."""
        try:
            amount = number_of(self.amount.text(), self.gap.unit)
            if amount is None:
                self._refuse("Say how large it is: a number, or a formula such as 1/3.")
                return
            said = Said(amount, str(self.kind.currentData()), self.who.text().strip() or "the user")
            network, fresh = stated(self.session, self.gap, said)
        except (FormulaError, NoniusError) as error:
            self._refuse(str(error))
            return
        self.session.edit(f"State {self.gap.name[:1].lower()}{self.gap.name[1:]}", network)
        self.session.select([fresh])
        super().accept()

    def _refuse(self, sentence: str) -> None:
        self.refused.setText(sentence)
        self.refused.show()
        self.amount.setFocus()
