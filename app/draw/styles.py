"""A scene in another dress: how a view draws surfaces, and colours that several views share. Shapes are not touched."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from app.legend import coloured_values
from modules.data.scene import Colouring, Layer, Scene, SurfaceLook

DRAWINGS: Mapping[str, Mapping[str, Any]] = MappingProxyType({
    "as made": {},
    "smooth": {"smooth": True, "edges": False},
    "flat": {"smooth": False, "edges": False},
    "edges": {"edges": True},
    "wireframe": {"wire": True, "edges": False, "relief": False, "lit": False},
})  # fmt: skip
"""Ways in which a view draws surfaces: what they change of the look that a renderer gave."""

Key = tuple[str, str, str]
Ranges = Mapping[Key, tuple[float, float]]


@dataclass
class Wardrobe:
    """Keeps layers in their dress: the same layer in the same dress is the same object, so a viewport leaves it alone."""

    _kept: dict[int, tuple[Layer, Hashable, Layer]] = field(default_factory=dict)

    def dressed(self, scene: Scene, drawing: str = "as made", ranges: Ranges = MappingProxyType({})) -> Scene:
        """The scene with its surfaces drawn in a way, and colours on given ranges; itself if nothing changes.

        Parameters
        ----------
        drawing : one of `DRAWINGS`; another counts as "as made"
        ranges : as `common` gives them
        """
        kept: dict[int, tuple[Layer, Hashable, Layer]] = {}
        for layer in scene.layers:
            wanted = {k: v for k, v in _changes(layer, drawing, ranges).items() if getattr(layer.look, k) != v}
            key = tuple(wanted.items())
            old = self._kept.get(id(layer))
            if old is not None and old[0] is layer and old[1] == key:
                kept[id(layer)] = old
            else:
                kept[id(layer)] = (layer, key, replace(layer, look=replace(layer.look, **wanted)) if wanted else layer)
        self._kept = kept
        layers = tuple(kept[id(layer)][2] for layer in scene.layers)
        return scene if all(a is b for a, b in zip(layers, scene.layers, strict=True)) else replace(scene, layers=layers)


def drawn_as(scene: Scene, drawing: Any) -> Scene:
    """The scene as the view data of its node ask for it."""
    return Wardrobe().dressed(scene, str(drawing))


def _changes(layer: Layer, drawing: str, ranges: Ranges) -> dict[str, Any]:
    changes = dict(DRAWINGS.get(drawing, {})) if isinstance(layer.look, SurfaceLook) else {}
    colouring = _colouring(layer)
    if colouring is not None and _key(colouring) in ranges:
        changes["colouring"] = replace(colouring, range=ranges[_key(colouring)])
    return changes


def common(scenes: Iterable[Scene]) -> dict[Key, tuple[float, float]]:
    """The range of each kind of value over all scenes: values of one name, unit and colour map are of one kind."""
    found: dict[Key, tuple[float, float]] = {}
    for scene in scenes:
        for layer in scene.layers:
            colouring = _colouring(layer)
            if colouring is None:
                continue
            low, high = colouring.range or _ends(layer, colouring)
            before = found.get(_key(colouring), (low, high))
            found[_key(colouring)] = (min(low, before[0]), max(high, before[1]))
    return found


def _colouring(layer: Layer) -> Colouring | None:
    found = getattr(layer.look, "colouring", None)
    return found if isinstance(found, Colouring) else None


def _key(colouring: Colouring) -> Key:
    return (colouring.title or colouring.by, colouring.unit, colouring.map.name)


def _ends(layer: Layer, colouring: Colouring) -> tuple[float, float]:
    values = coloured_values(layer, colouring)
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
