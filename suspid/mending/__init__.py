"""What cleaning is made of: clocks, gaps, samples that cannot be, units."""
