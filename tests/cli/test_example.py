"""Cases that come with the program can be written, and run where they are."""

from pathlib import Path

import pytest
from command_line import command, refusal

import hydrosim as hs


@pytest.mark.parametrize("name", ["reverse_float_over", "topside_removal", "one_dimensional"])
def test_an_example_is_whole(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every case of it can be read where it was written, with all files that it names."""
    run = command(monkeypatch, capsys, "example")
    assert name in run().out
    result = run(name, "-o", tmp_path)
    assert result.code == 0
    assert f"about {tmp_path}/cases/{name}/README.md" in result.out
    assert (tmp_path / "cases" / name / "README.md").is_file()
    cases = sorted((tmp_path / "cases" / name).glob("*.yaml"))
    assert cases
    for path in cases:
        assert all(file.is_relative_to(tmp_path) for file in hs.load_case(path).inputs())


def test_unknown_examples(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    example = command(monkeypatch, capsys, "example")
    said = refusal(example, tmp_path, "base", "-o", tmp_path)
    assert "expected one of chain, flap, flume" in said
