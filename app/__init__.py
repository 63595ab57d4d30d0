"""Nonius Explorer: networks of modules in which every wire carries its accuracy."""

__version__ = "0.1.0"
