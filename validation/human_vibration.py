"""Published numbers of human vibration: tables of ISO 8041-1:2017, and the test signals they belong to.

The weighting factors are those of Annex B at the true centres 10^(n/10) Hz of one-third-octave bands; the responses to
saw-tooth bursts are those of Table 8 (whole body) and Table 9 (low frequency). Numbers as printed, transcribed by
phonometry (its test data names the tables).
"""

from __future__ import annotations

import numpy as np

from suspid.units import RealArray, Second

# Weighting, number n of its first band, factors of the bands from there on.
FACTORS: dict[str, tuple[int, tuple[float, ...]]] = {
    "Wk": (-10, (
        0.03121, 0.04931, 0.07756, 0.1207, 0.1832, 0.2644, 0.3504, 0.4188, 0.4588, 0.4767, 0.4825, 0.4846, 0.4935,
        0.5308, 0.6335, 0.8071, 0.9648, 1.039, 1.054, 1.037, 0.9884, 0.8989, 0.7743, 0.6373, 0.5103, 0.4031, 0.316,
        0.2451, 0.1857, 0.1339, 0.08873, 0.05311, 0.02922, 0.01528, 0.007795, 0.003935, 0.001978,
    )),
    "Wd": (-10, (
        0.06242, 0.09867, 0.1553, 0.242, 0.3682, 0.533, 0.7097, 0.854, 0.9443, 0.9914, 1.011, 1.007, 0.9707, 0.8913,
        0.7733, 0.6398, 0.5143, 0.4081, 0.3226, 0.255, 0.2017, 0.1597, 0.1266, 0.1004, 0.07958, 0.06299, 0.04965,
        0.03872, 0.02946, 0.0213, 0.01414, 0.008478, 0.004668, 0.002442, 0.001246, 0.0006293, 0.0003164,
    )),
    "Wf": (-17, (
        0.02407, 0.03803, 0.06021, 0.09619, 0.1575, 0.2675, 0.4537, 0.6951, 0.9, 1.004, 0.9928, 0.8501, 0.6149, 0.3884,
        0.2225, 0.1157, 0.05434, 0.02352, 0.009705, 0.003916, 0.001566,
    )),
    "Wc": (-10, (
        0.06238, 0.09858, 0.1551, 0.2415, 0.3669, 0.5302, 0.7042, 0.8442, 0.9292, 0.9716, 0.991, 1.0, 1.006, 1.012,
        1.017, 1.023, 1.024, 1.013, 0.9739, 0.8941, 0.7762, 0.6425, 0.5166, 0.4098, 0.3236, 0.2549, 0.2002, 0.1557,
        0.1182, 0.08538, 0.05665, 0.03394, 0.01868, 0.009772, 0.004987, 0.002518, 0.001266,
    )),
    "We": (-10, (
        0.06252, 0.09893, 0.156, 0.2435, 0.3715, 0.5394, 0.7198, 0.8635, 0.9389, 0.9423, 0.8798, 0.7683, 0.6372, 0.5127,
        0.407, 0.3218, 0.2543, 0.2012, 0.1594, 0.1263, 0.1002, 0.07954, 0.06314, 0.05011, 0.03975, 0.03147, 0.02481,
        0.01935, 0.01473, 0.01065, 0.007071, 0.004239, 0.002334, 0.001221, 0.0006232, 0.0003147, 0.0001582,
    )),
    "Wj": (-10, (
        0.03099, 0.04897, 0.07703, 0.1199, 0.1821, 0.263, 0.3489, 0.4176, 0.4585, 0.4776, 0.4844, 0.4851, 0.4832,
        0.4819, 0.4889, 0.5246, 0.6251, 0.7948, 0.947, 1.016, 1.03, 1.026, 1.019, 1.012, 1.006, 1.0, 0.9911, 0.972,
        0.9304, 0.8465, 0.7075, 0.5338, 0.37, 0.2437, 0.1565, 0.09951, 0.06297,
    )),
    "Wb": (-10, (
        0.02494, 0.03941, 0.06198, 0.09645, 0.1464, 0.2113, 0.28, 0.3347, 0.3666, 0.3808, 0.3853, 0.3864, 0.3916,
        0.4168, 0.496, 0.6653, 0.885, 1.026, 1.054, 1.026, 0.9745, 0.9042, 0.8144, 0.7088, 0.5973, 0.4906, 0.395,
        0.3118, 0.2389, 0.1734, 0.1154, 0.06929, 0.03818, 0.01999, 0.0102, 0.005154, 0.002591,
    )),
    "Wm": (-10, (
        0.01584, 0.0251, 0.03976, 0.06293, 0.09941, 0.1563, 0.243, 0.3684, 0.5304, 0.7003, 0.8329, 0.9071, 0.9342,
        0.9319, 0.9101, 0.8721, 0.8184, 0.7498, 0.6692, 0.5819, 0.4941, 0.4114, 0.3375, 0.2738, 0.2203, 0.176, 0.1396,
        0.1093, 0.08336, 0.06036, 0.04013, 0.02407, 0.01326, 0.006937, 0.003541, 0.001788, 0.000899,
    )),
}  # fmt: skip
# Table 8: cycles in each burst (0: continuous), rms and VDV after the weighting. Tolerances 10 and 12 %.
BURSTS: dict[str, dict[int, tuple[float, float]]] = {
    "Wk": {1: (0.0299, 0.323), 2: (0.0411, 0.38), 4: (0.0577, 0.455), 8: (0.0814, 0.543), 16: (0.115, 0.648),
           0: (0.362, 1.15)},
    "Wd": {1: (0.00669, 0.0779), 2: (0.00906, 0.0852), 4: (0.0116, 0.0923), 8: (0.0148, 0.101), 16: (0.0197, 0.115),
           0: (0.059, 0.197)},
    "We": {1: (0.00342, 0.0409), 2: (0.00478, 0.0452), 4: (0.00637, 0.0493), 8: (0.00816, 0.0535), 16: (0.0102, 0.0592),
           0: (0.0295, 0.0987)},
}  # fmt: skip
# Table 9: rms and MSDV of low-frequency bursts after Wf. Tolerance 10 %.
SLOW_BURSTS = {
    1: (0.0197, 0.9651), 2: (0.0236, 1.156), 4: (0.0304, 1.489), 8: (0.0416, 2.038), 16: (0.0571, 2.797),
    0: (0.176, 8.622),
}  # fmt: skip
RATE = 2000.0  # of whole-body bursts; steps of the saw-tooth are far above the band
SLOW_RATE = 50.0


