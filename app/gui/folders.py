"""Where dialogs for files begin: the folders that the user prefers, else where the work is."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from PySide6.QtCore import QSettings

KINDS: Final = {"networks": "Networks", "data": "Data", "pictures": "Pictures"}


def preferred(kind: str) -> Path | None:
    """The folder that the user chose for a kind of files; None for none, or one that is no longer there."""
    said = str(QSettings().value(f"folder/{kind}", "") or "")
    found = Path(said) if said else None
    return found if found is not None and found.is_dir() else None


def prefer(kind: str, folder: str) -> None:
    """Remember a folder; "" for none."""
    QSettings().setValue(f"folder/{kind}", folder.strip())


def start(kind: str, work: Path | None = None) -> Path:
    """Where a dialog begins: the preferred folder, else that of the work, else the user's home."""
    return preferred(kind) or (work.parent if work is not None else Path.home())
