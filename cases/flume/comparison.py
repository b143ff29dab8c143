"""How far is a floating section from its experiment in a wave flume?

Sundsdal, Greco, Hanssen and Lugni 2025 measured loads on a held section, and the motions of the
free one on a rig with springs and dry friction. Compared are first harmonics and means over whole
periods before waves come back. The runs of the cases have the same windows. Nothing is fitted. With
--keep tables and picture are written into the page of the case.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.evidence import with_block
from benchmarks.report import ROOT, Answer, Row, page_table
from hydrosim import load_case, simulate
from hydrosim.database import load
from tests.validation_data import unpacked

FOLDER = Path(__file__).parent
PAGE = FOLDER / "README.md"
DATABASE = ROOT / "hydro_db" / "flume_section.nc"
BEGIN, END = "<!-- tables: python -m benchmarks --keep flume -->", "<!-- end of tables -->"
MODEL_PLACE = 7.0  # m from the wave maker
WAY_BACK = 12.0  # m that a wave goes until it is back at the model, by the experiment's table
RAMP_PERIODS = 5
AMPLITUDE: Mapping[int, float] = {1: 0.0119, 2: 0.0198}
"""Wave amplitudes [m], measured without the model, by the index of the height."""
SPRINGS = 59.72  # N/m, mean of four offset tests
FRICTION = (0.20, 0.35, 0.50)  # N: least, middle and most to begin to slide
ACCELEROMETERS_APART = 0.2599  # m
PERIODS: Mapping[str, float] = {"heave": 1.17, "roll": 1.26, "roll, sway held": 1.28, "sway": 7.50}
"""Periods of decay tests [s]."""
DECAYS: Mapping[str, tuple[int, dict[str, object]]] = {
    "heave": (1, {"joints.heave.initial": {"offset": "0.02 m"}}),
    "roll": (2, {"joints.roll.initial": {"angle": "5 deg"}}),
    "roll, sway held": (
        2,
        {"joints.roll.initial": {"angle": "5 deg"}, "joints.sway.stiffness": "100 kN/m"},
    ),
    "sway": (0, {"joints.sway.initial": {"offset": "0.1 m"}, "duration": "20 s"}),
}
"""Coordinate that swings, and the keys of its decay."""
HALF_SWINGS = 4  # that a period is the mean of


class Band(NamedTuple):
    """Smallest and largest of several measurements."""

    low: float
    high: float

    @classmethod
    def of(cls, values: Iterable[float]) -> Band:
        """Band of those ``values`` that are numbers."""
        found = [value for value in values if np.isfinite(value)]
        return cls(min(found), max(found))

    def distance(self, value: float) -> float:
        """How far outside, of the nearer bound; 0 within."""
        if value > self.high:
            return value / self.high - 1.0
        return min(0.0, value / self.low - 1.0) if self.low > 0.0 else 0.0


class FixedLoads(NamedTuple):
    """The held section at a frequency [rad/s]: per amplitude [kN/m] or its square [kN/m^2], each
    as (mean of heights; lowest and highest of all records and halves of windows) measured, and as
    hydrosim has it."""

    frequency: float
    records: int
    measured: np.ndarray  # (sway, heave, drift) x (mean, lowest, highest)
    computed: np.ndarray  # (sway, heave, drift)

    def errors(self) -> np.ndarray:
        """Of the measured means (3,)."""
        return np.asarray(self.computed / self.measured[:, 0] - 1.0)


class FreeMotions(NamedTuple):
    """The free section in one wave: bands over instruments and repeats, and hydrosim's values with
    the least, the middle and the largest friction (3 each)."""

    frequency: float
    height: int
    records: int
    heave: Band  # m
    roll: Band  # rad
    force: Band  # N, mean
    sway: Band  # m, mean
    computed: Mapping[str, np.ndarray]

    def distances(self, name: str) -> np.ndarray:
        """How far the values of a quantity are outside of its band (3,)."""
        return np.array([getattr(self, name).distance(value) for value in self.computed[name]])


def answer() -> Answer:
    """Tables and picture."""
    fixed, free, periods = fixed_loads(), free_motions(), natural_periods()
    blocks = [_fixed_page(fixed), _free_page(free), _period_page(periods)]
    kept = {PAGE: with_block(PAGE.read_text("utf-8"), "\n\n".join(blocks), BEGIN, END)}
    tables = {
        "Held section": [_fixed_row(each) for each in fixed],
        "Free section": [_free_row(each) for each in free],
        "Decay tests": [_period_row(name, period) for name, period in periods.items()],
    }
    return Answer(tables, remarks(fixed, free), picture(fixed, free), kept, FOLDER / "flume.png")


def remarks(fixed: list[FixedLoads], free: list[FreeMotions]) -> list[str]:
    """The figures that the page and the README name."""
    sway, heave, _ = rms_errors(fixed)
    drift = drift_errors(fixed)
    return [
        f"held, 4.1 to 8.6 rad/s: sway {sway:.1%} rms, heave {heave:.1%} rms",
        f"drift of the held section, 5.8 to 8 rad/s: {drift.min():+.1%} to {drift.max():+.1%}",
        *(
            f"{each.frequency:.2f} rad/s, height {each.height}, outside: "
            + ", ".join(f"{name} {each.distances(name)[1]:+.1%}" for name in each.computed)
            for each in free
        ),
    ]


def rms_errors(fixed: list[FixedLoads]) -> np.ndarray:
    """Root mean squares of the errors of sway and heave load and of drift (3,) up to 8.6 rad/s."""
    errors = np.array([each.errors() for each in fixed if each.frequency < 8.6])
    return np.asarray(np.sqrt(np.mean(errors**2, axis=0)))


def drift_errors(fixed: list[FixedLoads]) -> np.ndarray:
    """Errors of the drift from 5.8 to 8 rad/s."""
    return np.array([each.errors()[2] for each in fixed if 5.8 < each.frequency < 8.0])


def records(name: str) -> xr.Dataset:
    """Records of the ``fixed`` or of the ``free`` section."""
    with xr.open_dataset(unpacked(f"flume/{name}.nc")) as dataset:
        return dataset.load()


def window(record: xr.Dataset) -> tuple[float, int]:
    """End of the window [s after the wave maker started], and the number of whole periods before
    it: from the end of the ramp until waves are back."""
    period, speed = float(record.period), float(record.group_velocity)
    periods = int((WAY_BACK / speed - RAMP_PERIODS * period) / period)
    return (MODEL_PLACE + WAY_BACK) / speed, max(1, periods)


def harmonic(
    time: np.ndarray, values: np.ndarray, period: float, end: float, periods: int
) -> tuple[float, complex]:
    """Mean, and first harmonic as a complex amplitude, over whole periods up to ``end`` [s]."""
    chosen = (time >= end - periods * period) & (time < end)
    angle = 2.0 * np.pi / period * time[chosen]
    columns = np.column_stack([np.ones(angle.size), np.cos(angle), np.sin(angle)])
    mean, cosine, sine = np.linalg.lstsq(columns, values[chosen], rcond=None)[0]
    return float(mean), complex(cosine, -sine)


def measured_harmonic(record: xr.Dataset, channel: str) -> tuple[float, complex]:
    """Of a channel over the window, as `channel_harmonic`."""
    return channel_harmonic(record, channel, *window(record))


def channel_harmonic(
    record: xr.Dataset, channel: str, end: float, periods: int
) -> tuple[float, complex]:
    """Mean and first harmonic of a channel, with its mean before the waves as zero; not a number if
    the channel did not change."""
    known = np.isfinite(record.time.values)
    time = record.time.values[known].astype(float)
    values = record[channel].values[known].astype(float)
    if np.ptp(values[time > 0.0]) == 0.0:
        return np.nan, complex(np.nan, np.nan)
    values = values - values[time < 0.0].mean()
    return harmonic(time, values, float(record.period), end, periods)


def halves(record: xr.Dataset) -> list[tuple[float, int]]:
    """Both halves of the window; the window itself if it has one period."""
    end, periods = window(record)
    if periods == 1:
        return [(end, 1)]
    half = periods // 2
    return [(end - half * float(record.period), half), (end, half)]


@cache
def fixed_loads() -> list[FixedLoads]:
    """The held section at all measured frequencies."""
    dataset = records("fixed")
    return [_fixed_at(dataset, period) for period in sorted(set(dataset.period.values))[::-1]]


def _fixed_at(dataset: xr.Dataset, period: float) -> FixedLoads:
    rows = np.flatnonzero(dataset.period.values == period)
    by_height: dict[int, list[list[float]]] = {}
    every: list[list[float]] = []
    for row in rows:
        record = dataset.isel(run=row)
        height = int(record.wave_height_index)
        loads = _measured_loads(record, AMPLITUDE[height], *window(record))
        by_height.setdefault(height, []).append(loads)
        parts = [window(record), *halves(record)]
        every += [_measured_loads(record, AMPLITUDE[height], *part) for part in parts]
    means = np.mean([np.mean(values, axis=0) for values in by_height.values()], axis=0)
    bounds = np.min(every, axis=0), np.max(every, axis=0)
    measured = np.stack([means, *bounds], axis=1)
    speed = float(dataset.group_velocity.values[rows[0]])
    return FixedLoads(2.0 * np.pi / period, len(rows), measured, _computed_loads(period, speed))


def _measured_loads(record: xr.Dataset, amplitude: float, end: float, periods: int) -> list[float]:
    drift, sway = channel_harmonic(record, "Fy", end, periods)
    _, heave = channel_harmonic(record, "Fz", end, periods)
    values = [abs(sway) / amplitude, abs(heave) / amplitude, drift / amplitude**2]
    return [value / 1000.0 for value in values]


def _computed_loads(period: float, speed: float) -> np.ndarray:
    """Loads of a run of the held section, and the drift of its database, as `FixedLoads`."""
    amplitude = AMPLITUDE[2]
    run = simulate(load_case(FOLDER / "fixed.yaml", _wave(period, speed, amplitude)))
    load_on_transducer = run.joint_force.sel(joint="transducer")
    end, periods = float(run.time[-1]), _periods(period, speed)
    amplitudes = [
        abs(
            harmonic(run.time.values, load_on_transducer.sel(dof=dof).values, period, end, periods)[
                1
            ]
        )
        for dof in ("sway", "heave")
    ]
    database = load(DATABASE)
    assert database.mean_drift_held is not None
    held = database.mean_drift_held[:, 0, 1]
    drift = np.interp(2.0 * np.pi / period, database.frequency, held)
    return np.array([*(value / amplitude for value in amplitudes), drift]) / 1000.0


def _periods(period: float, speed: float) -> int:
    return max(1, int((WAY_BACK / speed - RAMP_PERIODS * period) / period))


def _wave(period: float, speed: float, amplitude: float) -> dict[str, object]:
    """Keys of a case for a wave that begins at the model at t = 0, until it is back."""
    wave = {"amplitude": amplitude, "period": period, "ramp": RAMP_PERIODS * period}
    duration = round(WAY_BACK / speed, 2)
    return {"duration": duration} | {f"environment.waves.{key}": x for key, x in wave.items()}


@cache
def free_motions() -> list[FreeMotions]:
    """The free section in all measured waves."""
    dataset = records("free")
    waves = sorted(set(zip(-dataset.period.values, dataset.wave_height_index.values, strict=True)))
    return [_free_in(dataset, -period, int(height)) for period, height in waves]


def _free_in(dataset: xr.Dataset, period: float, height: int) -> FreeMotions:
    same = (dataset.period.values == period) & (dataset.wave_height_index.values == height)
    chosen = [dataset.isel(run=row) for row in np.flatnonzero(same)]
    measured = [_measured_motions(record) for record in chosen]
    bands = {name: Band.of(x for each in measured for x in each[name]) for name in measured[0]}
    speed = float(chosen[0].group_velocity)
    runs = [computed_motions(period, speed, AMPLITUDE[height], friction) for friction in FRICTION]
    computed = {name: np.array([run[name] for run in runs]) for name in bands}
    return FreeMotions(2.0 * np.pi / period, height, len(chosen), **bands, computed=computed)


def _measured_motions(record: xr.Dataset) -> dict[str, list[float]]:
    """By all instruments: amplitudes by camera and by accelerometers; the mean force of both
    springs by camera and stiffness, by their tensions, and by the strain gauge of the rail; the
    mean sway by camera and by the tensions."""
    squared = (2.0 * np.pi / float(record.period)) ** 2
    starboard, port = (
        measured_harmonic(record, name)[1] for name in ("ACC_Heave_SB", "ACC_HEAVE_PS")
    )
    sway, _ = measured_harmonic(record, "Sway")
    tensions = [measured_harmonic(record, f"Tension_{side}")[0] for side in ("SB", "PS")]
    pull = tensions[0] - tensions[1]
    gauge, _ = measured_harmonic(record, "Force_Sway")
    return {
        "heave": [abs(measured_harmonic(record, "Heave")[1]), abs(starboard + port) / 2 / squared],
        "roll": [
            abs(measured_harmonic(record, "Roll")[1]),
            abs(starboard - port) / ACCELEROMETERS_APART / squared,
        ],
        "force": [SPRINGS * sway, pull, -gauge],
        "sway": [sway, pull / SPRINGS],
    }


def computed_motions(
    period: float, speed: float, amplitude: float, friction: float
) -> dict[str, float]:
    """Amplitudes of heave and roll, mean force of the springs, and mean sway, of a run."""
    keys = _wave(period, speed, amplitude) | {"joints.sway.friction.static_force": friction}
    run = simulate(load_case(FOLDER / "free.yaml", keys))
    end, periods = float(run.time[-1]), _periods(period, speed)
    sway, heave, roll = (
        harmonic(run.time.values, values, period, end, periods)
        for values in run.joint_position.values.T
    )
    mean = sway[0]
    return {"heave": abs(heave[1]), "roll": abs(roll[1]), "force": SPRINGS * mean, "sway": mean}


@cache
def natural_periods() -> Mapping[str, float]:
    """Periods of decays of the free section [s], as those of the experiment."""
    return {name: _decay_period(*DECAYS[name]) for name in PERIODS}


def _decay_period(coordinate: int, keys: dict[str, object]) -> float:
    """Mean of the first half swings, times two."""
    run = simulate(load_case(FOLDER / "decay.yaml", {"joints.roll.initial": None} | keys))
    time, values = run.time.values, run.joint_position.values[:, coordinate]
    before = np.flatnonzero(values[:-1] * values[1:] < 0.0)[: HALF_SWINGS + 1]
    step = time[before + 1] - time[before]
    crossings = time[before] - values[before] * step / (values[before + 1] - values[before])
    return float(2.0 * np.diff(crossings).mean())


def _fixed_row(each: FixedLoads) -> Row:
    row: dict[str, str | float] = {"w [rad/s]": each.frequency, "records": each.records}
    for name, measured, value in zip(QUANTITIES, each.measured, each.computed, strict=True):
        row |= {f"{name} measured": measured[0], f"{name} hydrosim": value}
    return row


QUANTITIES = ("sway load [kN/m]", "heave load [kN/m]", "drift [kN/m²]")
MOTIONS: Mapping[str, tuple[str, float, str]] = {
    "heave": ("heave [mm]", 1e3, "{:.1f}"),
    "roll": ("roll [deg]", 180.0 / np.pi, "{:.2f}"),
    "force": ("mean force [N]", 1.0, "{:.3f}"),
    "sway": ("mean sway [mm]", 1e3, "{:.1f}"),
}
"""Label, factor and form of what is measured of the free section."""


def _free_row(each: FreeMotions) -> Row:
    row: dict[str, str | float] = {"w [rad/s]": each.frequency, "height": each.height}
    for name, (label, factor, form) in MOTIONS.items():
        band = getattr(each, name)
        row[f"{label} measured"] = _span(band, factor, form)
        row[f"{label} hydrosim"] = float(each.computed[name][1] * factor)
    return row


def _period_row(name: str, period: float) -> Row:
    return {"decay": name, "measured [s]": PERIODS[name], "hydrosim [s]": period}


def _span(band: Band, factor: float, form: str) -> str:
    return f"{form.format(factor * band.low)} to {form.format(factor * band.high)}"


def _fixed_page(fixed: list[FixedLoads]) -> str:
    head = ("ω [rad/s]", "records", *QUANTITIES)
    rows = []
    for each in fixed:
        cells = [_fixed_cell(m, e) for m, e in zip(each.measured, each.errors(), strict=True)]
        rows.append((f"{each.frequency:.2f}", str(each.records), *cells))
    return page_table(head, rows)


def _fixed_cell(measured: np.ndarray, error: float) -> str:
    mean, low, high = measured
    return f"{mean:.3g} ({low:.3g} to {high:.3g}): {100.0 * error:+.1f} %"


def _free_page(free: list[FreeMotions]) -> str:
    head = ("ω [rad/s]", "waves [mm]", "records", *(label for label, _, _ in MOTIONS.values()))
    rows = []
    for each in free:
        cells = [_free_cell(each, name) for name in MOTIONS]
        wave = f"{1e3 * AMPLITUDE[each.height]:.1f}"
        rows.append((f"{each.frequency:.2f}", wave, str(each.records), *cells))
    return page_table(head, rows)


def _free_cell(each: FreeMotions, name: str) -> str:
    _, factor, form = MOTIONS[name]
    value, distance = each.computed[name][1], each.distances(name)[1]
    outside = "within" if distance == 0.0 else f"{100.0 * distance:+.1f} %"
    return f"{_span(getattr(each, name), factor, form)}: {form.format(factor * value)}, {outside}"


def _period_page(periods: Mapping[str, float]) -> str:
    rows = [
        (
            name,
            f"{PERIODS[name]:.2f}",
            f"{period:.3f}",
            f"{100 * (period / PERIODS[name] - 1):+.1f} %",
        )
        for name, period in periods.items()
    ]
    return page_table(("decay", "measured [s]", "hydrosim [s]", "error"), rows)


def picture(fixed: list[FixedLoads], free: list[FreeMotions]) -> Figure:
    """The held section in the upper row, the free one in the lower row."""
    figure = Figure((12.0, 7.2), dpi=100, layout="constrained")
    axes = figure.subplots(2, 3)
    titles = ("Held: sway load", "Held: heave load", "Held: mean drift force")
    units = ("per wave amplitude [kN/m]", "per wave amplitude [kN/m]", "per amplitude² [kN/m²]")
    for k, axis in enumerate(axes[0]):
        _draw_fixed(axis, fixed, k)
        axis.set(title=titles[k], ylabel=units[k])
    names = {"heave": "Free: heave", "roll": "Free: roll", "force": "Free: mean force of springs"}
    labels = ("per wave amplitude [m/m]", "per wave amplitude [deg/cm]", "per amplitude² [kN/m²]")
    for axis, (name, title), label in zip(axes[1], names.items(), labels, strict=True):
        _draw_free(axis, free, name)
        axis.set(title=title, ylabel=label)
    for axis in axes.flat:
        axis.set(xlabel="wave frequency [rad/s]", xlim=(3.9, 10.2))
        axis.grid(alpha=0.3)
        axis.spines[["top", "right"]].set_visible(False)
    axes[0, 0].legend(fontsize="small", frameon=False)
    axes[1, 0].legend(fontsize="small", frameon=False)
    return figure


def _draw_fixed(axis: Axes, fixed: list[FixedLoads], k: int) -> None:
    frequencies = [each.frequency for each in fixed]
    measured = np.array([each.measured[k] for each in fixed])
    bars = np.abs(measured[:, 1:] - measured[:, :1]).T
    axis.errorbar(
        frequencies, measured[:, 0], bars, fmt="o", color="k", ms=4, capsize=3,
        label="measured: mean; repeats, halves of windows",
    )  # fmt: skip
    computed = [each.computed[k] for each in fixed]
    axis.plot(frequencies, computed, "-", color="#0072B2", label="hydrosim")
    axis.set_ylim(bottom=0.0)


PER_AMPLITUDE: Mapping[str, tuple[float, int]] = {
    "heave": (1.0, 1),
    "roll": (180.0 / np.pi / 100.0, 1),
    "force": (1e-3, 2),
}
"""Factor of the picture, and the power of the amplitude that a quantity is divided by."""
SHIFT: Mapping[int, float] = {1: -0.04, 2: 0.04}  # rad/s, so that both heights are seen
LOOKS: Mapping[int, tuple[str, str]] = {1: ("k", "o"), 2: ("#D55E00", "s")}


def _draw_free(axis: Axes, free: list[FreeMotions], name: str) -> None:
    for height, (colour, marker) in LOOKS.items():
        chosen = [each for each in free if each.height == height]
        factor, power = PER_AMPLITUDE[name]
        factor = factor / AMPLITUDE[height] ** power
        places = [each.frequency + SHIFT[height] for each in chosen]
        low, high = factor * np.array([getattr(each, name) for each in chosen]).T
        middle, half = (low + high) / 2, (high - low) / 2
        label = f"measured, all instruments, {1e3 * AMPLITUDE[height]:.1f} mm"
        axis.errorbar(places, middle, half, fmt="none", color=colour, capsize=4, label=label)
        least, value, most = factor * np.array([each.computed[name] for each in chosen]).T
        spread = np.abs([value - np.minimum(least, most), np.maximum(least, most) - value])
        label = f"hydrosim, friction 0.2 to 0.5 N, {1e3 * AMPLITUDE[height]:.1f} mm"
        axis.errorbar(
            places, value, spread, fmt=marker, color=colour, mfc="white", ms=5, label=label
        )
