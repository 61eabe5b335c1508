"""The report of what fleets cost: on a few records it says what it is to say."""

from __future__ import annotations

import pytest

from validation.fleet import report


@pytest.mark.slow
class TestReport:
    def test_a_small_one(self) -> None:
        text = report(records=6, growth=(2, 4), on_dask=2)
        assert "byte by byte" in text
        assert "NOT the same" not in text
        for heading in ("Beside a plain loop", "Against the number of records", "Ten million records"):
            assert heading in text
        assert "2 workers of a Dask cluster" in text
