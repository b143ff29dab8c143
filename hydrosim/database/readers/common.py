"""Functions for several readers: exact inverse conversion, symmetry, choice of the mean drift."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hydrosim.database.database import Complex, Real

_ODD = 1e-2  # coupling relative to the diagonals by panels that are not exactly symmetric
_MOMENTUM = [0, 1, 5]  # surge, sway, yaw


def inverse(forward: Callable[[Real], Real], guess: Real, wanted: Real) -> Real:
    """Numbers close to ``guess`` that ``forward`` maps to ``wanted`` to the bit, if a neighbour of
    the guess does; else the guess. So a quotient times its divisor is the original number."""
    result = np.array(guess, dtype=float)
    for neighbour in (np.nextafter(guess, np.inf), np.nextafter(guess, -np.inf), guess):
        result = np.where(forward(neighbour) == wanted, neighbour, result)
    return result


def quotient(value: Real, factor: Real | float) -> Real:
    """``value`` / ``factor``, chosen so that its product with the factor is ``value`` again if
    possible."""
    return inverse(lambda x: x * factor, value / factor, value)


def mirror_image(added_mass: Real, heading: Real, excitation: Complex) -> bool:
    """Whether each body is symmetric about y = 0, as far as the coefficients show. Then surge,
    heave and pitch do not couple with sway, roll and yaw, and waves along x excite only the
    former."""
    even = np.arange(added_mass.shape[-1]) % 2 == 0
    diagonal = np.abs(np.diagonal(added_mass, axis1=1, axis2=2)).max(axis=0)
    rotation = np.arange(even.size) % 6 > 2
    floor = np.where(rotation, diagonal[rotation].max(), diagonal[~rotation].max()) * 1e-6
    scale = np.sqrt(np.maximum(diagonal, floor))
    coupling = np.abs(added_mass).max(axis=0) / np.outer(scale, scale)
    along = excitation[:, np.abs(np.sin(heading)) < 1e-6]
    load = np.abs(along).max(axis=(0, 1), initial=0.0) / scale
    return bool(
        coupling[even][:, ~even].max() < _ODD
        and coupling[~even][:, even].max() < _ODD
        and load[~even].max() <= _ODD * load[even].max()
    )


def preferred_drift(
    momentum: Real | None, control_surface: Real | None, pressure: Real | None, bodies: int
) -> tuple[Real | None, str]:
    """Mean drift (nw, nh, n) from up to three methods, and a remark on it.

    Surge, sway and yaw come from the conservation of momentum, the most accurate method. It gives
    only the sum for several bodies, and is then not used. The others come from the control surface,
    else from the pressure, else they are zero.
    """
    full, name = control_surface, "over a control surface"
    if full is None:
        full, name = pressure, "by pressure integration"
    if momentum is None or (bodies > 1 and full is not None):
        return full, "" if full is None else name
    if bodies > 1:
        return None, "by momentum conservation only, which holds for all bodies together: left out"
    drift = np.zeros_like(momentum) if full is None else full.copy()
    drift[..., _MOMENTUM] = momentum[..., _MOMENTUM]
    rest = "unknown and zero" if full is None else name
    return drift, f"surge, sway, yaw by momentum conservation; heave, roll, pitch {rest}"
