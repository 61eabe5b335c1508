"""Damaged files: every mutated file of modes, car or record ends in an answer or in one error of suspid's.

Mutations are drawn apart from the readers: characters, lines and numbers are dropped, doubled, exchanged or replaced
by extreme ones. What comes back is counted: an answer, a refusal (`SuspidError` of one line), or anything else, which
is a defect.
"""

from __future__ import annotations

import json
import re
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from tabulate import tabulate

from suspid import (
    ModalSet,
    Suspension,
    SuspidError,
    compare,
    eigenmodes,
    free_decay,
    full_car,
    grip,
    half_car,
    quarter_car,
    read_car,
    reconstruct,
    ride,
    simulate,
    statespace,
)
from suspid.identification import modes_to_dict, read_modes
from suspid.model import car_to_toml

MODES, CARS = 1500, 3000
SEED = 480_000
NUMBER = re.compile(r"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
EXTREME = (
    "0", "-0.0", "-1", "1", "1e-320", "5e-324", "1e-300", "1e300", "-1e300", "1e-150", "1e150", "1e-30", "1e30",
    "1e999", "nan", "inf", "-inf", "NaN", "Infinity", "true", "null", '"seat"', "[]", "[1, 2]", "{}",
    "12345678901234567890123", "1e-8", "1e8", "0.5", "2", "-3.7",
)  # fmt: skip

Call = Callable[[], object]


def mutated(text: str, rng: np.random.Generator) -> str:
    """Return a text with one to three mutations."""
    for _ in range(int(rng.integers(1, 4))):
        text = _mutated_once(text, rng)
    return text


def _mutated_once(text: str, rng: np.random.Generator) -> str:
    kind = rng.choice(["number", "number", "number", "scale", "character", "line", "cut", "word", "piece"])
    numbers = list(NUMBER.finditer(text))
    if kind in ("number", "scale") and numbers:
        found = numbers[int(rng.integers(len(numbers)))]
        new = str(rng.choice(EXTREME))
        if kind == "scale":
            new = f"{found[0]}e{int(rng.integers(-330, 330))}" if "e" not in found[0].lower() else f"-{found[0]}"
        return text[: found.start()] + new + text[found.end() :]
    place = int(rng.integers(len(text) + 1))
    if kind == "character":
        new = str(rng.choice(list("0159.,-+e[]{}=\"' \n#\tµ\0")))
        return text[:place] + new + text[place + int(rng.integers(2)) :]
    if kind == "cut":
        return text[:place]
    if kind == "piece":
        stop = min(len(text), place + int(rng.integers(1, 40)))
        return text[:stop] + text[place:stop] * int(rng.integers(2)) + text[stop + int(rng.integers(20)) :]
    parts = text.split("\n") if kind == "line" else re.split(r"(\w+)", text)
    one, two = (int(rng.integers(len(parts))) for _ in "ab")
    how = int(rng.integers(3))
    if how == 0:
        parts[one], parts[two] = parts[two], parts[one]
    elif how == 1:
        del parts[one]
    else:
        parts.insert(one, parts[two])
    return ("\n" if kind == "line" else "").join(parts)


def outcome(call: Call) -> str:
    """Return how a call ended: ``answer``, ``refused``, or the name and place of another error or a warning."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            call()
        except SuspidError as error:
            return "refused" if str(error).strip() else "an empty message"
        except Exception as error:
            frames = traceback.extract_tb(error.__traceback__)
            own = [frame.name for frame in frames if "/suspid/" in frame.filename]
            return f"{type(error).__name__} in {own[-1] if own else '?'}"
    return "answer"


def truth() -> Suspension:
    """Return the car whose modes are damaged."""
    return quarter_car(
        seat_mass=200, chassis_mass=200, tire_mass=200, seat_stiffness=200e3, chassis_stiffness=400e3,
        tire_stiffness=800e3, seat_damping=300, chassis_damping=200, tire_damping=100,
    )  # fmt: skip


def files_of_modes() -> list[tuple[str, str]]:
    """Return sound files of modes: as written by the library, with and without covariance, and by hand."""
    exact = eigenmodes(truth())
    rng = np.random.default_rng(SEED)
    size = 2 * len(exact) * (1 + len(exact.channels))
    root = 1e-3 * rng.standard_normal((size, size))
    measured = ModalSet(poles=exact.poles, shapes=exact.shapes, channels=exact.channels, covariance=root @ root.T)
    small = ModalSet.from_wn_zeta(exact.wn, exact.zeta, wn_std=0.01 * exact.wn, zeta_std=0.1 * exact.zeta)
    rows = "\n".join(
        f"[[modes]]\nfrequency_hz = {wn / (2 * np.pi):.9g}\nzeta = {zeta:.9g}\n"
        for wn, zeta in zip(exact.wn, exact.zeta, strict=True)
    )
    whole = [modes_to_dict(modes) for modes in (exact, measured, small)]
    # Without what the poles say as well, a changed number contradicts nothing.
    bare = [
        {**content, "modes": [{key: mode[key] for key in ("pole_rad_per_s", "shape")} for mode in modes]}
        for content in whole
        if isinstance(modes := content["modes"], list)
    ]
    return [*((".json", json.dumps(content, indent=1)) for content in (*whole, *bare, *bare)), (".toml", rows)]


def files_of_cars() -> list[tuple[str, str]]:
    """Return sound files of cars of every form."""
    half = half_car(
        chassis_mass=900, pitch_inertia=1500, front_tire_mass=60, rear_tire_mass=60, cg_to_front=1.2, cg_to_rear=1.5,
        front_stiffness=18e3, rear_stiffness=20e3, front_tire_stiffness=190e3, rear_tire_stiffness=190e3,
        front_damping=1400, rear_damping=1500,
    )  # fmt: skip
    full = full_car(
        chassis_mass=1400, pitch_inertia=2200, roll_inertia=500, front_tire_mass=45, rear_tire_mass=40,
        cg_to_front=1.2, cg_to_rear=1.5, front_track=1.5, rear_track=1.5, front_stiffness=25e3, rear_stiffness=24e3,
        front_tire_stiffness=200e3, rear_tire_stiffness=200e3, front_damping=1500, rear_damping=1500,
    )  # fmt: skip
    examples = Path(__file__).parent.parent / "examples"
    extras = '\n[mounts]\nchassis = 1e6\n\n[sensors]\naz = { acceleration = "chassis" }\npot = { travel = "chassis" }\n'
    hatchback = (examples / "hatchback.toml").read_text(encoding="utf-8")
    curve = "\n[friction]\nchassis = 30.0\n\n[curves]\nchassis = [[-1.0, -700.0], [0.0, 0.0], [1.0, 2000.0]]\n"
    texts = [hatchback, hatchback + extras, hatchback + curve, (examples / "nominal_car.toml").read_text("utf-8")]
    return [(".toml", text) for text in (*texts, car_to_toml(truth()), car_to_toml(half), car_to_toml(full))]


def use_modes(path: Path, chosen: int) -> None:
    """Read modes and do with them what one does."""
    modes = read_modes(path)
    str(modes)
    if chosen == 0:
        str(compare(modes, eigenmodes(truth()), rtol=0.02))
    elif chosen == 1 and modes.covariance is not None:
        modes.interval(0.95)
    else:
        str(reconstruct(modes, truth(), search=False))


def use_car(path: Path, chosen: int) -> None:
    """Read a car and do with it one of the things that one does."""
    car = read_car(path)
    str(car)
    car_to_toml(car)
    linear = car if car.linear else car.linearised(amplitude=0.1)
    time = np.arange(200) / 200
    road = np.where(time > 0.1, 0.01, 0.0)
    uses: tuple[Call, ...] = (
        lambda: str(eigenmodes(linear)),
        lambda: statespace(linear),
        lambda: free_decay(car, time, initial_state={f"v_{car.coordinates[0]}": 1.0}),
        lambda: simulate(car, time, dict.fromkeys(car.roads, road)),
        lambda: str(grip(linear)),
        lambda: str(ride(linear, road="C", speed=20)),
    )
    uses[chosen % len(uses)]()


def counted(
    files: Sequence[tuple[str, str]], use: Callable[[Path, int], None], number: int, *, seed: int = SEED
) -> Counter[str]:
    """Return how often each outcome was met over a number of mutated files."""
    found = Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        for k in range(number):
            rng = np.random.default_rng([seed, k])
            suffix, text = files[k % len(files)]
            path = Path(folder, f"file{suffix}")
            path.write_text(mutated(text, rng), encoding="utf-8")
            found[outcome(partial(use, path, int(rng.integers(6))))] += 1
    return found


def report(*, modes: int = MODES, cars: int = CARS) -> str:
    """Return the report as markdown."""
    kinds = {
        "modes (JSON, TOML)": counted(files_of_modes(), use_modes, modes),
        "cars (TOML)": counted(files_of_cars(), use_car, cars),
    }
    rows = []
    for kind, found in kinds.items():
        other = {name: count for name, count in found.items() if name not in ("answer", "refused")}
        rows.append(
            [
                kind,
                str(sum(found.values())),
                str(found["answer"]),
                str(found["refused"]),
                "; ".join(f"{count} {name}" for name, count in other.items()) or "0",
            ]
        )
    headers = ["mutated files", "number", "answer", "refused in one line", "anything else"]
    return "\n\n".join(
        [
            "# Damaged files",
            f"Sound files with one to three mutations each, seed {SEED}: numbers replaced by extreme ones or scaled by "
            f"powers of ten, characters, words and lines dropped, doubled or exchanged, ends cut off. Modes are then "
            f"compared or reconstructed from; with cars, modes, state space, decays, drives, grip or ride.",
            tabulate(rows, headers=headers, tablefmt="github", disable_numparse=True) + "\n",
        ]
    )
