"""Calls of each peer: public functions only, with the settings of a careful user."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from suspid import IdentificationError, ModalSet, identify
from suspid.records import as_response
from suspid.units import Hertz, RealArray
from validation.peer_skeletons import RATE, Estimates, fcwt_skeleton, pywt_skeleton, ssqueezepy_skeleton

# Subspace methods work on every tenth sample of the low-pass filtered record.
REDUCTION = 10
SLOW: Hertz = RATE / REDUCTION
# Order of the subspace models: three pairs, and one for the filter and the noise.
ORDER = 8
# Information given to a method: H the frequencies to 5 %, N the number of modes or an order, - nothing.
Given = Literal["H", "N", "-"]


@dataclass(frozen=True, kw_only=True, slots=True)
class Method:
    """One way to find modes in the samples of one channel at `RATE`, with or without hints."""

    name: str
    distribution: str
    module: str
    given: Given
    settings: str
    run: Callable[[RealArray, RealArray], Estimates]


def suspid_unaided(samples: RealArray, near: RealArray) -> Estimates:
    """Return all modes of `identify`."""
    del near
    return _pairs(identify(as_response(np.arange(len(samples)) / RATE, samples[None], ("seat",))).modes)


def suspid_ridge(samples: RealArray, near: RealArray) -> Estimates:
    """Return at most three modes by the ridges."""
    record = as_response(np.arange(len(samples)) / RATE, samples[None], ("seat",))
    try:
        return _pairs(identify(record, modes=len(near), method="ridge").modes)
    except IdentificationError as error:
        return _pairs(error.found) if isinstance(error.found, ModalSet) else []


def mwdi(samples: RealArray, near: RealArray) -> Estimates:
    """Damping by the ratio of two Morlet-wave integrals, at the maximum of the integral."""
    identifier = importlib.import_module("mwdi").MorletWave(samples, RATE)

    def one(guess: float) -> tuple[float, float]:
        # 30 cycles unless the record is shorter. A wave of 30 cycles misses a maximum 5 % away, one of ten does not.
        rough = identifier.find_natural_frequency(guess, 8, 10)
        cycles = min(30, int(rough * len(samples) / RATE / (2 * np.pi)) - 2)
        wn = identifier.find_natural_frequency(rough, 8, cycles)
        zeta = identifier.identify_damping(wn, n_1=8, n_2=12, k=cycles, find_exact_freq=False, root_finding="Newton")
        return float(wn), float(zeta)

    return _each(near, one)


def morlet_wave_modal(samples: RealArray, near: RealArray) -> Estimates:
    """Least squares over Morlet waves of many lengths, from zeta = 1 %."""
    modal = importlib.import_module("mwmodal")
    rough = importlib.import_module("mwdi").MorletWave(samples, RATE)

    def one(guess: float) -> tuple[float, float]:
        start = rough.find_natural_frequency(guess, 8, 10)
        wn, zeta, *_ = modal.MorletWaveModal(samples, RATE).identify_modal_parameters(start, 0.01)
        return float(wn), float(zeta)

    return _each(near, one)


def pyyeti_automatic(samples: RealArray, near: RealArray) -> Estimates:
    """ERA, singular values and modes chosen by its own indicators."""
    del near
    return _pyyeti(samples, svd_tol=0.05, all_lower_limits=None)


def pyyeti_given_order(samples: RealArray, near: RealArray) -> Estimates:
    """ERA with twice as many pairs as modes, none of them refused."""
    return _pyyeti(samples, svd_tol=2 * len(near), all_lower_limits=0.0)


def control_default(samples: RealArray, near: RealArray) -> Estimates:
    """ERA of python-control on the whole record at full rate, with its own m and n."""
    control = importlib.import_module("control")
    system, _ = control.eigensys_realization(samples, r=2 * len(near), dt=1 / RATE)
    return _modes_of(system.A, RATE)


def control_large(samples: RealArray, near: RealArray) -> Estimates:
    """ERA of python-control with Hankel matrices of half the record."""
    control = importlib.import_module("control")
    system, _ = control.eigensys_realization(slowed(samples), r=2 * len(near), m=240, n=240, dt=1 / SLOW)
    return _modes_of(system.A, SLOW)


def koma(samples: RealArray, near: RealArray) -> Estimates:
    """Covariance SSI of orders 2 to 60, stable poles, clusters of HDBSCAN."""
    del near
    oma, clustering = importlib.import_module("koma.oma"), importlib.import_module("koma.clustering")
    poles, shapes, orders = oma.covssi(slowed(samples)[:, None], SLOW, 60, np.arange(2, 61, 2), showinfo=False)
    # The phase collinearity of one channel is 1, so the range must include 1.
    valid = {"freq": [0, np.inf], "damping": [0, np.inf], "mpc": [-np.inf, np.inf]}
    poles, shapes, orders, _ = oma.find_stable_poles(poles, shapes, orders, 1, valid_range=valid)
    clusterer = clustering.PoleClusterer(
        poles, shapes, orders, min_samples=5, min_cluster_size=5, scaling={"lambda_real": 1.0, "lambda_imag": 1.0}
    )
    clusters = clusterer.postprocess(prob_threshold=0.5)
    if not len(clusters[0]):
        return []
    zeta, wn, *_ = clustering.group_clusters(*clusters)
    return [(float(np.median(w)), float(np.median(z))) for w, z in zip(wn, zeta, strict=True)]


def pyoma(samples: RealArray, near: RealArray) -> Estimates:
    """Covariance SSI of order 12; the pole nearest to each frequency."""
    setup = importlib.import_module("pyoma2.setup").SingleSetup(slowed(samples)[:, None], SLOW)
    no_limits = {"xi_max": 0.5, "mpc_lim": None, "mpd_lim": None, "CoV_max": None}
    ssi = importlib.import_module("pyoma2.algorithms").SSI(name="ssi", br=20, ordmax=12, method="cov", hc=no_limits)
    setup.add_algorithms(ssi)
    setup.run_by_name("ssi")

    def one(guess: float) -> tuple[float, float]:
        setup.mpe("ssi", sel_freq=[guess / (2 * np.pi)], order_in=12, rtol=0.08)
        return 2 * np.pi * float(ssi.result.Fn[0]), float(ssi.result.Xi[0])

    return _each(near, one)


def sdypy(samples: RealArray, near: RealArray) -> Estimates:
    """LSCF on the spectrum of the record times exp(-t / 2 s), the stable pole nearest to each frequency."""
    model_of = importlib.import_module("sdypy.EMA").Model
    time, fall = np.arange(len(samples)) / RATE, 0.5
    spectrum, hertz = np.fft.rfft(samples * np.exp(-fall * time)) / RATE, np.fft.rfftfreq(len(samples), 1 / RATE)
    model = model_of(frf=spectrum[None], freq=hertz, lower=0.5, upper=30, pol_order_high=30, frf_form="receptance")
    model.get_poles(method="lscf", show_progress=False)

    def one(guess: float) -> tuple[float, float]:
        model.select_closest_poles([guess / (2 * np.pi)], f_window=1)
        wn, zeta = 2 * np.pi * float(model.nat_freq[0]), float(model.nat_xi[0])
        pole = complex(fall - zeta * wn, wn * np.sqrt(1 - zeta**2))
        return abs(pole), -pole.real / abs(pole)

    return _each(near, one)


def sippy(samples: RealArray, near: RealArray) -> Estimates:
    """PARSIM-K of order 8 between an impulse, one sample ahead, and the record."""
    del near
    output = np.concatenate([[0.0], slowed(samples)])
    impulse = np.zeros_like(output)
    impulse[0] = 1.0
    identification = importlib.import_module("sippy_unipi").system_identification
    system = identification(output[None], impulse[None], "PARSIM-K", SS_fixed_order=ORDER, tsample=1 / SLOW)
    return _modes_of(system.A, SLOW)


def slowed(samples: RealArray) -> RealArray:
    """Return the samples at `SLOW`, low-pass filtered forward and backward."""
    from scipy.signal import decimate

    return np.asarray(decimate(samples, REDUCTION), float)


def _pairs(modes: ModalSet | None) -> Estimates:
    return [(float(w), float(z)) for w, z in zip(modes.wn, modes.zeta, strict=True)] if modes is not None else []


def _modes_of(A: Any, rate: Hertz) -> Estimates:
    """Return the modes of a discrete state matrix."""
    eigenvalues = np.linalg.eigvals(np.asarray(A, float)).astype(complex)
    poles = rate * np.log(eigenvalues[eigenvalues.imag > 0])
    return [(float(abs(p)), float(-p.real / abs(p))) for p in poles]


def _each(near: RealArray, one: Callable[[float], tuple[float, float]]) -> Estimates:
    """Return the result of each guess; a peer that refuses one may still find the others."""
    found = []
    for guess in near:
        try:
            found.append(one(float(guess)))
        except Exception:  # A peer may raise anything.
            continue
    return found


def _pyyeti(samples: RealArray, *, svd_tol: float, all_lower_limits: float | None) -> Estimates:
    era = importlib.import_module("pyyeti.era").ERA(
        slowed(samples), SLOW, svd_tol=svd_tol, auto=True, all_lower_limits=all_lower_limits, verbose=False,
        show_plot=False,
    )  # fmt: skip
    return [(2 * np.pi * float(f), float(z)) for f, z in zip(era.freqs_hz, era.zeta, strict=True)]


METHODS = (
    Method(name='suspid, identify(record)', distribution="suspid", module="suspid", given="-",
           settings="none", run=suspid_unaided),
    Method(name='suspid, identify(record, modes=3, method="ridge")', distribution="suspid", module="suspid", given="N",
           settings="none", run=suspid_ridge),
    Method(name="MorletWaveModal", distribution="MorletWaveModal", module="mwmodal", given="H",
           settings="from zeta = 1 %; frequency first refined by mwdi over ten cycles", run=morlet_wave_modal),
    Method(name="mwdi", distribution="mwdi", module="mwdi", given="H",
           settings="n = 8 and 12, exact form; 30 cycles or what the record has; frequency first refined over ten",
           run=mwdi),
    Method(name="pywt.cwt + skeleton script", distribution="PyWavelets", module="pywt", given="H",
           settings="N = 10; the script below", run=pywt_skeleton),
    Method(name="ssqueezepy.cwt + the same", distribution="ssqueezepy", module="ssqueezepy", given="H",
           settings="Morlet of the same N, double precision", run=ssqueezepy_skeleton),
    Method(name="fCWT + the same", distribution="fCWT", module="fcwt", given="H",
           settings="Morlet of the same N", run=fcwt_skeleton),
    Method(name="pyyeti ERA, automatic", distribution="pyyeti", module="pyyeti.era", given="-",
           settings="50 Hz; defaults", run=pyyeti_automatic),
    Method(name="pyyeti ERA, 6 modes kept", distribution="pyyeti", module="pyyeti.era", given="N",
           settings="50 Hz; svd_tol=6, no lower limits", run=pyyeti_given_order),
    Method(name="python-control ERA, defaults", distribution="control", module="control", given="N",
           settings="500 Hz; r=6", run=control_default),
    Method(name="python-control ERA, m = n = 240", distribution="control", module="control", given="N",
           settings="50 Hz; r=6", run=control_large),
    Method(name="koma SSI-cov + HDBSCAN", distribution="koma-python", module="koma", given="-",
           settings="50 Hz; 60 block rows, orders 2 to 60, clusters of at least 5", run=koma),
    Method(name="pyOMA_2 SSI-cov, order 12", distribution="pyOMA_2", module="pyoma2", given="H",
           settings="50 Hz; 20 block rows", run=pyoma),
    Method(name="sdypy-EMA lscf + exponential window", distribution="sdypy-EMA", module="sdypy.EMA", given="H",
           settings="exp(-t / 2 s), undone in the poles; 0.5 to 30 Hz, orders up to 30", run=sdypy),
    Method(name="sippy_unipi PARSIM-K", distribution="sippy_unipi", module="sippy_unipi", given="N",
           settings=f"50 Hz; order {ORDER}", run=sippy),
)  # fmt: skip
