"""All that a module writer imports."""

from pathlib import Path
from typing import Annotated, Literal, NamedTuple

from modules.data.accuracy import (
    EXACT,
    Accuracy,
    Flag,
    Missing,
    Source,
    Term,
    bound,
    deviation,
    exactly,
    unknown,
)
from modules.data.geometry import Cells, Field, Primitive, Shown
from modules.data.grid import Curvilinear, Frame, Grid, Rectilinear, Regular, Unstructured, regular
from modules.data.memo import memo
from modules.data.operators import (
    Chain,
    Gather,
    Identity,
    Interleave,
    Matrix,
    Operator,
    Spread,
    Stencil,
    Sum,
    along,
    scaling,
    select,
    stencil,
    uniform,
)
from modules.data.scene import (
    ChartLook,
    Colouring,
    ImageLook,
    LabelLook,
    LineLook,
    PointLook,
    SceneLook,
    SurfaceLook,
    Text,
    VolumeLook,
)
from modules.data.wires import ColourMap, Geometry, Layer, Model, Samples, Scene, Table, Value
from modules.declare import accuracy_mapper, mapper, modeller, reader, renderer
from modules.parameters import Choice, Position, Range
from modules.progress import Cancelled, Progress

__all__ = [
    "EXACT", "Accuracy", "Annotated", "Cancelled", "Cells", "Chain", "ChartLook", "Choice", "ColourMap", "Colouring",
    "Curvilinear", "Field", "Flag", "Frame", "Gather", "Geometry", "Grid", "Identity", "ImageLook", "Interleave",
    "LabelLook", "Layer", "LineLook", "Literal", "Matrix", "Missing", "Model", "NamedTuple", "Operator", "Path",
    "PointLook", "Position", "Primitive", "Progress", "Range", "Rectilinear", "Regular", "Samples", "Scene",
    "SceneLook", "Shown", "Source", "Spread", "Stencil", "Sum", "SurfaceLook", "Table", "Term", "Text", "Unstructured",
    "Value", "VolumeLook", "accuracy_mapper", "along", "bound", "deviation", "exactly", "mapper", "memo", "modeller",
    "reader", "regular", "renderer", "scaling", "select", "stencil", "uniform", "unknown",
]  # fmt: skip
