"""The base case in six degrees of freedom with four fenders or one, and four pairs of friction.

The thesis has four fenders at x = +-20 m and one compression, and does not say which. It has
several pairs of friction, and does not say whether the normal force is that of all fenders or of
one. So this table is a spread over what is not stated, and chooses nothing.
"""

from __future__ import annotations

from cases.reverse_float_over.thesis.runs import BASE, FRICTION, Settings, base_figures, run_case

TABLE = "Six degrees of freedom: fenders and friction of the base case"

DECK = 7.5  # m above the centre of gravity
FENDERS: dict[str, Settings] = {
    "four fenders": {},
    **{
        f"one point at {x:+g} m": {"forces.interface.points": [[float(x), 0.0, DECK]]}
        for x in (-20, 0, 20)
    },
}
PAIRS = {"0.2/0.1": (0.2, 0.1), "0.7/0.4": (0.7, 0.4)}
SHARES = {"": 1.0, " of a quarter of N": 0.25}

VARIANTS = {
    f"{fenders}, {pair}{of}": {
        **points,
        f"{FRICTION}.static": share * static,
        f"{FRICTION}.kinetic": share * kinetic,
    }
    for fenders, points in FENDERS.items()
    for pair, (static, kinetic) in PAIRS.items()
    for of, share in SHARES.items()
}


def figures(variant: str, seed: int) -> dict[str, float]:
    """Figures of one run."""
    return base_figures(run_case(BASE, seed, VARIANTS[variant]))
