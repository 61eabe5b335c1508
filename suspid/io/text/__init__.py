"""Text files: encoding, dialect, layout, cells."""
