"""Join decays that depend on their amplitude: at the amplitudes that they have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from suspid.identification.common_amplitude import ONE_MODE, overlap, pole_at
from suspid.identification.covariance import ratios
from suspid.identification.identification import Identification
from suspid.identification.joint_fit import Agreement, agreement_of
from suspid.identification.nonlinear import AmplitudeDependence
from suspid.model import ModalSet, common_mac, paired
from suspid.units import ComplexArray, RealArray
from suspid.values import frozen_real

# Share of the decays that hold a mode at least.
HELD_SHARE = 0.5
# By decay, the number of the mode in it.
Members: TypeAlias = dict[int, int]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Joined:
    """The modes of several decays, see `Repeats`."""

    modes: ModalSet
    consistency: tuple[Agreement, ...]
    loudness: RealArray
    amplitude_dependence: tuple[AmplitudeDependence | None, ...]


def joined(each: Sequence[Identification]) -> Joined:
    """Return the modes of several decays that were each fitted with forces of their own.

    Linear poles that are common to all would be between amplitudes that differ, and further ones would stand for that.
    So each mode is that of the single fits, at the middle of the amplitudes that all of its decays met, where they
    are compared as well, each weighted with its information; where they met none in common, it is the plain mean of
    those over the cycles of each, with their scatter. A mode that less than half of the decays hold is left to them.
    """
    groups = _groups([found.modes for found in each])
    # What few decays have their fits may have made; what they have in common, they have not.
    groups = [members for members in groups if len(members) >= HELD_SHARE * len(each)] or groups
    if not groups:
        return Joined(modes=each[0].modes, consistency=(), loudness=frozen_real([]), amplitude_dependence=())
    parts = [_Mode.of(each, members) for members in groups]
    order = np.argsort([abs(part.pole) for part in parts], kind="stable")
    parts = [parts[k] for k in order]
    return Joined(
        modes=_modes(parts, each[0].modes.channels),
        consistency=tuple(part.agreement for part in parts),
        loudness=frozen_real([part.loudness for part in parts]),
        amplitude_dependence=tuple(part.table for part in parts),
    )


def strongest(found: Joined, number: int) -> Joined:
    """Return the modes that most decays hold, and of those that as many do the ones whose frequency is known best."""
    assert found.modes.wn_std is not None
    fewer = np.array([-len(one.held) for one in found.consistency], float)
    rank = np.lexsort(np.stack([found.modes.wn_std / found.modes.wn, fewer]))
    kept = np.sort(rank[:number])
    return Joined(
        modes=found.modes[kept.tolist()],
        consistency=tuple(found.consistency[k] for k in kept),
        loudness=frozen_real(found.loudness[kept]),
        amplitude_dependence=tuple(found.amplitude_dependence[k] for k in kept),
    )


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class _Mode:
    """A mode of several decays."""

    pole: complex
    covariance: RealArray  # of its real and imaginary part
    shape: ComplexArray  # (channel,)
    of_shape: RealArray  # covariance of the real and imaginary parts of the shape, channel by channel
    agreement: Agreement
    loudness: float
    table: AmplitudeDependence | None

    @classmethod
    def of(cls, each: Sequence[Identification], members: Members) -> _Mode:
        """Join a mode."""
        tables = [each[r].amplitude_dependence[k] if each[r].amplitude_dependence else None for r, k in members.items()]
        alone = len(tables) == 1
        table = tables[0] if alone else _pooled(tables)
        found, covariances = list[RealArray](), list[RealArray]()
        for (r, k), own in zip(members.items(), tables, strict=True):
            pole, covariance = complex(each[r].modes.poles[k]), _of_pole(each[r].modes, k)
            if not alone and table is not None and own is not None:
                pole, covariance = pole_at(own, table.holds_at)
            found.append(np.array([pole.real, pole.imag]))
            covariances.append(covariance)
        informations = [np.asarray(np.linalg.pinv(covariance)) for covariance in covariances]
        agreement = agreement_of(found, informations, list(members))
        apart = table is None and not alone
        if apart:
            weights, widening = [np.eye(2) / len(found)] * len(found), 1.0
        else:
            together = np.linalg.pinv(np.sum(informations, axis=0))
            weights, widening = [together @ information for information in informations], agreement.widening
        mean = np.sum([w @ p for w, p in zip(weights, found, strict=True)], axis=0)
        # What the forces of a fit do not describe is alike in all decays: their errors add up, as those of one do.
        spread = np.sum([w @ _root(c) for w, c in zip(weights, covariances, strict=True)], axis=0)
        covariance = spread @ spread.T * widening
        if apart:
            covariance += np.cov(np.transpose(found)) / len(found)
        shape, of_shape = _shape(each, members)
        return cls(
            pole=complex(*mean),
            covariance=covariance,
            shape=shape,
            of_shape=of_shape,
            agreement=agreement,
            loudness=max(float(each[r].loudness[k]) for r, k in members.items()),
            table=table,
        )


def _groups(sets: Sequence[ModalSet]) -> list[Members]:
    """Return which modes of the decays are one: each decay's are paired with the means of those before."""
    groups: list[Members] = []
    for r, modes in enumerate(sets):
        groups.sort(key=lambda members: abs(_middle(sets, members)))
        pairs = dict[int, int]()
        if groups and len(modes):
            shapes = [_shapes_of(sets[s])[:, k] for s, k in (next(iter(members.items())) for members in groups)]
            known = ModalSet(
                poles=np.array([_middle(sets, members) for members in groups]),
                shapes=np.stack(shapes, axis=1),
                channels=modes.channels,
            )
            pairs = paired(modes, known, mac=common_mac(modes, known), gate=ONE_MODE)
        for group, mode in pairs.items():
            groups[group][r] = mode
        groups += [{r: mode} for mode in range(len(modes)) if mode not in pairs.values()]
    return groups


