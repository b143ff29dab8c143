"""A hull with known transfer functions: the Froude-Krylov load on a box."""

from dataclasses import dataclass

import numpy as np

RHO, G = 1025.0, 9.81
LENGTH, BEAM, DRAUGHT = 260.0, 63.0, 12.4


def froude_krylov(omega: np.ndarray, heading: np.ndarray) -> np.ndarray:
    """Loads (nw, nh, 6) per unit amplitude on the box in deep water, for exp(+i w t): closed form
    of the integral of the incident pressure; roll, pitch and yaw are left zero."""
    k = omega[:, None] ** 2 / G
    a, b = 0.5 * k * LENGTH * np.cos(heading), 0.5 * k * BEAM * np.sin(heading)
    wall = 2j * RHO * G * (1.0 - np.exp(-k * DRAUGHT)) / k
    load = np.zeros((*a.shape, 6), dtype=complex)
    load[..., 0] = wall * np.sin(a) * BEAM * np.sinc(b / np.pi)
    load[..., 1] = wall * np.sin(b) * LENGTH * np.sinc(a / np.pi)
    load[..., 2] = (
        RHO * G * np.exp(-k * DRAUGHT) * LENGTH * BEAM * np.sinc(a / np.pi) * np.sinc(b / np.pi)
    )
    return load


def smooth_drift(omega: np.ndarray, heading: np.ndarray) -> np.ndarray:
    """Mean drift (nw, nh, 6) of a plausible form, with a moment."""
    short = np.tanh((omega[:, None] / 0.7) ** 4)
    drift = np.zeros((*short.shape[:1], heading.size, 6))
    drift[..., 0] = 0.5 * RHO * G * BEAM * short * np.cos(heading)
    drift[..., 1] = 0.5 * RHO * G * LENGTH * short * np.sin(heading)
    drift[..., 5] = 10.0 * RHO * G * LENGTH * short * np.sin(2.0 * heading)
    return drift


@dataclass(frozen=True, eq=False)
class Box:
    """The box as a database."""

    frequency: np.ndarray
    heading: np.ndarray
    excitation: np.ndarray
    mean_drift: np.ndarray | None
    source: str = "box.nc"
    qtf_frequency: np.ndarray | None = None
    qtf_heading: np.ndarray | None = None
    qtf_difference: np.ndarray | None = None
    qtf_sum: np.ndarray | None = None


def box_at(omega: np.ndarray, degrees: np.ndarray) -> Box:
    heading = np.radians(degrees)
    return Box(omega, heading, froude_krylov(omega, heading), smooth_drift(omega, heading))
