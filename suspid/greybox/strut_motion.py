"""Force and motion of one strut from a record, each with independent noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from suspid.cleaning import RecordLike, without_sentinels
from suspid.errors import InputError, RecordError
from suspid.files import printable
from suspid.greybox.car_records import record_of_car
from suspid.model import Suspension, output_weights
from suspid.signals import Signal, as_signal
from suspid.units import RealArray, Second
from suspid.values import listed, nearest_names
from suspid.wording import Argument


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class StrutMotion:
    """Force and motion of a strut, from one record.

    ``force`` is that of spring and damper. ``motion`` is the travel, or the acceleration of the travel plus ``share``
    times the force: so much that the noise of the sensors on the body cancels in it.
    """

    step: Second
    force: RealArray  # [N]
    motion: RealArray  # [m/s2], or [m] where it is the travel
    share: float  # [1/kg]
    travel: bool
    channels: tuple[str, ...]  # that were used


def strut_motion(record: RecordLike, car: Suspension, strut: str, given: Sequence[str] | None) -> StrutMotion:
    """Return force and motion of a strut, whose forces on the sprung masses are told by their accelerations.

    With as many struts on the sprung coordinates q as there are coordinates, their forces are
    ``f = -(arms^T)^-1 M q''``.

    Raises
    ------
    InputError
        If there is no such strut, or its force does not follow from the accelerations.
    RecordError
        If channels are missing, or the record is too short.
    """
    # Fewer samples do not fill the ranges of a curve.
    signal = as_signal(record_of_car(record, car), least=1000)
    names = [s.name for s in car.struts]
    if strut not in names:
        raise InputError(f"there is no strut {strut!r}.{nearest_names(strut, names)}")
    body, per_force, elongation = _statics(car, names.index(strut), given)
    rows = _channels(car, signal.channels)
    on_body = [name for name, (order, w) in rows.items() if order == 2 and not np.any(np.delete(w, body))]
    weights = np.array([rows[name][1][body] for name in on_body]).reshape(-1, len(body))
    if np.linalg.matrix_rank(weights) < len(body):
        raise RecordError(
            f"the accelerations of the sprung masses ({listed([car.coordinates[i] for i in body])}) are not measured: "
            f"the record has {listed(signal.channels)}"
        )
    to_body = np.linalg.pinv(weights)
    values = dict(zip(signal.channels, signal.values, strict=True))
    force_weights = per_force @ to_body
    force = force_weights @ np.array([values[name] for name in on_body])
    others = [int(i) for i in np.flatnonzero(elongation) if i not in body]
    ends = {i: next((m for m, (o, w) in rows.items() if o == 2 and _alone(w, i)), None) for i in others}
    if all(ends.values()):
        own = elongation[body] @ to_body
        share = -float(own @ force_weights / (force_weights @ force_weights))
        acceleration = own @ np.array([values[name] for name in on_body])
        for i, name in ends.items():
            if name is not None:
                acceleration = acceleration + elongation[i] / rows[name][1][i] * values[name]
        used = (*on_body, *(str(name) for name in ends.values()))
        _check_samples(used, signal)
        return StrutMotion(
            step=signal.step,
            force=force,
            motion=acceleration + share * force,
            share=share,
            travel=False,
            channels=used,
        )
    travel = next((name for name, (order, w) in rows.items() if order == 0 and np.array_equal(w, elongation)), None)
    if travel is None:
        missing = [[*car.coordinates, *car.roads][i] for i, name in ends.items() if name is None]
        raise RecordError(
            f"the motion of strut {strut!r} is not measured: give '{strut}_travel', or "
            f"{listed([f'{name}_acceleration' for name in missing])}; the record has {listed(signal.channels)}"
        )
    _check_samples((*on_body, travel), signal)
    return StrutMotion(
        step=signal.step,
        force=force,
        motion=values[travel],
        share=0.0,
        travel=True,
        channels=(*on_body, travel),
    )


def _check_samples(names: Sequence[str], signal: Signal) -> None:
    """Refuse samples that are no motion: a single one of them bends the curve of a whole record."""
    for name in names:
        row = signal.values[signal.channels.index(name)]
        _, outliers = without_sentinels(name, signal.timepts, row)
        if outliers:
            raise RecordError(
                f"{printable(name)} has samples that are no motion ({outliers[0].text}, first at "
                f"{outliers[0].start:.6g} s): interpolate them, or read the file with read_record or clean, which do"
            )


def _statics(car: Suspension, strut: int, given: Sequence[str] | None) -> tuple[list[int], RealArray, RealArray]:
    """Return the sprung coordinates, a strut's force per acceleration of each, and its elongation."""
    arms = np.hstack([car.arms(car.coordinates), car.arms(car.roads)])
    n = len(car.coordinates)
    if given is None:
        # Wheels stand on a road, unless the strut itself does.
        wheels = [i for i in range(n) if np.any(arms[:, i] * np.any(arms[:, n:] != 0, axis=1))]
        wheels = wheels if not np.any(arms[strut, n:]) else []
    else:
        for name in given:
            if name not in car.coordinates:
                raise InputError(
                    Argument("given"), f": there is no coordinate {name!r}.{nearest_names(name, car.coordinates)}"
                )
        wheels = [car.coordinates.index(name) for name in given]
    body = [i for i in range(n) if i not in wheels]
    acting = [j for j in range(len(arms)) if np.any(arms[j, body])]
    if not body or strut not in acting:
        raise InputError(f"strut {car.struts[strut].name!r} acts on no sprung mass, so no acceleration gives its force")
    square = arms[np.ix_(acting, body)]
    if len(acting) != len(body) or np.linalg.matrix_rank(square) < len(body):
        raise InputError(
            f"the forces of {len(acting)} struts ({listed([car.struts[j].name for j in acting])}) do not follow from "
            f"the accelerations of {len(body)} sprung coordinates ({listed([car.coordinates[i] for i in body])}); "
            f"damper_curve needs as many struts as coordinates: name the coordinates whose motion is given, or "
            f"describe one corner of the car"
        )
    inertia = np.diag(car.M)[body]
    per_force = -(np.linalg.inv(square.T) * inertia)[acting.index(strut)]
    return body, per_force, arms[strut]


def _channels(car: Suspension, channels: Sequence[str]) -> dict[str, tuple[int, RealArray]]:
    """Return the order of derivative and the weights of coordinates and roads of each channel of the suspension."""
    rows = {}
    for name in channels:
        try:
            order, weights, roads = output_weights(car, name)
        except InputError:
            continue
        rows[name] = (order, np.concatenate([weights, roads]))
    return rows


def _alone(weights: RealArray, at: int) -> bool:
    return bool(weights[at]) and not np.any(np.delete(weights, at))
