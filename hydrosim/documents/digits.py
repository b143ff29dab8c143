"""Numbers in readable form."""

from __future__ import annotations


def digits_of(value: float, digits: int = 4) -> str:
    """A number with this many significant digits, without powers of ten where it is readable
    without."""
    if 10.0**digits <= abs(value) < 1e9:
        return f"{float(f'{value:.{digits - 1}e}'):,.0f}"
    return f"{value:.{digits}g}"
