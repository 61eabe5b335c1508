"""Data of MATLAB's System Identification Toolbox: outputs and inputs of each experiment, on its own clock."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat
from scipy.io.matlab import MatlabObject

from suspid import RecordError, analyse, read_recording
from suspid.words import LeftOut, Note

ROWS = 300
STEPS = np.arange(ROWS)
RINGING = 2 + np.exp(-STEPS / 60) * np.cos(STEPS / 3) + 1e-4 * np.random.default_rng(0).standard_normal(ROWS)
PUSH = np.where(STEPS < 0, 0.0, 3.0)[:, None]
EMPTY = np.zeros((0, 0))


def cells(*values: Any) -> np.ndarray:
    found = np.empty((1, len(values)), object)
    for k, value in enumerate(values):
        found[0, k] = value
    return found


def iddata(outputs: list[np.ndarray], inputs: list[np.ndarray], *, of_class: str = "iddata", **fields: Any) -> Any:
    """Return an object as MATLAB has it: cells with one array for each experiment, texts for each channel."""
    count = len(outputs)
    whole = {
        "Domain": "Time",
        "OutputData": cells(*outputs),
        "OutputName": cells(*(f"y{k + 1}" for k in range(outputs[0].shape[1]))),
        "OutputUnit": cells(*("" for _ in range(outputs[0].shape[1]))),
        "InputData": cells(*inputs),
        "InputName": cells(*(f"u{k + 1}" for k in range(inputs[0].shape[1]))),
        "Ts": cells(*[0.05] * count),
        "Tstart": cells(*[EMPTY] * count),
        "SamplingInstants": cells(*(np.zeros((len(one), 0)) for one in outputs)),
        "TimeUnit": "seconds",
        "ExperimentName": cells(*(f"Exp{k + 1}" for k in range(count))),
        "Notes": EMPTY,
        **fields,
    }
    content = np.empty((1, 1), [(name, object) for name in whole])
    for name, value in whole.items():
        content[name][0, 0] = value
    return MatlabObject(content, of_class)


def saved(folder: Path, **variables: Any) -> Path:
    savemat(folder / "r.mat", variables)
    return folder / "r.mat"


def test_outputs_and_inputs_are_channels_on_the_clock_of_the_object(tmp_path: Path) -> None:
    both = np.column_stack([RINGING, -RINGING])
    names: dict[str, Any] = {
        "OutputName": cells("seat", "tire"),
        "OutputUnit": cells("mm", "kN"),
        "InputName": cells("push"),
    }
    data = iddata([both], [PUSH], **names, Tstart=cells(1.0))
    recording = read_recording(saved(tmp_path, data=data, t=STEPS * 0.05))
    assert recording.names == ("data.seat", "data.tire", "data.push")
    assert [channel.unit for channel in recording.channels] == ["mm", "kN", ""]
    assert [channel.rate for channel in recording.channels] == [20, 20, 20]
    assert recording.tests == ()
    assert np.array_equal([channel.values for channel in recording.channels], np.column_stack([both, PUSH]).T)
    assert np.allclose(recording["data.push"].timepts, 1 + STEPS / 20, rtol=0, atol=1e-12)


@pytest.mark.parametrize(("unit", "step"), [("milliseconds", 50.0), ("minutes", 0.05 / 60), ("", 0.05)])
def test_the_step_is_in_its_unit(tmp_path: Path, unit: str, step: float) -> None:
    data = iddata([RINGING[:, None]], [PUSH], Ts=cells(step), TimeUnit=unit)
    assert read_recording(saved(tmp_path, data=data))["data.y1"].rate == pytest.approx(20)


def test_stamps_are_used_where_there_is_no_step(tmp_path: Path) -> None:
    """An object on uneven times has them in place of a step."""
    stamps = np.cumsum(np.where(STEPS % 3, 50.0, 60.0))
    times: dict[str, Any] = {"Ts": cells(EMPTY), "SamplingInstants": cells(stamps[:, None]), "TimeUnit": "milliseconds"}
    (seat,) = read_recording(saved(tmp_path, z=iddata([RINGING[:, None]], [PUSH[:, :0]], **times))).channels
    assert seat.rate is None
    assert np.array_equal(seat.timepts, stamps / 1000)


def test_without_a_step_the_rate_is_to_be_given(tmp_path: Path) -> None:
    path = saved(tmp_path, z=iddata([RINGING[:, None]], [PUSH], Ts=cells(EMPTY)))
    with pytest.raises(RecordError, match="sampling rate"):
        read_recording(path)
    assert read_recording(path, fs=20)["z.y1"].timepts[-1] == pytest.approx((ROWS - 1) / 20)


def test_objects_and_experiments_are_tests(tmp_path: Path) -> None:
    short = iddata([RINGING[:200, None]], [PUSH[:200]])
    two = {"id": iddata([RINGING[:, None]], [PUSH]), "val": short, "gain": STEPS[:50]}
    recording = read_recording(saved(tmp_path, **two))
    assert recording.tests == ("id", "val")
    assert recording.of_test("val")["val.y1"].values.size == 200
    assert dict(recording.left_out)["gain"].code is LeftOut.NO_TIME
    assert read_recording(tmp_path / "r.mat", time="val").names == ("val.y1", "val.u1")

    data = iddata([RINGING[:, None], RINGING[:200, None]], [PUSH, PUSH[:200]], Ts=cells(0.05, 0.1))
    recording = read_recording(saved(tmp_path, data=data))
    assert recording.names == ("data[Exp1].y1", "data[Exp1].u1", "data[Exp2].y1", "data[Exp2].u1")
    assert recording.tests == ("data[Exp1]", "data[Exp2]")
    assert [recording[f"data[Exp{k}].y1"].rate for k in (1, 2)] == [20, 10]
    # The parts of a name are told by points.
    named = iddata([RINGING[:, None], RINGING[:200, None]], [PUSH, PUSH[:200]], ExperimentName=cells("a.1", "b.x"))
    assert read_recording(saved(tmp_path, data=named)).tests == ("data[1]", "data[2]")


def test_outputs_and_inputs_of_one_name_are_told_apart(tmp_path: Path) -> None:
    data = iddata([RINGING[:, None]], [PUSH], OutputName=cells("z"), InputName=cells("z"))
    assert read_recording(saved(tmp_path, data=data)).names == ("data.output/z", "data.input/z")


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (iddata([RINGING[:, None]], [PUSH], Domain="Frequency"), "'data' is sampled over frequency, not over time"),
        (iddata([RINGING[:, None]], [PUSH], TimeUnit="years"), "'data' has its time in 'years'"),
        (iddata([RINGING[:, None] * 1j], [PUSH]), "'data' contains no real values"),
        (iddata([RINGING[:, None]], [PUSH[:9]]), "outputs of 300 samples, and inputs of another length"),
        (iddata([RINGING[:, None]], [PUSH], of_class="frd"), "'data' is an object of class 'frd'; save its contents"),
    ],
)
def test_what_is_no_record_is_told(tmp_path: Path, data: Any, why: str) -> None:
    with pytest.raises(RecordError, match=why):
        read_recording(saved(tmp_path, data=data))


def test_an_input_that_is_held_is_no_motion(tmp_path: Path) -> None:
    found = analyse(saved(tmp_path, data=iddata([RINGING[:, None]], [PUSH + (STEPS[:, None] > 4)])))
    assert Note.HELD_CHANNEL in {note.code for note in found.notes}
    assert found.identification is not None
    assert found.modes.wn == pytest.approx([20 / 3], rel=1e-2)
