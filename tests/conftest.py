"""Settings of all tests."""

import gc
from pathlib import Path

import pytest
from hypothesis import settings

# No test fails because the machine is busy.
settings.register_profile("no clock", deadline=None)
settings.load_profile("no clock")


@pytest.fixture(scope="session")
def scratch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder whose files the examples of hypothesis overwrite."""
    return tmp_path_factory.mktemp("scratch")


def pytest_collection_finish() -> None:
    """Leave the modules of all tests to no collection of garbage: each failed reading of a file asks for one."""
    gc.collect()
    gc.freeze()
