"""Runs of the tables of the thesis are kept, and made again only where something has changed."""

import csv
import json
import subprocess
import sys
from collections import defaultdict
from dataclasses import asdict, replace

import numpy as np
import pytest
from scenes import ROOT
from scipy.stats import binomtest, t

from cases.reverse_float_over.thesis import score
from cases.reverse_float_over.thesis.command import TABLES, with_other_models
from cases.reverse_float_over.thesis.runner import (
    Record,
    complete_seeds,
    made_with,
    read_records,
    table_module,
)
from cases.reverse_float_over.thesis.score import figures_by_seed
from cases.reverse_float_over.thesis.tables import rows_of, write_rows

PROGRAM = [sys.executable, "-m", "cases.reverse_float_over.thesis"]
TABLE, VARIANT = "six_degrees", "four fenders, 0.2/0.1"


def _record(seed, made=None):
    return Record(TABLE, VARIANT, seed, made or made_with(TABLE, VARIANT), 0.4, {"surge": -1.2})


def _write(folder, *records):
    lines = [json.dumps(asdict(record)) for record in records]
    (folder / f"{TABLE}.jsonl").write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize(
    ("written", "counted"),
    [
        ([_record(1), _record(2)], [0, 1]),
        ([_record(1), replace(_record(1), cpu=0.7)], [1]),  # the last of a run
        ([_record(1, "another program"), _record(2)], [1]),
        ([replace(_record(1), variant="five fenders"), _record(2)], [1]),
    ],
)
def test_records_of_this_program_and_of_variants_that_are_count(tmp_path, written, counted):
    _write(tmp_path, *written)
    assert read_records(TABLE, tmp_path) == [written[k] for k in counted]


def test_seeds_count_once_all_their_variants_are_made(tmp_path):
    variants = list(table_module(TABLE).VARIANTS)
    whole = [replace(_record(2, made_with(TABLE, name)), variant=name) for name in variants]
    _write(tmp_path, _record(1), *reversed(whole))
    assert complete_seeds([TABLE], tmp_path) == whole


def test_a_line_that_was_cut_short_does_not_count(tmp_path):
    _write(tmp_path, _record(1), _record(2))
    path = tmp_path / f"{TABLE}.jsonl"
    path.write_text(path.read_text()[:-20])
    assert read_records(TABLE, tmp_path) == [_record(1)]


def test_settings_are_part_of_what_a_run_is_made_with(monkeypatch):
    before = made_with(TABLE, VARIANT)
    changed = {**table_module(TABLE).VARIANTS, VARIANT: {"duration": 1.0}}
    monkeypatch.setattr(table_module(TABLE), "VARIANTS", changed)
    made_with.cache_clear()
    try:
        assert made_with(TABLE, VARIANT) != before
    finally:
        made_with.cache_clear()


def test_the_score_counts_the_seeds_that_agree():
    variants = table_module("sensitivities").VARIANTS
    ends = {seed: -1.0 if seed <= 3 else -2.0 for seed in range(1, 11)}
    figures = dict.fromkeys(_names_of_base_figures(), 0.0)
    records = [
        Record("sensitivities", variant, seed, "", 0.0, {**figures, "surge_2000": end})
        for variant in variants
        for seed, end in ends.items()
    ]
    rows = {row["statement"]: row for row in score.score(records)}
    assert (rows["ends at 120 m"]["agree"], rows["ends at 120 m"]["n"]) == (3, 10)
    assert rows["moored surge is positive"]["agree"] == 0


def _names_of_base_figures():
    return (
        *(f"surge_{time}" for time in (600, 1000, 1500, 2000)),
        *("initial_contact_lasts", "compressed_lasts", "stuck_lasts", "stick_1500_2000"),
        *("fenders_moving_ahead", "fenders_moving_back", "moored_mean"),
        *("velocity_stuck", "heave_velocity", "last_slip", "surge_end"),
    )


