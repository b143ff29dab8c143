"""What several readers need: numbers that come back exactly, symmetry, which drift to take."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hydrosim.database.database import Complex, Real

_ODD = 1e-2  # coupling, relative to the diagonals, that panels which are no mirror images leave
_MOMENTUM = [0, 1, 5]  # surge, sway, yaw


def inverse(forward: Callable[[Real], Real], guess: Real, wanted: Real) -> Real:
    """Numbers close to ``guess`` that ``forward`` takes to ``wanted`` bit for bit, where a
    neighbour of the guess does; the guess where none does. So a quotient times its divisor is
    what it was made of."""
    result = np.array(guess, dtype=float)
    for neighbour in (np.nextafter(guess, np.inf), np.nextafter(guess, -np.inf), guess):
        result = np.where(forward(neighbour) == wanted, neighbour, result)
    return result


def quotient(value: Real, factor: Real | float) -> Real:
    """``value`` / ``factor``, chosen so that the product is ``value`` again where it can be."""
    return inverse(lambda x: x * factor, value / factor, value)


def mirror_image(added_mass: Real, heading: Real, excitation: Complex) -> bool:
    """True if each body is its own mirror image in y = 0, as far as the coefficients tell: surge,
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
    """Mean drift (nw, nh, n) of three methods made one, and a remark on it.

    Surge, sway and yaw are taken from the conservation of momentum, the most accurate, which
    cannot tell several bodies apart and is then not used; the rest from the control surface, else
    from the pressure, else zero.
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
