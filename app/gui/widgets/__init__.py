"""Widgets of the control panel: one for each kind of parameter, chosen by its declaration."""
