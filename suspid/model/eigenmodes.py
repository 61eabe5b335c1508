"""Exact modes of a model."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np

from suspid.arguments import explained
from suspid.errors import InputError
from suspid.model.modes import ModalSet
from suspid.model.statespace import state_matrix
from suspid.model.suspension import Suspension
from suspid.model.suspension_checks import check_linear
from suspid.units import ComplexArray

if TYPE_CHECKING:
    import control


@explained
def eigenmodes(system: control.LTI | Suspension) -> ModalSet:
    """Return the exact modes of a model: its eigenvalues, and its eigenvectors at the outputs.

    Parameters
    ----------
    system : control.StateSpace, control.TransferFunction or Suspension
        The model. A transfer function is realised first: poles that cancel are kept. The poles z of a sampled system
        are converted to continuous time, ``log(z) / dt``.

    Returns
    -------
    ModalSet
        Shapes at the system's outputs, or at the suspension's coordinates (displacements). The largest component of
        each is 1; a shape is zero where no output sees the mode. A real pole or a pole at zero is an entry of its own
        and a conjugate pair is one entry, see `ModalSet.kinds`.

    Raises
    ------
    InputError
        If the system is none of these, is a transfer function that cannot be realised, or is sampled and has no
        sampling time or has a pole at z = 0 (a pure delay).

    Examples
    --------
    >>> from suspid import quarter_car
    >>> car = quarter_car(seat_mass=200, chassis_mass=200, tire_mass=200,
    ...                   seat_stiffness=200e3, chassis_stiffness=400e3, tire_stiffness=800e3,
    ...                   seat_damping=300, chassis_damping=200, tire_damping=100)
    >>> eigenmodes(car).wn.round(4)
    array([21.2737, 50.1386, 83.8549])
    """
    if isinstance(system, Suspension):
        check_linear(system, "eigenmodes")
        matrix, channels, dt = state_matrix(system), system.coordinates, None
        outputs = np.eye(len(channels), len(matrix))
    else:
        if not hasattr(system, "A") and hasattr(system, "num") and hasattr(system, "output_labels"):
            system = _realised(system)
        if not hasattr(system, "A") or not hasattr(system, "output_labels"):
            needed = "a control.StateSpace, a control.TransferFunction or a Suspension"
            raise InputError(f"eigenmodes needs {needed}, not {type(system).__name__}{_instead(system)}")
        matrix, outputs = np.asarray(system.A, float), np.asarray(system.C, float)
        channels, dt = tuple(system.output_labels), system.dt
    poles, vectors = np.linalg.eig(matrix)
    poles, vectors = poles.astype(complex), vectors.astype(complex)
    still = np.eye(len(matrix)) if dt else np.zeros_like(matrix)
    if dt:
        poles = _continuous(poles, dt)
    if len(matrix) and np.linalg.matrix_rank(matrix - still) < len(matrix):
        # These poles of a singular model count as zero. A double pole at zero, as of a free mass, is computed as about
        # the square root of the float resolution (1.5e-8); a higher limit would hide slow modes.
        poles = np.where(np.abs(poles) <= 3e-8 * np.max(np.abs(poles), initial=0.0), 0.0, poles)
    shapes = outputs @ vectors
    # Outputs in which the states cancel show rounding alone.
    # Where the sum over the states is rounding, no output sees the mode.
    shapes[np.abs(shapes) <= 1e-12 * (np.abs(outputs) @ np.abs(vectors))] = 0.0
    upper = poles.imag >= 0
    return ModalSet(poles=poles[upper], shapes=scaled_shapes(shapes[:, upper]), channels=channels)


def _realised(system: control.TransferFunction) -> control.StateSpace:
    """Return a transfer function in state space; the poles of the realisation are its own."""
    import control

    try:
        return control.ss(system)
    except control.ControlMIMONotImplemented:
        raise InputError(
            f"a transfer function of {system.noutputs} outputs and {system.ninputs} inputs is realised with slycot "
            "alone: install it, pass the model as a control.StateSpace, or one element, such as system[0, 0]"
        ) from None
    except ValueError as error:
        raise InputError(
            f"{error}: the degree of its numerator is the higher one; its modes are those of "
            "control.tf(1, system.den[0][0])"
        ) from None


def _instead(system: object) -> str:
    """Return what to write where the argument is something else that modes are known of."""
    if isinstance(system, str | os.PathLike):
        return "; read_car reads one from a file"
    if hasattr(system, "output_labels") and hasattr(system, "y"):
        return "; identify finds the modes of a record"
    if hasattr(system, "frdata") or hasattr(system, "fresp"):
        return "; frequency responses are samples, without poles: pass the model, or identify the record"
    if np.ndim(system) == 2:  # type: ignore[arg-type]
        return "; write control.ss(A, B, C, D) for a state matrix"
    if hasattr(system, "zeros") and hasattr(system, "poles"):
        return "; write control.ss(A, B, C, D) or control.tf(num, den) with the numbers of the system"
    return ""


def scaled_shapes(shapes: ComplexArray) -> ComplexArray:
    """Return the shapes (channel, mode), each divided by its largest component."""
    if not len(shapes):
        return shapes
    largest = np.take_along_axis(shapes, np.argmax(np.abs(shapes), axis=0)[None, :], axis=0)
    return np.asarray(shapes / np.where(largest == 0, 1.0, largest))


def _continuous(poles: ComplexArray, dt: float | bool) -> ComplexArray:
    if dt is True:
        raise InputError("the system is sampled but its sampling time is unspecified (dt=True); give dt in seconds")
    if np.any(poles == 0):
        raise InputError(f"{np.sum(poles == 0)} poles at z = 0 are pure delays: they have no natural frequency")
    return np.asarray(np.log(poles) / dt)
