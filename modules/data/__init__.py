"""What travels on a wire: grids, samples, models, geometry, layers, and the accuracy of each."""
