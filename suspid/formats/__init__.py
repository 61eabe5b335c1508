"""Files into tables: one module a format."""
