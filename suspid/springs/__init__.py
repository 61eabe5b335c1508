"""What reconstruction is made of: unknowns, observations, convex programs, searches, verdicts."""
