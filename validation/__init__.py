"""The reports that judge the library: ``python -m validation`` writes them to ``validation/report``."""
