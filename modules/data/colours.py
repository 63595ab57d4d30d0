"""Colour tables by name, as text."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

CIVIDIS = (
    "00224E 00285B 002E6A 053371 1A386F 273E6E 32436D 3B496C 434E6C 4B546C 535A6D 5A5F6E 61656F 686A71 6F7073 767676 7D7C78 "
    "838179 8B8778 928D78 9A9376 A29975 AAA073 B3A670 BBAD6D C3B369 CCBA64 D4C15F DDC858 E6D051 EFD748 F8DF3C FEE838"
)
"""Cividis in 33 steps; between them it differs from the original by at most 6 of 255."""
ERRORS = "E6E8EC DCCFB0 DAA84A BF6A17 74290A"
"""Clay to ember: lightness only falls, so it reads in grey and with every colour vision."""
GREYS = "2B2F36 F4F5F7"
DIVERGING = "00437A 136FAD 609CCA ABCAE4 F0F1F2 E7C093 CC873F A4560F 6F2F07"
"""Blue over light grey to brown: both sides are equally dark (L* 28, 45, 62, 80, 95), and no vision takes one for the other."""

TABLES = MappingProxyType({"values": CIVIDIS, "errors": ERRORS, "greys": GREYS, "diverging": DIVERGING})


def rgb(words: str) -> NDArray[np.float64]:
    """(n, 3) colours in [0, 1] of "RRGGBB RRGGBB ..."."""
    return np.array([[int(w[i : i + 2], 16) / 255 for i in (0, 2, 4)] for w in words.split()])
