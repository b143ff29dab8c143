"""The tutorial's files and commands, as they are written there, from an empty folder."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

TUTORIAL = Path(__file__).parents[2] / "docs" / "tutorial.md"
BLOCK = re.compile(r"^```(yaml|sh)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.mark.bem
def test_what_stands_there_works(tmp_path: Path) -> None:
    """Every command ends well and none warns: the barge is meant to be a sound one."""
    pytest.importorskip("capytaine")
    blocks = BLOCK.findall(TUTORIAL.read_text())
    assert len(blocks) > 8
    for kind, text in blocks:
        if kind == "yaml":
            name = text.splitlines()[0].removeprefix("# file: ")
            (tmp_path / name).write_text(text)
            continue
        for line in text.splitlines():
            program, *arguments = line.split()
            assert program == "hydrosim"
            command = [sys.executable, "-m", "hydrosim", *arguments]
            done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
            assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}"
            assert "warning" not in done.stdout + done.stderr, f"{line}\n{done.stdout}"
    for made in ("barge.png", "own_motions.png", "quay_contact.png", "seeds.nc", "quay.html"):
        assert (tmp_path / made).stat().st_size > 1000
