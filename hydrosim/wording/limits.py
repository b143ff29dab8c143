"""The report of limits of operation: significant heights, their confidence, what governs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from hydrosim.wording.assumptions import case_nodes
from hydrosim.presentation.document import Cell, Document, List, Node, Sentence, Table, Value, warnings
from hydrosim.presentation.figures import Curve, Curves
from hydrosim.presentation.units import units_of
from hydrosim.wording.parts import Parts, nodes_of, title_of

NEEDED = ("limit", "low", "high", "governing")
SAID = {
    "method": "method",
    "probability": "share of the seas that hold all criteria",
    "confidence": "confidence of the intervals",
    "seeds": "seeds",
    "runs": "runs",
    "runs_of_all": "runs of a whole grid",
    "lowest": "lowest height looked at [m]",
    "highest": "highest height looked at [m]",
    "apart": "heights apart [m]",
    "planned": "planned time of the operation [s]",
    "window": "window with its contingency [s]",
    "alpha_table": "table of alpha factors",
    "bearing": "bearing of the x axis [rad]",
    "hindcast": "hindcast",
    "program": "program",
    "versions": "versions",
    "case_file": "case file",
}
OF_RUNS = ("confidence", "seeds", "runs", "runs_of_all")  # of nothing where spectra say the limits
HOUR = 3600.0
OVER = ("stage", "swell", "heading", "peak_period")


def is_limits(found: xr.Dataset) -> bool:
    """Whether a dataset is what `hydrosim operability` writes."""
    return all(name in found for name in NEEDED) and set(OVER) <= set(found.limit.dims)


def limits_document(found: xr.Dataset) -> Document:
    """The report of limits of operation."""
    share = float(found.attrs.get("probability", np.nan))
    said = f"Limits of operation up to which {share:.3g} of the seas hold all criteria"
    return Document(title_of(found), said, nodes_of(PARTS, found))


def _criteria(found: xr.Dataset) -> Iterator[str]:
    yield from str(found.attrs.get("criteria", "none are named")).splitlines()


def _outcome(found: xr.Dataset) -> Iterator[Node]:
    yield Points(list(_criteria(found)))
    if "failed" in found.attrs:
        yield Points([str(found.attrs["failed"])], grave=True)
    for stage in found.stage.values:
        at = found.sel(stage=stage)
        title = f"Limits of {stage}" if found.sizes["stage"] > 1 else "Limits"
        curves = {name: _curve(each, found) for name, each in _each(at)}
        yield Curves(title, "peak period [s]", "significant height [m]", curves)
    head = ("stage", "waves", "peak period", "limiting height", "interval", "governed by")
    yield Table(head, list(_rows(found)))
    yield from _weather(found)


def _weather(found: xr.Dataset) -> Iterator[Node]:
    """What the limits are worth in a scatter diagram and a hindcast."""
    if "scatter_workable" in found:
        workable, outside = (
            f"{float(found[f'scatter_{name}']):.1%}" for name in ("workable", "outside")
        )
        yield Sentence(
            f"Of the scatter diagram {workable} is workable; {outside} is at peak periods without a"
            " limit and counts as not workable."
        )
    if "waiting" not in found:
        return
    length = float(found.waiting.attrs["window"]) / HOUR
    yield Sentence(
        f"Of the hindcast {float(found.hindcast_outside):.1%} is in seas without a limit and counts"
        f" as not workable. A window lasts {length:g} h."
    )
    head = ("season", "workable", "a window can begin in", "waiting P50", "P90", "after the last")
    yield Table(head, [_season(found.sel(season=season)) for season in found.season.values])


def _season(at: xr.Dataset) -> list[Cell]:
    workable, startable, never = (
        f"{float(at[f'hindcast_{name}']):.1%}" for name in ("workable", "startable", "never")
    )
    waits = [
        number(float(w) / HOUR, "h") if np.isfinite(w) else "beyond the record"
        for w in at.waiting.values
    ]
    return [str(at.season.values), workable, startable, *waits, never]


def _each(at: xr.Dataset) -> Iterator[tuple[str, xr.Dataset]]:
    """Limits over the peak period, of each heading and swell, by what the waves are."""
    for swell in at.swell.values:
        for heading in at.heading.values:
            name = f"to {np.degrees(float(heading)):g} deg"
            name += "" if swell == "none" else f", swell {swell}"
            yield name, at.sel(swell=swell, heading=heading)


def _curve(at: xr.Dataset, found: xr.Dataset) -> Curve:
    top = float(found.attrs.get("highest", np.inf))
    points = zip(at.peak_period.values, at.governing.values, strict=True)
    remarks = [f"m at {period:g} s {_governed(by)}" for period, by in points]
    high = np.minimum(at.high.values, top)
    return Curve(at.peak_period.values, at.limit.values, at.low.values, high, remarks)


def _governed(by: object) -> str:
    return f"governed by {by}" if str(by) else ""


def _rows(found: xr.Dataset) -> Iterator[list[Cell]]:
    for stage in found.stage.values:
        for name, at in _each(found.sel(stage=stage)):
            for k, period in enumerate(at.peak_period.values):
                one = at.isel(peak_period=k)
                low, high = (number(float(one[end])).text for end in ("low", "high"))
                interval = f"{low} to {'above all' if np.isinf(one.high) else high} m"
                interval = "none, without runs" if _by_spectra(found) else interval
                limit = number(float(one.limit), "m")
                by = str(one.governing.values) or "none up to the highest"
                yield [str(stage), name, number(float(period), "s"), limit, interval, by]


def _case(found: xr.Dataset) -> Iterator[Node]:
    yield Sentence("The case of all seas; heights, peak periods, headings and seeds are the study's.")
    yield from case_nodes(found)


def _assumed(found: xr.Dataset) -> Iterator[Node]:
    spectra = _by_spectra(found)
    known = {
        said: _shown(found.attrs[name])
        for name, said in SAID.items()
        if name in found.attrs and not (spectra and name in OF_RUNS)
    }
    yield Table(("assumption", ""), list(known.items()))
    yield Sentence(
        "A limit of 0 is below all heights that were looked at; one at the highest of them may be"
        " higher. Between peak periods nothing was computed. hydrosim check says the warnings of"
        " the case; those of single runs are not kept."
    )


def _by_spectra(found: xr.Dataset) -> bool:
    """Whether limits are from response spectra, of all seeds that there could be."""
    return int(found.attrs.get("runs", 1)) == 0


def _shown(value: object) -> str | Number:
    return value if isinstance(value, str) else number(float(str(value)))


def _convergence(found: xr.Dataset) -> Iterator[Node]:
    if "otherwise" in found and found.attrs.get("runs"):
        inferred, wrong = int(found.inferred.sum()), int(found.otherwise.sum())
        yield Sentence(f"Of {inferred} runs at limits inferred from other heights, {wrong} differ.")
    yield Sentence("Not assessed: how limits change with the step of the solver.")


PARTS: Parts = {
    "outcome": ("Limits", _outcome),
    "case": ("Case", _case),
    "assumptions": ("Assumptions", _assumed),
    "convergence": ("Convergence", _convergence),
}
"""Sections by name: the heading, and what gives the nodes below it, of limits."""
