"""The examples in the docstrings of public functions run as they stand."""

from doctest import DocTestFinder, DocTestRunner
from pathlib import Path

import numpy as np
import pytest

import hydrosim as hs
from hydrosim.interface.accessor import RunAccessor
from hydrosim.interface.analyse import analyse, fit_decay
from hydrosim.interface.compare import compare, export
from hydrosim.interface.new import write_new_case
from hydrosim.interface.study import study
from hydrosim.study.many_runs import simulate_many

ROOT = Path(__file__).parents[2]
PUBLIC = (
    *(hs.load_case, hs.simulate, hs.open_run, hs.check, analyse, fit_decay, study, simulate_many),
    *(compare, export, write_new_case, RunAccessor.channel),
)


@pytest.mark.parametrize("function", PUBLIC, ids=lambda function: function.__name__)
def test_the_example_runs(function, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for folder in ("cases", "hydro_db"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    names = {"hs": hs, "np": np, "Path": Path}
    (example,) = DocTestFinder(recurse=False).find(function, function.__name__, globs=names)
    assert example.examples
    assert DocTestRunner().run(example).failed == 0
