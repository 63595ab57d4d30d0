"""A scene on a plotter, in a window or off screen: the only door through which our data becomes VTK actors.

`show` compares layers by identity: the same layer is left alone, a new look only sets properties, a new shape only
gives its mapper new data. In two dimensions the same actors are seen from above by a parallel camera that cannot turn,
each layer lifted above the one before, so that none fights with another for the same depth.
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from app.draw.extent import Box, of_layers
from app.draw.looks import KINDS, Kind, Style
from app.theme import rgb, theme
from modules.data.scene import Layer, Scene, SurfaceLook

Floats = NDArray[np.float64]

Camera = dict[str, Any]
"""position, focal, up: three numbers each; angle in degrees; height in world units (parallel); parallel: a flag."""

ANGLE = 26.0
"""Of view, in degrees: a long lens, which bends a surface little."""
FROM = (-0.42, -1.0, 0.72)
"""Where a view in space is first seen from: the south, a little west, above."""
MARGIN = 1.04


def prepare() -> None:
    """Before VTK is first imported: no X server is asked for where there is none."""
    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")


def off_screen(size: tuple[int, int]) -> Any:
    """A plotter without a window, `size` pixels wide and high, that smooths its edges."""
    prepare()
    import pyvista
    from vtkmodules.vtkCommonCore import vtkSMPTools

    vtkSMPTools.SetBackend("STDThread")
    plotter = pyvista.Plotter(off_screen=True, window_size=list(size), lighting="none")
    plotter.render_window.SetMultiSamples(4)
    return plotter


@dataclass
class Drawn:
    """A layer as it stands on the plotter."""

    layer: Layer
    kind: Kind
    props: list[Any]
    key: Hashable = None
    lift: float = 0.0


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
    stretch : of y in two dimensions, for charts whose axes have nothing to do with each other
    """

    plotter: Any
    scale: float = 1.0
    stretch: float = 1.0
    scene: Scene | None = None
    _drawn: list[Drawn] = field(default_factory=list)
    _style: Style | None = None
    _box: Any = None
    _aims: bool = False

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
            self._lights()
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
        from vtkmodules.vtkFiltersSources import vtkCubeSource
        from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

        cube, mapper = vtkCubeSource(), vtkPolyDataMapper()
        cube.SetBounds(*extent.lifted(scene.look.exaggeration).bounds)
        mapper.SetInputConnection(cube.GetOutputPort())
        self._box = vtkActor()
        self._box.SetMapper(mapper)
        prop = self._box.GetProperty()
        prop.SetRepresentationToWireframe()
        prop.SetColor(*rgb(theme(scene.look.theme)["box"]))
        prop.SetLineWidth(1.0 * self.scale)
        prop.LightingOff()
        prop.FrontfaceCullingOn()
        self._box.PickableOff()
        self.plotter.renderer.AddViewProp(self._box)

    def _lights(self) -> None:
        """A light over the left shoulder, and a weak one from the right that opens the shadows."""
        from vtkmodules.vtkRenderingCore import vtkLight

        self.plotter.renderer.RemoveAllLights()
        for place, strength in (((-0.7, 0.75, 0.8), 0.92), ((0.9, 0.1, 0.7), 0.22)):
            light = vtkLight()
            light.SetLightTypeToCameraLight()
            light.SetPosition(*place)
            light.SetFocalPoint(0.0, 0.0, 0.0)
            light.SetIntensity(strength)
            self.plotter.renderer.AddLight(light)

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
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkFloatArray

        window = self.plotter.render_window
        width, height = window.GetSize()
        buffer = vtkFloatArray()
        window.GetZbufferData(0, 0, width - 1, height - 1, buffer)
        depth = vtk_to_numpy(buffer).reshape(height, width)
        clip = self._clip(points)
        x = np.nan_to_num((clip[:, 0] + 1) / 2 * width, nan=-1).astype(int)
        y = np.nan_to_num((clip[:, 1] + 1) / 2 * height, nan=-1).astype(int)
        inside = (x >= 2) & (y >= 2) & (x < width - 2) & (y < height - 2)
        before = np.ones(len(points), bool)
        nearest = depth[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)]
        before[inside] = nearest[inside] < (clip[inside, 2] + 1) / 2 - 2e-3
        return before

    def pixels(self) -> Any:
        """(height, width, 3) uint8: what the window shows now."""
        self.plotter.render_window.Render()
        return self.plotter.screenshot(return_img=True)


def ground_of(scene: Scene) -> Literal["view", "clay"]:
    """What lines and dust of a scene lie on."""
    clay = any(isinstance(one.look, SurfaceLook) and one.look.opacity > 0.5 for one in scene.layers)
    return "clay" if clay else "view"


def fitted(extent: Box, dimensions: int, aspect: float, exaggeration: float = 1.0) -> Camera:
    """The camera that sees all of a box: from above in two dimensions, from the south and above in three."""
    if dimensions == 2:
        wide, high = extent.sides[0] or 1.0, extent.sides[1] or 1.0
        height = max(high, wide / aspect)
        x, y, z = extent.centre
        return {
            "position": [x, y, z + 10 * extent.diagonal], "focal": [x, y, z], "up": [0.0, 1.0, 0.0],
            "angle": ANGLE, "height": height, "parallel": True,
        }  # fmt: skip
    lifted = extent.lifted(exaggeration)
    length = math.sqrt(sum(v * v for v in FROM))
    away = [v / length for v in FROM]
    distance = lifted.distance(away, ANGLE, aspect) * MARGIN
    position = [c + distance * a for c, a in zip(lifted.centre, away, strict=True)]
    return {
        "position": position, "focal": list(lifted.centre), "up": [0.0, 0.0, 1.0],
        "angle": ANGLE, "height": lifted.diagonal, "parallel": False,
    }  # fmt: skip
