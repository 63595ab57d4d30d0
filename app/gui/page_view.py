"""Rich text with our port glyphs in it."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QPointF, QUrl
from PySide6.QtGui import QPainter, QPixmap, QTextDocument
from PySide6.QtWidgets import QFrame, QTextBrowser, QWidget

from app.gui import glyphs
from app.gui.glyphs import Look


class PageView(QTextBrowser):
    """Shows a page; `port:Model` is a picture of that port."""

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.look = look
        self.setOpenLinks(False)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setStyleSheet("QTextBrowser { background: transparent; border: 0; }")
        self.document().setDocumentMargin(0)

    def show_page(self, html: str) -> None:
        """Show a page from its beginning."""
        self.document().setDefaultFont(glyphs.font(12))
        self.clear()
        self.setHtml(html)

    def loadResource(self, kind: int, name: QUrl | str) -> Any:
        """Draw ports."""
        url = QUrl(name)
        if url.scheme() != "port" or kind != QTextDocument.ResourceType.ImageResource.value:
            return super().loadResource(kind, url)
        pixmap = QPixmap(28, 28)
        pixmap.setDevicePixelRatio(2)
        pixmap.fill("transparent")
        painter = QPainter(pixmap)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        glyphs.port(painter, url.path(), QPointF(7, 7), self.look, scale=0.85)
        painter.end()
        return pixmap
