"""Limits of operation: significant heights, their confidence, what governs, what they are worth."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.files import document_nodes
from hydrosim.files.display_units import units_of
from hydrosim.files.document import Document
from hydrosim.files.document_layout import digits_of
from hydrosim.report.sentences import sections
from hydrosim.statistics.weather import MAX_HEADING_GAP, image_of, without_images
from hydrosim.statistics.weather import MIRROR_REASON as SIDES

if TYPE_CHECKING:
    import xarray as xr

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
NO_LIMIT = {side: f"no limit: {side} the heights" for side in ("below", "above")}
"""What is said of a sea whose limit is on a side of the heights."""
HOUR_S = 3600.0


def limits_document(limits: xr.Dataset) -> Document:
    """The report of limits of operation."""
    units = units_of(limits.attrs)
    block = sections.title_block(limits, sections.case_data(limits))
    nodes = [*block, *sections.build_sections(LIMIT_SECTIONS, limits)]
    return Document(sections.title_of(limits), nodes, _subtitle_text(limits), units)


def limits_tables(limits: xr.Dataset) -> Document:
    """Criteria, limits and what they are worth, without the case and its assumptions."""
    return Document(
        sections.title_of(limits),
        list(_describe_outcome(limits)),
        _subtitle_text(limits),
        units_of(limits.attrs),
    )


def _subtitle_text(limits: xr.Dataset) -> str:
    share = float(limits.attrs.get("probability", np.nan))
    return f"Limits of operation up to which {share:.3g} of the seas hold all criteria"


def _describe_outcome(limits: xr.Dataset) -> document_nodes.Nodes:
    criteria = sections.lines_of(limits, "criteria") or ["none are named"]
    yield document_nodes.List(criteria, "Criteria")
    if "failed" in limits.attrs:
        yield document_nodes.Verdict(
            document_nodes.Outcome.BAD, "{}", [str(limits.attrs["failed"])]
        )
    yield from _describe_method(limits)
    if SIDES in limits.attrs:
        yield document_nodes.Sentence("{}", [str(limits.attrs[SIDES])])
    for stage in limits.stage.values:
        at = limits.sel(stage=stage)
        title = f"Limits of {stage}" if limits.sizes["stage"] > 1 else "Limits"
        yield limit_chart(at, title)
    head = ("stage", "waves", "peak period", "limiting height", "interval", "governed by")
    yield document_nodes.Table(head, list(_limit_rows(limits)))
    yield from weather_nodes(limits)


def _describe_method(limits: xr.Dataset) -> Iterator[document_nodes.Sentence]:
    """How the limits were found; how often what was inferred of other heights proved wrong."""
    method = str(limits.attrs.get("method", ""))
    if _are_from_spectra(limits):
        yield document_nodes.Sentence(
            "The limits are by response spectra ({}).", [method], detail=True
        )
        return
    runs, of = (int(limits.attrs.get(name, 0)) for name in ("runs", "runs_of_all"))
    text = "The limits take {} runs of {} seeds, {} of a whole grid ({})."
    share = document_nodes.Value(runs / of if of else np.nan, "share", 2)
    yield document_nodes.Sentence(
        text, [str(runs), str(limits.attrs.get("seeds", "")), share, method], True
    )
    if "otherwise" in limits:
        text = "Of {} runs at limits inferred from other heights, {} differ."
        inferred, wrong = int(limits.inferred.sum()), int(limits.otherwise.sum())
        yield document_nodes.Sentence(text, [str(inferred), str(wrong)], detail=True)


def weather_nodes(limits: xr.Dataset) -> document_nodes.Nodes:
    """What the limits are worth in a scatter diagram and a hindcast."""
    several = limits.sizes["heading"] * limits.sizes["swell"] > 1
    if several and "bearing" not in limits.attrs and {"scatter_workable", "waiting"} & {*limits}:
        yield document_nodes.Sentence(
            "Weather is held against the least limit of all headings and swells. If the hindcast"
            " has directions, operability.bearing turns them into headings."
        )
    if "scatter_workable" in limits:
        shares = limits.scatter_workable, limits.scatter_outside
        workable, outside = document_nodes.value_cells(shares, "share", 3)
        low, high = limits.peak_period.values[[0, -1]]
        yield document_nodes.Sentence(
            "Of the scatter diagram {} is workable. {} is outside peak periods of {} and counts as"
            " not workable.",
            [workable, outside, document_nodes.Between(low, high, "s")],
        )
    if "planned" in limits.attrs:
        planned, window = (float(limits.attrs[name]) for name in ("planned", "window"))
        yield document_nodes.Sentence(
            "The operation is planned to take {}, with a contingency of {}. A contingency that is"
            " not given is as long as the operation.",
            [
                document_nodes.Value(planned / HOUR_S, "h"),
                document_nodes.Value((window - planned) / HOUR_S, "h"),
            ],
        )
    if "alpha" in limits:
        yield from _describe_alpha_factors(limits)
    if "waiting" in limits:
        yield from _describe_hindcast(limits)


def _describe_alpha_factors(limits: xr.Dataset) -> document_nodes.Nodes:
    """The alpha factor of each limit."""
    unmirrored = without_images(limits)
    head = (
        "peak period",
        *(_heading_words(float(heading), unmirrored) for heading in unmirrored.heading.values),
    )
    rows: list[document_nodes.Row] = [
        [digits_of(float(period)), *document_nodes.value_cells(at, "", 3)]
        for period, at in zip(unmirrored.peak_period.values, unmirrored.alpha.values.T, strict=True)
    ]
    yield document_nodes.Table(
        head, rows, f"Alpha factors by {limits.alpha.attrs.get('long_name', '')}"
    )
    if limits.alpha.isnull().any():
        lowest = document_nodes.Value(float(limits.attrs.get("alpha_lowest", np.nan)), "m", 3)
        count, of = int(unmirrored.alpha.isnull().sum()), unmirrored.alpha.size
        yield document_nodes.warning(
            "The alpha table begins at {}, above {} of {} limits. These have no factor and count as"
            " not workable: give the table a column for lower heights.",
            [lowest, str(count), str(of)],
        )


def _describe_hindcast(limits: xr.Dataset) -> document_nodes.Nodes:
    """Windows and waiting times in a hindcast."""
    yield document_nodes.Sentence("Hindcast: {}.", [str(limits.attrs.get("hindcast", ""))])
    if "bearing" in limits.attrs:
        bearing = document_nodes.Value(float(limits.attrs["bearing"]), "rad")
        yield document_nodes.Sentence(
            "Its directions are headings, with the x axis at a bearing of {}.", [bearing]
        )
    outside = document_nodes.Value(float(limits.hindcast_outside), "share", 3)
    if outside.number > MAX_SHARE_OUTSIDE:
        yield document_nodes.warning(
            "{} of the time has no limit. Add peak periods, and with a bearing headings at most {}"
            " apart, that cover the hindcast.",
            [outside, document_nodes.Value(MAX_HEADING_GAP, "rad", 3)],
        )
    else:
        yield document_nodes.Sentence(
            "{} of the time has no limit and counts as not workable.", [outside]
        )
    if "hindcast_below_alpha" in limits:
        share = document_nodes.Value(float(limits.hindcast_below_alpha), "share", 3)
        text = "{} of the time has a limit below the alpha table, and counts as not workable."
        yield document_nodes.warning(text, [share])
    window = float(limits.waiting.attrs["window"]) / HOUR_S
    head = ("season", "workable", "a window can begin in", "waiting P50", "P90", "after the last")
    rows = [_season_cells(limits.sel(season=season)) for season in limits.season.values]
    yield document_nodes.Table(head, rows, f"Windows of {window:g} h")


def _season_cells(at: xr.Dataset) -> document_nodes.Row:
    shares = at.hindcast_workable, at.hindcast_startable, at.hindcast_never
    workable, startable, never = document_nodes.value_cells(shares, "share", 3)
    waits = [
        document_nodes.Value(float(w) / HOUR_S, "h") if np.isfinite(w) else "beyond the record"
        for w in at.waiting.values
    ]
    return [str(at.season.values), workable, startable, *waits, never]


def _limits_by_heading(at: xr.Dataset) -> Iterator[tuple[str, xr.Dataset]]:
    """Limits over the peak period, of each heading and swell, by what the waves are; those that
    are mirrored to the other side are named with their own."""
    unmirrored = without_images(at)
    for swell in unmirrored.swell.values:
        for heading in unmirrored.heading.values:
            name = _heading_words(float(heading), unmirrored)
            name += "" if swell == "none" else f", swell {swell}"
            yield name, unmirrored.sel(swell=swell, heading=heading)


def distinct_lines(at: xr.Dataset) -> list[tuple[str, xr.Dataset]]:
    """Limits over the peak period by what the waves are, those that are the same under one name."""
    lines: list[tuple[str, xr.Dataset]] = []
    for name, line in _limits_by_heading(at):
        for k, (other, earlier) in enumerate(lines):
            if _limits_alone(line).equals(_limits_alone(earlier)):
                lines[k] = f"{other}; {name}", earlier
                break
        else:
            lines.append((name, line))
    return lines


def _limits_alone(line: xr.Dataset) -> xr.Dataset:
    return line[[*LIMIT_VARIABLES]].reset_coords(["swell", "heading"], drop=True)


def _heading_words(heading: float, limits: xr.Dataset) -> str:
    image = image_of(heading, limits)
    other = "" if image is None else f" and {_degrees_text(image)}"
    return f"to {_degrees_text(heading)}{other} deg"


def _degrees_text(heading: float) -> str:
    return f"{round(np.degrees(heading), 6):g}"


def limit_chart(at: xr.Dataset, title: str = "Limits") -> document_nodes.Chart:
    """Limits of a stage over the peak period; a line for each heading and swell."""
    lines = {f"waves {name}": _limit_line(line) for name, line in distinct_lines(at)}
    return document_nodes.Chart(
        title, "significant height", "m", lines, x_label="peak period", x_unit="s"
    )


def _limit_line(at: xr.Dataset) -> document_nodes.ChartLine:
    """Limits that lie within the heights, with what governs them. Where a sea has none, it is
    beyond the lowest or the highest."""
    sides = np.array([side_of(float(limit), at) for limit in at.limit.values])
    limit, low, high = (np.where(sides == "", at[name], np.nan) for name in LIMIT_VARIABLES[:3])
    remarks = [
        NO_LIMIT[side] if side else f"governed by {by}" if str(by) else ""
        for side, by in zip(sides, at.governing.values, strict=True)
    ]
    bounds = np.select(
        [sides == "below", sides == "above"], [at.attrs["lowest"], at.attrs["highest"]], np.nan
    )
    if _are_from_spectra(at):
        low, high = np.zeros((2, 0))
    high = np.minimum(high, at.attrs["highest"])
    return document_nodes.ChartLine(limit, at.peak_period.values, low, high, bounds, remarks)


def side_of(limit: float, limits: xr.Dataset) -> str:
    """Whether a limit is "below" or "above" the heights looked at; "" if it is between them."""
    if limit < limits.attrs["lowest"]:
        return "below"
    near = 0.5 * limits.attrs["apart"] if limits.attrs["runs"] else 0.0
    return "above" if limit >= limits.attrs["highest"] - near else ""


def _limit_rows(limits: xr.Dataset) -> Iterator[document_nodes.Row]:
    for stage in limits.stage.values:
        for name, at in _limits_by_heading(limits.sel(stage=stage)):
            for k, period in enumerate(at.peak_period.values):
                at_period = at.isel(peak_period=k)
                limit, interval = _limit_cells(at_period)
                by = str(at_period.governing.values)
                yield [
                    str(stage),
                    name,
                    document_nodes.Value(float(period), "s"),
                    limit,
                    interval,
                    by,
                ]


def _limit_cells(at_period: xr.Dataset) -> tuple[document_nodes.Cell, document_nodes.Cell]:
    """A limit with its interval, or on which side of the heights it lies."""
    limit, low, high = (float(at_period[name]) for name in ("limit", "low", "high"))
    side = side_of(limit, at_period)
    if side == "below":
        return document_nodes.Sentence(
            "below {}", [document_nodes.Value(at_period.attrs["lowest"], "m")]
        ), "the first is too high"
    if side == "above":
        return document_nodes.Sentence(
            "above {}", [document_nodes.Value(at_period.attrs["highest"], "m")]
        ), "all hold"
    if _are_from_spectra(at_period):
        return document_nodes.Value(limit, "m"), "none, without runs"
    top = high if high <= at_period.attrs["highest"] else np.inf
    return document_nodes.Value(limit, "m"), document_nodes.Between(max(low, 0.0), top, "m", 3)


def _describe_case(limits: xr.Dataset) -> document_nodes.Nodes:
    yield document_nodes.Sentence(
        "The case of all seas. Heights, peak periods, headings and seeds are those of the study."
    )
    yield from sections.case_nodes(limits, sections.case_data(limits))


def _limit_assumptions(limits: xr.Dataset) -> document_nodes.Nodes:
    spectra = _are_from_spectra(limits)
    assumptions = {
        label: sections.attribute_text(limits.attrs[name])
        for name, label in ASSUMPTION_LABELS.items()
        if name in limits.attrs and not (spectra and name in RUN_ATTRIBUTES)
    }
    yield document_nodes.Table(("assumption", ""), list(assumptions.items()))
    yield document_nodes.Sentence(
        "Nothing was computed between peak periods. Warnings of single runs are not kept:"
        " hydrosim check prints those of the case."
    )


def _are_from_spectra(limits: xr.Dataset) -> bool:
    """Whether limits are from response spectra, of all seeds that there could be."""
    return int(limits.attrs.get("runs", 1)) == 0


def _describe_convergence(limits: xr.Dataset) -> document_nodes.Nodes:
    yield document_nodes.Sentence(
        "This study does not assess how limits change with the step of the solver."
    )


LIMIT_SECTIONS: sections.Sections[xr.Dataset] = {
    "outcome": ("Limits", _describe_outcome),
    "case": ("Case", _describe_case),
    "assumptions": ("Assumptions", _limit_assumptions),
    "convergence": ("Convergence", _describe_convergence),
}
"""Sections by name: the heading, and what gives the nodes below it."""
