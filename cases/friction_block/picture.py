"""Runs the five laws on the block and draws what they make of it: `base.png`, and the figures."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import hydrosim as hs

HERE = Path(__file__).parent
CASES = ("exact", "slope_1e4", "slope_1e6", "slope_1e8", "slope_1e10")


def main() -> None:
    """Table on standard output, picture beside this file."""
    runs = {name: hs.simulate(hs.load_case(HERE / f"{name}.yaml")) for name in CASES}
    exact = runs["exact"].position.values[:, 0, 0]
    figure, (top, bottom) = plt.subplots(2, 1, sharex=True, figsize=(9, 7), layout="constrained")
    for name, run in runs.items():
        x, v = run.position.values[:, 0, 0], run.velocity.values[:, 0, 0]
        style = {"color": "black", "lw": 2.0} if name == "exact" else {"lw": 1.0}
        top.plot(run.time, x, label=_label(name), **style)
        bottom.plot(run.time, 1e3 * v, **style)
        off = np.abs(x - exact).max()
        print(f"{name:10s} end {x[-1]:9.5f} m, largest difference from exact {off:.2e} m")
    top.set(ylabel="position [m]", ylim=(-1.0, 6.0))
    bottom.set(xlabel="time [s]", ylabel="velocity [mm/s]", xlim=(0, 200), ylim=(-80, 120))
    figure.legend(loc="outside upper center", ncols=5)
    figure.savefig(HERE / "base.png", dpi=110)
    held = hs.simulate(hs.load_case(HERE / "held.yaml"))
    print(f"held: creep in an hour {np.abs(held.position.values).max():g} m")


def _label(name: str) -> str:
    return f"{name.replace('_', ' ')} N s/m" if name != "exact" else "exact law"


if __name__ == "__main__":
    main()
