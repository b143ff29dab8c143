"""Methods of a run in Python: `run.hydrosim`, for every `xarray.Dataset` of a run.

Methods and their results:

    run.hydrosim                           print and notebooks show the summary: how the run ended,
                                           warnings, motions, contacts; also of many runs
    run.hydrosim.channels()                the names of all channels
    run.hydrosim.channel("speed.barge")    one over time, with its unit
    run.hydrosim.picture("motions")        a figure of matplotlib
    run.hydrosim.statistics(200.0)         extremes with confidence, as by `hydrosim statistics`
    run.hydrosim.report("report.html")     the page that `hydrosim report` writes
    runs.hydrosim.extremes_over_seeds()    of many runs: most probable extremes and P90
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import xarray as xr

from hydrosim.results.dataset import is_part
from hydrosim.results.runs_file import RUN, is_of_runs

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from hydrosim.files.document import Document


@xr.register_dataset_accessor("hydrosim")
class RunAccessor:
    """Methods of a run: channels, pictures, statistics and a report."""

    def __init__(self, run: xr.Dataset) -> None:
        self._run = run

    def __repr__(self) -> str:
        attributes = self._run.attrs
        title = attributes.get("title", "")
        if is_of_runs(self._run):
            return f"<{self._run.sizes[RUN]} runs: {title}>"
        what = "part of a run" if is_part(self._run) else "run"
        return f"<{what}: {title}, {attributes.get('status', 'unknown')}>"

    def __str__(self) -> str:
        return str(self.summary())

    def _repr_html_(self) -> str:
        return self.summary()._repr_html_()

    def _single_run(self) -> xr.Dataset:
        """The run; InputError if the dataset holds many."""
        from hydrosim.errors import InputError

        if is_of_runs(self._run):
            raise InputError(
                f"found {self._run.sizes[RUN]} runs; expected one run, as hs.simulate or"
                " hs.open_run gives. For many runs, use summary() or extremes_over_seeds()."
            )
        return self._run

    def summary(self) -> Document:
        """Text that `hydrosim run` prints: end of the run, warnings, motions, contacts, lines. Of
        many runs, the text that `hydrosim statistics` prints of a study."""
        from hydrosim.report.sentences.run import run_document
        from hydrosim.report.sentences.study import study_tables

        if is_of_runs(self._run):
            return study_tables(self._run)
        return run_document(self._run)

    def channels(self) -> list[str]:
        """Names of all channels, including those derived from recorded ones."""
        from hydrosim.results.channels import channel_names

        return channel_names(self._single_run())

    def channel(self, name: str) -> xr.DataArray:
        """Channel (nt,) over time, with its unit. Raises InputError if the run has no channel of
        that name."""
        from hydrosim.results.channels import channel_series

        run = self._single_run()
        values, unit = channel_series(run, name)
        return xr.DataArray(values, {"time": run.time}, ("time",), name, {"units": unit})

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
        from hydrosim.errors import InputError
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
        from hydrosim.errors import InputError
        from hydrosim.statistics.over_seeds import extremes_over_seeds

        if not is_of_runs(self._run):
            raise InputError("found one run; expected many runs: hs.simulate_many(cases).")
        return extremes_over_seeds(self._run)

    def report(self, path: str | Path) -> Path:
        """Write the report of the run as a page; return its path."""
        from hydrosim.files.outputs import as_output
        from hydrosim.report.document import run_document
        from hydrosim.report.page import written_page

        output = as_output(path, "report")
        written_page(run_document(self._single_run()), output)
        return output.path
