"""The command that writes the response of a car as a record."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from suspid.cli.measured import record_in_words
from suspid.cli.named_values import names_in, pairs
from suspid.cli.option_groups import Grouped
from suspid.cli.output import check_apart, said_warnings, say
from suspid.cli.quantities import Finite, Positive, Profile, Whole
from suspid.cli.streams import CAR, RECORD_FILE
from suspid.files import printable, replacing
from suspid.records import as_response, inputs_of
from suspid.signals import as_signal
from suspid.units import RealArray

if TYPE_CHECKING:
    import control

    from suspid.model import Suspension

# More samples do not fit into memory; most such requests are a mistyped rate or length.
MOST_SIMULATED = 50_000_000
# A step comes so long after the start [s] that a record shows the car at rest before.
REST = 0.5


@click.command("simulate", cls=Grouped)
@click.argument("car", type=CAR)
@click.option("-o", "--output", type=RECORD_FILE, metavar="FILE", required=True, help="The record to write (.csv).")
@click.option("--fs", type=Positive("Hz"), default=500.0, show_default=True, help="Sampling rate.")
@click.option("--duration", type=Positive("seconds"), default=10.0, show_default=True, help="Length of the record.")
@click.option("--impulse", metavar="INPUT", help="Free decay after a unit impulse on an input, such as road.")
@click.option("--initial", metavar="STATE=VALUE", multiple=True, help="Start, such as v_tire=1 [m/s]; repeat.")
@click.option("--road", "road_class", metavar="A..H", help="Drive on a random road of this class of ISO 8608.")
@click.option(
    "--speed",
    type=Profile("m/s"),
    metavar="M/S",
    help="Speed on that road, needed with --road; SECONDS:M/S,… changes it and writes a speed channel.",
)
@click.option(
    "--behind",
    metavar="ROAD=OTHER:METRES",
    multiple=True,
    help="ROAD follows OTHER METRES later; repeat. [independent]",
)
@click.option(
    "--sweep", type=(Positive("Hz"), Positive("Hz"), float), metavar="FROM TO AMPLITUDE", help="Sweep [Hz, Hz, m or N]."
)
@click.option("--step", type=Finite("m or N"), metavar="HEIGHT", help=f"Step after {REST:g} s [m or N].")
@click.option(
    "--input", "inputs", metavar="NAME", multiple=True, help="Swept or stepped; repeat, or NAME,NAME. [all roads]"
)
@click.option(
    "--channel", "channels", metavar="NAME", multiple=True, help="Output; repeat, or NAME,NAME. [all displacements]"
)
@click.option("--snr", type=Finite("dB"), metavar="dB", help="Add white noise at this ratio to every output.")
@click.option("--seed", type=Whole(0), help="Seed of noise and road; needed with --snr or --road.")
@click.option("--digits", type=Whole(1, 17), help="Significant digits of the samples. [every bit]")
def simulate_command(
    car: Path,
    output: Path,
    fs: float,
    duration: float,
    impulse: str | None,
    initial: tuple[str, ...],
    road_class: str | None,
    speed: tuple[tuple[float, float], ...] | None,
    behind: tuple[str, ...],
    sweep: tuple[float, float, float] | None,
    step: float | None,
    inputs: tuple[str, ...],
    channels: tuple[str, ...],
    snr: float | None,
    seed: int | None,
    digits: int | None,
) -> None:
    """Write the response of CAR (.toml) as a record.

    It is a free decay, or driven by a road, a sweep or a step.

    Roads and forces are written as channels of their own, after the outputs. Inputs are roads, and forces as
    chassis_force or chassis_travel_force.
    """
    from suspid.io import check_record_name, write_record
    from suspid.model import eigenmodes, read_car
    from suspid.simulation import add_noise, simulate

    driven = [road_class is not None, sweep is not None, step is not None]
    if sum(driven) > 1 or (impulse is not None) + bool(initial) + any(driven) != 1:
        raise click.UsageError("Give one of --impulse, --initial, --road, --sweep and --step.")
    if (road_class is None) != (speed is None) or (behind and road_class is None):
        raise click.UsageError("--road needs --speed; --speed and --behind go with --road.")
    if inputs and not (sweep or step is not None):
        raise click.UsageError("--input goes with --sweep or --step.")
    if (snr is None and road_class is None) != (seed is None):
        why = "--snr and --road need --seed" if seed is None else "--seed goes with --snr or --road"
        raise click.UsageError(f"{why}: the same seed makes the same record.")
    count = round(fs * duration) if fs * duration <= MOST_SIMULATED else 0
    if count < 2:
        raise click.UsageError(f"{fs:g} Hz for {duration:g} s must be between 2 and {MOST_SIMULATED} samples.")
    state = pairs(initial, "--initial", float)
    channels, inputs = names_in(channels), names_in(inputs)
    check_record_name(output)
    check_apart([car], [output])
    with replacing(output) as draft, said_warnings() as said:
        suspension, rng = read_car(car), np.random.default_rng(seed)
        timepts = np.arange(count) / fs
        if any(driven):
            if road_class is not None and speed is not None:
                fast = np.interp(timepts, *np.array(speed).T)
                gained = (fast[1:] + fast[:-1]) / 2 - fast[0]
                distance = fast[0] * timepts + np.append(0.0, np.cumsum(gained)) / fs
                given = _heights(suspension, distance, road_class, behind, rng, 2 * float(np.max(fast)) / fs)
            else:
                shape: RealArray = _sweep(timepts, sweep) if sweep else np.where(timepts < REST, 0.0, step or 0.0)
                given = dict.fromkeys(inputs or suspension.roads, shape)
            record = simulate(
                suspension,
                timepts,
                given,
                outputs=channels or None,
                interpolation="cubic" if step is None else "linear",
            )
        else:
            record = _decay(suspension, timepts, channels, state, impulse)
        if snr is not None:
            record = add_noise(record, snr_db=snr, rng=rng)
        if speed is not None and len(speed) > 1:
            known = {**inputs_of(record), "speed [m/s]": fast}
            signal = as_signal(record)
            record = as_response(timepts, signal.values, signal.channels, inputs=known)
        poles = eigenmodes(suspension.linearised()).poles
        highest = float(np.max(np.abs(poles.imag), initial=0.0)) / (2 * math.pi)
        if highest >= fs / 2:
            said.append(f"a mode at {highest:.4g} Hz lies above half the sampling rate and is aliased")
        write_record(record, draft, digits=digits)
    say(f"{printable(str(output))}: {record_in_words(record)}")


def _decay(
    suspension: Suspension, timepts: RealArray, channels: Sequence[str], state: dict[str, float], impulse: str | None
) -> control.TimeResponseData:
    """Return a free decay, with friction and curves if the car has them."""
    from suspid.model import statespace
    from suspid.simulation import free_decay, simulate

    if not suspension.linear and channels and impulse is None:
        return simulate(suspension, timepts, {}, outputs=channels, initial_state=state)
    system = statespace(suspension, outputs=channels or None) if suspension.linear else suspension
    return free_decay(system, timepts, initial_state=state or None, impulse=impulse)


def _sweep(timepts: RealArray, sweep: tuple[float, float, float]) -> RealArray:
    """Return a sine, started at zero, whose frequency changes linearly over the record."""
    from scipy.signal import chirp

    first, last, amplitude = sweep
    return np.asarray(amplitude * chirp(timepts, first, float(timepts[-1]), last, phi=-90))


def _heights(
    suspension: Suspension,
    distance: RealArray,
    road_class: str,
    behind: Sequence[str],
    rng: np.random.Generator,
    shortest: float,
) -> dict[str, RealArray]:
    """Return the heights under every road input, from zero on; some meet what another has met before."""
    from suspid.simulation import WAVELENGTHS, road_profile

    follows: dict[str, tuple[str, float]] = {}
    for name, led in pairs(behind, "--behind", str).items():
        other, _, metres = led.rpartition(":")
        known = [road for road in suspension.roads if road != name]
        try:
            lag = float(metres)
        except ValueError:
            lag = math.nan
        if name not in suspension.roads or other not in known or not math.isfinite(lag):
            raise click.BadParameter(
                f"'{name}={led}': write ROAD=OTHER:METRES with roads of {', '.join(suspension.roads)}.",
                param_hint="'--behind'",
            )
        follows[name] = other, lag
    if any(other in follows for other, _ in follows.values()):
        raise click.BadParameter("a road that follows another cannot lead one.", param_hint="'--behind'")
    waves = (max(WAVELENGTHS[0], shortest), WAVELENGTHS[1])
    heights: dict[str, RealArray] = {}
    for road in suspension.roads:
        if road not in follows:
            tracks = {road: 0.0} | {name: lag for name, (other, lag) in follows.items() if other == road}
            where = np.stack([distance - lag for lag in tracks.values()])
            drawn = road_profile(where, roughness=road_class, rng=rng, wavelengths=waves)
            heights |= {name: row - row[0] for name, row in zip(tracks, drawn, strict=True)}
    return {road: heights[road] for road in suspension.roads}
