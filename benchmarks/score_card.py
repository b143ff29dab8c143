"""What comes out of the cases of the thesis, over six seeds: the tables of their READMEs.

The base case and its model of one dimension, as they are and with the five things varied that the
thesis varies. Stage one of the latter, the barge without friction, is run once for each value.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import xarray as xr

import hydrosim as hs
from benchmarks.report import ROOT, Answer, Row

CASES = ROOT / "cases"
BASE = CASES / "reverse_float_over" / "base.yaml"
UNHINDERED = CASES / "reverse_float_over" / "no_friction.yaml"
FLAT = CASES / "one_dimensional" / "base.yaml"
SEEDS = range(1, 7)
TIMES = (600.0, 1000.0, 1500.0, 2000.0)
FRICTION, LIFT = "forces.interface.friction", "forces.deballast.force.heave"
LIFTED, HOURLY = 119_900e3, 20_000 * 9810.0  # N at 500 s, and in an hour
K2, C2 = 5.6e8, 3.3e7

Settings = Mapping[str, object]
CONTACT: Mapping[str, Mapping[str, Settings]] = {
    "C3": {f"{c:g}": {f"{FRICTION}.slip_damping": c} for c in (0.0, 1e6, 1e8, 1e10)},
    "K2": {
        f"{k:g}": {f"{FRICTION}.stiffness": k, f"{FRICTION}.damping": C2 * (k / K2) ** 0.5}
        for k in (5.6e6, 5.6e7, 5.6e8)
    },
    "friction": {
        f"{s}/{k}": {f"{FRICTION}.static": s, f"{FRICTION}.kinetic": k}
        for s, k in ((0.7, 0.4), (0.4, 0.2), (0.2, 0.1), (0.2, 0.04))
    },
}
LIFTS = {
    f"{rate * 20_000:g} t/h": {LIFT: [0.0, LIFTED, LIFTED + rate * HOURLY]}
    for rate in (0.5, 1.0, 2.5)
}
STIFFNESS = {f"{half * 20_000:g} t per 0.5 m": half * 40_000 * 9806.65 for half in (0.5, 1.0, 2.0)}


def answer() -> Answer:
    """Tables by case: seeds, and means over them of what is varied."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        return Answer(
            {
                "six degrees of freedom": [_row(seed, _whole(seed)) for seed in SEEDS],
                "six degrees of freedom, varied": list(_varied(folder, flat=False)),
                "one dimension": [_row(seed, _flat(folder, seed)) for seed in SEEDS],
                "one dimension, varied": list(_varied(folder, flat=True)),
            }
        )


def _varied(folder: Path, *, flat: bool) -> Iterator[Row]:
    def run(seed: int, own: Settings, before: Settings) -> xr.Dataset:
        return _flat(folder, seed, own, before) if flat else _whole(seed, {**own, **before})

    for what, values in CONTACT.items():
        for value, own in values.items():
            yield _mean(what, value, [run(seed, own, {}) for seed in SEEDS])
    for value, before in LIFTS.items():
        yield _mean("deballasting", value, [run(seed, {}, before) for seed in SEEDS])
    for value, stiffness in STIFFNESS.items():
        key = "forces.interface.normal"
        own = {f"{key}.prescribed.factor": stiffness / 4.0} if flat else {}
        before = {f"{key}.stiffness": stiffness}
        yield _mean("vertical stiffness", value, [run(seed, own, before) for seed in SEEDS])


def _whole(seed: int, settings: Settings = {}) -> xr.Dataset:  # noqa: B006  it is only read
    return hs.simulate(hs.load_case(BASE, {"environment.waves.seed": seed, **settings}))


def _flat(
    folder: Path,
    seed: int,
    own: Settings = {},  # noqa: B006
    before: Settings = {},  # noqa: B006
) -> xr.Dataset:
    """A run of one dimension, behind a first stage with the settings ``before``."""
    file = folder / f"{seed}_{abs(hash(repr(before)))}.nc"
    if not file.exists():
        settings = {"environment.waves.seed": seed, **before}
        hs.simulate(hs.load_case(UNHINDERED, settings)).to_netcdf(file)
    interface = "forces.interface.normal.prescribed"
    records = {}
    for key in ("forces.waves.force.surge", interface):
        records |= {f"{key}.file": str(file), f"{key}.case": None}
    return hs.simulate(hs.load_case(FLAT, {**records, **own}))


def _row(seed: int, run: xr.Dataset) -> Row:
    surge, contact = _surge(run), run.time[(_force(run) > 0.0)]
    moored = surge.sel(time=slice(200.0, 500.0)).mean()
    return {
        "seed": seed,
        "first contact [s]": f"{float(contact[0]):.1f}",
        "moored mean [m]": f"{float(moored):.2f}",
        **{f"at {t:g} s [m]": f"{float(surge.sel(time=t)):.2f}" for t in TIMES},
        **_friction(run),
        "stick after 1500 s [%]": f"{_stuck(run):.0f}",
    }


def _mean(what: str, value: str, runs: list[xr.Dataset]) -> Row:
    ends = [float(_surge(run).sel(time=TIMES[-1])) for run in runs]
    early = [float(_surge(run).sel(time=1000.0)) for run in runs]
    return {
        "what": what,
        "value": value,
        "at 1000 s [m]": f"{np.mean(early):.2f}",
        "at 2000 s [m]": f"{np.mean(ends):.2f}",
        "least [m]": f"{min(ends):.2f}",
        "most [m]": f"{max(ends):.2f}",
        "stick after 1500 s [%]": f"{np.mean([_stuck(run) for run in runs]):.0f}",
    }


def _friction(run: xr.Dataset) -> Row:
    """Mean friction in surge from 600 to 1000 s, moving with the waves and against them, and the
    mean forces of waves and fenders."""
    part = run.sel(time=slice(600.0, 1000.0), dof="surge")
    force, speed = part.force_interface.sum("body"), part.velocity.isel(body=0)
    return {
        "friction in +x [kN]": f"{float(force.where(speed > 0.0).mean()) / 1e3:.0f}",
        "friction in -x [kN]": f"{float(force.where(speed < 0.0).mean()) / 1e3:.0f}",
        "fenders' mean [kN]": f"{float(force.mean()) / 1e3:.0f}",
    }


def _stuck(run: xr.Dataset) -> float:
    """Share of the time after 1500 s in which points stick [%]."""
    mode = run.fender_mode.sel(time=slice(1500.0, None))
    names = str(run.fender_mode.attrs["flag_meanings"]).split()
    return 100.0 * float((mode == names.index("stick")).mean())


def _surge(run: xr.Dataset) -> xr.DataArray:
    return run.position.isel(body=0).sel(dof="surge")


def _force(run: xr.Dataset) -> xr.DataArray:
    return run.fender_normal_force.sum("fender")
