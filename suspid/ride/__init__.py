"""Figures that a car or a record is judged by: comfort, grip, travel.

The room for `ride`, `grip`, `road` and `tune`. Nothing is here yet. A metric is a module of its name with a
function that takes a `suspid.Suspension` or a record and returns a frozen result in SI units.
"""
