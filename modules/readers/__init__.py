"""Readers: (nothing) -> Samples, with what is known of the data's accuracy."""
