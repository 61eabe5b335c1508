"""Foreign readers: each failure becomes one line, and nothing is printed."""

from __future__ import annotations

import logging
import sys
import warnings

import pytest

from suspid.errors import RecordError
from suspid.io.foreign import sheltered, unique_names


class Broken:
    """Like a reader that failed before it had anything to close."""

    def __del__(self) -> None:
        raise AttributeError("no header")


def noisy() -> int:
    sys.stdout.write("a line")
    sys.stderr.write("another")
    warnings.warn("a warning", ResourceWarning, stacklevel=1)
    logging.getLogger("a.library").error("an entry")
    return 7


class TestSilence:
    def test_only_the_result_comes_through(
        self, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
    ) -> None:
        assert sheltered(noisy, extra="mdf", suffix=".a") == 7
        assert capsys.readouterr() == ("", "")
        assert not caplog.records

    def test_ends_with_the_reading(self, caplog: pytest.LogCaptureFixture) -> None:
        hook = sys.unraisablehook
        sheltered(noisy, extra="mdf", suffix=".a")
        logging.getLogger("a.library").error("an entry")
        assert [record.message for record in caplog.records] == ["an entry"]
        assert sys.unraisablehook is hook


class TestFailures:
    @pytest.mark.parametrize(
        "kind", [MemoryError, RecursionError, OSError, KeyError, AssertionError, ZeroDivisionError]
    )
    def test_become_one_line(self, kind: type[Exception]) -> None:
        def read() -> None:
            raise kind("here\nand\x1b[2J there")

        with pytest.raises(RecordError, match=f"^is damaged: {kind.__name__}: .*here") as caught:
            sheltered(read, extra="mdf", suffix=".a")
        assert str(caught.value).isprintable()
        # The frames of the reader, and what they hold open, are gone.
        assert caught.value.__context__ is None

    def test_of_destructors_are_not_heard(self, capsys: pytest.CaptureFixture[str]) -> None:
        def read() -> None:
            reader = Broken()
            raise ValueError(str(type(reader)))

        with pytest.raises(RecordError):
            sheltered(read, extra="mdf", suffix=".a")
        assert capsys.readouterr() == ("", "")

    def test_of_our_own_stay(self) -> None:
        def read() -> None:
            raise RecordError("is cut off")

        with pytest.raises(RecordError, match="^is cut off$"):
            sheltered(read, extra="mdf", suffix=".a")

    def test_a_long_message_is_cut(self) -> None:
        def read() -> None:
            raise ValueError("x" * 10_000)

        with pytest.raises(RecordError) as caught:
            sheltered(read, extra="mdf", suffix=".a")
        assert len(str(caught.value)) < 300


class TestUniqueNames:
    def test_all_differ_whatever_they_are(self) -> None:
        named = [("a", "z"), ("b", "z"), ("", "z"), ("", "z"), ("a", ""), ("", "a/z"), ("a", "z")]
        names = unique_names(named)
        assert len(set(names)) == len(named)
        assert all(names)
