"""Methods of a run in Python: `run.hydrosim`, for every `xarray.Dataset` of a run.

Methods and their results:

    run.hydrosim                           print and notebooks show the summary: how the run ended,
                                           warnings, motions, contacts; also of other results
    run.hydrosim.channels()                the names of all channels
    run.hydrosim.channel("speed.barge")    one over time, with its unit
    run.hydrosim.to_dataframe("speed.*")   a frame of pandas: a column for each channel
    run.hydrosim.plot.motions()            figures of matplotlib: overview, motions, contact, ...
    run.hydrosim.plot.channels("speed.*")  curves of channels; ax=... draws on your own axes
    run.hydrosim.extremes(start="200 s")   extremes with confidence: `hydrosim show --statistics`
    run.hydrosim.explain("surge")          why a body moved: `hydrosim show --why`
    run.hydrosim.compare("test.csv")       against a recording: `hydrosim compare`
    run.hydrosim.export("run.csv")         for other programs: `hydrosim export`
    run.hydrosim.case()                    the case that repeats the run: `hydrosim export --case`
    run.hydrosim.report("report.html")     a page: `hydrosim report`
    runs.hydrosim.to_dataframe()           of many runs: a row for each run
    runs.hydrosim.extremes_over_seeds()    of many runs: most probable extremes and P90
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from hydrosim.errors import InputError

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from hydrosim.files.arguments import Names
    from hydrosim.files.document import Document
    from hydrosim.interface.printed import PrintedResult


@xr.register_dataset_accessor("hydrosim")
class RunAccessor:
    """Methods of a run: channels, pictures, statistics and a report."""

    def __init__(self, run: xr.Dataset) -> None:
        self._run = run

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> None:
            methods = ", ".join(name for name in dir(type(self)) if not name.startswith("_"))
            raise AttributeError(
                f"run.hydrosim has no {name!r}; it has {methods}. Variables are those of the run"
                " itself, such as run.position."
            )

    def __repr__(self) -> str:
        from hydrosim.results.dataset import is_part

        attributes = self._run.attrs
        title = attributes.get("title", "")
        if self._holds_many():
            return f"<{self._run.sizes['run']} runs: {title}>"
        what = "part of a run" if is_part(self._run) else "run"
        return f"<{what}: {title}, {attributes.get('status', 'unknown')}>"

    def __str__(self) -> str:
        return str(self.summary())

    def _repr_html_(self) -> str:
        return self.summary()._repr_html_()

    def _holds_many(self) -> bool:
        from hydrosim.results.runs_file import is_of_runs

        return is_of_runs(self._run)

    def _single_run(self) -> xr.Dataset:
        """The run; InputError if the dataset holds many, or none."""
        from hydrosim.results.dataset import RUN_FILE_HINT

        if self._holds_many():
            raise InputError(
                f"found {self._run.sizes['run']} runs; expected one run, as hs.simulate or"
                " hs.open_run gives. For many runs, use summary(), to_dataframe() or"
                " extremes_over_seeds()."
            )
        if missing := [name for name in ("time", "body", "dof") if name not in self._run]:
            raise InputError(f"found a dataset without {', '.join(missing)}; {RUN_FILE_HINT}.")
        self._refuse_joined()
        return self._run

    def _refuse_joined(self) -> None:
        """Raises InputError for runs that xarray has joined along a dimension of its own."""
        dims = self._run.position.dims if "position" in self._run else ()
        if not self._holds_many() and (joined := {*dims} - {"time", "body", "dof"}):
            dim = joined.pop()
            raise InputError(
                f"found runs joined along {dim}; expected one run. Select it before you ask"
                f" .hydrosim: runs.isel({dim}=0)."
            )

    def _result(self) -> xr.Dataset:
        """The run or runs; InputError if the dataset is neither."""
        return self._run if self._holds_many() else self._single_run()

    def summary(self) -> Document:
        """Text that the command of a result prints: of a run, the end of the run, warnings,
        motions, contacts, lines; also of many runs, limits, comparisons, linear analyses."""
        from hydrosim.interface.show import summary_of

        self._refuse_joined()
        return summary_of(self._run)

    def channels(self) -> list[str]:
        """Names of all channels, including those derived from recorded ones."""
        from hydrosim.results.channels import channel_names

        return channel_names(self._single_run())

    def channel(self, name: str) -> xr.DataArray:
        """Channel (nt,) over time, with its unit; of many runs (run, nt), of what they keep over
        time. Raises InputError if there is no channel of that name.

        >>> case = hs.load_case("cases/friction_block/exact.yaml", {"duration": "20 s"})
        >>> hs.simulate(case).hydrosim.channel("position.block.surge").attrs["units"]
        'm'
        """
        from hydrosim.results.channels import channel_series

        if not isinstance(name, str):
            raise InputError(f"found {name!r}; expected one name: to_dataframe() takes several.")
        if self._holds_many():
            return _channel_of_runs(self._run, name)
        run = self._single_run()
        values, unit = channel_series(run, name)
        return xr.DataArray(values, {"time": run.time}, ("time",), name, {"units": unit})

    def to_dataframe(
        self, channels: Names = (), statistics: Sequence[str] = ("smallest", "largest")
    ) -> pd.DataFrame:
        """Frame of pandas in SI. Of one run: a column over time [s] for each of the ``channels``,
        which may be patterns, by default all that are not zero. Of many runs: a row for each, with
        seed, parameters, figures, and ``statistics`` of each channel that has some."""
        from hydrosim.files.arguments import names_in
        from hydrosim.interface.frames import frame_of_channels, frame_of_runs

        if self._holds_many():
            return frame_of_runs(self._run, names_in(statistics))
        return frame_of_channels(self._single_run(), names_in(channels))

    def picture(self, name: str = "overview") -> Figure:
        """Figure by its name in `hydrosim.report.charts.pictures.PICTURES`, such as "overview" or
        "motions". Raises InputError if there is no such picture, or if the run has no data for
        it."""
        from hydrosim.report.charts.pictures import figure

        return figure(self._single_run(), name)

    def statistics(self, start: float = 0.0, channels: Sequence[str] = ()) -> xr.Dataset:
        """Means, periods and extremes with confidence intervals, from ``start`` [s] on. They cover
        motions, contacts, lines and the additional ``channels``, which may be patterns such as
        "speed.*". Raises InputError if hardly any record is left after ``start``."""
        from hydrosim.results.channels import channel_names, match_channels
        from hydrosim.statistics.statistics import has_enough_records, statistics

        run = self._single_run()
        end = float(run.time[-1])
        if not (isinstance(start, int | float) and has_enough_records(run, start)):
            raise InputError(
                f"found a start of {start!r}; expected a time in seconds well before"
                f" the end of the run at {end:g} s."
            )
        asked = [channels] if isinstance(channels, str) else channels
        channel_list = match_channels(channel_names(run), asked, "channels")
        return statistics(run, start, channels=channel_list)

    def extremes_over_seeds(self) -> xr.Dataset:
        """Most probable extremes and P90 over seeds, with 90 % intervals, by channel and side, as
        `hydrosim.statistics.over_seeds.extremes_over_seeds` describes; ``to_dataframe()`` gives a
        table. Raises InputError for one run, and for fewer than 8 seeds."""
        from hydrosim.statistics.over_seeds import extremes_over_seeds

        if not self._holds_many():
            raise InputError("found one run; expected many runs: hs.simulate_many(cases).")
        return extremes_over_seeds(self._run)

    @property
    def plot(self) -> RunPlots:
        """Pictures by their names, such as ``plot.motions()``."""
        return RunPlots(self._single_run())

    def extremes(self, **options: Any) -> PrintedResult:
        """Means, periods and extremes with intervals, with the options of
        `hydrosim.interface.show.find_extremes`."""
        from hydrosim.interface.show import find_extremes

        return find_extremes(self._result(), **options)

    def explain(self, direction: str = "surge", **options: Any) -> PrintedResult:
        """Why a body moved, with the options of `hydrosim.interface.show.explain`."""
        from hydrosim.interface.show import explain

        return explain(self._result(), direction=direction, **options)

    def compare(self, recorded: str | Path | pd.DataFrame, **options: Any) -> PrintedResult:
        """Comparison with a recording, with the options of `hydrosim.interface.compare.compare`."""
        from hydrosim.interface.compare import compare

        return compare(self._result(), recorded, **options)

    def export(self, output: str | Path, **options: Any) -> PrintedResult:
        """Write channels for other programs, with the options of
        `hydrosim.interface.compare.export`."""
        from hydrosim.interface.compare import export

        return export(self._result(), output, **options)

    def case(self, number: int | None = None) -> str:
        """Case (YAML) that repeats the run; of many runs that of a ``number``, from 0 on."""
        from hydrosim.run.provenance import case_of

        return case_of(self._run, number)

    def report(
        self, path: str | Path | None = None, *, replay: bool = False, overwrite: bool = False
    ) -> Path:
        """Write the report of a result as a page, or its three-dimensional ``replay``; return its
        path. Without a path, it has the name that `hydrosim report` gives it."""
        from hydrosim.interface.show import write_report

        output = True if path is None else path
        return write_report(self._run, output, replay=replay, overwrite=overwrite).files[0]


def _channel_of_runs(runs: xr.Dataset, name: str) -> xr.DataArray:
    """Channel (run, nt) of many runs; InputError if they do not keep it over time."""
    from hydrosim.files.series import columns_of, select
    from hydrosim.results.channels import RUN

    if name not in (names := [*columns_of(runs.isel(run=0))]):
        kept = ", ".join(dict.fromkeys(column.partition(".")[0] for column in names)) or "nothing"
        raise InputError(
            f"found {name}, but these runs keep {kept} over time. Ask for more by"
            " simulate_many(cases, variables=[...]), or output: {variables: ...} of a study."
        )
    series = [select(RUN, runs.isel(run=k), name) for k in range(runs.sizes["run"])]
    coordinates = {name: of for name, of in runs.coords.items() if of.dims in (("run",), ("time",))}
    values = [value for value, _ in series]
    return xr.DataArray(values, coordinates, ("run", "time"), name, {"units": series[0][1]})


class RunPlots:
    """Pictures of a run by name: ``plot()`` is the overview, ``plot.motions()`` one of the others.
    Each draws on axes ``ax`` of matplotlib, one for each panel, if given; it returns the figure."""

    def __init__(self, run: xr.Dataset) -> None:
        self._run = run

    def __dir__(self) -> list[str]:
        from hydrosim.report.charts.pictures import picture_names

        return picture_names()

    def __call__(self, name: str = "overview", ax: Axes | Sequence[Axes] | None = None) -> Figure:
        """Picture of this name; InputError if there is none, or no data for it."""
        from hydrosim.report.charts.pictures import draw_on_axes, figure

        return figure(self._run, name) if ax is None else draw_on_axes(self._run, name, ax)

    def channels(self, names: Names, ax: Axes | Sequence[Axes] | None = None) -> Figure:
        """Channels over time, those of one unit in one panel; patterns such as "position.*"."""
        from hydrosim.files.arguments import names_in
        from hydrosim.report.charts.pictures import draw_channels

        return draw_channels(self._run, names_in(names), ax)

    def __getattr__(self, name: str) -> Callable[..., Figure]:
        if name.startswith("_") or name not in dir(self):
            raise AttributeError(
                f"run.hydrosim.plot has no picture {name!r}; it has {', '.join(dir(self))}"
            )
        return partial(self, name)
