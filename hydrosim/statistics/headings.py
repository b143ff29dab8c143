"""Headings of limits, and those to the other side of a scene that is its own mirror image."""

from __future__ import annotations

import numpy as np
import xarray as xr

MIRRORED_ATTRIBUTE = "mirrored"
"""Attribute: the headings [rad] whose limits are those to the other side."""
MIRROR_REASON = "mirror"  # attribute: why limits are mirrored, or why not, in words
FULL_TURN = 2.0 * np.pi
SAME_HEADING_RAD = 1e-6  # rad


def without_images(found: xr.Dataset) -> xr.Dataset:
    """The limits without those to the other side."""
    images = np.atleast_1d(found.attrs.get(MIRRORED_ATTRIBUTE, []))
    own = [k for k, at in enumerate(found.heading.values) if not np.any(images == at)]
    return found.isel(heading=own)


def image_of(heading: float, found: xr.Dataset) -> float | None:
    """The heading [rad] to the other side whose limits are those of this one."""
    for at in np.atleast_1d(found.attrs.get(MIRRORED_ATTRIBUTE, [])):
        if _heading_difference(float(at), -heading) < SAME_HEADING_RAD:
            return float(at)
    return None


def images_of(headings: np.ndarray) -> list[tuple[float, float]]:
    """Headings, and those to their other sides that are not among them, within one turn."""
    first = float(headings[0])
    found = []
    for heading in headings.tolist():
        if all(
            _heading_difference(-heading, other) > SAME_HEADING_RAD for other in headings.tolist()
        ):
            found.append((heading, first + (-heading - first) % FULL_TURN))
    return found


def _heading_difference(one: float, other: float) -> float:
    """How far two directions are apart [rad]."""
    return abs((one - other + np.pi) % FULL_TURN - np.pi)
