"""A database with made-up quadratic transfer functions, smooth and complex."""

from dataclasses import replace

import numpy as np
from known_box import Box, box_at

FREQUENCY = np.linspace(0.3, 1.2, 19)


def difference(w1: np.ndarray, w2: np.ndarray, b1: float = 0.0, b2: float = 0.0) -> np.ndarray:
    """T- (..., 6) in surge, heave and pitch, with T-_21 = conj T-_12 where the headings swap."""
    mean, apart = 0.5 * (w1 + w2), w1 - w2
    size = 1e5 * mean**2 * np.cos(0.5 * (b1 + b2))
    phase = np.exp(1j * (2.0 * apart * mean + 0.3 * (b1 - b2)))
    load = np.zeros((*mean.shape, 6), dtype=complex)
    load[..., 0] = size * phase
    load[..., 2] = -0.5 * size * (1.0 + apart**2)
    load[..., 4] = 20.0 * size * phase.conj()
    return load


def total(w1: np.ndarray, w2: np.ndarray) -> np.ndarray:
    """T+ (..., 6) in heave, with T+_21 = T+_12."""
    load = np.zeros((*(w1 + w2).shape, 6), dtype=complex)
    load[..., 2] = 3e4 * (w1 + w2) * np.exp(1j * (w1 * w2 + 0.7))
    return load


def with_qtf(headings: list[tuple[float, float]], frequency: np.ndarray = FREQUENCY) -> Box:
    """The box with QTFs for pairs of headings [rad]; its drift is the diagonal for waves to 0."""
    w1, w2 = frequency[:, None], frequency[None, :]
    box = box_at(np.arange(1, 111) * 0.02, np.arange(0.0, 360.0, 15.0))
    drift = np.zeros((box.frequency.size, box.heading.size, 6))
    for k, b in enumerate(box.heading):
        drift[:, k] = difference(box.frequency, box.frequency, b, b).real
    return replace(
        box,
        mean_drift=drift,
        qtf_frequency=frequency,
        qtf_heading=np.array(headings),
        qtf_difference=np.array([difference(w1, w2, *pair) for pair in headings]),
        qtf_sum=np.array([total(w1, w2) for _ in headings]),
    )
