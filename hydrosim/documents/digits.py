"""Numbers as people read them."""

from __future__ import annotations


def digits_of(value: float, digits: int = 4) -> str:
    """A number to so many digits, without powers of ten where it reads well without."""
    if 10.0**digits <= abs(value) < 1e9:
        return f"{float(f'{value:.{digits - 1}e}'):,.0f}"
    return f"{value:.{digits}g}"
