"""Which charts show an identification: scalogram, fit, shapes, skeletons, and the recording it was cut from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from suspid.model import scaled_shapes
from suspid.reporting.charts import Band, Chart, Scale, Tick, area, decades, image, labelled, line, palette
from suspid.reporting.thinning import pooled, power_weights, row_edges
from suspid.signals import as_signal
from suspid.units import RealArray, Second
from suspid.wavelets import ABOVE_NOISE, Ridge, fit_skeleton

if TYPE_CHECKING:
    from suspid.identification import Identification
    from suspid.model import ModalSet
    from suspid.signals import Signal

LIGHT = ("#ffffff", "#d7e5f3", "#8fbbdd", "#3f86bf", "#12507f", "#06294a")
DARK = ("#15191e", "#17304a", "#1f5684", "#3f8ec6", "#9accea", "#f2fafd")
SHADES = 64
DECIBELS = 60.0
COLUMNS = 640
CYCLES = 6.0
# Numbers of decays stand in so many rows, each as wide as this share of the plot at most, on a phone.
TEXT_ROWS, TEXT_ROOM = 4, 0.08


@dataclass(frozen=True, kw_only=True, slots=True)
class ShapeBar:
    """One channel in a mode: real part, amplitude with its sign, over the largest component [1]; phase [degree]."""

    real: float
    amplitude: float
    angle: str


def scalogram_chart(identification: Identification) -> Chart:
    """Return the modulus of the transform with the ridges, the edges and the modes."""
    scalogram, ridges = identification.scalogram, identification.ridges
    signal = scalogram.signal
    start, end = signal.start, signal.start + signal.duration
    order = np.argsort(scalogram.omega)
    hertz = np.asarray(scalogram.omega)[order] / (2 * np.pi)
    edges = np.linspace(start, end, min(COLUMNS, signal.values.shape[1]) + 1) - signal.step / 2
    modulus = pooled(scalogram, power_weights(scalogram), edges)[order]
    level = 20 * np.log10(np.maximum(modulus / (np.max(modulus) or 1.0), 10 ** (-DECIBELS / 20)))
    indices = np.round((1 + level / DECIBELS) * (SHADES - 1)).astype(np.uint8)
    ends = row_edges(hertz)
    across, up = Scale(low=start, high=end), Scale(low=float(ends[0]), high=float(ends[-1]), log=True)
    # The cones reach into each other where a wavelet outlasts the record.
    cone, half = scalogram.cone[order], signal.duration / 2
    curves = []
    for side, sign in ((start, 1), (end, -1)):
        reach = np.minimum(cone, half)[::-1]
        within = np.array([side, side, *(side + sign * reach)])
        curves.append(area(within, np.array([up.low, up.high, *hertz[::-1]]), across, up, "cone"))
        curves.append(line(side + sign * cone, np.where(cone < half, hertz, np.nan), across, up, "edge"))
    for ridge in ridges:
        sought = (ridge.timepts >= ridge.onset) & (ridge.timepts <= ridge.window.stop)
        away = [np.abs(np.log(ridge.trace / other.omega)) for other in ridges]
        own = np.abs(np.log(ridge.trace / ridge.omega)) <= np.min(away, axis=0)
        curves.append(
            line(ridge.timepts, np.where(sought & own, ridge.trace, np.nan) / (2 * np.pi), across, up, "trace")
        )
        at = np.full(2, ridge.omega / (2 * np.pi))
        curves.append(line(np.array([ridge.window.start, ridge.window.stop]), at, across, up, "ridge"))
    damped = identification.modes.poles.imag / (2 * np.pi)
    turning = 2 * np.pi
    return Chart(
        title="",
        described=f"Scalogram of all channels with {len(ridges)} ridges",
        x_label="time [s]",
        y_label="frequency [Hz]",
        x_ticks=across.ticks(),
        y_ticks=up.ticks(most=8),
        curves=tuple(curves),
        image=image(indices[::-1], palette(LIGHT, SHADES), palette(DARK, SHADES)),
        right_label="angular frequency [rad/s]",
        right_ticks=Scale(low=up.low * turning, high=up.high * turning, log=True).ticks(most=8),
        marks=tuple(
            Tick(at=float(up.share([f])[0]), text=str(k)) for k, f in enumerate(damped, 1) if up.low < f < up.high
        ),
    )


def fit_charts(identification: Identification, channel: int, unit: str) -> tuple[Chart, ...]:
    """Return the record of a channel with fit and residual: the whole, and the first cycles."""
    record, fitted, residual = (
        as_signal(r) for r in (identification.response, identification.fitted, identification.residual)
    )
    poles = identification.modes.poles
    turning = poles.imag[poles.imag > 0]
    end = record.start + record.duration
    spans = [("whole record", record.start, end)]
    if len(turning):
        stop = record.start + max(CYCLES * 2 * np.pi / float(np.min(turning)), 20 * record.step)
        spans += [("first cycles", record.start, stop)] if stop < record.start + 0.6 * record.duration else []
    charts = []
    for title, low, high in spans if len(spans) > 1 else [("", record.start, end)]:
        kept = slice(0, int(np.ceil((high - low) / record.step)) + 1)
        time = record.timepts[kept]
        parts = [s.values[channel, kept] for s in (record, fitted, residual)]
        across, up = Scale(low=low, high=high), _around(np.concatenate(parts))
        label, ticks = labelled(up, unit or "unit")
        charts.append(
            Chart(
                title=title,
                described=f"Record, fit and residual of channel {channel + 1}",
                x_label="time [s]",
                y_label=f"[{label}]",
                x_ticks=across.ticks(),
                y_ticks=ticks,
                curves=tuple(
                    line(time, part, across, up, style)
                    for part, style in zip(parts, ("record", "fit", "residual"), strict=True)
                ),
            )
        )
    return tuple(charts)


def skeleton_charts(ridge: Ridge) -> tuple[Chart, Chart]:
    """Return modulus and phase along a ridge, with the lines fitted in the shaded window."""
    fit = fit_skeleton(ridge)
    across = Scale(low=float(ridge.timepts[0]), high=float(ridge.timepts[-1]))
    window = across.share([ridge.window.start, ridge.window.stop])
    bands = (Band(start=float(window[0]), stop=float(window[1]), style="window"),)
    modulus = np.abs(ridge.skeleton)
    heard = [i for i in range(len(modulus)) if np.any(modulus[i] > 0)]
    largest = float(np.max(modulus, initial=0.0)) or 1.0
    ends = [min(0.3 * ABOVE_NOISE * ridge.floor[i], 0.3 * float(np.exp(fit.lines[i].real[-1]))) for i in heard]
    lowest = max(min([*ends, 0.1 * largest]), 1e-8 * largest)
    up = Scale(low=lowest, high=3 * largest, log=True)
    curves = [line(ridge.timepts, modulus[i], across, up, f"channel c{i % 8}") for i in heard]
    curves += [line(fit.timepts, np.exp(fit.lines[i].real), across, up, "fitted") for i in heard]
    elapsed = ridge.timepts - ridge.onset
    reference = ridge.omega * (fit.timepts - ridge.onset)
    phases, reach = [], 0.05
    for i in heard:
        phase = np.unwrap(np.angle(ridge.skeleton[i] * np.exp(-1j * ridge.omega * elapsed))) - fit.origin[i].imag
        fitted = fit.logarithm[i].imag - reference - fit.origin[i].imag
        # Unwrapping starts in the noise or in the edge: whole turns are taken from the trusted samples.
        phases.append(phase + fitted[0] - phase[np.argmax(ridge.trusted)])
        clear = np.abs(ridge.skeleton[i, ridge.trusted]) > ABOVE_NOISE * ridge.floor[i]
        reach = max(reach, float(np.max(np.abs(fitted[clear]), initial=0.0)))
    sides = Scale(low=-1.3 * reach, high=1.3 * reach)
    straight = (fit.pole.imag - ridge.omega) * (fit.timepts - ridge.onset)
    turned = [line(ridge.timepts, p, across, sides, f"channel c{i % 8}") for i, p in zip(heard, phases, strict=True)]
    name = f"ridge at {ridge.omega / (2 * np.pi):.4g} Hz"
    unit, ticks = labelled(sides, "rad")
    return (
        Chart(
            title=name,
            described=f"Modulus along the {name}, with the fitted lines",
            x_label="",
            y_label="modulus [√s × unit]",
            x_ticks=across.ticks(most=5),
            y_ticks=decades(up),
            curves=tuple(curves),
            bands=bands,
        ),
        Chart(
            title="",
            described=f"Phase along the {name}, less that of its frequency, with the fitted line",
            x_label="time [s]",
            y_label=f"phase left [{unit}]",
            x_ticks=across.ticks(most=5),
            y_ticks=ticks,
            curves=(*turned, line(fit.timepts, straight, across, sides, "fitted")),
            bands=bands,
        ),
    )


def shape_bars(modes: ModalSet) -> tuple[tuple[ShapeBar, ...], ...]:
    """Return the components of each mode, by mode and channel."""
    if modes.shapes is None:
        return ()
    return tuple(
        tuple(
            ShapeBar(
                real=float(value.real),
                amplitude=float(np.copysign(abs(value), value.real)),
                angle=_degrees(complex(value)),
            )
            for value in shape
        )
        for shape in scaled_shapes(modes.shapes).T
    )


def recording_chart(
    record: Signal, channel: int, title: str, unit: str, stretches: Sequence[tuple[Second, Second]], used: int | None
) -> Chart:
    """Return a channel of a whole recording, with the decays found in it shaded and numbered."""
    across, up = Scale(low=record.start, high=record.start + record.duration), _around(record.values[channel])
    label, ticks = labelled(up, unit or "unit")
    starts = across.share([start for start, _ in stretches])
    stops = across.share([stop for _, stop in stretches])
    rows, free = np.zeros(len(starts), int), [-1.0] * TEXT_ROWS
    for i in np.argsort(starts, kind="stable"):
        # The first row where the text before it ends; the last, where there is none.
        rows[i] = next((row for row, end in enumerate(free) if end <= starts[i]), TEXT_ROWS - 1)
        free[rows[i]] = starts[i] + TEXT_ROOM
    bands = [
        Band(start=start, stop=stop, style="used" if i == used else "decay", text=str(i + 1), row=row)
        for i, (start, stop, row) in enumerate(zip(starts.tolist(), stops.tolist(), rows.tolist(), strict=True))
    ]
    return Chart(
        title=title,
        described=f"The recording with {len(stretches)} decays",
        x_label="time [s]",
        y_label=f"[{label}]",
        x_ticks=across.ticks(),
        y_ticks=ticks,
        curves=(line(record.timepts, record.values[channel], across, up, "fit", pieces=2 * COLUMNS),),
        bands=tuple(sorted(bands, key=lambda band: band.style == "used")),
    )


def _degrees(component: complex) -> str:
    """Return the phase in whole degrees, that of nothing as 0 and half a turn without a sign."""
    degrees = round(float(np.degrees(np.angle(component)))) if abs(component) > 0.005 else 0
    return f"{180 if degrees == -180 else degrees}".replace("-", "−")


def _around(values: RealArray) -> Scale:
    low, high = float(np.min(values)), float(np.max(values))
    margin = 0.06 * (high - low) or 0.5 * abs(high) or 1.0
    return Scale(low=low - margin, high=high + margin)
