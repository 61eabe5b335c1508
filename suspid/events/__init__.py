"""What finding decays and joining repeats is made of."""
