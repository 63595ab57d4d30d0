"""Renderers: Geometry or Samples -> Layer (what to show, and how); `view` -> Scene."""
