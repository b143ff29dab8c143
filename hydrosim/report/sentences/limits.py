"""Limits of operation: significant heights, their confidence, what governs, what they are worth."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from hydrosim.files.display_units import units_of
from hydrosim.files.document import Document
from hydrosim.files.document_layout import digits_of
from hydrosim.files.document_nodes import (
    Between,
    Cell,
    Curves,
    List,
    Node,
    Outcome,
    PlottedCurve,
    Sentence,
    Table,
    Value,
    Verdict,
)
from hydrosim.report.sentences.sections import (
    Sections,
    attribute_text,
    build_sections,
    case_nodes,
    lines_of,
    title_block,
    title_of,
)
from hydrosim.statistics.weather import MAX_HEADING_GAP, image_of, without_images
from hydrosim.statistics.weather import MIRROR_REASON as SIDES

LIMIT_VARIABLES = ("limit", "low", "high", "governing")
ASSUMPTION_LABELS = {
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
    "alpha_lowest": "lowest height of the table of alpha factors [m]",
    "bearing": "bearing of the x axis [rad]",
    "hindcast": "hindcast",
    "program": "program",
    "versions": "versions",
    "case_file": "case file",
}
RUN_ATTRIBUTES = ("confidence", "seeds", "runs", "runs_of_all")
"""What means nothing where spectra give the limits."""
MAX_SHARE_OUTSIDE = 0.5
"""Share of the time without a limit from which headings or periods are lacking."""
HOUR_S = 3600.0
LIMIT_DIMS = ("stage", "swell", "heading", "peak_period")


def is_limits(found: xr.Dataset) -> bool:
    """Whether a dataset is what `hydrosim operability` writes."""
    has_variables = all(name in found for name in LIMIT_VARIABLES)
    return has_variables and set(LIMIT_DIMS) <= set(found.limit.dims)


def limits_document(found: xr.Dataset) -> Document:
    """The report of limits of operation."""
    units = units_of(found.attrs)
    nodes = [*title_block(found), *build_sections(LIMIT_SECTIONS, found)]
    return Document(title_of(found), nodes, _subtitle(found), units)


def limits_tables(found: xr.Dataset) -> Document:
    """Criteria, limits and what they are worth, without the case and its assumptions."""
    return Document(title_of(found), list(_outcome(found)), _subtitle(found), units_of(found.attrs))


def _subtitle(found: xr.Dataset) -> str:
    share = float(found.attrs.get("probability", np.nan))
    return f"Limits of operation up to which {share:.3g} of the seas hold all criteria"


def _outcome(found: xr.Dataset) -> Iterator[Node]:
    criteria = lines_of(found, "criteria") or ["none are named"]
    yield List(criteria, "Criteria")
    if "failed" in found.attrs:
        yield Verdict(Outcome.BAD, "{}", [str(found.attrs["failed"])])
    yield from _method(found)
    if SIDES in found.attrs:
        yield Sentence("{}", [str(found.attrs[SIDES])])
    for stage in found.stage.values:
        at = found.sel(stage=stage)
        title = f"Limits of {stage}" if found.sizes["stage"] > 1 else "Limits"
        curves = {name: _curve(each, found) for name, each in distinct_lines(at)}
        yield Curves(title, "peak period", "s", "significant height", "m", curves)
    head = ("stage", "waves", "peak period", "limiting height", "interval", "governed by")
    yield Table(head, list(_rows(found)))
    yield from weather_nodes(found)


def _method(found: xr.Dataset) -> Iterator[Sentence]:
    """How the limits were found; how often what was inferred of other heights proved wrong."""
    method = str(found.attrs.get("method", ""))
    if _by_spectra(found):
        yield Sentence("The limits are by response spectra ({}).", [method], detail=True)
        return
    runs, of = (int(found.attrs.get(name, 0)) for name in ("runs", "runs_of_all"))
    text = "The limits take {} runs of {} seeds, {} of a whole grid ({})."
    share = Value(runs / of if of else np.nan, "share", 2)
    yield Sentence(text, [str(runs), str(found.attrs.get("seeds", "")), share, method], True)
    if "otherwise" in found:
        text = "Of {} runs at limits inferred from other heights, {} differ."
        inferred, wrong = int(found.inferred.sum()), int(found.otherwise.sum())
        yield Sentence(text, [str(inferred), str(wrong)], detail=True)


def weather_nodes(found: xr.Dataset) -> Iterator[Node]:
    """What the limits are worth in a scatter diagram and a hindcast."""
    several = found.sizes["heading"] * found.sizes["swell"] > 1
    if several and "bearing" not in found.attrs and {"scatter_workable", "waiting"} & {*found}:
        yield Sentence(
            "Weather is held against the least limit of all headings and swells. If the hindcast"
            " has directions, operability.bearing turns them into headings."
        )
    if "scatter_workable" in found:
        workable, outside = (
            Value(float(found[f"scatter_{name}"]), "share", 3) for name in ("workable", "outside")
        )
        low, high = found.peak_period.values[[0, -1]]
        yield Sentence(
            "Of the scatter diagram {} is workable. {} is outside peak periods of {} and counts as"
            " not workable.",
            [workable, outside, Between(low, high, "s")],
        )
    if "planned" in found.attrs:
        planned, window = (float(found.attrs[name]) for name in ("planned", "window"))
        yield Sentence(
            "The operation is planned to take {}, with a contingency of {}. A contingency that is"
            " not given is as long as the operation.",
            [Value(planned / HOUR_S, "h"), Value((window - planned) / HOUR_S, "h")],
        )
    if "alpha" in found:
        yield from _alpha(found)
    if "waiting" in found:
        yield from _hindcast(found)


def _alpha(found: xr.Dataset) -> Iterator[Node]:
    """The alpha factor of each limit."""
    own = without_images(found)
    head = ("peak period", *(_heading_words(float(heading), own) for heading in own.heading.values))
    rows: list[list[Cell]] = [
        [digits_of(float(period)), *(Value(float(x), "", 3) for x in at)]
        for period, at in zip(own.peak_period.values, own.alpha.values.T, strict=True)
    ]
    yield Table(head, rows, f"Alpha factors by {found.alpha.attrs.get('long_name', '')}")
    if found.alpha.isnull().any():
        lowest = Value(float(found.attrs.get("alpha_lowest", np.nan)), "m", 3)
        count, of = int(own.alpha.isnull().sum()), own.alpha.size
        yield Verdict(
            Outcome.WARNING,
            "The alpha table begins at {}, above {} of {} limits. These have no factor and count as"
            " not workable: give the table a column for lower heights.",
            [lowest, str(count), str(of)],
        )


def _hindcast(found: xr.Dataset) -> Iterator[Node]:
    """Windows and waiting times in a hindcast."""
    yield Sentence("Hindcast: {}.", [str(found.attrs.get("hindcast", ""))])
    if "bearing" in found.attrs:
        bearing = Value(float(found.attrs["bearing"]), "rad")
        yield Sentence(
            "Its directions are headings, with the x axis at a bearing of {}.", [bearing]
        )
    outside = Value(float(found.hindcast_outside), "share", 3)
    if outside.number > MAX_SHARE_OUTSIDE:
        yield Verdict(
            Outcome.WARNING,
            "{} of the time has no limit. Add peak periods, and with a bearing headings at most {}"
            " apart, that cover the hindcast.",
            [outside, Value(MAX_HEADING_GAP, "rad", 3)],
        )
    else:
        yield Sentence("{} of the time has no limit and counts as not workable.", [outside])
    if "hindcast_below_alpha" in found:
        share = Value(float(found.hindcast_below_alpha), "share", 3)
        text = "{} of the time has a limit below the alpha table, and counts as not workable."
        yield Verdict(Outcome.WARNING, text, [share])
    window = float(found.waiting.attrs["window"]) / HOUR_S
    head = ("season", "workable", "a window can begin in", "waiting P50", "P90", "after the last")
    rows = [_season(found.sel(season=season)) for season in found.season.values]
    yield Table(head, rows, f"Windows of {window:g} h")


def _season(at: xr.Dataset) -> list[Cell]:
    workable, startable, never = (
        Value(float(at[f"hindcast_{name}"]), "share", 3)
        for name in ("workable", "startable", "never")
    )
    waits = [
        Value(float(w) / HOUR_S, "h") if np.isfinite(w) else "beyond the record"
        for w in at.waiting.values
    ]
    return [str(at.season.values), workable, startable, *waits, never]


def _limits_by_heading(at: xr.Dataset) -> Iterator[tuple[str, xr.Dataset]]:
    """Limits over the peak period, of each heading and swell, by what the waves are; those that
    are mirrored to the other side are named with their own."""
    own = without_images(at)
    for swell in own.swell.values:
        for heading in own.heading.values:
            name = _heading_words(float(heading), own)
            name += "" if swell == "none" else f", swell {swell}"
            yield name, own.sel(swell=swell, heading=heading)


def distinct_lines(at: xr.Dataset) -> list[tuple[str, xr.Dataset]]:
    """Limits over the peak period by what the waves are, those that are the same under one name."""
    found: list[tuple[str, xr.Dataset]] = []
    for name, each in _limits_by_heading(at):
        for k, (other, known) in enumerate(found):
            if all(
                _arrays_equal(each[part].values, known[part].values) for part in LIMIT_VARIABLES
            ):
                found[k] = f"{other}; {name}", known
                break
        else:
            found.append((name, each))
    return found


def _arrays_equal(one: np.ndarray, other: np.ndarray) -> bool:
    return np.array_equal(one, other, equal_nan=one.dtype.kind == "f")


def _heading_words(heading: float, found: xr.Dataset) -> str:
    image = image_of(heading, found)
    other = "" if image is None else f" and {_degrees(image)}"
    return f"to {_degrees(heading)}{other} deg"


def _degrees(heading: float) -> str:
    return f"{round(np.degrees(heading), 6):g}"


def _curve(at: xr.Dataset, found: xr.Dataset) -> PlottedCurve:
    """A curve of the limits that lie within the heights; a sea without one has no point."""
    top = float(found.attrs.get("highest", np.inf))
    points = zip(at.peak_period.values, at.governing.values, strict=True)
    remarks = [f"m at {period:g} s {_governing_words(by)}" for period, by in points]
    within = np.array([not side_of(float(limit), found) for limit in at.limit.values])
    limit, low, high = (np.where(within, at[name].values, np.nan) for name in LIMIT_VARIABLES[:3])
    return PlottedCurve(at.peak_period.values, limit, low, np.minimum(high, top), remarks)


def _governing_words(by: object) -> str:
    return f"governed by {by}" if str(by) else ""


def side_of(limit: float, found: xr.Dataset) -> str:
    """Whether a limit is "below" or "above" the heights looked at; "" if it is between them."""
    if limit < found.attrs["lowest"]:
        return "below"
    near = 0.5 * found.attrs["apart"] if found.attrs["runs"] else 0.0
    return "above" if limit >= found.attrs["highest"] - near else ""


def _rows(found: xr.Dataset) -> Iterator[list[Cell]]:
    for stage in found.stage.values:
        for name, at in _limits_by_heading(found.sel(stage=stage)):
            for k, period in enumerate(at.peak_period.values):
                one = at.isel(peak_period=k)
                limit, interval = _limit(one)
                by = str(one.governing.values)
                yield [str(stage), name, Value(float(period), "s"), limit, interval, by]


def _limit(one: xr.Dataset) -> tuple[Cell, Cell]:
    """A limit with its interval, or on which side of the heights it lies."""
    limit, low, high = (float(one[name]) for name in ("limit", "low", "high"))
    side = side_of(limit, one)
    if side == "below":
        return Sentence("below {}", [Value(one.attrs["lowest"], "m")]), "the first is too high"
    if side == "above":
        return Sentence("above {}", [Value(one.attrs["highest"], "m")]), "all hold"
    if _by_spectra(one):
        return Value(limit, "m"), "none, without runs"
    top = high if high <= one.attrs["highest"] else np.inf
    return Value(limit, "m"), Between(max(low, 0.0), top, "m", 3)


def _case(found: xr.Dataset) -> Iterator[Node]:
    yield Sentence(
        "The case of all seas. Heights, peak periods, headings and seeds are those of the study."
    )
    yield from case_nodes(found)


def _limit_assumptions(found: xr.Dataset) -> Iterator[Node]:
    spectra = _by_spectra(found)
    known = {
        said: attribute_text(found.attrs[name])
        for name, said in ASSUMPTION_LABELS.items()
        if name in found.attrs and not (spectra and name in RUN_ATTRIBUTES)
    }
    yield Table(("assumption", ""), list(known.items()))
    yield Sentence(
        "Nothing was computed between peak periods. Warnings of single runs are not kept:"
        " hydrosim check prints those of the case."
    )


def _by_spectra(found: xr.Dataset) -> bool:
    """Whether limits are from response spectra, of all seeds that there could be."""
    return int(found.attrs.get("runs", 1)) == 0


def _convergence(found: xr.Dataset) -> Iterator[Node]:
    yield Sentence("This study does not assess how limits change with the step of the solver.")


LIMIT_SECTIONS: Sections[xr.Dataset] = {
    "outcome": ("Limits", _outcome),
    "case": ("Case", _case),
    "assumptions": ("Assumptions", _limit_assumptions),
    "convergence": ("Convergence", _convergence),
}
"""Sections by name: the heading, and what gives the nodes below it."""
