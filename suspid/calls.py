"""Calls that do not fit a function's signature: what Python says of them, with what to write instead."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from pathlib import PurePath

from suspid.values import nearest_names

# Names of arguments in other programs, and the names here; the first one that the function has is suggested.
CALLED_HERE: Mapping[str, tuple[str, ...]] = {
    "band": ("band_hz",),
    "dt": ("fs",),
    "freq": ("fs", "omega"),
    "freqs": ("omega",),
    "frequencies": ("omega",),
    "names": ("channels",),
    "noise": ("snr_db",),
    "order": ("modes",),
    "rate": ("fs",),
    "sampling_rate": ("fs",),
    "seed": ("rng",),
    "snr": ("snr_db",),
    "t": ("timepts", "fs"),
    "time": ("timepts",),
    "x0": ("initial_state",),
    "X0": ("initial_state",),
}


def _elsewhere(verb: Callable[..., object], name: str) -> str:
    """Return where an argument goes that other functions have: into the settings, or with the samples into a record."""
    parameters = inspect.signature(verb).parameters
    settings = inspect.unwrap(verb).__globals__.get("Settings") if "settings" in parameters else None
    if settings is not None and name in inspect.signature(settings).parameters:
        return f"it is one of the settings: settings=Settings({name}=…)"
    return "it belongs to the samples: pass as_record(data, fs=…)" if name == "fs" else ""


def misfit(
    verb: Callable[..., object], error: TypeError, args: Sequence[object], kwargs: Mapping[str, object]
) -> TypeError:
    """Return Python's error on a call, with the way out.

    Examples
    --------
    >>> def smooth(record, *, band_hz=None): ...
    >>> print(misfit(smooth, TypeError("smooth() got an unexpected keyword argument 'band'"), [1], {"band": 2}))
    smooth() got an unexpected keyword argument 'band'. Did you mean 'band_hz'?
    """
    parameters = inspect.signature(verb).parameters
    positional = [one for one in parameters.values() if one.kind is not inspect.Parameter.KEYWORD_ONLY]
    unknown = [name for name in kwargs if name not in parameters]
    if unknown:
        here = [name for name in CALLED_HERE.get(unknown[0], ()) if name in parameters][:1]
        if not here and (elsewhere := _elsewhere(verb, unknown[0])):
            return TypeError(f"{error}; {elsewhere}")
        way = f" Did you mean {here[0]!r}?" if here else nearest_names(unknown[0], list(parameters))
        return TypeError(f"{error}.{way}")
    way = f"help(suspid.{verb.__qualname__}) describes it"
    if len(args) > len(positional):
        by_name = [name for name in parameters if name not in {one.name for one in positional} | set(kwargs)]
        way = f"pass the rest by name, such as {by_name[0]}=…" if by_name else way
        if len(positional) == 1 and all(hasattr(one, "__len__") and not isinstance(one, str) for one in args[:2]):
            way = f"pass time and samples as one pair, {verb.__name__}((t, y)), or {way}"
        if verb.__annotations__.get("return") == "str" and isinstance(args[-1], str | PurePath):
            file = f"Path({str(args[-1])!r:.60})"
            way = f'it returns text: {file}.write_text({verb.__name__}(…), encoding="utf-8") writes it to the file'
    return TypeError(f"{error}; {way}")
