"""Records as responses of python-control: made from samples, their inputs, and parts of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.errors import RecordError
from suspid.samples import Samples, as_samples
from suspid.signals import JITTER, Signal, as_signal, real_numbers
from suspid.units import RealArray, Second
from suspid.wording import moment

if TYPE_CHECKING:
    import control

# The largest motion counts as late after this share of the record.
LATE = 0.02


def as_response(
    timepts: RealArray,
    values: RealArray,
    channels: Sequence[str],
    *,
    title: str = "",
    inputs: Mapping[str, RealArray] | None = None,
) -> control.TimeResponseData:
    """Return samples (channel, sample) and inputs by name as a response of one trace, squeezed if it has one channel.

    With inputs it is squeezed only where it has one of them too.
    """
    return as_samples(timepts, values, channels, title=title, inputs=inputs).response


def like(
    record: control.TimeResponseData,
    timepts: RealArray,
    values: RealArray,
    channels: Sequence[str],
    *,
    title: str = "",
    inputs: Mapping[str, RealArray] | None = None,
) -> control.TimeResponseData:
    """Return what `as_response` does, or `Samples` if the record is such: what was made of it stays of its kind."""
    made = as_samples(timepts, values, channels, title=title, inputs=inputs)
    return made if isinstance(record, Samples) else made.response


def of_channels(record: control.TimeResponseData, names: Sequence[str]) -> control.TimeResponseData:
    """Return a record of some of its channels, in the order of the names.

    Examples
    --------
    >>> both = as_response(np.arange(2.0), np.array([[1.0, 2.0], [3.0, 4.0]]), ["seat", "tire"])
    >>> of_channels(both, ["tire"]).y.tolist()
    [[3.0, 4.0]]
    """
    signal = as_signal(record)
    rows = [signal.channels.index(name) for name in names]
    title = str(getattr(record, "title", None) or "")
    return like(record, signal.timepts, signal.values[rows], names, title=title)


def inputs_of(response: control.TimeResponseData) -> dict[str, RealArray]:
    """Return the inputs of a response of one trace by name; empty where it has none.

    Examples
    --------
    >>> record = as_response(np.arange(2.0), np.ones((1, 2)), ["seat"], inputs={"road": np.array([0.0, 0.1])})
    >>> inputs_of(record)
    {'road': array([0. , 0.1])}
    """
    samples, labels = getattr(response, "inputs", None), getattr(response, "input_labels", None)
    if samples is None:
        return {}
    table = real_numbers(samples, "the inputs")
    table = table.reshape(-1, table.shape[-1])
    return dict(zip(labels or [f"u[{i}]" for i in range(len(table))], table, strict=True))


@explained
def cut(
    response: control.TimeResponseData, *, start: Second | None = None, stop: Second | None = None
) -> control.TimeResponseData:
    """Return the part of a record from ``start`` to ``stop``, such as a decay from its release on.

    Parameters
    ----------
    response : control.TimeResponseData
        The record.
    start, stop : float, optional
        First and last time to keep [s]. Default: the record's own.

    Raises
    ------
    RecordError
        If fewer than two samples are left.

    Examples
    --------
    >>> import numpy as np
    >>> record = as_response(np.arange(5) / 10, np.arange(5.0)[None], ["seat"])
    >>> cut(record, start=0.2).time
    array([0.2, 0.3, 0.4])
    """
    signal = as_signal(response)
    time = signal.timepts
    slack = JITTER * signal.step
    first = -np.inf if start is None else start - slack
    last = np.inf if stop is None else stop + slack
    keep = (time >= first) & (time <= last)
    if np.sum(keep) < 2:
        raise RecordError(
            f"the record has {np.sum(keep)} samples {span(start, stop)}; "
            f"it lasts from {moment(time[0])} to {moment(time[-1])} s"
        )
    inputs = {name: samples[keep] for name, samples in inputs_of(response).items()}
    return like(response, time[keep], signal.values[:, keep], signal.channels, inputs=inputs)


def span(start: Second | None, stop: Second | None) -> str:
    """Return in words what lies between two times, of which one may be open.

    Examples
    --------
    >>> span(2.0, None), span(None, 3.0), span(2.0, 3.0)
    ('from 2 s on', 'until 3 s', 'from 2 to 3 s')
    """
    if stop is None:
        return f"from {moment(start)} s on" if start is not None else "in all"
    return f"until {moment(stop)} s" if start is None else f"from {moment(start)} to {moment(stop)} s"


def late_start(signal: Signal) -> Second | None:
    """Return the time of the largest motion [s], if that is after a fiftieth of the record, else None."""
    about = np.abs(signal.values - signal.values.mean(axis=1, keepdims=True))
    strength = np.sum((about / np.maximum(about.max(axis=1, keepdims=True), 1e-300)) ** 2, axis=0)
    peak = int(np.argmax(strength))
    return float(signal.timepts[peak]) if peak > LATE * signal.values.shape[1] else None
