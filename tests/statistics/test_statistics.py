"""Statistics of records whose figures are known; what is said of those that have no extremes."""

import re
from typing import Any

import numpy as np
import pytest
import xarray as xr
from random_records import KINDS
from reading import ends, number, row, rows, texts

from hydrosim.dofs import DOFS
from hydrosim.elements.contact.law import OPEN, SLIP, STICK
from hydrosim.files.document import Document
from hydrosim.files.document_nodes import Node
from hydrosim.files.series import unit_of
from hydrosim.report.sentences.statistics import contact_nodes, figures, nodes_over_seeds
from hydrosim.results.phases import contact_phases
from hydrosim.statistics.extremes import LAWS, ExtremeModel
from hydrosim.statistics.gumbel import fit_maxima
from hydrosim.statistics.over_seeds import GUMBEL_METHOD, MIN_RUNS
from hydrosim.statistics.statistics import statistics

TIME = np.arange(0.0, 2000.0, 0.5)


def record(time: np.ndarray = TIME, ramp: float = 0.0, **motions: np.ndarray) -> xr.Dataset:
    """A run with these motions, in waves of like frequencies, and nothing else."""
    position = np.zeros((time.size, 1, 6))
    for dof, x in motions.items():
        position[:, 0, DOFS.index(dof)] = x
    return xr.Dataset(
        {
            "position": (("time", "body", "dof"), position),
            "wave_elevation": ("time", waves(99, time)),
        },
        coords={"time": time, "body": ["barge"], "dof": list(DOFS)},
        attrs={"title": "known", "wave_ramp": ramp},
    )


def with_contact(run: xr.Dataset, modes: np.ndarray, force: np.ndarray) -> xr.Dataset:
    """The run with one fender in these modes."""
    time = run.time.values
    return run.assign(
        fender_mode=(("time", "fender"), modes[:, None], {"flag_meanings": "open stick slip"}),
        fender_slip_distance=(("time", "fender"), 0.01 * np.cumsum(modes == SLIP)[:, None]),
        fender_normal_force=(("time", "fender"), force[:, None]),
        contact_phase=(("time", "contact_group"), contact_phases(time, modes[:, None])[:, None]),
    ).assign_coords(fender=["interface 1"], contact_group=["interface"])


def waves(seed: int = 1, time: np.ndarray = TIME) -> np.ndarray:
    """So much of a record of a Gaussian wave motion."""
    return KINDS["Gaussian wave motion"].draw(np.random.default_rng(seed))[: time.size]


def of(run: xr.Dataset, dof: str, **options: Any) -> dict[str, float]:
    found = statistics(run, **options).motion.sel(body="barge", dof=dof)
    return {str(name): float(found.sel(statistic=name)) for name in found.statistic.values}


def basis(found: xr.Dataset, dof: str, side: str = "largest") -> ExtremeModel:
    return ExtremeModel(int(found.motion_basis.sel(body="barge", dof=dof, side=side)))


def nodes(found: xr.Dataset) -> list[Node]:
    """What is said of statistics."""
    return [*figures(found), *contact_nodes(found)]


def text_of(found: xr.Dataset) -> str:
    return str(Document("known", nodes(found)))


def test_sine() -> None:
    """A hundred periods of 20 s about 3 m."""
    found = of(record(heave=3.0 + 2.0 * np.sin(2 * np.pi * TIME / 20.0)), "heave")
    assert found["mean"] == pytest.approx(3.0, abs=1e-12)
    assert found["std"] == pytest.approx(np.sqrt(2.0), rel=1e-12)
    assert found["significant"] == pytest.approx(4.0 * np.sqrt(2.0), rel=1e-12)
    assert found["period"] == pytest.approx(20.0, rel=1e-9)
    assert (found["smallest"], found["largest"]) == pytest.approx((1.0, 5.0))


