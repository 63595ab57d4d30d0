"""The rooms of the walk, and the two cellars under them.

    readers -> modellers -> mappers -> accuracy_mappers -> renderers

Each file of a room is one technique: a decorated function. `modules.data` says what travels on a wire,
`modules.kernels` computes on plain arrays. A room knows nothing of networks or windows.
"""
