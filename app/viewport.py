"""A scene on a plotter, in a window or off screen: the only door through which our data becomes VTK actors.

`show` compares layers by identity: the same layer is left alone, a new look only sets properties, a new shape only
gives its mapper new data. In two dimensions the same actors are seen from above by a parallel camera that cannot turn,
each layer lifted above the one before, so that none fights with another for the same depth.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.draw import meshes, space
from app.draw.dressing import Kind, Style, frame_actor
from app.draw.extent import Box, frame_of, of_layers
from app.draw.ink import Overlay
from app.draw.looks import KINDS
from app.draw.page import Rect
from app.draw.stage import ANGLE, Camera, depths, fitted, grabbed, ground_of, lights, off_screen
from app.draw.wording import Wording, in_pixels
from app.theme import theme
from modules.data.scene import LabelLook, Layer, Scene

Floats = NDArray[np.float64]

__all__ = ["Camera", "Changes", "Viewport", "fitted", "ground_of", "off_screen"]


@dataclass
class Drawn:
    """A layer as it stands on the plotter."""

    layer: Layer
    kind: Kind
    props: list[Any]
    key: Hashable = None


@dataclass(frozen=True)
class Changes:
    """What `show` did: numbers of layers."""

    same: int = 0
    made: int = 0
    fed: int = 0
    dressed: int = 0
    removed: int = 0


@dataclass
class Viewport:
    """A view of a scene.

    Parameters
    ----------
    plotter : any pyvista plotter, in a window or off screen
    scale : pixels of the plotter for one at 100 %
    words : whether labels are drawn; a picture writes its own
    numbers : whether the edges of a scene in space have numbers; a picture writes its own
    stretch : of y in two dimensions, for charts whose axes have nothing to do with each other
    """

    plotter: Any
    scale: float = 1.0
    stretch: float = 1.0
    words: bool = True
    numbers: bool = False
    scene: Scene | None = None
    _drawn: list[Drawn] = field(default_factory=list)
    _style: Style | None = None
    _box: Any = None
    _lifted: Box | None = None
    _corner: tuple[int, int, int] | None = None
    _wording: Wording | None = None
    _numbers: Overlay | None = None
    _watched: bool = False

    def show(self, scene: Scene) -> Changes:
        """Draw a scene; only what changed since the last one is touched.

        Returns
        -------
        How many layers were left alone, made, fed with data, dressed and removed

        Raises
        ------
        ValueError : a layer has a look or a shape that nobody draws
        """
        extent = of_layers(scene.layers)
        style = self._styled(scene, extent)
        restyled, first = style != self._style, self.scene is None
        turned = first or (self.scene is not None and self.scene.look.dimensions != scene.look.dimensions)
        counts = dict.fromkeys(("same", "made", "fed", "dressed", "removed"), 0)
        pairs = self._pairs(scene.layers)
        kept = {id(d) for d, _ in pairs if d is not None}
        for old in self._drawn:
            if id(old) not in kept:
                counts["removed"] += 1
                self._remove(old)
        self._drawn = [self._drawing(drawn, layer, style, restyled, counts) for drawn, layer in pairs]
        self.scene, self._style = scene, style
        if not self._watched:
            self._watched = bool(self.plotter.renderer.AddObserver("StartEvent", lambda *_: self._before_frame()))
        self._place(scene, extent)
        if turned:
            self._lock(scene)
            self.fit()
        self.plotter.renderer.ResetCameraClippingRange()
        return Changes(**counts)

    def _styled(self, scene: Scene, extent: Box) -> Style:
        colours = theme(scene.look.theme)
        self.plotter.renderer.SetBackground(*colours.rgb("view"))
        if not self.plotter.renderer.GetLights().GetNumberOfItems() or self.scene is None:
            lights(self.plotter.renderer)
        return Style(theme=colours, ground=ground_of(scene), scale=self.scale, extent=max(extent.sides) or 1.0)

    def _pairs(self, layers: Sequence[Layer]) -> list[tuple[Drawn | None, Layer]]:
        """Each layer with what already stands for it: itself, else the first one left of the same kind of look."""
        left = list(self._drawn)
        pairs: list[tuple[Drawn | None, Layer]] = []
        for layer in layers:
            same = next((d for d in left if d.layer is layer), None)
            if same is not None:
                left.remove(same)
            pairs.append((same, layer))
        for i, (drawn, layer) in enumerate(pairs):
            if drawn is None:
                near = next((d for d in left if d.kind is KINDS.get(type(layer.look))), None)
                if near is not None:
                    left.remove(near)
                pairs[i] = (near, layer)
        return pairs

    def _drawing(
        self, drawn: Drawn | None, layer: Layer, style: Style, restyled: bool, counts: dict[str, int]
    ) -> Drawn:
        if drawn is None:
            if type(layer.look) not in KINDS:
                there = ", ".join(t.__name__ for t in KINDS)
                raise ValueError(f"nobody draws a {type(layer.look).__name__}: looks are {there}")
            kind = KINDS[type(layer.look)]
            drawn = Drawn(layer, kind, kind.made())
            for prop in drawn.props:
                self.plotter.renderer.AddViewProp(prop)
            counts["made"] += 1
        elif drawn.layer is layer and not restyled:
            counts["same"] += 1
            return drawn
        key = drawn.kind.key(layer, style)
        if key != drawn.key:
            drawn.kind.feed(drawn.props, layer, style)
            counts["fed"] += 1
        if key != drawn.key or restyled or drawn.layer.look != layer.look:
            drawn.kind.dress(drawn.props, layer, style)
            counts["dressed"] += 1
        drawn.layer, drawn.key = layer, key
        return drawn

    def _remove(self, drawn: Drawn) -> None:
        for prop in drawn.props:
            self.plotter.renderer.RemoveViewProp(prop)

    def _place(self, scene: Scene, extent: Box) -> None:
        """Layers lifted one above the other in two dimensions; heights exaggerated in three."""
        flat = scene.look.dimensions == 2
        step = (extent.sides[2] or extent.diagonal * 1e-3) * 1.01
        for i, drawn in enumerate(self._drawn):
            for prop in drawn.props:
                prop.SetPosition(0.0, 0.0, i * step if flat else 0.0)
                prop.SetScale(1.0, self.stretch if flat else 1.0, 1.0 if flat else scene.look.exaggeration)
        self._frame(scene, extent)

    def _frame(self, scene: Scene, extent: Box) -> None:
        """The box around a scene in space, of which only the far sides are drawn."""
        if self._box is not None:
            self.plotter.renderer.RemoveViewProp(self._box)
            self._box = None
        if scene.look.dimensions == 2 or not scene.look.axes or not extent.known:
            return
        self._box = frame_actor(theme(scene.look.theme).rgb("box"), self.scale)
        self._lifted, self._corner = extent.lifted(scene.look.exaggeration), None
        self._turn_frame()
        self.plotter.renderer.AddViewProp(self._box)

    def _before_frame(self) -> None:
        """What follows the camera: the far sides of the box, its numbers, and the labels."""
        self._turn_frame()
        self._number()
        if self.scene is None or not self.words or not any(isinstance(d.layer.look, LabelLook) for d in self._drawn):
            return
        if self._wording is None:
            self._wording = Wording(self.plotter.renderer, self.scale)
        size = tuple(self.plotter.render_window.GetSize())
        factor = self.scene.look.exaggeration if self.scene.look.dimensions == 3 else 1.0
        self._wording.update(
            self.scene, theme(self.scene.look.theme), lambda at: in_pixels(self.project(at * [1, 1, factor]), size), size
        )  # fmt: skip

    def _number(self) -> None:
        """Numbers along three edges of the box."""
        wanted = self.numbers and self._box is not None and self._lifted is not None
        if self.scene is None or (self._numbers is None and not wanted):
            return
        if self._numbers is None:
            self._numbers = Overlay(self.plotter.renderer, self.scale)
        width, height = self.plotter.render_window.GetSize()
        self._numbers.begin(theme(self.scene.look.theme), height)
        if wanted and self._lifted is not None:
            eye = np.asarray(self.plotter.renderer.GetActiveCamera().GetPosition())
            space.axes(
                self._numbers, Rect(0, 0, width, height), self._lifted, frame_of(self.scene.layers),
                self.scene.look.exaggeration, lambda at: in_pixels(self.project(at), (width, height)), eye,
            )  # fmt: skip
        self._numbers.end()

    def _turn_frame(self) -> None:
        """The three sides that meet in the corner nearest to the eye are left out, so that none crosses the scene."""
        if self._box is None or self._lifted is None:
            return
        corner = self._lifted.near_corner(self.plotter.renderer.GetActiveCamera().GetPosition())
        if corner != self._corner:
            self._corner = corner
            self._box.GetMapper().SetInputData(meshes.frame(self._lifted.corners(), corner))

    def _lock(self, scene: Scene) -> None:
        """A flat view is moved and zoomed, never turned; where there is a mouse."""
        if getattr(self.plotter, "iren", None) is None:
            return
        if scene.look.dimensions == 2:
            self.plotter.enable_2d_style()
        else:
            self.plotter.enable_trackball_style()

    # --- camera

    @property
    def aspect(self) -> float:
        """Width over height of the window."""
        width, height = self.plotter.render_window.GetSize()
        return float(width / max(1, height))

    def fit(self) -> None:
        """See all of the scene."""
        assert self.scene is not None
        extent = of_layers(self.scene.layers)
        self.camera = fitted(extent, self.scene.look.dimensions, self.aspect, self.scene.look.exaggeration)

    @property
    def camera(self) -> Camera:
        """Where the view is seen from, as plain numbers."""
        camera = self.plotter.renderer.GetActiveCamera()
        return {
            "position": list(camera.GetPosition()),
            "focal": list(camera.GetFocalPoint()),
            "up": list(camera.GetViewUp()),
            "angle": camera.GetViewAngle(),
            "height": 2 * camera.GetParallelScale(),
            "parallel": bool(camera.GetParallelProjection()),
        }

    @camera.setter
    def camera(self, given: Mapping[str, Any]) -> None:
        flat = self.scene is not None and self.scene.look.dimensions == 2
        camera = self.plotter.renderer.GetActiveCamera()
        focal = [float(v) for v in given["focal"]]
        height = float(given["height"])
        position, up = given["position"], given["up"]
        if flat:  # from above, whatever was asked for
            extent = of_layers(self.scene.layers) if self.scene else None
            far = 10 * (extent.diagonal if extent else 1.0) + height
            position, up = (focal[0], focal[1], focal[2] + far), (0.0, 1.0, 0.0)
        camera.SetFocalPoint(*focal)
        camera.SetPosition(*position)
        camera.SetViewUp(*up)
        camera.SetParallelProjection(flat or bool(given.get("parallel", False)))
        camera.SetParallelScale(height / 2)
        camera.SetViewAngle(float(given.get("angle", ANGLE)))
        self.plotter.renderer.ResetCameraClippingRange()
        self.plotter.camera_set = True

    def pixel(self, *, farthest: bool = False) -> float:
        """World units of one pixel of the window: everywhere in a parallel view, else at the focal point.

        Parameters
        ----------
        farthest : at the far end of the scene instead, where a pixel covers most
        """
        camera = self.plotter.renderer.GetActiveCamera()
        height = self.plotter.render_window.GetSize()[1]
        if camera.GetParallelProjection():
            return float(2 * camera.GetParallelScale() / height)
        distance = camera.GetDistance()
        if farthest and self.scene is not None:
            corners = of_layers(self.scene.layers).lifted(self.scene.look.exaggeration).corners()
            depth = (corners - np.asarray(camera.GetPosition())) @ np.asarray(camera.GetDirectionOfProjection())
            distance = max(distance, float(depth.max()))
        return float(2 * distance * math.tan(math.radians(camera.GetViewAngle()) / 2) / height)

    def project(self, points: Floats) -> Floats:
        """(n, 2) places in the window, from 0 at the left and top to 1, of (n, 3) points as they are drawn."""
        clip = self._clip(points)
        return np.stack([0.5 + clip[:, 0] / 2, 0.5 - clip[:, 1] / 2], axis=1)

    def _clip(self, points: Floats) -> Floats:
        """(n, 3) places in the view, each from -1 to 1; NaN behind the eye."""
        camera = self.plotter.renderer.GetActiveCamera()
        matrix = camera.GetCompositeProjectionTransformMatrix(self.aspect, -1.0, 1.0)
        m = np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
        flat = np.column_stack([points, np.ones(len(points))]) @ m.T
        w = np.where(flat[:, 3:] > 0, flat[:, 3:], np.nan)
        return np.asarray(flat[:, :3] / w)

    def directions(self) -> tuple[Floats, Floats]:
        """Right and up of the window, as unit vectors of the world."""
        camera = self.plotter.renderer.GetActiveCamera()
        matrix = camera.GetModelViewTransformMatrix()
        rows = np.array([[matrix.GetElement(i, j) for j in range(3)] for i in range(2)])
        return rows[0], rows[1]

    def hidden(self, points: Floats) -> Any:
        """(n,) whether something is drawn before a point, or it lies beyond the window. Call after `pixels`."""
        depth = depths(self.plotter.render_window)
        height, width = depth.shape
        clip = self._clip(points)
        x = np.nan_to_num((clip[:, 0] + 1) / 2 * width, nan=-1).astype(int)
        y = np.nan_to_num((clip[:, 1] + 1) / 2 * height, nan=-1).astype(int)
        inside = (x >= 2) & (y >= 2) & (x < width - 2) & (y < height - 2)
        before = np.ones(len(points), bool)
        nearest = depth[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)]
        before[inside] = nearest[inside] < (clip[inside, 2] + 1) / 2 - 2e-3
        return before

    def pixels(self) -> NDArray[np.uint8]:
        """(height, width, 3) uint8: what the window shows now."""
        self.plotter.render_window.Render()
        return grabbed(self.plotter.render_window)
