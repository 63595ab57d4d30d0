"""How a module looks in a list: room, name with the letters that were typed, one quiet line, ports at the right."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QFontMetricsF, QPainter

from app.gui import glyphs
from app.gui.glyphs import Look, font
from app.gui.ranking import Match
from modules.declare import Module, Port

MIDDLE = Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft


def kinds(module: Module) -> tuple[str, str]:
    """(type of the first port or "", type of the first output)."""
    first = module.ports[0].type.__name__ if module.ports else ""
    return first, module.outputs[0].type.__name__ if module.outputs else ""


def ports(painter: QPainter, module: Module, right: float, y: float, look: Look, spread: float = 17.0) -> float:
    """Draw in -> out so that it ends at the right; where it begins."""
    into, out = kinds(module)
    x = right - 6
    if out:
        glyphs.port(painter, out, QPointF(x, y), look, scale=0.72)
    x -= spread
    painter.setPen(glyphs.pen(look["text 3"], 1.2))
    painter.drawLine(QPointF(x - 3.5, y), QPointF(x + 3.5, y))
    painter.drawLine(QPointF(x + 1, y - 2.5), QPointF(x + 3.5, y))
    painter.drawLine(QPointF(x + 1, y + 2.5), QPointF(x + 3.5, y))
    x -= spread
    if into:
        glyphs.port(painter, into, QPointF(x, y), look, scale=0.72)
    return x - 8


def name(
    painter: QPainter, text: str, marked: tuple[int, ...], box: QRectF, look: Look, size: int = 12, role: str = "text"
) -> None:
    """Draw a text with some letters in the colour of action."""
    shown = QFontMetricsF(font(size)).elidedText(text, Qt.TextElideMode.ElideRight, box.width())
    x = box.left()
    run, strong = "", False
    for i, letter in enumerate([*shown, ""]):
        if run and (letter == "" or (i in marked) != strong):
            painter.setFont(font(size, strong))
            painter.setPen(look["action" if strong else role])
            painter.drawText(QRectF(x, box.top(), box.width() + 40, box.height()), MIDDLE, run)
            x += QFontMetricsF(font(size, strong)).horizontalAdvance(run)
            run = ""
        strong = i in marked
        run += letter


def row(painter: QPainter, match: Match, box: QRectF, look: Look, *, chosen: bool) -> None:
    """A row of quick-add, 48 high."""
    module = match.module
    if chosen:
        painter.fillRect(box, look["selected row"])
        painter.fillRect(QRectF(box.left(), box.top(), 3, box.height()), look["action"])
    glyphs.room(painter, module.room, QPointF(box.left() + 16, box.center().y() - 8), look["text 2"])
    begin = ports(painter, module, box.right() - 20, box.center().y(), look, 24)
    left = box.left() + 46
    name(painter, module.title, match.letters, QRectF(left, box.top() + 6, begin - left - 8, 18), look, 13)
    quiet = f"also called {match.also}" if match.also else first_sentence(module)
    painter.setFont(font(11))
    painter.setPen(look["text 2" if chosen else "text 3"])
    text = QFontMetricsF(font(11)).elidedText(quiet, Qt.TextElideMode.ElideRight, begin - left - 8)
    painter.drawText(QRectF(left, box.top() + 24, begin - left, 16), MIDDLE, text)


def first_sentence(module: Module) -> str:
    """The first sentence of what it does, without its full stop."""
    return " ".join(module.summary.split()).split(". ")[0].rstrip(".")


def page(module: Module, look: Look, examples: list[str] | None = None, *, short: bool = False) -> str:
    """The help of a module as rich text.

    Parameters
    ----------
    examples : names of packaged networks in which it stands
    short : without parameters, source and examples
    """
    quiet, brass = look["text 2"].name(), look["brass"].name()
    parts = [f"<p style='font-size:15px'><b>{escape(module.title)}</b></p>", f"<p>{_flow(module.summary)}</p>"]
    if module.ports:
        parts.append(_table("Takes", [(p.type.__name__, p.name, _port_words(p)) for p in module.ports], look))
    gives = [(o.type.__name__, o.name, glyphs.TYPES.get(o.type.__name__, o.type.__name__)) for o in module.outputs]
    parts.append(_table("Gives", gives, look))
    if module.accuracy:
        parts.append(f"<p style='margin-top:12px'><b style='color:{brass}'>Accuracy</b><br>{_flow(module.accuracy)}</p>")
    if short:
        if module.parameters:
            names = escape(", ".join(p.name.replace("_", " ") for p in module.parameters))
            parts.append(f"<p style='margin-top:12px'><span style='color:{quiet}'>Settings</span><br>{names}</p>")
        return _whole(parts, look)
    if module.parameters:
        parts.append(_settings(module, quiet))
    if module.source:
        parts.append(f"<p style='margin-top:12px'><span style='color:{quiet}'>Source</span><br>{_flow(module.source)}</p>")
    if examples:
        action = look["action"].name()
        links = ", ".join(f"<a href='network:{escape(n)}' style='color:{action}'>{escape(n)}</a>" for n in examples)
        parts.append(f"<p style='margin-top:12px'><span style='color:{quiet}'>Used in</span><br>{links}</p>")
    parts.append(f"<p style='margin-top:12px;color:{look['text 3'].name()}'>{escape(module.id)}, version {module.version}</p>")
    return _whole(parts, look)


def _whole(parts: list[str], look: Look) -> str:
    return f"<div style='color:{look['text'].name()};font-size:12px'>{''.join(parts)}</div>"


def _flow(text: str) -> str:
    text = text[:1].upper() + text[1:]
    return "<br>".join(escape(" ".join(block.split())) for block in text.split("\n\n"))


def _port_words(port: Port) -> str:
    kind = glyphs.TYPES.get(port.type.__name__, port.type.__name__)
    notes = [kind, "several" if port.many else "", "may be left unwired" if port.optional else ""]
    said = ", ".join(n for n in notes if n)
    return f"{said}: {port.words}" if port.words else said


def _table(title: str, lines: list[tuple[str, str, str]], look: Look) -> str:
    quiet = look["text 2"].name()
    body = "".join(
        f"<tr><td style='padding:2px 8px 2px 0'><img src='port:{kind}' width='14' height='14'></td>"
        f"<td style='padding:2px 12px 2px 0'>{escape(label)}</td><td style='color:{quiet}'>{escape(words)}</td></tr>"
        for kind, label, words in lines
    )
    return f"<p style='margin-top:12px;color:{quiet}'>{title}</p><table cellspacing='0'>{body}</table>"


def _settings(module: Module, quiet: str) -> str:
    from app.commands.describe import _default, _takes

    body = "".join(
        f"<tr><td style='padding:2px 12px 2px 0'>{escape(p.name.replace('_', ' '))}</td>"
        f"<td style='padding:2px 12px 2px 0'>{escape(_default(p).removeprefix('= '))}</td>"
        f"<td style='color:{quiet};padding:2px 0'>{escape(_takes(p))}</td></tr>"
        for p in module.parameters
    )
    title = "Settings, and what they are unless you change them"
    return f"<p style='margin-top:12px;color:{quiet}'>{title}</p><table>{body}</table>"


def counts(values: Mapping[str, object]) -> dict[str, int]:
    """How often each module was taken, from what settings keep as text."""
    return {str(k): int(str(v)) for k, v in values.items() if str(v).isdigit()}