@pytest.mark.parametrize("model", score.MODELS, ids=lambda model: model.name)
def test_statements_name_variants_that_tables_have(model):
    variants = table_module(model.table).VARIANTS

    def of(variant):
        assert model.variant_of(variant) in variants
        return defaultdict(float)

    for statement in model.tests:
        statement(of)


def test_every_statement_quotes_the_thesis():
    tests = {test for model in score.MODELS for test in model.tests}
    assert len(tests) > 25
    assert {row for model in score.MODELS for row in model.tests.values()} == set(range(1, 15))
    for test in tests:
        quote, _, place = test.__doc__.rpartition("(")
        assert "'" in quote
        assert place[0].isdigit() or place == "abstract)"


def test_an_unknown_table_is_refused():
    command = [*PROGRAM, "--tables", "seven_degrees"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "six_degrees" in done.stderr


@pytest.mark.slow
def test_three_seeds_of_all_tables(tmp_path):
    # `exact` is tests/validation/test_one_dimension.py
    tables = [table for table in TABLES if table != "exact"]
    command = [*PROGRAM, "--seeds", "3", "--runs", tmp_path, "--tables", *tables]
    first = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    files = sorted(tmp_path.glob("*.jsonl"))
    assert len(files) >= 6
    for file in files:
        _compare_means(file)
    _compare_shares(tmp_path)
    kept = [file.read_text() for file in files]
    second = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    assert second.stdout == first.stdout
    assert second.stderr == ""
    assert [file.read_text() for file in files] == kept


def _compare_means(file):
    """Each row of a table against numpy and scipy."""
    records = [json.loads(line) for line in file.read_text().splitlines()]
    rows = list(csv.DictReader(file.with_suffix(".csv").open()))
    assert rows
    for row in rows:
        of_variant = [r["figures"] for r in records if r["variant"] == row["variant"]]
        values = np.array([figures[row["figure"]] for figures in of_variant])
        values = values[np.isfinite(values)]
        assert int(row["n"]) == values.size
        if values.size > 1:
            error = values.std(ddof=1) / np.sqrt(values.size)
            half = t.ppf(0.95, values.size - 1) * error
            found = [float(row[name]) for name in ("mean", "lower", "upper", "deviation")]
            mean = values.mean()
            expected = [mean, mean - half, mean + half, values.std(ddof=1)]
            assert found == pytest.approx(expected, rel=1e-5, abs=1e-5 * abs(values).max())


def _compare_shares(folder):
    """Each row of the score card against scipy."""
    rows = list(csv.DictReader((folder / "score.csv").open()))
    assert {int(row["row"]) for row in rows} == set(range(1, 15))
    for row in rows:
        agree, n = int(row["agree"]), int(row["n"])
        assert n == (1 if row["model"] == "block" else 3)
        interval = binomtest(agree, n).proportion_ci(0.9, "wilson")
        found = [float(row[name]) for name in ("share", "lower", "upper")]
        assert found == pytest.approx([agree / n, interval.low, interval.high], abs=1e-5)


def test_a_table_that_is_made_anew_keeps_the_others(tmp_path):
    """The card of one model replaces its own rows; those of other models stay as they were."""
    path = tmp_path / "score.csv"
    old = [_row_of(3, "pressed", "1"), _row_of(6, "base", "7")]
    write_rows(old, path)
    found = with_other_models([_row_of(3, "pressed", "5")], path)
    assert found == [_row_of(3, "pressed", "5"), {**old[1], "row": "6"}]


def test_a_run_that_cannot_continue_does_not_count():
    """Neither in means nor, with all of its seed, in the score."""
    whole = [replace(_record(seed), figures={"surge": -float(seed)}) for seed in (1, 2, 3)]
    records = [*whole, replace(_record(4), figures={})]
    (row,) = rows_of(records)
    assert (row["n"], row["mean"]) == (3, -2.0)
    assert set(figures_by_seed(records)[TABLE]) == {1, 2, 3}


def _row_of(number, model, agree):
    return {"row": number, "statement": "it crawls", "model": model, "agree": agree}
