import pickle
import subprocess
import sys
from pathlib import Path

import control
import numpy as np
import pytest

from suspid import RecordError
from suspid.records import as_response, late_start
from suspid.samples import as_samples
from suspid.signals import Signal, as_signal, uniform_step


def response(times: object, values: object) -> control.TimeResponseData:
    values = np.atleast_2d(np.asarray(values, float))
    return as_response(np.asarray(times, float), values, [f"c{i}" for i in range(len(values))])


class TestSamples:
    def test_there_and_back(self) -> None:
        times, values = 5.0 + 0.1 * np.arange(4), np.arange(8.0).reshape(2, 4)
        signal = as_signal(response(times, values))
        np.testing.assert_array_equal(signal.values, values)
        np.testing.assert_allclose(signal.timepts, times, rtol=1e-15, atol=0)
        assert signal.channels == ("c0", "c1")
        assert signal.start == 5.0
        assert signal.step == pytest.approx(0.1, rel=1e-14)
        assert signal.duration == pytest.approx(0.4, rel=1e-14)
        assert not signal.values.flags.writeable

    def test_one_trace_of_an_impulse_response_is_taken(self) -> None:
        system = control.ss([[-1.0]], [[1.0]], [[1.0]], 0)
        made = control.impulse_response(system, np.linspace(0, 1, 11))
        np.testing.assert_allclose(as_signal(made).values[0], np.exp(-made.time), rtol=1e-12, atol=0)

    def test_samples_of_the_library_are_checked_once_and_not_copied(self) -> None:
        samples = as_samples(np.arange(5.0), np.arange(10.0).reshape(2, 5), ["a", "b"])
        signal = as_signal(samples)
        assert as_signal(samples) is signal
        assert np.shares_memory(signal.values, samples.y)
        assert not signal.values.flags.writeable
        with pytest.raises(RecordError, match="has 5 samples; at least 6"):
            as_signal(samples, least=6)

    def test_what_follows_from_samples_is_not_pickled_with_them(self) -> None:
        samples = as_samples(np.arange(500.0), np.ones((1, 500)), ["a"])
        size = len(pickle.dumps(samples))
        assert len(as_signal(samples).values) == len(samples.response.outputs.reshape(1, -1))
        assert len(pickle.dumps(samples)) == size
        np.testing.assert_array_equal(pickle.loads(pickle.dumps(samples)).y, samples.y)

    def test_two_traces_are_refused(self) -> None:
        system = control.ss([[-1.0]], [[1.0, 2.0]], [[1.0]], [[0, 0]])
        with pytest.raises(RecordError, match="contains 2 traces"):
            as_signal(control.impulse_response(system, np.linspace(0, 1, 11)))

    @pytest.mark.parametrize("bad", [np.nan, np.inf])
    def test_a_gap_is_named_with_channel_and_time(self, bad: float) -> None:
        with pytest.raises(RecordError, match=r"channel 'c1' has 1 of 3 samples .* t = 0\.2 s"):
            as_signal(response([0, 0.1, 0.2], [[1, 2, 3], [1, 2, bad]]))

    def test_too_short(self) -> None:
        with pytest.raises(RecordError, match="has 1 samples; at least 2"):
            as_signal(response([0.0], [[1.0]]))
        with pytest.raises(RecordError, match="at least 9"):
            as_signal(response([0.0, 1.0], [[1.0, 2.0]]), least=9)

    def test_no_response(self) -> None:
        with pytest.raises(RecordError, match="not list"):
            as_signal([1.0, 2.0])


class TestTime:
    def test_rounded_stamps_are_uniform(self) -> None:
        assert uniform_step(np.round(np.arange(1000) / 512, 5)) == pytest.approx(1 / 512, rel=1e-4)

    @pytest.mark.parametrize(
        ("times", "message"),
        [
            ([0.0, 0.1, 0.1, 0.2], r"does not increase at 1 of 4 samples, the first after t = 0\.1 s"),
            ([0.0, 0.2, 0.1], r"next stamp 0\.1 s"),
            ([0.0, np.nan, 0.2], "the first is number 2"),
            ([0.0, 0.1, 0.2, 0.35], "time is irregular"),
            ([0.0, 0.1, 0.2, 0.3, 1.2], "time is irregular"),
            (
                [0.0, 0.1, 0.2, 0.3, 1.4],
                r"after t = 0\.3 s the next stamp is 1\.1 s later, but the usual step is 0\.1 s",
            ),
        ],
    )
    def test_refused(self, times: list[float], message: str) -> None:
        with pytest.raises(RecordError, match=message):
            uniform_step(np.array(times))

    @pytest.mark.parametrize(("off", "fine"), [(0.009, True), (0.012, False)])
    def test_the_jitter_allowed_is_a_hundredth_of_a_step(self, off: float, fine: bool) -> None:
        times = np.arange(11.0)
        times[5] += off
        if fine:
            assert uniform_step(times) == 1.0
        else:
            with pytest.raises(RecordError, match=r"t = 5\.012 s lies 0\.012 steps off"):
                uniform_step(times)


@pytest.mark.parametrize(("place", "late"), [(15, None), (25, 2.5)])
def test_the_largest_motion_is_late_after_a_fiftieth_of_the_record(place: int, late: float | None) -> None:
    values = np.exp(-np.abs(np.arange(1000.0) - place) / 50)
    assert late_start(Signal(start=0.0, step=0.1, values=values[None], channels=("seat",))) == late


def test_a_record_is_identified_without_importing_python_control() -> None:
    """It takes longer to import than all else together; a response is made where a user takes one."""
    lines = (
        "import sys",
        "from suspid import Settings, analyse",
        "from suspid.fleet.job import Job",
        "from suspid.fleet.records import Entry",
        "from suspid.fleet.work import work",
        "found = analyse(sys.argv[1])",
        "str(found), str(found.verdict)",
        "done = work(Job(settings=Settings()), [Entry(name='a record', path=sys.argv[1])])",
        "assert (done.records, done.failed) == (1, 0)",
        "assert 'control' not in sys.modules",
        "import control",
        "assert isinstance(found.identification.response, control.TimeResponseData)",
        "assert isinstance(found.record, control.TimeResponseData)",
    )
    example = Path(__file__).parents[1] / "examples" / "quarter_car.csv"
    subprocess.run([sys.executable, "-c", "\n".join(lines), str(example)], check=True)
