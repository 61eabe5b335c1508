"""What is read is what was given: imaginary parts, masks and the ends of cut files are not dropped without a word."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest

from suspid import RecordError, as_record, identify, read_record, read_recording
from suspid.errors import RecordWarning
from suspid.records import inputs_of

TIME = np.arange(200) / 100
MOTION = np.exp(-TIME) * np.sin(40 * TIME)
COMPLEX = MOTION + 1j * MOTION[::-1]
MASKED = np.ma.masked_array(MOTION, mask=np.arange(TIME.size) % 50 == 3)


def response(**given: Any) -> control.TimeResponseData:
    return control.TimeResponseData(
        time=TIME,
        outputs=given.get("outputs", MOTION[None]),
        inputs=given.get("inputs"),
        output_labels=["seat"],
        input_labels=["road"] if "inputs" in given else None,
        issiso=True,
    )


def masked_later() -> control.TimeResponseData:
    """Return a response whose samples were masked after it was made: python-control drops a mask that it is given."""
    made = response()
    made.y = MASKED[None]
    return made


class TestNumbersThatAreNotReal:
    @pytest.mark.parametrize(
        "give",
        [
            lambda: as_record(COMPLEX, fs=100),
            lambda: as_record([list(COMPLEX)], fs=100),
            lambda: as_record((TIME, COMPLEX)),
            lambda: as_record((TIME + 1j, MOTION)),
            lambda: as_record(response(outputs=COMPLEX[None])),
            lambda: identify(response(outputs=COMPLEX[None])),
            lambda: inputs_of(response(inputs=COMPLEX[None])),
        ],
    )
    def test_complex(self, give: Any) -> None:
        with pytest.raises(RecordError, match="complex"):
            give()

    @pytest.mark.parametrize(
        "give",
        [
            lambda: as_record(MASKED, fs=100),
            lambda: as_record([MASKED, MOTION], fs=100),
            lambda: as_record((TIME, MASKED)),
            lambda: as_record(MOTION, timepts=np.ma.masked_array(TIME, mask=TIME == 1)),
            lambda: as_record(masked_later()),
            lambda: identify(masked_later()),
        ],
    )
    def test_masked(self, give: Any) -> None:
        with pytest.raises(RecordError, match="masked"):
            give()

    @pytest.mark.parametrize("parts", ["ri", ("re", "im"), ("Real", "Imag")])
    def test_complex_in_a_file_is_left_out_and_named(self, tmp_path: Path, parts: Any) -> None:
        h5py = pytest.importorskip("h5py")
        numbers = np.zeros(TIME.size, [(parts[0], float), (parts[1], float)])
        numbers[parts[0]], numbers[parts[1]] = COMPLEX.real, COMPLEX.imag
        with h5py.File(tmp_path / "r.h5", "w") as file:
            file["t"], file["seat"], file["whole"] = TIME, numbers, MOTION
        recording = read_recording(tmp_path / "r.h5")
        assert recording.names == ("whole",)
        assert str(dict(recording.left_out)["seat"]) == "is complex; a record is real"

    def test_fill_values_of_netcdf_are_missing_samples(self, tmp_path: Path) -> None:
        h5py = pytest.importorskip("h5py")
        # Values that are met elsewhere: nothing but the attribute tells them.
        stated = {"_FillValue": MOTION[70], "missing_value": [MOTION[80], 7.0]}
        with h5py.File(tmp_path / "r.h5", "w") as file:
            file["t"] = TIME
            for name, value in stated.items():
                file[name] = MOTION
                file[name].attrs[name] = value
        recording = read_recording(tmp_path / "r.h5")
        assert [np.flatnonzero(np.isnan(recording[name].values)).tolist() for name in stated] == [[70], [80]]

    def test_a_record_prints_what_it_is(self) -> None:
        assert (
            str(as_record(MOTION, fs=100, channels=["seat"])) == "200 samples at 100 Hz from t = 0 s, 1 channel: seat"
        )


ROWS = 24
TEXTS = {
    "fixed": ",".join(["{0:.2f}", "{1:.6f}"]),
    "exponents": ",".join(["{0:.2f}", "{1:.4e}"]),
    "as many digits as needed": ",".join(["{0!r}", "{1!r}"]),
    "whole": ",".join(["{0:.2f}", "{2}"]),
    "semicolons at the end": "{0:.2f};{1:.6f};",
    "remarks": ",".join(["{0:.2f}", "{1:.6f}", "running"]),
    "one column": "{1:.6f}",
}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
@pytest.mark.parametrize("name", TEXTS)
def test_a_text_cut_anywhere_is_read_true_or_with_a_word(tmp_path: Path, name: str, encoding: str) -> None:
    """Cut a text at every one of its last characters: its samples are those of the whole one, or something is said."""
    lines = [TEXTS[name].format(t, x, round(1000 * x)) for t, x in zip(TIME.tolist(), MOTION.tolist(), strict=True)]
    head = {"semicolons at the end": "t;seat;", "remarks": "t,seat,note", "one column": "seat"}.get(name, "t,seat")
    text = "\n".join([head, *lines[40 : 40 + ROWS], ""])
    told = 0

    def columns(length: int) -> list[list[float]]:
        (tmp_path / "r.csv").write_bytes(text[:length].encode(encoding))
        recording = read_recording(tmp_path / "r.csv", fs=100 if name == "one column" else None)
        nonlocal told
        told = sum(why.code.value in ("cut_short", "cut_cell", "cut_number", "no_end") for _, why in recording.left_out)
        return [recording["seat"].values.tolist(), recording["seat"].timepts.tolist()]

    whole = columns(len(text))
    assert not told
    for cut in range(1, 2 * len(lines[-1])):
        seat, time = columns(len(text) - cut)
        true = [x if x == x else None for x in seat] == [
            y if x == x else None for x, y in zip(seat, whole[0], strict=False)
        ] and time == whole[1][: len(time)]
        assert true or told, text[-30 - cut : -cut]


def test_a_cut_number_is_left_out_and_warned_of(tmp_path: Path) -> None:
    rows = "".join(f"{t:.2f},{x:.6f}\n" for t, x in zip(TIME, MOTION, strict=True))
    (tmp_path / "r.csv").write_text("t,seat\n" + rows[:-3])
    with pytest.warns(RecordWarning, match=r"line 201 is cut short within its last number: .* has 4 of 6 characters"):
        record = read_record(tmp_path / "r.csv")
    assert len(record.time) == 199
    # All digits are there: only the line feed is missing.
    (tmp_path / "r.csv").write_text("t,seat\n" + rows[:-1])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(read_record(tmp_path / "r.csv").time) == 200


@pytest.mark.parametrize("missing", ["---", "-nan", "-1.#IND", "--"])
def test_a_word_for_what_is_missing_is_no_cut_number(tmp_path: Path, missing: str) -> None:
    rows = [f"{t:.2f},{x:.6f}" for t, x in zip(TIME, MOTION, strict=True)]
    (tmp_path / "r.csv").write_text("\n".join(["t,seat", *rows[:-1], f"{rows[-1].split(',')[0]},{missing}"]))
    assert len(read_recording(tmp_path / "r.csv")["seat"].values) == 200
