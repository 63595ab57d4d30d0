"""Modellers: Samples -> Samples or Model; each step says what it does to the accuracy."""
