"""Sentences of pages are short enough to be read at once."""

from long_sentences import long_sentences


def test_pages_have_no_long_sentences() -> None:
    assert [each for each in long_sentences() if each.place.endswith(".md")] == []
