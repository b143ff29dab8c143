"""The tasks of the cookbook, as they are written there, from an empty folder."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
from command_line import Command

import hydrosim as hs

COOKBOOK = Path(__file__).parents[2] / "docs" / "cookbook.md"
BLOCK = re.compile(r"^```(yaml|sh|python)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
MAX_LINES = 12
"""Lines of a block."""


def test_tasks_are_short() -> None:
    text = COOKBOOK.read_text()
    assert text.count("\n## ") >= 20
    assert max(len(block.split("\n")) - 1 for _, block in BLOCK.findall(text)) <= MAX_LINES


@pytest.mark.slow
def test_every_task_works(hydrosim: Command, tmp_path: Path) -> None:
    for kind, text in BLOCK.findall(COOKBOOK.read_text()):
        if kind == "python":
            exec(compile(text, "docs/cookbook.md", "exec"), {"__name__": "__main__", "hs": hs})
        elif kind == "yaml":
            name = text.splitlines()[0].partition("# file: ")[2]
            if name:
                (tmp_path / name).write_text(text)
        else:
            for line in text.splitlines():
                program, *arguments = shlex.split(line)
                assert program == "hydrosim"
                code, out, err = hydrosim(*arguments)
                assert code == 0, f"{line}\n{out}{err}"
                assert "note" not in err, line
    plt.close("all")
    for file in ("own_motions.png", "base_report.html", "pictures/base_channels.svg", "keys.yaml"):
        assert (tmp_path / file).stat().st_size > 100
