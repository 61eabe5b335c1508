"""ASAM MDF: blocks checked before asammdf may read them, channels, CAN frames."""
