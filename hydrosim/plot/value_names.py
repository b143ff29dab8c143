"""Short names of values in pictures of studies: lists and long texts become letters with a key."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill, shorten

from hydrosim.documents.value_text import letter_of, value_text

MAX_LETTERS_OF_NAME = 12
MAX_LETTERS_OF_ALL_NAMES = 54
MAX_LETTERS_OF_MEANING = 240
LETTERS_OF_KEY_LINE = 42


class ValueNames:
    """Names of values beside axes. Values that are too long for an axis get letters, the same ones
    in all panels of a picture; `key` says what they mean."""

    def __init__(self) -> None:
        self._letters: dict[str, str] = {}

    def names_of(self, values: Sequence[object]) -> list[str]:
        """A name for each of the ``values``, which stand beside one axis."""
        texts = [value_text(value) for value in values]
        room = min(MAX_LETTERS_OF_NAME, max(4, MAX_LETTERS_OF_ALL_NAMES // max(len(texts), 1)))
        if all(len(text) <= room for text in texts):
            return texts
        return [self._letters.setdefault(text, letter_of(len(self._letters))) for text in texts]

    def key(self) -> list[str]:
        """Each letter with its value, in lines that fit beside a picture."""
        return [
            fill(
                f"{letter}: {shorten(text, MAX_LETTERS_OF_MEANING, placeholder=' ...')}",
                LETTERS_OF_KEY_LINE,
            )
            for text, letter in self._letters.items()
        ]
