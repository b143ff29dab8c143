"""`draw` writes the pictures of a run to files; `figure` returns one of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from hydrosim.case.tables import plain, seas
from hydrosim.errors import InputError
from hydrosim.outputs import Output, make_folder, save_picture
from hydrosim.plot.layout import PictureFrame, ShadedPhase, picture
from hydrosim.plot.panels import Panel, TimeWindow, coarse
from hydrosim.plot.pictures import PICTURES, channels
from hydrosim.results.phases import Phase as Named
from hydrosim.results.phases import is_operation

LEGEND_COLUMNS = {"_forces": 2}
ALWAYS = TimeWindow()


class Format(StrEnum):
    """Formats of pictures."""

    PNG = "png"
    SVG = "svg"
    PDF = "pdf"


@dataclass(frozen=True)
class View:
    """Selection for the pictures of a run: the time, the channels (default: the usual ones), and
    the format."""

    window: TimeWindow = ALWAYS
    channels: Sequence[str] = ()
    format: Format = Format.PNG

    def pictures(self) -> dict[str, str]:
        """Names of all possible files, by the suffix after the name of the run."""
        suffixes = ["_channels"] if self.channels else [*PICTURES]
        return {suffix: f"{suffix}.{self.format}" for suffix in suffixes}


DEFAULT_VIEW = View()


def draw(
    run: xr.Dataset,
    folder: Path,
    stem: str,
    origin: Path | None = None,
    overwrite: bool = False,
    view: View = DEFAULT_VIEW,
) -> list[Path]:
    """Write the pictures of ``run`` and return their paths. ``stem``.png is the overview;
    ``stem``_motions.png and so on are the details; ``stem``_channels.png shows requested channels.
    Raises InputError if the folder cannot be made, if a picture would replace a file that is no
    earlier picture of the run ``origin``, or if the run has fewer than two records in the
    window."""
    _check(run, view.window)
    outputs = picture_outputs(folder, stem, origin, overwrite, view)
    found = zip(view.pictures(), outputs, strict=True)
    drawn = ((_panels(run, suffix, view), suffix, output) for suffix, output in found)
    return [
        save_picture(picture(panels, _frame(run, suffix, view.window)), output)
        for panels, suffix, output in drawn
        if panels
    ]


def picture_outputs(
    folder: Path,
    stem: str,
    origin: Path | None = None,
    overwrite: bool = False,
    view: View = DEFAULT_VIEW,
) -> list[Output]:
    """Outputs for all possible pictures of a run; raises as `draw` does."""
    make_folder(folder)
    made_of = origin or folder / f"{stem}.nc"
    paths = [folder / f"{stem}{name}" for name in view.pictures().values()]
    return [
        Output(path, "picture", made_of, (made_of,), overwrite, "pictures").checked_output()
        for path in paths
    ]


def figure(run: xr.Dataset, name: str = "overview", window: TimeWindow = ALWAYS) -> Figure:
    """Picture of a run by its name, such as "overview" or "motions". Raises InputError if there is
    no such picture, or if the run has no data for it."""
    known = {of.__name__: suffix for suffix, of in PICTURES.items()}
    panels = PICTURES[known[name]](run) if name in known else []
    if not panels:
        there = [each for each, suffix in known.items() if PICTURES[suffix](run)]
        raise InputError(f"picture: found {name!r}; expected one of {', '.join(there)}.")
    _check(run, window)
    return picture(panels, _frame(run, known[name], window))


def phases(run: xr.Dataset) -> tuple[list[ShadedPhase], str]:
    """Phases of the first group of contacts that goes through an operation, and its name; None if
    there is no such group."""
    if "contact_phase" not in run:
        return [], ""
    time = run.time.values
    each = run.contact_phase.transpose("contact_group", "time").values
    for group, of in zip(run.contact_group.values, each, strict=True):
        starts = np.flatnonzero(np.diff(of, prepend=-1))
        if is_operation(of):
            ends = [*time[starts[1:]], time[-1]]
            kinds = [Named(of[k]).name.lower().replace("_", " ") for k in starts]
            found = [ShadedPhase(*each) for each in zip(kinds, time[starts], ends, strict=True)]
            return found, str(group)
    return [], ""


def _panels(run: xr.Dataset, suffix: str, view: View) -> list[Panel]:
    return channels(run, view.channels) if view.channels else PICTURES[suffix](run)


def _frame(run: xr.Dataset, suffix: str, window: TimeWindow) -> PictureFrame:
    title = run.attrs.get("title", "")
    status = run.attrs.get("status", "complete")
    title = title if status == "complete" else f"{title} ({status})"
    remarks = seas(plain(str(run.attrs.get("case_resolved", ""))))
    if length := coarse(run.time.values, window):
        remarks.append(f"bands: smallest to largest of each {length:g} s; lines: mean")
    shaded, group = phases(run)
    said = ", ".join(f"{phase.name} to {phase.end:.0f} s" for phase in shaded[:-1])
    under = [f"phases of {group}: {said}, then {shaded[-1].name}"] if shaded else []
    return PictureFrame(
        title,
        [*filter(None, ["; ".join(remarks)]), *under],
        window,
        shaded,
        LEGEND_COLUMNS.get(suffix, 1),
    )


def _check(run: xr.Dataset, window: TimeWindow) -> None:
    time = run.time.values
    if time[window.record_slice(time)].size < 2:
        raise InputError(
            f"--from, --to: found {window.start:g} to {window.end:g} s, with fewer than two"
            " recorded times of the run; expected a longer part of"
            f" {time[0]:g} to {time[-1]:g} s."
        )
