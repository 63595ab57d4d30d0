"""Accuracy mappers: a geometry's accuracy -> geometry that shows it. This room is ours: the thesis does it inside mapping."""
