"""Networks of modules: what may be wired, what must fire, what is kept."""
