"""Tables of the thesis in READMEs are those of the files that the benchmark wrote."""

import csv
import json

import pytest

from cases.reverse_float_over.thesis import pages

NAMES = [page.parent.name for page in pages.PAGES]


@pytest.mark.parametrize("page", pages.PAGES, ids=NAMES)
def test_tables_of_readmes_are_those_that_were_measured(page):
    text = page.read_text()
    assert pages.MARK.search(text)
    assert pages.with_tables(text) == text


def test_each_table_stands_in_one_readme():
    text = "".join(page.read_text() for page in pages.PAGES)
    assert sorted(pages.MARK.findall(text)) == sorted(pages.TABLES)


def test_a_changed_figure_is_noticed():
    text = pages.PAGES[0].read_text()
    changed = text.replace("| -1.20 |", "| -1.30 |", 1)
    assert changed != text
    assert pages.with_tables(changed) == text


def test_tables_name_seeds_and_program():
    origin = json.loads((pages.MEASURED / "origin.json").read_text())
    for table in ("pressed", "sensitivities", "six_degrees", "steel", "wave_force"):
        assert origin[table].keys() >= {"commit", "numpy", "numba", "seeds"}
    with (pages.MEASURED / "score.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert {int(row["row"]) for row in rows} == set(range(1, 15))