def test_moments_of_known_laws() -> None:
    """A sine has a kurtosis of 3/2, its square a skewness of 0, an exponential record 2 and 9."""
    found = of(record(heave=np.sin(2 * np.pi * TIME / 20.0)), "heave")
    assert (found["skewness"], found["kurtosis"]) == pytest.approx((0.0, 1.5), abs=1e-9)
    quantiles = -np.log(1.0 - (np.arange(TIME.size) + 0.5) / TIME.size)
    found = of(record(heave=quantiles), "heave")
    assert (found["skewness"], found["kurtosis"]) == pytest.approx((2.0, 9.0), rel=0.05)
    assert np.isnan(of(record(), "sway")["kurtosis"])


def test_channels_that_are_asked_for() -> None:
    """The same figures as those of the motion that a channel is, also by phase."""
    x = waves()
    modes = np.where(TIME < 1000.0, OPEN, STICK)
    run = with_contact(record(heave=x), modes, 1e6 * (modes == STICK))
    run = run.assign_coords(fender_group=("fender", ["interface"]))
    run.position.attrs["dof_units"] = "m, m, m, rad, rad, rad"
    found = statistics(run, channels=["position.barge.heave", "fender_normal_force.interface"])
    same = found.motion.sel(body="barge", dof="heave")
    np.testing.assert_array_equal(found.named.sel(channel="position.barge.heave"), same)
    after = found.named_phase.sel(contact_group="interface", phase="stuck")
    assert float(after.sel(channel="position.barge.heave", statistic="mean")) == pytest.approx(
        x[TIME >= 1000.0].mean()
    )
    assert float(after.sel(channel="fender_normal_force.interface", statistic="mean")) == 1e6
    assert np.isnan(found.named_phase.sel(phase="compressed")).all()
    moments = row(nodes(found), "channel", "mean", of=["position.barge.heave"])
    assert number(moments["mean"], "m") == x.mean()
    assert "barge heave" not in text_of(found)  # that is the same channel
    stuck = ["position.barge.heave", "interface", "stuck"]
    phase = row(nodes(found), "channel", "group", "phase", of=stuck)
    assert number(phase["mean"], "m") == pytest.approx(x[TIME >= 1000.0].mean())
    assert "nan" not in text_of(found)


def test_each_statistic_has_its_unit() -> None:
    run = record(heave=np.sin(TIME), pitch=np.cos(TIME))
    run.position.attrs["dof_units"] = "m, m, m, rad, rad, rad"
    found = statistics(run, channels=["position.barge.pitch"])
    each = {"heave": "m", "pitch": "rad"}
    for dof, unit in each.items():
        for name in found.statistic.values:
            own = {"period": "s", "skewness": "1", "kurtosis": "1", "peak_shape": "1"}
            assert unit_of(found.motion.attrs, ["barge", dof, name]) == own.get(name, unit)
        assert unit_of(found.motion_extreme.attrs, ["barge", dof, "mpm"]) == unit
        squared = {"m": "m^2 s/rad", "rad": "rad s"}[unit]
        assert unit_of(found.motion_spectrum.attrs, ["barge", dof]) == squared
    assert "units" not in found.named.attrs
    assert found.named.unit.values == ["rad"]
    old = {"units": "m, rad or s"}  # of files of earlier versions
    assert [unit_of(old, [dof, "mean"]) for dof in each] == ["m", "rad"]


def test_what_is_before_the_start_does_not_count() -> None:
    x = np.where(TIME < 500.0, 100.0, np.sin(TIME))
    found = of(record(surge=x), "surge", start=500.0)
    assert found["largest"] < 1.01
    assert of(record(surge=x), "surge")["largest"] == 100.0


def test_a_regular_motion_has_its_amplitude_for_extremes() -> None:
    found = statistics(record(heave=3.0 + 2.0 * np.sin(2 * np.pi * TIME / 20.0)))
    assert basis(found, "heave") == ExtremeModel.REGULAR
    extreme = found.motion_extreme.sel(body="barge", dof="heave")
    np.testing.assert_allclose(extreme.sel(side="largest"), 5.0)
    np.testing.assert_allclose(extreme.sel(side="smallest"), 1.0)


