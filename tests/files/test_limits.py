"""What is too much for a case file is refused at once, with its place."""

import os
from pathlib import Path

import pytest

from hydrosim.case import load_case
from hydrosim.errors import InputError
from hydrosim.files.messages import MOST_TOLD
from hydrosim.files.yaml_nodes import MAX_LETTERS, MAX_NESTING, MOST_TEXT

BOMB = "a: &a [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{name}: &{name} [{', '.join([f'*{before}'] * 10)}]\n"
    for before, name in zip("abcdefgh", "bcdefghi", strict=True)
)
CHAIN = "a: &a0 [x]\n" + "".join(f"a{k}: &a{k} [*a{k - 1}]\n" for k in range(1, MAX_NESTING + 3))
TOO_MUCH = {
    "aliases": (BOMB, "values, with what aliases stand for"),
    "a chain of aliases": (CHAIN, f"found {MAX_NESTING + 1} levels in each other"),
    "an alias in itself": ("a: &a [1, *a]\n", "an alias within what it stands for"),
    "a mapping in itself": ("a: &a {b: *a}\n", "an alias within what it stands for"),
    "brackets": ("[" * 3000 + "]" * 3000, "nested too deeply"),
    "levels": ("[" * (MAX_NESTING + 2) + "]" * (MAX_NESTING + 2), "levels in each other"),
    "a list": ("a: [" + "1," * MOST_TEXT + "]", "characters; expected at most"),
    "a key": (f"? {'x' * (MAX_LETTERS['key'] + 1)}\n: 1\n", "found a key of 101 characters"),
    "a text": ("title: " + "x " * MAX_LETTERS["text"], "found a text of 19999 characters"),
    "half a character": ('title: "\\ud800"\n', r"found the character U\+D800 in a text"),
    "a key that steers a terminal": ('"\\e[2J": 1\n', r"found the character U\+001B in a key"),
    "no character": ('title: "\\U00110000"\n', "not valid YAML"),
}


@pytest.mark.parametrize("what", TOO_MUCH)
def test_too_much_is_refused(what: str, tmp_path: Path) -> None:
    text, told = TOO_MUCH[what]
    path = tmp_path / "case.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=told) as caught:
        load_case(path)
    assert str(caught.value).startswith(f"{path}:")
    assert len(str(caught.value)) < len(str(path)) + 300


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "case.yaml")
    with pytest.raises(InputError, match="found a pipe or a device"):
        load_case(tmp_path / "case.yaml")


def test_a_name_that_is_too_long_for_the_disk(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        load_case(tmp_path / ("x" * 5000))


def test_aliases_in_measure_are_read(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    path.write_text("title: x\nbodies: {a: &a {mass: 1, dofs: [surge]}, b: *a}\nduration: 1\n")
    assert load_case(path).data.bodies["b"].mass == 1.0


def test_a_list_of_thousands_is_not_answered_with_thousands_of_lines(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    many = "true," * 3000
    path.write_text(f"title: x\nbodies: {{a: {{mass: 1, dofs: [{many}]}}}}\nduration: 1\n")
    with pytest.raises(InputError) as caught:
        load_case(path)
    *lines, last = str(caught.value).splitlines()
    assert len(lines) == MOST_TOLD
    assert last == f"{3000 - MOST_TOLD} more problems are not shown. Correct these first."
