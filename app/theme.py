"""Colours by role, light and dark, and the type of pictures: the one file with colour numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

Name = Literal["light", "dark"]
RGB = tuple[float, float, float]

# role: dark, light
_ROLES: dict[str, tuple[str, str]] = {
    # window
    "canvas": ("#14171B", "#F1F3F5"),
    "canvas dots": ("#262C34", "#D9DEE4"),
    "panel": ("#1A1E24", "#FBFCFD"),
    "raised": ("#22272F", "#FFFFFF"),
    "head": ("#2B313B", "#EBEEF2"),
    "field": ("#14171B", "#FFFFFF"),
    "divider": ("#363E4A", "#D0D6DD"),
    "edge": ("#717D8E", "#7A8492"),
    "node edge": ("#717D8E", "#AEB6C0"),
    "text": ("#E8EBF0", "#1A1E24"),
    "text 2": ("#AEB6C2", "#4E5763"),
    "text 3": ("#949DAB", "#5F6874"),
    "text on action": ("#FFFFFF", "#FFFFFF"),
    "action": ("#6FB1F2", "#1B63AE"),
    "action fill": ("#2A6DB8", "#1B63AE"),
    "selected row": ("#243447", "#E1ECF8"),
    "brass": ("#E2B659", "#855600"),
    "failed": ("#FF8F80", "#B3261E"),
    "failed ground": ("#3A2220", "#FBE9E7"),
    "flag": ("#FFA866", "#9A4700"),
    "track": ("#3A424E", "#D5DAE1"),
    # ports
    "port Samples": ("#6CB6F0", "#1C6FB5"),
    "port Model": ("#4CC3A5", "#0B7A63"),
    "port Geometry": ("#F29A66", "#B5501B"),
    "port Layer": ("#E08BC4", "#A03A84"),
    "port Scene": ("#E08BC4", "#A03A84"),
    "port Table": ("#B5A8EA", "#6551B8"),
    "port Value": ("#C9CFD8", "#4C5560"),
    "port ColourMap": ("#9ED36A", "#4C7A12"),
    "port Pick": ("#7FD6E0", "#0C7480"),
    # pictures
    "view": ("#101216", "#FFFFFF"),
    "line": ("#F4F6F8", "#1A1E24"),
    "line on clay": ("#14171B", "#1A1E24"),
    "dust": ("#E8A23A", "#C25E00"),
    "dust on clay": ("#943E00", "#A24A00"),
    "clay": ("#B4BAC2", "#C4C9D0"),
    "box": ("#3A424E", "#B4BBC4"),
    "relief shadow": ("#101216", "#B9BFC7"),
    "relief flat": ("#23282F", "#E9ECEF"),
    "relief light": ("#424954", "#FFFFFF"),
}

FONTS = ("Noto Sans", "DejaVu Sans")
"""Of pictures, in order of choice; the second comes with matplotlib, so a picture never lacks one."""
MONO = ("Noto Sans Mono", "Consolas", "Menlo", "DejaVu Sans Mono")

SIZES: Mapping[str, float] = MappingProxyType(
    {"tick": 10.5, "caption": 11.0, "body": 12.5, "heading": 12.5, "title": 15.0, "total": 26.0, "page total": 34.0}
)
"""Sizes of type in pixels at 100 %."""


@dataclass(frozen=True)
class Theme:
    """Colours by role.

    Parameters
    ----------
    name : light or dark
    roles : role -> "#RRGGBB"
    """

    name: Name
    roles: Mapping[str, str]

    def __getitem__(self, role: str) -> str:
        """The colour of a role, "#RRGGBB"; a colour in that form is returned as it is.

        Raises
        ------
        KeyError : no such role
        """
        if role.startswith("#"):
            rgb(role)
            return role
        if role not in self.roles:
            raise KeyError(f"there is no colour {role!r}: give a role ({', '.join(self.roles)}) or #rrggbb")
        return self.roles[role]

    def on(self, role: str, ground: Literal["view", "clay"]) -> str:
        """The colour of a role as drawn on the bare view or on a clay surface, where lines and dust are darker."""
        special = f"{role} on {ground}"
        return self.roles[special] if special in self.roles else self[role]

    def rgb(self, role: str) -> RGB:
        """The colour of a role, in [0, 1]."""
        return rgb(self[role])


def rgb(colour: str) -> RGB:
    """The numbers in [0, 1] of "#RRGGBB".

    Raises
    ------
    ValueError : the text is no such colour
    """
    digits = colour.removeprefix("#")
    try:
        if len(digits) != 6:
            raise ValueError
        values = bytes.fromhex(digits)
    except ValueError:
        raise ValueError(f"{colour!r} is no colour: write #rrggbb") from None
    return (values[0] / 255, values[1] / 255, values[2] / 255)


def _theme(name: Name, column: int) -> Theme:
    return Theme(name, MappingProxyType({role: pair[column] for role, pair in _ROLES.items()}))


THEMES: Mapping[str, Theme] = MappingProxyType({"dark": _theme("dark", 0), "light": _theme("light", 1)})


def theme(name: str) -> Theme:
    """The theme of a name.

    Raises
    ------
    KeyError : neither light nor dark
    """
    if name not in THEMES:
        raise KeyError(f"there is no theme {name!r}: themes are {', '.join(THEMES)}")
    return THEMES[name]
