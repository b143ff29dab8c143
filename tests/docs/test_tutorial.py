"""The tutorial's files and commands, as they are written there, from an empty folder."""

import re
from pathlib import Path

import pytest
from command_line import Command

TUTORIAL = Path(__file__).parents[2] / "docs" / "tutorial.md"
BLOCK = re.compile(r"^```(yaml|sh)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.mark.bem
def test_what_stands_there_works(hydrosim: Command, tmp_path: Path) -> None:
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
            code, out, err = hydrosim(*arguments)
            assert code == 0, f"{line}\n{out}{err}"
            assert "warning" not in out + err, f"{line}\n{out}"
    for made in ("barge.png", "own_motions.png", "quay_contact.png", "seeds.nc", "quay.html"):
        assert (tmp_path / made).stat().st_size > 1000
