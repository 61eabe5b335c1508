"""What a fleet run is made of: the list, the parts, the work, the summary."""
