"""Numbers of text files, by each of the readers of numbers."""

from pathlib import Path

import numpy as np
import pytest

from suspid import RecordError, read_recording


class TestNumbers:
    """Every number is the double next to it, which Python's own reading of a float is, whichever reader took it."""

    @staticmethod
    def text(mark: str, decimal: str) -> tuple[str, list[list[float]]]:
        rng = np.random.default_rng(3)
        mantissas, powers = rng.uniform(-10, 10, (6000, 3)), rng.integers(-320, 300, (6000, 3))
        cells = [
            [f"{m:.{digits}f}e{p}" for m, p, digits in zip(ms, ps, (17, 3, 9), strict=True)]
            for ms, ps in zip(mantissas.tolist(), powers.tolist(), strict=True)
        ]
        rows = "".join(mark.join([str(k), *row]).replace(".", decimal) + "\n" for k, row in enumerate(cells))
        return mark.join(["t", "a", "b", "c"]) + "\n" + rows, [[float(cell) for cell in row] for row in cells]

    @pytest.mark.parametrize(("mark", "decimal"), [(",", "."), (";", ","), ("\t", ".")])
    @pytest.mark.parametrize("worth", [0, 1 << 62])
    def test_readers_agree(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mark: str, decimal: str, worth: int
    ) -> None:
        pytest.importorskip("pyarrow")
        monkeypatch.setattr("suspid.io.text.numbers.WORTH_ARROW", worth)
        text, expected = self.text(mark, decimal)
        (tmp_path / "r.csv").write_text(text)
        found = read_recording(tmp_path / "r.csv")
        assert np.array_equal(np.array([found[name].values for name in "abc"]).T, expected)

    @pytest.mark.parametrize("odd", ["", "nan", "1e", "+5", "abc", "1_0", '"7"', "#5"])
    def test_what_one_reader_refuses_is_read_as_before(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, odd: str
    ) -> None:
        pytest.importorskip("pyarrow")
        rows = [f"{k / 10},{k % 7},{k % 3}\n" for k in range(50)]
        rows[30] = f"3.0,{odd},0\n"
        (tmp_path / "r.csv").write_text("".join(["t,a,b\n", *rows]))
        told: list[object] = []
        for worth in (0, 1 << 62):
            monkeypatch.setattr("suspid.io.text.numbers.WORTH_ARROW", worth)
            try:
                found = read_recording(tmp_path / "r.csv")
                told.append((found.left_out, [channel.values.tobytes() for channel in found.channels]))
            except RecordError as error:
                told.append(str(error))
        assert told[0] == told[1]
