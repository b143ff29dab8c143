"""What a run can be asked in Python: `run.hydrosim`, for every `xarray.Dataset` of a run.

run.hydrosim                           in a notebook: title, how it ended, motions, warnings
run.hydrosim.channels()                the names of all channels
run.hydrosim.channel("speed.barge")    one over time, with its unit
run.hydrosim.picture("motions")        a figure of matplotlib
run.hydrosim.statistics(200.0)         extremes with confidence, as `hydrosim statistics` has them
run.hydrosim.report("report.html")     the page that `hydrosim report` writes
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import xarray as xr

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from hydrosim.presentation.document import Document


@xr.register_dataset_accessor("hydrosim")
class RunAccessor:
    """A run, and what can be asked of it."""

    def __init__(self, run: xr.Dataset) -> None:
        self._run = run

    def __repr__(self) -> str:
        attributes = self._run.attrs
        return f"<run: {attributes.get('title', '')}, {attributes.get('status', 'unknown')}>"

    def _repr_html_(self) -> str:
        return self.summary()._repr_html_()

    def summary(self) -> Document:
        """What `hydrosim run` prints: how the run ended, warnings, motions, contacts, lines."""
        from hydrosim.wording.run import run_document

        return run_document(self._run)

    def channels(self) -> list[str]:
        """The names of all channels, also of those that follow from what is recorded."""
        from hydrosim.results.channels import names

        return names(self._run)

    def channel(self, name: str) -> xr.DataArray:
        """A channel (nt,) over time, with its unit; InputError if the run has none of that name."""
        from hydrosim.results.channels import series

        values, unit = series(self._run, name)
        return xr.DataArray(values, {"time": self._run.time}, ("time",), name, {"units": unit})

    def picture(self, name: str = "overview") -> Figure:
        """A figure, one of `hydrosim.plot.pictures.PICTURES` by its name, "overview", "motions"...;
        InputError where the run has nothing of it, or has no such picture."""
        from hydrosim.plot.draw import figure

        return figure(self._run, name)

    def statistics(self, start: float = 0.0, channels: Sequence[str] = ()) -> xr.Dataset:
        """Means, periods, extremes with confidence from ``start`` [s] on, of motions, contacts and
        lines, and of other ``channels`` by name; InputError where next to nothing is left then."""
        from hydrosim.errors import InputError
        from hydrosim.statistics.statistics import enough_from, statistics

        end = float(self._run.time[-1])
        if not (isinstance(start, int | float) and enough_from(self._run, start)):
            raise InputError(f"found a start of {start!r}; expected seconds well before {end:g} s.")
        asked = [channels] if isinstance(channels, str) else channels
        return statistics(self._run, start, channels=asked)

    def report(self, path: str | Path) -> Path:
        """Write the report of the run as a page, and say where it is."""
        from hydrosim.outputs import as_output
        from hydrosim.report.page import written_page
        from hydrosim.report.run import run_document

        output = as_output(path, "report")
        written_page(run_document(self._run), output)
        return output.path
