"""Headings of limits, and those to the other side of a scene that is its own mirror image."""

from __future__ import annotations

import numpy as np
import xarray as xr

MIRRORED = "mirrored"  # attribute: the headings [rad] whose limits are those to the other side
SAID = "mirror"  # attribute: why limits are mirrored, or why not, in words
TURN = 2.0 * np.pi
NEAR = 1e-6  # rad


def without_images(found: xr.Dataset) -> xr.Dataset:
    """The limits without those to the other side."""
    images = np.atleast_1d(found.attrs.get(MIRRORED, []))
    own = [k for k, at in enumerate(found.heading.values) if not np.any(images == at)]
    return found.isel(heading=own)


def image_of(heading: float, found: xr.Dataset) -> float | None:
    """The heading [rad] to the other side whose limits are those of this one."""
    for at in np.atleast_1d(found.attrs.get(MIRRORED, [])):
        if _apart(float(at), -heading) < NEAR:
            return float(at)
    return None


def images_of(headings: np.ndarray) -> list[tuple[float, float]]:
    """Headings, and those to their other sides that are not among them, within one turn."""
    first = float(headings[0])
    found = []
    for heading in headings.tolist():
        if all(_apart(-heading, other) > NEAR for other in headings.tolist()):
            found.append((heading, first + (-heading - first) % TURN))
    return found


def _apart(one: float, other: float) -> float:
    """How far two directions are apart [rad]."""
    return abs((one - other + np.pi) % TURN - np.pi)
