"""Sensors: units, signs and scales, and the vertical in a tilted accelerometer."""
