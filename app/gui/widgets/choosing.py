"""Which widget a parameter gets: read from its declaration alone."""

from __future__ import annotations

from typing import get_args, get_origin

from app.gui.widgets.field import Field
from app.gui.widgets.number import NumberField
from app.gui.widgets.plain import LETTERS, SEGMENTS, Colour, File, Named, Options, Segments, Several, Words, YesNo
from modules.parameters import Parameter


def field_of(parameter: Parameter) -> Field:
    """The widget for a parameter."""
    kind = parameter.type
    options = parameter.options
    if options:
        few = len(options) <= SEGMENTS and sum(map(len, options)) <= LETTERS and "map" not in parameter.name
        return Segments(parameter) if few else Options(parameter)
    if kind is bool:
        return YesNo(parameter)
    if kind in (int, float):
        return NumberField(parameter)
    if parameter.is_path:
        return File(parameter)
    if get_origin(kind) is tuple and all(a in (int, float, Ellipsis) for a in get_args(kind)):
        return Several(parameter)
    if parameter.choice is not None:
        return Named(parameter)
    if parameter.name == "colour":
        return Colour(parameter)
    return Words(parameter)
