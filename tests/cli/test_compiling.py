"""A compile is announced where one begins, and only there."""

from pathlib import Path

from command_line import printed

TESTS = Path(__file__).parents[1]
PROGRAM = """
import sys
from rich.console import Console
from hydrosim.cli.terminal import announce_compiling
import linked_kernels, test_linking as here
with announce_compiling(Console(file=sys.stdout)):
    print("begin")
    linked_kernels.scaled(1.0, here.SCALE)
    linked_kernels.summed(here.VALUES, here.SCALE)
"""


def test_the_first_compile_is_announced_once(tmp_path: Path) -> None:
    first, *rest = said(tmp_path)
    assert first == "begin"  # not before it is known that something is to be compiled
    assert "".join(rest).startswith("compiling kernels")
    assert "".join(rest).count("compiling") == 1
    assert str(tmp_path) in "".join(rest)


def test_what_is_on_disk_is_not_announced(tmp_path: Path) -> None:
    said(tmp_path)
    assert said(tmp_path) == ["begin"]


def said(cache: Path) -> list[str]:
    """What `PROGRAM` prints in a new process with this cache folder."""
    paths = {
        "PYTHONPATH": f"{TESTS.parent}:{TESTS}:{TESTS / 'jit'}",
        "HYDROSIM_CACHE_DIR": str(cache),
    }
    return printed(PROGRAM, **paths).splitlines()
