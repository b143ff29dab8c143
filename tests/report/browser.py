"""A headless Chromium without a network, as the tests of pages use it."""

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import pytest

SOFTWARE = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


class Opened(NamedTuple):
    """A page, what it said on its console, and what it asked the network for."""

    page: Any
    said: list[str]
    asked: list[str]


@contextmanager
def opened(path: Path, **options: Any) -> Iterator[Opened]:
    """The page of a file in Chromium; skips the test where there is none."""
    if CHROMIUM is None:
        pytest.skip("there is no chromium")
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as p:
        browser = p.chromium.launch(executable_path=CHROMIUM, args=SOFTWARE)
        context = browser.new_context(offline=True, **options)
        page, said, asked = context.new_page(), [], []
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("request", lambda request: asked.append(request.url))
        page.goto(path.as_uri(), wait_until="load")
        page.wait_for_timeout(300)
        yield Opened(page, said, [url for url in asked if url != path.as_uri()])
        browser.close()


COLOURS = """(canvas) => {
  canvas.scrollIntoView({behavior: "instant", block: "center"});
  const copy = document.createElement("canvas");
  copy.width = canvas.width;
  copy.height = canvas.height;
  const g = copy.getContext("2d");
  g.drawImage(canvas, 0, 0);
  const pixels = g.getImageData(0, 0, copy.width, copy.height).data;
  return new Set(new Uint32Array(pixels.buffer)).size;
}"""
"""How many colours a canvas has."""


def until(page: Any, holds: Callable[[], bool]) -> bool:
    """Whether it comes to hold within some seconds: what is drawn is drawn later."""
    for _ in range(100):
        if holds():
            return True
        page.wait_for_timeout(100)
    return False
