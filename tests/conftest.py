"""Settings of all tests."""

import gc
from html import escape
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# No test fails because the machine is busy.
settings.register_profile("no clock", deadline=None)
settings.load_profile("no clock")

# Importing all tests makes millions of objects and no garbage to speak of.
gc.disable()


@pytest.fixture(scope="session")
def scratch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder whose files the examples of hypothesis overwrite."""
    return tmp_path_factory.mktemp("scratch")


@pytest.fixture
def words_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the pictures of reports empty: their layout takes most of a page, and most tests read the words beside."""

    def empty(figure: "Figure", *, name: str, described: str) -> str:
        assert figure.axes, f"nothing is drawn in {name}"
        return f'<svg viewBox="0 0 4 3" role="img" aria-label="{escape(described)}"></svg>'

    monkeypatch.setattr(import_module("suspid.reporting.pictures"), "svg_of", empty)


def pytest_collection_finish() -> None:
    """Leave the modules of all tests to no collection of garbage: each failed reading of a file asks for one."""
    gc.collect()
    gc.freeze()
    gc.enable()
