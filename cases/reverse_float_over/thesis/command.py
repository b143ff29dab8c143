"""All tables of the thesis, over as many seeds as asked for."""

from __future__ import annotations

import json
import os
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path

from benchmarks.report import Row, machine, markdown
from cases.reverse_float_over.thesis.one_dimension import STATEMENTS
from cases.reverse_float_over.thesis.pages import write_tables
from cases.reverse_float_over.thesis.runner import (
    KEPT,
    MEASURED,
    Figures,
    Record,
    complete_seeds,
    compute_missing,
    cpu_of_seed,
    table_module,
)
from cases.reverse_float_over.thesis.score import score
from cases.reverse_float_over.thesis.statements import rows_of_shares
from cases.reverse_float_over.thesis.tables import read_rows, rows_of, write_rows

TABLES = (
    "one_dimension",
    "exact",
    "lagged",
    "resolution",
    "six_degrees",
    "sensitivities",
    "wave_force",
    "pressed",
    "steel",
    "block",
)


def main(arguments: Sequence[str]) -> None:
    """Make the runs that are missing, write the tables as CSV files and print the score card."""
    options = _options(arguments)
    folder = MEASURED if options.keep else options.runs
    records = _records(options)
    for table in dict.fromkeys(record.table for record in records):
        of_table = [record for record in records if record.table == table]
        path = folder / f"{table}.csv"
        write_rows(rows_of(of_table), path)
        print(f"{table_module(table).TABLE}: {path}\n    {_cost(of_table)}")
    shares = _shares_of_statements(records)
    if shares:
        write_rows(shares, folder / "one_dimension_shares.csv")
    card = score(records)
    if card:
        write_rows(with_other_models(card, folder / "score.csv"), folder / "score.csv")
        short = [{key: row[key] for key in row if key != "quote"} for row in card]
        print(f"\n{markdown(short)}")
    _write_origin(records, folder)
    if options.keep:
        write_tables()


def _records(options: Namespace) -> list[Record]:
    """Figures of all runs, or of those that are made."""
    if options.so_far:
        return complete_seeds(options.tables, options.runs)
    seeds = range(1, options.seeds + 1)
    return compute_missing(options.tables, seeds, options.workers, options.runs)


def _options(arguments: Sequence[str]) -> Namespace:
    parser = ArgumentParser(prog="python -m cases.reverse_float_over.thesis", description=__doc__)
    parser.add_argument("--seeds", type=_positive, default=50, help="1 to this number; default 50")
    parser.add_argument("--tables", nargs="+", choices=TABLES, default=TABLES, help="default all")
    parser.add_argument(
        "--workers", type=_positive, default=os.cpu_count() or 1, help="default: all cores"
    )
    parser.add_argument("--runs", type=Path, default=KEPT, help="folder of the figures of runs")
    so_far = "make no runs; tables of the seeds whose runs are made"
    parser.add_argument("--so-far", action="store_true", help=so_far)
    kept = "write the tables to the folder measured beside this and into the READMEs of cases"
    parser.add_argument("--keep", action="store_true", help=kept)
    return parser.parse_args(arguments)


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise ValueError(text)
    return number


def _cost(records: Sequence[Record]) -> str:
    """CPU time of the runs, and how long fifty seeds take."""
    seed = cpu_of_seed(records)
    return (
        f"{len(records)} runs, {seed:.1f} s of CPU a seed;"
        f" fifty seeds take {50 * seed / 2 / 60:.0f} min on two idle cores"
    )


def _shares_of_statements(records: Sequence[Record]) -> list[Row]:
    """Of how many seeds each statement on the one-dimensional model holds."""
    seeds: dict[int, dict[str, Figures]] = {}
    for record in records:
        if record.table == "one_dimension":
            seeds.setdefault(record.seed, {})[record.variant] = record.figures
    return rows_of_shares(STATEMENTS, seeds.values()) if seeds else []


def with_other_models(card: Sequence[Row], path: Path) -> list[Row]:
    """The rows of a card, and those of a kept one that are about other models."""
    models = {row["model"] for row in card}
    before = read_rows(path) if path.exists() else []
    kept: list[Row] = [dict(row) for row in before if row["model"] not in models]
    return sorted([*card, *kept], key=lambda row: int(row["row"]))


def _write_origin(records: Sequence[Record], folder: Path) -> None:
    """What each table was made with, and of which seeds. Other tables keep theirs."""
    path = folder / "origin.json"
    origin = json.loads(path.read_text()) if path.exists() else {}
    seeds: dict[str, set[int]] = {}
    for record in records:
        seeds.setdefault(record.table, set()).add(record.seed)
    for table, found in seeds.items():
        origin[table] = {**machine(), "seeds": " ".join(map(str, sorted(found)))}
    path.write_text(json.dumps(origin, indent=2) + "\n")
