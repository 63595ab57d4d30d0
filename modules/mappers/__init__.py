"""Mappers: Model -> Geometry, and how far each shape may lie from the truth of the model."""
