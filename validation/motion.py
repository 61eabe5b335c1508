"""Independent motion of a car: equations written out anew, integrated by a Runge-Kutta method of fourth order.

Nothing here is taken from the library's equations, its discretisation or its roads. Roads are white slopes in
distance, coloured by one pole, and the tire rolls over them with a patch of some length, so that nothing is left that
the steps of the integration would fold back; a damper on a mount is a force with an equation of its own; sensors sample
after a common zero-phase filter, as a logger does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from scipy.fft import next_fast_len
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter, resample_poly

from suspid import Suspension
from suspid.records import as_response
from suspid.units import Hertz, Metre, RealArray, Second

if TYPE_CHECKING:
    import control

STEP: Second = 0.0005  # of the integration; the fastest motion, of a damper on a stiff mount, takes three of them
FINE = 2  # steps between the samples that the logger filters
GRID: Metre = 0.01  # of the road
PATCH = 13  # points of the road over which a tire averages, with weights of a raised cosine: at 20 m/s, up to 285 Hz
CORNER = 0.01  # cycle/m, below which the road is level
BEND = 0.17  # cycle/m, where a bent road changes its slope: at 20 m/s in the middle between 0.5 and 24 Hz
RADIUS: Metre = 0.3  # of a wheel
LEVELS = {"level": 0.0, "A": 16e-6, "B": 64e-6, "C": 256e-6, "D": 1024e-6}  # G_d(0.1 cycle/m) [m3]


@dataclass(frozen=True, kw_only=True, slots=True)
class Drive:
    """A drive, and what its sensors do; in SI units.

    ``noise`` is the standard deviation of each channel, ``gain`` and ``delay`` are errors of sensors, by channel.
    """

    duration: Second = 60.0
    rate: Hertz = 200.0
    road: str = "B"
    exponents: tuple[float, float] = (2.0, 2.0)  # of the road, below and above the wave number BEND
    order: float = 0.0  # force of an unbalanced wheel at `speed` [N], growing with the square of the speed
    speed: float = 20.0
    spread: float = 0.15  # of the speed: it swings so far up and down, once in 30 s
    bumps: int = 0
    body_force: float = 0.0  # rms, over the mass of the body [m/s2], between 0.5 and 4 Hz
    engine: float = 0.0  # amplitude, over the mass of the body [m/s2], near 14 Hz
    wheelbase: Metre = 2.7
    noise: Mapping[str, float] = field(default_factory=dict)
    gain: Mapping[str, float] = field(default_factory=dict)
    delay: Mapping[str, Second] = field(default_factory=dict)


def matrices(car: Suspension) -> tuple[RealArray, RealArray, RealArray, RealArray]:
    """Return A and B of ``x' = A x + B u``, and the accelerations ``P x + Q u`` of the coordinates.

    x are coordinates, velocities and the force of each damper on a mount; u are roads, their rates, and a force on each
    coordinate.
    """
    names, roads = list(car.masses), list(car.roads)
    n, r = len(names), len(roads)
    mounted = [s for s in car.struts if s.mount_stiffness is not None and s.damping > 0]
    size, width = 2 * n + len(mounted), 2 * r + n
    force, by_input = np.zeros((n, size)), np.zeros((n, width))
    A, B = np.zeros((size, size)), np.zeros((size, width))
    for i, name in enumerate(names):
        A[i, n + i] = 1
        by_input[i, 2 * r + i] = 1
        for strut in car.struts:
            arm = strut.arms.get(name, 0.0)
            on_mount = strut in mounted
            for j, other in enumerate(names):
                force[i, j] -= arm * strut.stiffness * strut.arms.get(other, 0.0)
                force[i, n + j] -= 0 if on_mount else arm * strut.damping * strut.arms.get(other, 0.0)
            for j, road in enumerate(roads):
                by_input[i, j] -= arm * strut.stiffness * strut.arms.get(road, 0.0)
                by_input[i, r + j] -= 0 if on_mount else arm * strut.damping * strut.arms.get(road, 0.0)
            if on_mount:
                force[i, 2 * n + mounted.index(strut)] -= arm
    for k, strut in enumerate(mounted):
        mount = float(strut.mount_stiffness or 0.0)
        A[2 * n + k, 2 * n + k] = -mount / strut.damping
        for j, other in enumerate(names):
            A[2 * n + k, n + j] = mount * strut.arms.get(other, 0.0)
        for j, road in enumerate(roads):
            B[2 * n + k, r + j] = mount * strut.arms.get(road, 0.0)
    mass = np.array(list(car.masses.values()))[:, None]
    A[n : 2 * n], B[n : 2 * n] = force / mass, by_input / mass
    return A, B, force / mass, by_input / mass


def integrated(
    car: Suspension, inputs: RealArray, start: RealArray, *, keep: int = FINE
) -> tuple[RealArray, RealArray]:
    """Return displacements and accelerations, (coordinate, sample), every ``keep`` steps.

    ``inputs`` (input, half step) stand at twice the rate of the steps, as the method of fourth order needs them.
    """
    A, B, P, Q = matrices(car)
    h, eye = STEP, np.eye(len(A))
    hA = h * A
    # The four stages of the method, multiplied out for a linear system.
    propagate = eye + hA @ (eye + hA @ (eye / 2 + hA @ (eye / 6 + hA / 24)))
    first = h * (eye / 6 + hA @ (eye / 6 + hA @ (eye / 12 + hA / 24))) @ B
    middle = h * (4 * eye / 6 + hA @ (2 * eye / 6 + hA / 12)) @ B
    last = h * B / 6
    pushes = first @ inputs[:, :-2:2] + middle @ inputs[:, 1:-1:2] + last @ inputs[:, 2::2]
    poles, vectors = np.linalg.eig(propagate)
    turned = np.linalg.solve(vectors, np.column_stack([start, pushes]).astype(complex))
    # Each mode of the method is a recursion of its own.
    states = (vectors @ [lfilter([1.0], [1.0, -pole], row) for pole, row in zip(poles, turned, strict=True)]).real
    kept, seen = states[:, ::keep], inputs[:, :: 2 * keep]
    return kept[: len(P)], P @ kept + Q @ seen


def road_heights(distance: RealArray, level: float, rng: np.random.Generator) -> RealArray:
    """Return the heights of a road whose slope is white in distance down to a corner, at given distances.

    They are those of the middle of a tire's patch. Without it the road's slope has no upper end: the integration, and
    the sensors of a wheel, would show what lies above half their rates as motion that moves no body.
    """
    low = float(np.min(distance))
    count = int(np.ceil((float(np.max(distance)) - low) / GRID)) + 4 + int(5 / (CORNER * GRID))
    slope = np.sqrt((2 * np.pi * 0.1) ** 2 * level / (2 * GRID)) * rng.standard_normal(count)
    pole = np.exp(-2 * np.pi * CORNER * GRID)
    patch = np.hanning(PATCH + 2)[1:-1]
    heights = lfilter(patch / np.sum(patch), [1.0], lfilter([GRID], [1.0, -pole], slope))[int(5 / (CORNER * GRID)) :]
    return np.asarray(CubicSpline(GRID * np.arange(len(heights)), heights)(distance - low))


def bent_heights(
    distance: RealArray, level: float, exponents: tuple[float, float], rng: np.random.Generator
) -> RealArray:
    """Return the heights of a road whose spectrum has one exponent below BEND and another above.

    It is a sum of waves of random phase and Gaussian amplitude, averaged over the tire's patch.
    """
    low = float(np.min(distance))
    count = next_fast_len(int(np.ceil((float(np.max(distance)) - low + 1 / CORNER) / GRID)) + 4, real=True)
    n = np.fft.rfftfreq(count, GRID)[1:]
    below, above = exponents
    density = level * (BEND / 0.1) ** -below * (n / BEND) ** -np.where(n < BEND, below, above) * (n > CORNER)
    patch = np.hanning(PATCH + 2)[1:-1]
    places = GRID * (np.arange(PATCH) - PATCH // 2)
    seen = np.cos(2 * np.pi * n[:, None] * places) @ (patch / np.sum(patch))
    lines = rng.standard_normal((2, len(n)))
    waves = np.sqrt(density / (4 * count * GRID)) * count * seen * (lines[0] + 1j * lines[1])
    heights = np.fft.irfft(np.concatenate([[0.0], waves]), count)
    return np.asarray(CubicSpline(GRID * np.arange(count), heights)(distance - low))


def driven(car: Suspension, drive: Drive, rng: np.random.Generator) -> tuple[dict[str, RealArray], RealArray]:
    """Return the clean channels of a drive by name at the rate of the logger, and the times."""
    lead: Second = 2.0  # before the record, so that no start is special
    half_steps = round((drive.duration + 2 * lead) / STEP) * 2 + 1
    t = np.asarray(STEP / 2 * np.arange(half_steps))
    swing = drive.spread * np.sin(2 * np.pi * t / 30 + rng.uniform(0, 2 * np.pi))
    distance = np.cumsum(drive.speed * (1 + swing)) * STEP / 2
    roads = list(car.roads)
    inputs = np.zeros((2 * len(roads) + len(car.masses), half_steps))
    tracks: dict[str, RealArray] = {}
    for i, road in enumerate(roads):
        side = road.rpartition("_")[2]
        axle = "rear" if "rear" in road else "front"
        track = side if side in ("left", "right") else ""
        if track not in tracks:
            both = np.stack([distance, distance - drive.wheelbase])
            straight = drive.exponents == (2.0, 2.0)
            level = LEVELS[drive.road]
            heights = road_heights(both, level, rng) if straight else bent_heights(both, level, drive.exponents, rng)
            for place in distance[-1] * (1 + np.arange(drive.bumps)) / (drive.bumps + 1):
                # A speed bump of 5 cm, half a sine of 0.5 m.
                heights += 0.05 * np.sin(np.pi * np.clip((both - place) / 0.5, 0, 1))
            tracks[track] = heights
        inputs[i] = tracks[track][int(axle == "rear")]
        inputs[len(roads) + i] = np.gradient(inputs[i], STEP / 2)
    force: RealArray = drive.engine * _engine(t) + _band(drive.body_force, half_steps, rng)
    body = next(i for i, name in enumerate(car.masses) if name in ("chassis", "heave"))
    mass = list(car.masses.values())[body]
    inputs[2 * len(roads) + body] = mass * force
    if drive.order:
        turned = distance / RADIUS + rng.uniform(0, 2 * np.pi)
        wheel = list(car.masses).index("tire")
        inputs[2 * len(roads) + wheel] = drive.order * (1 + swing) ** 2 * np.sin(turned)
    displacement, acceleration = integrated(car, inputs, np.zeros(2 * len(car.masses) + _mounts(car)))
    clean: dict[str, RealArray] = {}
    for name, z, a in zip(car.masses, displacement, acceleration, strict=True):
        clean[name], clean[f"{name}_acceleration"] = z, a
    for i, road in enumerate(roads):
        clean[road] = inputs[i, :: 2 * FINE]
    clean["speed"] = drive.speed * (1 + swing[:: 2 * FINE])
    first, count = round(lead * drive.rate), round(drive.duration * drive.rate)
    late = {name: _late(row, drive.delay.get(name, 0.0)) for name, row in clean.items()}
    times = np.arange(count) / drive.rate
    return {name: _logged(row, drive.rate)[first : first + count] for name, row in late.items()}, times


def record_of(
    clean: Mapping[str, RealArray], times: RealArray, channels: tuple[str, ...], drive: Drive, rng: np.random.Generator
) -> control.TimeResponseData:
    """Return what the sensors give: gain errors and noise."""
    rows = [
        drive.gain.get(name, 1.0) * clean[name] + drive.noise.get(name, 0.0) * rng.standard_normal(len(times))
        for name in channels
    ]
    return as_response(times, np.array(rows), channels)


def _mounts(car: Suspension) -> int:
    return sum(s.mount_stiffness is not None and s.damping > 0 for s in car.struts)


def _late(row: RealArray, delay: Second) -> RealArray:
    shift = round(delay / (STEP * FINE))
    return np.concatenate([np.full(shift, row[0]), row[: len(row) - shift]]) if shift else row


def _logged(row: RealArray, rate: Hertz) -> RealArray:
    """Return the samples of a logger with a zero-phase filter against aliasing."""
    down = round(1 / (rate * STEP * FINE))
    return np.asarray(resample_poly(row - row[0], 1, down, window=("kaiser", 8.0)) + row[0])


def _band(rms: float, count: int, rng: np.random.Generator) -> RealArray:
    """Return Gaussian noise between 0.5 and 4 Hz."""
    if not rms:
        return np.zeros(count)
    size = next_fast_len(count, real=True)
    lines = rng.standard_normal((2, size // 2 + 1))
    f = np.fft.rfftfreq(size, STEP / 2)
    row = np.fft.irfft(np.where((f > 0.5) & (f < 4), lines[0] + 1j * lines[1], 0), size)
    return np.asarray(rms * row[:count] / np.std(row))


def _engine(t: RealArray) -> RealArray:
    """Return a line that wanders slowly about 14 Hz."""
    return np.asarray(np.sin(2 * np.pi * (14 * t + np.sin(2 * np.pi * t / 20))))
