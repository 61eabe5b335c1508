"""Ride: weightings, doses and roads beside the standards, spectra beside an independent integrator, optima.

Time-domain figures come from `validation.motion`, which shares neither equations nor roads with the library.
"""

from __future__ import annotations

import os
import time
from dataclasses import replace

import control
import numpy as np
from numpy.typing import ArrayLike

from suspid import (
    Road,
    Suspension,
    add_noise,
    classify_road,
    estimate,
    free_decay,
    grip,
    quarter_car,
    ride,
    road,
    road_profile,
    sensitivities,
    statespace,
    tune,
    tune_active,
    tune_damper,
    weighting,
)
from suspid.performance import ROAD_LIMITS
from suspid.performance.weightings import weighted
from suspid.records import as_response
from suspid.simulation import ROUGHNESS
from suspid.text_tables import text_table
from suspid.units import RealArray
from validation.cars import TWO_AXLES
from validation.human_vibration import BURSTS, FACTORS, SLOW_BURSTS, bursts, centres, slow_bursts
from validation.motion import CORNER, GRID, PATCH, Drive, driven

SEEDS = int(os.environ.get("SUSPID_SEEDS", "30"))
FIRST_SEED = 930_000
QUARTER = quarter_car(
    chassis_mass=350, tire_mass=50, chassis_stiffness=22e3, tire_stiffness=210e3, chassis_damping=1300
)
HALF = TWO_AXLES
# Dampers of the tire with which the figures of the bench are computed [N s/m].
BENCH_TIRES = (50.0, 60.0)
# Figures worked out for this car before `grip` was written: damper [N s/m], adhesion [%], least phase [deg].
EXPECTED_GRIP = ((1300.0, 60.0, 63.9), (900.0, None, 47.8), (650.0, 29.0, 35.9), (400.0, 0.0, 22.7))
LEVEL = 0.95
# Class, speed [m/s], sampling rate [Hz] and time [s] of measured roads; of long ones half as many are drawn.
MEASURED_ROADS = (
    ("A", 10.0, 200.0, 60.0), ("C", 20.0, 200.0, 60.0), ("F", 30.0, 200.0, 60.0), ("F", 30.0, 200.0, 300.0),
    ("F", 45.0, 100.0, 300.0),
)  # fmt: skip
LONG_ROAD = 300.0