def centres(name: str) -> tuple[RealArray, RealArray]:
    """Return the true band centres [Hz] of a weighting, and its printed factors."""
    first, factors = FACTORS[name]
    return 10 ** (np.arange(first, first + len(factors)) / 10), np.array(factors)


def bursts(cycles: int) -> tuple[RealArray, float]:
    """Return the whole-body signal and its rate: saw-teeth of 100 rad/s and 1 m/s2, every 10 s from 1 s on, 60 s."""
    return _saw(cycles, rate=RATE, angular=100.0, start=1.0, every=10.0, duration=60.0), RATE


def slow_bursts(cycles: int) -> tuple[RealArray, float]:
    """Return the low-frequency signal and its rate: the same of 2.5 rad/s, every 400 s from 40 s on, 2400 s."""
    return _saw(cycles, rate=SLOW_RATE, angular=2.5, start=40.0, every=400.0, duration=2400.0), SLOW_RATE


def _saw(cycles: int, *, rate: float, angular: float, start: Second, every: Second, duration: Second) -> RealArray:
    # Each sample is the mean over its step, so that no jump between samples leaves an offset: the saw-tooth is the
    # derivative of a continuous chain of parabolas, zero where a burst begins and ends.
    edges, period = (np.arange(round(duration * rate) + 1) - 0.5) / rate, 2 * np.pi / angular
    since = (edges - start) % every if cycles else edges
    on = (edges >= start) & (since < cycles * period) if cycles else np.ones_like(edges, bool)
    return np.diff(np.where(on, period * ((since / period + 0.5) % 1.0 - 0.5) ** 2, 0.0)) * rate