class TestWithoutExtremes:
    """Each is told for what it is, with no number and no "nan"."""

    @staticmethod
    def said(run: xr.Dataset, **options: Any) -> str:
        found = statistics(run, **options)
        assert "nan" not in text_of(found)
        return "\n".join(texts(nodes(found)))

    def test_few_waves(self) -> None:
        x = np.sin(2 * np.pi * TIME / 200.0)
        assert basis(statistics(record(sway=x)), "sway") == ExtremeModel.TOO_SHORT
        assert "too short" in self.said(record(sway=x))

    def test_no_period(self) -> None:
        moments = row(nodes(statistics(record(surge=TIME))), "channel", "mean", of=["barge surge"])
        assert np.isnan(number(moments["period"], "s"))
        assert number(moments["mean"], "m") == TIME.mean()
        self.said(record(surge=TIME))

    def test_constant_channels_are_not_printed(self) -> None:
        found = statistics(record(surge=waves(), sway=0.0 * TIME + 3.0))
        assert basis(found, "sway") == basis(found, "yaw") == ExtremeModel.CONSTANT
        assert "sway" not in text_of(found)

    def test_one_peak(self) -> None:
        self.said(record(heave=np.exp(-(((TIME - 1000.0) / 5.0) ** 2))))

    def test_growing_waves(self) -> None:
        run = record(heave=waves() * np.minimum(TIME / 200.0, 1.0), ramp=200.0)
        assert basis(statistics(run), "heave") == ExtremeModel.WAVES_GROW
        assert "the waves grow until 200 s. Start there (--from 200)." in self.said(run)
        assert basis(statistics(run, 200.0), "heave") == ExtremeModel.GAUSSIAN

    def test_a_run_that_ends_while_the_waves_grow(self) -> None:
        self.said(record(heave=waves() * TIME / 2000.0, ramp=5000.0))

    def test_a_lift(self) -> None:
        text = self.said(record(heave=0.1 * waves() + TIME / 2000.0))
        found = re.search(r"the mean goes from (\S+) m to (\S+) m", text)
        assert found is not None
        assert (float(found[1]), float(found[2])) == pytest.approx((0.1, 0.9), abs=0.03)

    def test_waves_that_grow_over_the_whole_record(self) -> None:
        text = self.said(record(heave=waves() * (1.0 + 2.0 * TIME / 2000.0)))
        assert "the standard deviation goes from" in text

    def test_an_operation(self) -> None:
        """Pitch itself is stationary; but contact begins at half the time, and heave is lifted."""
        touching = TIME > 1000.0
        moving = {"pitch": waves(), "heave": waves(2) + 4.0 * touching}
        run = with_contact(record(**moving), np.where(touching, STICK, OPEN), 1e6 * touching)
        assert basis(statistics(record(**moving)), "pitch") == ExtremeModel.GAUSSIAN
        assert basis(statistics(run), "pitch") == ExtremeModel.OPERATION
        assert np.isnan(statistics(run).motion_extreme.sel(dof="pitch")).all()
        assert "contact goes through phases" in self.said(run)

    def test_a_fender_that_is_touched_late_is_no_operation(self) -> None:
        """If nothing changes: contact is rare, and that is said of its force."""
        x = waves()
        force = np.maximum(x - np.sort(x)[-20], 0.0)
        force[: TIME.size // 3] = 0.0
        run = with_contact(record(pitch=x), np.where(force > 0.0, SLIP, OPEN), force)
        found = statistics(run)
        assert basis(found, "pitch") == ExtremeModel.GAUSSIAN
        assert found.fender_force_basis.sel(side="largest") in (
            ExtremeModel.RARE,
            ExtremeModel.TOO_SHORT,
        )
        self.said(run)

    def test_not_finite(self) -> None:
        x = waves().copy()
        x[-1] = np.nan
        assert basis(statistics(record(heave=x)), "heave") == ExtremeModel.NOT_FINITE
        assert "barge heave: It is not finite." in texts(nodes(statistics(record(heave=x))))

    @pytest.mark.parametrize("count", [4, 5, 30, 200])
    def test_short_records(self, count: int) -> None:
        time = TIME[:count]
        self.said(record(time, heave=waves(time=time), pitch=np.sin(time)))

    def test_all_zero(self) -> None:
        (moments,) = rows(nodes(statistics(record())), "channel", "mean")
        assert moments["channel"] == "wave elevation"


def test_whole_seconds_and_a_last_record_off_the_grid() -> None:
    """Times may be whole numbers; the end of a run is recorded wherever it is."""
    time = np.arange(3000)
    run = record(time, heave=waves(time=time))
    assert basis(statistics(run), "heave") == ExtremeModel.GAUSSIAN
    odd = run.assign_coords(time=np.append(time[:-1], time[-2] + 0.3))
    assert statistics(odd).attrs["exposure"] == 2999.0
    assert of(odd, "heave")["period"] == pytest.approx(of(run, "heave")["period"], rel=1e-3)


def test_smallest_is_the_largest_mirrored() -> None:
    x = KINDS["slow drift, damping 0.2"].draw(np.random.default_rng(4))
    time = np.arange(x.size, dtype=float)
    up, down = (statistics(record(time, surge=sign * x)) for sign in (1.0, -1.0))
    a = up.motion_extreme.sel(body="barge", dof="surge", side="largest").values
    b = down.motion_extreme.sel(body="barge", dof="surge", side="smallest").values
    np.testing.assert_allclose(a[[0, 2, 1, 4, 3]], -b)


def test_a_longer_exposure_has_larger_extremes() -> None:
    """Of a Gaussian process sigma sqrt(2 ln n) goes with n; n itself changes with the level by what
    short steps miss and how waves come in groups, by a tenth at most: 2 ln 10 +- 0.1."""
    run = record(heave=waves())
    once, tenfold = (
        statistics(run, exposure=t).motion_extreme.sel(body="barge", dof="heave", side="largest")
        for t in (2000.0, 20000.0)
    )
    figures = of(run, "heave")
    mpm = np.array([float(each.sel(extreme="mpm")) for each in (once, tenfold)])
    level = (mpm - figures["mean"]) / figures["std"]
    assert level[1] ** 2 - level[0] ** 2 == pytest.approx(2 * np.log(10.0), abs=0.1)


def test_spectrum_holds_the_variance() -> None:
    random = np.random.default_rng(3)
    x = np.convolve(random.normal(size=TIME.size + 20), np.ones(21) / 21, mode="valid")
    found = statistics(record(pitch=x))
    step = float(np.diff(found.frequency.values[:2])[0])
    variance = float(found.motion_spectrum.sel(body="barge", dof="pitch").sum()) * step
    assert variance == pytest.approx(x.var(), rel=0.15)  # eight segments and a window


def test_crawl_by_phase() -> None:
    """A body that creeps 0.5 m while its fenders knock, and none after; the place at the ends of a
    phase is a mean over a minute."""
    place = np.interp(TIME, [600.0, 1000.0], [0.0, -0.5]) + 0.1 * np.sin(2 * np.pi * TIME / 8.0)
    modes = np.full(TIME.size, OPEN, dtype=np.int8)
    modes[(TIME >= 600.0) & (TIME % 8.0 < 4.0)] = SLIP
    modes[TIME >= 1000.0] = STICK
    found = statistics(with_contact(record(surge=place), modes, 1e6 * (modes != OPEN)))
    crawl = found.phase_crawl.sel(contact_group="interface", body="barge", axis="x")
    assert float(crawl.sel(phase="moored")) == pytest.approx(0.0, abs=0.03)
    assert float(crawl.sel(phase="initial contact")) == pytest.approx(-0.5, abs=0.04)
    assert float(crawl.sel(phase="stuck")) == pytest.approx(0.0, abs=0.03)
    assert float(found.fender_share.sel(fender="interface 1").sum()) == pytest.approx(1.0)
    assert float(found.phase_duration.sum()) == pytest.approx(TIME[-1], rel=1e-3)
    first = row(nodes(found), "group", "phase", of=["interface", "initial contact"])
    assert number(first["duration"], "s") == pytest.approx(400.0, rel=0.02)
    assert number(first["crawl in x"], "m") == pytest.approx(-0.5, abs=0.04)


def test_runs_by_gumbels_law() -> None:
    """Over seeds: intervals as of a fit to their largest values; failed runs do not count."""
    figures = [statistics(record(heave=waves(seed))) for seed in range(MIN_RUNS)]
    failed = figures[0] * np.nan
    runs = xr.concat([*figures, failed], "run")
    said = list(nodes_over_seeds(runs))
    high = runs.motion.sel(body="barge", dof="heave", statistic="largest").values[:-1]
    (between,) = rows(said, "motion", "smallest")
    assert between["motion"] == "barge heave"
    assert number(between["largest"], "m") == high.max()
    heave = ["barge heave", "largest"]
    largest = row(said, "channel", "side", "most probable", of=heave)
    rare = row(said, "channel", "side", "P90", of=heave)
    law = fit_maxima(high)
    p90 = law.location - law.scale * np.log(-np.log(0.9))
    assert number(largest["most probable"], "m") == pytest.approx(law.location, rel=1e-9)
    assert number(rare["P90"], "m") == pytest.approx(p90, rel=1e-9)
    assert ends(largest["another run"], "m") == pytest.approx(
        law.prediction_interval(1.0), rel=1e-9
    )
    assert rare["by"] == GUMBEL_METHOD
    assert len(list(nodes_over_seeds(runs.isel(run=[0, 1])))) == 1


def test_runs_that_follow_no_law_are_told_by_their_order() -> None:
    """Half of the runs have a knock: the smallest and largest of 19 hold another in 90 %."""
    figures = [statistics(record(heave=waves(seed))) for seed in range(19)]
    runs = xr.concat(figures, "run")
    knocked = runs.motion.sel(body="barge", dof="heave", statistic="largest").values
    knocked[::3] += 5.0 + np.arange(knocked[::3].size)
    runs.motion.loc[{"body": "barge", "dof": "heave", "statistic": "largest"}] = knocked
    heave = ["barge heave", "largest"]
    largest = row(nodes_over_seeds(runs), "channel", "side", "most probable", of=heave)
    rare = row(nodes_over_seeds(runs), "channel", "side", "P90", of=heave)
    assert ends(largest["another run"], "m") == (knocked.min(), knocked.max())
    assert rare["by"] == "order of the runs (interval of another run holds 90 %)"
    low, high = ends(rare["interval"], "m")
    assert low < knocked.max()
    assert high == np.inf  # so few runs do not bound it
    few = row(nodes_over_seeds(runs.isel(run=slice(9))), "channel", "side", "P90", of=heave)
    assert few["by"] == (
        "order of the runs (interval of another run holds 80 %; with 19 runs it would hold 90 %)"
    )


def test_a_line_cannot_push() -> None:
    """A line that is nearly slack: its predicted smallest tension is zero, not below."""
    tension = 3.8 + waves(4)
    run = record(heave=waves(1))
    run = run.assign(spring_tension=(("time", "spring"), 1e4 * tension[:, None]))
    found = statistics(run.assign_coords(spring=["line"]))
    smallest = found.spring_force_extreme.sel(spring="line", side="smallest")
    assert ExtremeModel(int(found.spring_force_basis.sel(spring="line", side="smallest"))) in LAWS
    assert float(smallest.min()) == 0.0
    motion = statistics(record(heave=1e4 * tension)).motion_extreme
    unbounded = motion.sel(body="barge", dof="heave", side="smallest")
    assert float(unbounded.min()) < 0.0
    np.testing.assert_array_equal(smallest, np.maximum(unbounded, 0.0))


def test_what_has_no_law_is_told_with_what_to_do() -> None:
    """The number of seeds, the study file and the command."""
    x = KINDS["Gaussian wave motion"].draw(np.random.default_rng(1))
    time = 0.5 * np.arange(x.size)
    x[5000] = 300.0
    said = texts(nodes(statistics(record(time, heave=x))))
    assert any(line.startswith("barge heave") and line.endswith("run 19 seeds.") for line in said)
    assert "`hydrosim study STUDY.yaml`" in said[-1]
    assert "`seeds: 1-19`" in said[-1]