class BenchRoad(Road):
    """The road of `validation.motion`: level below a corner, and seen through the patch of a tire."""

    __slots__ = ()

    def spectrum(self, hertz: ArrayLike) -> RealArray:
        """Return the spectral density of the height that the tire sees [m2/Hz]."""
        n = np.asarray(hertz, float) / self.speed
        patch = np.hanning(PATCH + 2)[1:-1]
        places = GRID * (np.arange(PATCH) - PATCH // 2)
        seen = np.cos(2 * np.pi * n[..., None] * places) @ (patch / np.sum(patch))
        return np.asarray(super().spectrum(hertz) * seen**2 * n**2 / (n**2 + CORNER**2))


def bench_road(car: Suspension, *, speed: float) -> BenchRoad:
    """Return the road of class C of `validation.motion` under a car."""
    made = road("C", speed=speed, under=car, wavelengths=(0.05, 1e5))
    return BenchRoad(
        roughness=made.roughness, speed=made.speed, exponent=made.exponent, wavelengths=made.wavelengths,
        places=made.places,
    )  # fmt: skip


def decibel(ratio: RealArray) -> float:
    """Return the largest error of ratios that ought to be 1 [dB]."""
    return float(np.max(np.abs(20 * np.log10(ratio))))


def weighting_table() -> str:
    """Return the table of the weightings: largest errors over all bands, in frequency and of tones in time."""
    rows: dict[str, list[str]] = {"weighting": [], "bands": [], "in frequency [dB]": [], "tones in time [dB]": []}
    for name in FACTORS:
        f, factors = centres(name)
        rate = 2000.0 if f[-1] > 10 else 50.0
        ratios = []
        for hertz, factor in zip(f, factors, strict=True):
            # After a minute, or many periods of the slowest filter, a tone is steady; whole periods are compared.
            settled, periods = 60.0 if f[0] > 0.05 else 400.0, max(int(4 * hertz), 4)
            count = round(periods / hertz * rate)
            t = np.arange(round(settled * rate) + count) / rate
            felt = weighted(np.sin(2 * np.pi * hertz * t), 1 / rate, name)[-count:]
            # Amplitude by projection: the stretch need not end with a period.
            pair = np.column_stack([np.sin(2 * np.pi * hertz * t[-count:]), np.cos(2 * np.pi * hertz * t[-count:])])
            ratios.append(float(np.hypot(*np.linalg.lstsq(pair, felt, rcond=None)[0])) / factor)
        rows["weighting"].append(name)
        rows["bands"].append(f"{len(f)}, {f[0]:.3g} to {f[-1]:.3g} Hz")
        rows["in frequency [dB]"].append(f"{decibel(np.abs(weighting(name, f)) / factors):.4f}")
        rows["tones in time [dB]"].append(f"{decibel(np.array(ratios)):.4f}")
    return text_table(rows)


def dose_table() -> str:
    """Return the table of the saw-tooth bursts: rms, VDV and MSDV beside the printed ones."""
    rows: dict[str, list[str]] = {"weighting": [], "cycles": [], "figure": [], "printed": [], "found": [], "error": []}
    cases = [(name, cycles, bursts, printed, ("VDV",)) for name in BURSTS for cycles, printed in BURSTS[name].items()]
    cases += [("Wf", cycles, slow_bursts, printed, ("MSDV",)) for cycles, printed in SLOW_BURSTS.items()]
    for name, cycles, signal, printed, dose in cases:
        samples, rate = signal(cycles)
        found = ride(as_response(np.arange(len(samples)) / rate, samples[None], ["seat"]), weightings={"seat": name})
        for figure, expected in zip((name, *dose), printed, strict=True):
            value = found[f"seat.{figure}"]
            cells = [name, str(cycles) if cycles else "continuous", "rms" if figure == name else figure]
            cells += [f"{expected:.4g}", f"{value:.4g}", f"{100 * (value / expected - 1):+.1f} %"]
            for column, cell in zip(rows.values(), cells, strict=True):
                column.append(cell)
    return text_table(rows)


def road_table() -> str:
    """Return the table of the classes: limits, the spectrum's level, and what a generated road is found to be."""
    rows: dict[str, list[str]] = {
        "class": [], "upper limit": [], "by spectrum": [], "generated, 2 km": [], "exponent": [], "found": [],
    }  # fmt: skip
    for seed, name in enumerate(ROUGHNESS):
        made = road(name, speed=20.0)
        record = made.record(np.arange(0, 100, 0.0025), rng=np.random.default_rng(FIRST_SEED + seed))
        found = classify_road(record, speed=20.0)
        low, high = found.interval(LEVEL)["roughness"]
        limit = ROAD_LIMITS[name]
        cells = [
            name,
            f"{1e6 * limit:.0f}" if np.isfinite(limit) else "none",
            # In time the level at 0.1 cycle/m is the density at 2 Hz, times the speed.
            f"{1e6 * float(made.spectrum(2.0)) * 20:.6g}",
            f"{1e6 * found.roughness:.0f} ({1e6 * low:.0f} to {1e6 * high:.0f})",
            f"{found.exponent:.3f}",
            found.name,
        ]
        for column, cell in zip(rows.values(), cells, strict=True):
            column.append(cell)
    return text_table(rows)


def road_coverage_table(draws: int) -> str:
    """Return the table of intervals that hold the true road, of heights at points: shorter waves fold into others."""
    rows: dict[str, list[str]] = {
        "class": [], "speed [m/s]": [], "rate [Hz]": [], "length [s]": [], "roads": [], "roughness": [], "exponent": [],
    }  # fmt: skip
    for name, speed, rate, seconds in MEASURED_ROADS:
        count = draws if seconds < LONG_ROAD else draws // 2
        held = np.zeros(2)
        for seed in range(count):
            t = np.arange(0, seconds, 1 / rate)
            heights = road_profile(speed * t, roughness=name, rng=np.random.default_rng([FIRST_SEED, 8, seed]))
            ends = classify_road((t, heights), speed=speed).interval(LEVEL)
            true = {"roughness": ROUGHNESS[name], "exponent": 2.0}
            held += [ends[key][0] < true[key] < ends[key][1] for key in ("roughness", "exponent")]
        cells = [name, f"{speed:.0f}", f"{rate:.0f}", f"{seconds:.0f}", str(count)]
        cells += [f"{share:.1%}" for share in held / count]
        for column, cell in zip(rows.values(), cells, strict=True):
            column.append(cell)
    return text_table(rows)


def drive_table(name: str, car: Suspension, felt: tuple[str, ...], wheels: dict[str, str], seeds: int) -> str:
    """Return the table of figures by spectra beside means over drives of an independent integrator.

    ``wheels`` are the tires of wheels; the struts above them are named like the car's presets.
    """
    made = bench_road(car, speed=20.0)
    base = max(behind for behind, _ in made.places.values()) or 2.7
    expected = ride(car, road=made, duration=60.0)
    drawn: dict[str, list[float]] = {}
    for seed in range(seeds):
        drive = Drive(duration=60.0, rate=500.0, road="C", speed=20.0, spread=0.0, wheelbase=base)
        clean, times = driven(car, drive, np.random.default_rng([FIRST_SEED, seed]))
        channels = [f"{c}_acceleration" for c in felt]
        seen = ride(as_response(times, np.array([clean[c] for c in channels]), channels))
        for figure in seen.figures:
            if figure.endswith((".rms", ".Wk", ".We", ".VDV", ".crest")):
                drawn.setdefault(figure, []).append(seen[figure])
        for strut in car.struts:
            stretch = sum(arm * clean[c] for c, arm in strut.arms.items())
            stretch = np.asarray(stretch) - np.mean(stretch)
            if f"{strut.name}.travel" in expected.figures:
                drawn.setdefault(f"{strut.name}.travel", []).append(float(np.std(stretch)))
                drawn.setdefault(f"{strut.name}.peak_travel", []).append(float(np.max(np.abs(stretch))))
            elif strut.name in wheels:
                rate = np.gradient(stretch, times)
                force = strut.stiffness * stretch + strut.damping * rate
                drawn.setdefault(f"{wheels[strut.name]}.load", []).append(float(np.std(force)))
    rows: dict[str, list[str]] = {name: [], "spectra": [], "drives": [], "±": [], "ratio": [], "sd off": []}
    for figure, values in drawn.items():
        # Powers have no bias of their own, their roots have: means of squares are compared.
        power = 1 if "peak" in figure or "crest" in figure else 4 if "VDV" in figure else 2
        mean = float(np.mean(np.power(values, power))) ** (1 / power)
        error = float(np.std(np.power(values, power), ddof=1)) / len(values) ** 0.5 / (power * mean ** (power - 1))
        cells = [figure, f"{expected[figure]:.4g}", f"{mean:.4g}", f"{error:.2g}"]
        cells += [f"{mean / expected[figure]:.3f}", f"{(mean - expected[figure]) / error:+.1f}"]
        for column, cell in zip(rows.values(), cells, strict=True):
            column.append(cell)
    return text_table(rows)


def optimum_table() -> str:
    """Return the table of the published optimum beside `tune`."""
    rows: dict[str, list[str]] = {"k [N/m]": [], "published c": [], "tune": [], "published rms": [], "by tune": []}
    everywhere = road("C", speed=20.0, wavelengths=(1e-4, 1e6))
    slope = (2 * np.pi * 0.1) ** 2 * everywhere.roughness * everywhere.speed / 2
    for stiffness in (12e3, 22e3, 45e3):
        car = QUARTER.with_parameters(stiffness={"chassis": stiffness})
        found = tune(car, parameters=["chassis.damping"], objective="chassis_acceleration.rms", road=everywhere)
        best = stiffness * np.sqrt(400 / 210e3)
        rms = np.sqrt(slope / 2 * (stiffness**2 * 400 / best + 210e3 * best)) / 350
        cells = [
            f"{stiffness:.0f}",
            f"{best:.2f}",
            f"{found.choices[0, 0]:.2f}",
            f"{rms:.5f}",
            f"{found.values[0, 0]:.5f}",
        ]
        for column, cell in zip(rows.values(), cells, strict=True):
            column.append(cell)
    return text_table(rows)


def front_text() -> str:
    """Return the time of a front, and whether a grid of cars has a better one."""
    both, strut = ("chassis_acceleration.Wk", "tire.load"), ("chassis.stiffness", "chassis.damping")
    request = {"parameters": strut, "objective": both, "road": "C", "speed": 20.0}
    tune(QUARTER, **request)  # type: ignore[arg-type]
    start = time.process_time()
    found = tune(QUARTER, **request)  # type: ignore[arg-type]
    seconds = time.process_time() - start
    gain = 0.0
    for k in np.geomspace(22e3 / 4, 22e3 * 4, 20):
        for c in np.geomspace(1300 / 4, 1300 * 4, 20):
            other = ride(
                QUARTER.with_parameters(stiffness={"chassis": k}, damping={"chassis": c}), road="C", speed=20.0
            )
            ratio = found.values / [other[name] for name in both]
            gain = max(gain, float(np.max(np.min(ratio, axis=1))) - 1)
    return (
        f"A front of {len(found.cars)} cars over k and c of the quarter car takes {seconds:.2f} s of processor time. "
        f"The best of 400 cars on a grid beats a car of the front in both figures by {max(gain, 0.0):.1e}.\n\n"
        f"```\n{found}\n```"
    )


def curve_text(seeds: int) -> str:
    """Return a damper's curve for three roads, and its figures beside those of an independent integrator."""
    drives = (("A", 30.0), ("C", 20.0), ("D", 14.0))
    car, wanted = QUARTER, "chassis_acceleration.Wk"
    found = tune_damper(car, strut="chassis", roads=drives, objective=wanted, constraints={"chassis.travel": 0.018})
    rows: dict[str, list[str]] = {
        "road": [],
        "figure": [],
        "by work": [],
        "integrated": [],
        "ratio": [],
        "one rate": [],
    }
    for k, (kind, speed) in enumerate(drives):
        curved = _integrated(car, np.array(found.strut.curve), kind, speed, seeds)
        single = _integrated(car, np.array([[-1.0, -1.0], [1.0, 1.0]]) * [1.0, found.single or 0.0], kind, speed, seeds)
        for i, figure in enumerate(found.figures):
            expected = float(found.values[k, i])
            cells = [
                kind,
                figure,
                f"{expected:.4g}",
                f"{curved[i]:.4g}",
                f"{curved[i] / expected:.3f}",
                f"{single[i]:.4g}",
            ]
            for column, cell in zip(rows.values(), cells, strict=True):
                column.append(cell)
    return f"```\n{found}\n```\n\n```\n{text_table(rows)}\n```"


def _integrated(car: Suspension, curve: RealArray, kind: str, speed: float, seeds: int) -> tuple[float, float]:
    """Return weighted acceleration and rms travel of a quarter car with a damper's curve, by Runge and Kutta."""
    step, seconds = 5e-4, 45.0
    t = step / 2 * np.arange(round(2 * seconds / step) + 1)
    made = road(kind, speed=speed, under=car)
    heights = [made.heights(t, rng=np.random.default_rng([FIRST_SEED, 7, s])) for s in range(seeds)]
    z_road = np.array([one[car.roads[0]] for one in heights])
    k, k_tire = (next(s.stiffness for s in car.struts if s.name == name) for name in ("chassis", "tire"))
    body, wheel = car.masses["chassis"], car.masses["tire"]
    ends = [np.diff(curve[:2], axis=0)[0], np.diff(curve[-2:], axis=0)[0]]
    # Far beyond the last points the curve goes on straight.
    far = np.concatenate([curve[:1] - 50 * ends[0], curve, curve[-1:] + 50 * ends[1]])

    def rate(x: RealArray, h: RealArray) -> RealArray:
        force = k * (x[0] - x[1]) + np.interp(x[2] - x[3], far[:, 0], far[:, 1])
        return np.array([x[2], x[3], -force / body, (force - k_tire * (x[1] - h)) / wheel])

    x, kept = np.zeros((4, seeds)), []
    for i in range(0, len(t) - 2, 2):
        first = rate(x, z_road[:, i])
        if i % 8 == 0:
            kept.append([first[2], x[0] - x[1]])
        second = rate(x + step / 2 * first, z_road[:, i + 1])
        third = rate(x + step / 2 * second, z_road[:, i + 1])
        fourth = rate(x + step * third, z_road[:, i + 2])
        x = x + step / 6 * (first + 2 * second + 2 * third + fourth)
    outputs = np.array(kept, np.float64)[round(5 / (4 * step)) :]  # (sample, output, seed), without the start
    felt = [
        ride(
            as_response(4 * step * np.arange(len(outputs), dtype=float), outputs[:, :1, s].T, ["chassis_acceleration"])
        )
        for s in range(seeds)
    ]
    weighted_rms = float(np.sqrt(np.mean([one["chassis_acceleration.Wk"] ** 2 for one in felt])))
    return weighted_rms, float(np.sqrt(np.mean(np.var(outputs[:, 1], axis=0))))


def derivative_text() -> str:
    """Return the largest difference of exact elasticities from central differences."""
    found = sensitivities(HALF, road="C", speed=20.0)
    worst, h = 0.0, 1e-5
    for p, name in enumerate(found.parameters):
        owner, _, quantity = name.rpartition(".")
        value = getattr(next(s for s in HALF.struts if s.name == owner), quantity)
        ends = [
            sensitivities(HALF.with_parameters(**{quantity: {owner: value * f}}), road="C", speed=20.0).values
            for f in (1 - h, 1 + h)
        ]
        slope = (np.log(ends[1]) - np.log(ends[0])) / np.log((1 + h) / (1 - h))
        worst = max(worst, float(np.nanmax(np.abs(slope - found.elasticity[:, p]))))
    rows = len(found.names)
    return f"Half car, {rows} modes and figures by {len(found.parameters)} parameters: largest difference {worst:.1e}."


def bench_table() -> str:
    """Return adhesion and least phase by `grip` beside figures that were worked out apart."""
    rows: dict[str, list[str]] = {
        name: []
        for name in (
            "damper [N s/m]",
            "tire's damper",
            "adhesion, expected [%]",
            "grip",
            "phase, expected [deg]",
            "grip ",
        )
    }
    for damping, adhesion, phase in EXPECTED_GRIP:
        for tire in BENCH_TIRES:
            found = grip(QUARTER.with_parameters(damping={"chassis": damping, "tire": tire}))
            cells = (
                f"{damping:.0f}",
                f"{tire:.0f}",
                "-" if adhesion is None else f"{adhesion:.0f}",
                f"{100 * found.adhesion[0]:.1f}",
                f"{phase:.1f}",
                f"{np.degrees(found.phase[0]):.1f}",
            )
            for column, cell in zip(rows.values(), cells, strict=True):
                column.append(cell)
    return text_table(rows)


def active_text() -> str:
    """Return how far the convex program for an active strut is from `control.lqr`, where nothing is limited."""
    objective = {"chassis_acceleration": 1.0, "tire_travel": 0.004, "chassis_travel": 0.02}
    found = tune_active(QUARTER, actuator="chassis_travel", objective=objective, road="C", speed=20.0)
    system = statespace(QUARTER, outputs=list(objective), forces=["chassis_travel"])
    scale = np.array(list(objective.values()))
    C, D = np.asarray(system.C) / scale[:, None], np.asarray(system.D)[:, 0] / scale
    gain, _, _ = control.lqr(system.A, system.B, C.T @ C, np.array([[D @ D]]), (C.T @ D)[:, None])
    off = float(np.max(np.abs(found.gain - gain[0])) / np.max(np.abs(gain)))
    return (
        f"Force of an actuator beside the strut of the quarter car, by `tune_active`: the largest difference of a gain "
        f"from that of `control.lqr` is {off:.1e} of the largest gain; cost and lower bound differ by "
        f"{abs(found.cost / found.bound - 1):.1e}."
    )


def coverage_text(draws: int) -> str:
    """Return the share of intervals that hold where the car was estimated from a decay."""
    car = QUARTER
    truth = ride(car, road="C", speed=20.0)
    use = ("chassis_acceleration.Wk", "chassis.travel", "tire.load", "tire.lifts")
    nominal = car.with_parameters(stiffness={"chassis": 22e3 * 0.7}, damping={"chassis": 1300 * 1.3})
    decay = free_decay(car, np.arange(0, 3, 0.005), initial_state={"v_tire": 1.0})
    held = np.zeros(len(use))
    for seed in range(draws):
        noisy = add_noise(decay, snr_db=20.0, rng=np.random.default_rng([FIRST_SEED, seed]))
        ends = ride(estimate(noisy, nominal, fixed=["tire.damping"]), road="C", speed=20.0).interval(LEVEL)
        held += [ends[name][0] < truth[name] < ends[name][1] for name in use]
    shares = ", ".join(f"{name} {share:.0%}" for name, share in zip(use, held / draws, strict=True))
    return (
        f"Quarter car estimated from a decay at 20 dB, {draws} draws, start 30 % off: the 95 % intervals of its "
        f"ride hold the true figure in {np.mean(held) / draws:.1%} ({shares})."
    )


def report() -> str:
    """Return the report as markdown."""
    quarter = drive_table("quarter car", QUARTER, ("chassis",), {"tire": "tire"}, SEEDS)
    tires = {"front_tire": "front", "rear_tire": "rear"}
    half = drive_table("half car", replace(HALF, sensors=()), ("heave", "pitch"), tires, SEEDS)
    parts = [
        "# Ride, roads and tuning",
        "## Weightings beside ISO 8041-1:2017, Annex B",
        "Largest error over all one-third-octave bands, whose factors are printed with four digits (0.004 dB). The "
        "standard allows 1 dB within the band. Its numbers, here and below, are those that phonometry has transcribed "
        "into its test data; the standard itself was not at hand.",
        f"```\n{weighting_table()}\n```",
        "## Doses beside ISO 8041-1:2017, Tables 8 and 9",
        "Saw-tooth bursts through `ride(record)`. The standard allows 10 %, of VDV 12 %.",
        f"```\n{dose_table()}\n```",
        "## Roads beside ISO 8608",
        "G_d(0.1 cycle/m) in 1e-6 m3; 95 % intervals in brackets. Classes and limits are taken from publications that "
        "quote the standard.",
        f"```\n{road_table()}\n```",
        "How often the 95 % intervals hold the true road, where heights are points of it. The spectrum of a class is a "
        "multiple of that of another, so that class decides nothing.",
        f"```\n{road_coverage_table(max(SEEDS, 100))}\n```",
        "## Spectra beside an independent integrator",
        f"Figures of `ride(car)` and means over {SEEDS} drives of 60 s on roads of class C at 20 m/s, integrated by "
        f"`validation/motion.py`; ± is the standard error of the mean.",
        f"```\n{quarter}\n\n{half}\n```",
        "## A published optimum",
        "The damper of least body acceleration on white slopes, c = k ((m_s + m_u) / k_t)^(1/2), and the acceleration "
        "there (M. Gobbi and G. Mastinu, Journal of Sound and Vibration 245, 2001, 457-481), for 350 / 50 kg and "
        "210 kN/m.",
        f"```\n{optimum_table()}\n```",
        "## Fronts",
        front_text(),
        "## Wheels on a test bench",
        "Adhesion after EUSAMA (platform 3 mm, 25 to 0 Hz) and least phase after EGEA SPECSUS2018 of the quarter car, "
        "beside figures that were worked out apart; these leave the damper of the tire open. How well they are known "
        "from drives stands in [wear](wear.md).",
        f"```\n{bench_table()}\n```",
        "## An active strut",
        active_text(),
        "## A damper's curve for three roads",
        curve_text(SEEDS),
        "## Sensitivities beside central differences",
        derivative_text(),
        "## Intervals",
        coverage_text(max(SEEDS, 100)),
    ]
    return "\n\n".join(parts) + "\n"


if __name__ == "__main__":
    print(report())