def _middle(sets: Sequence[ModalSet], members: Members) -> complex:
    """Return the mean pole of a mode so far."""
    return complex(np.mean([sets[r].poles[k] for r, k in members.items()]))


def _pooled(tables: Sequence[AmplitudeDependence | None]) -> AmplitudeDependence | None:
    """Return the windows of all decays by falling amplitude; None if there is no amplitude that all of them met."""
    middle, known = overlap(tables), [table.known for table in tables if table is not None]
    if middle is None:
        return None
    every = np.argsort(-np.concatenate([table.amplitude for table in known]), kind="stable")
    spans = [span for table in known for span in table.spans]

    def column(name: str) -> RealArray:
        return frozen_real(np.concatenate([getattr(table, name) for table in known])[every])

    return AmplitudeDependence(
        spans=tuple(spans[k] for k in every),
        channel=known[0].channel,
        amplitude=column("amplitude"),
        wn=column("wn"),
        zeta=column("zeta"),
        wn_std=column("wn_std"),
        zeta_std=column("zeta_std"),
        holds_at=middle,
    )


def _root(covariance: RealArray) -> RealArray:
    """Return the symmetric square root of a covariance."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)) @ vectors.T)


def _of_pole(modes: ModalSet, k: int) -> RealArray:
    assert modes.covariance is not None
    return np.asarray(modes.covariance[2 * k : 2 * k + 2, 2 * k : 2 * k + 2])


def _shapes_of(modes: ModalSet) -> ComplexArray:
    assert modes.shapes is not None
    return modes.shapes


def _shape(each: Sequence[Identification], members: Members) -> tuple[ComplexArray, RealArray]:
    """Return the mean of the shapes in units of one channel, weighted by channel, and its covariance."""
    sizes = np.sum([np.abs(_shapes_of(each[r].modes)[:, k]) for r, k in members.items()], axis=0)
    unit = int(np.argmax(sizes))
    shapes, covariances = zip(*[_in_units_of(unit, each[r].modes, k) for r, k in members.items()], strict=True)
    variances = np.array([covariance.diagonal().reshape(-1, 2).sum(axis=1) for covariance in covariances])
    # In the channel that is the unit, and of shapes that are known exactly, all count alike.
    weights = 1 / np.where(variances > 0, variances, 1.0)
    weights = np.where(np.all(variances > 0, axis=0), weights / weights.sum(axis=0), 1 / len(variances))
    parts = np.repeat(weights, 2, axis=1)
    covariance = np.sum([c * np.outer(w, w) for c, w in zip(covariances, parts, strict=True)], axis=0)
    return np.sum(weights * np.array(shapes), axis=0), covariance


def _in_units_of(unit: int, modes: ModalSet, k: int) -> tuple[ComplexArray, RealArray]:
    """Return the shape of a mode that is 1 in a channel, with its covariance."""
    assert modes.covariance is not None
    size = 2 * len(modes.channels)
    start = 2 * len(modes) + k * size
    own = modes.covariance[start : start + size, start : start + size]
    shapes, slopes = ratios(_shapes_of(modes)[:, k : k + 1], np.array([unit]))
    return shapes[:, 0], slopes @ own @ slopes.T


def _modes(parts: Sequence[_Mode], channels: Sequence[str]) -> ModalSet:
    count, size = len(parts), 2 * len(channels)
    covariance = np.zeros((count * (2 + size),) * 2)
    for k, part in enumerate(parts):
        at = 2 * count + k * size
        covariance[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = part.covariance
        covariance[at : at + size, at : at + size] = part.of_shape
    return ModalSet(
        poles=np.array([part.pole for part in parts]),
        shapes=np.stack([part.shape for part in parts], axis=1),
        channels=channels,
        covariance=covariance,
    )
