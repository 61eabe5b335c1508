"""Settings of all tests."""

from hypothesis import settings

# No test fails because the machine is busy.
settings.register_profile("no clock", deadline=None)
settings.load_profile("no clock")
