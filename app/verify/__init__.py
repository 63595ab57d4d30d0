"""Whether what a network states of its errors is so: it is run on data whose truth is known."""
