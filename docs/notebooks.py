"""The notebooks of `docs/notebooks/` as pages: executed as the site is built, each in an empty
folder, and shown with what they print and draw. A cell that fails fails the build.

In the repository they are without outputs.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import nbformat
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from nbclient import NotebookClient

HERE = Path(__file__).parent
ANSI = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")
LONGEST = 300  # s of a cell


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds a page for each notebook; the notebook itself goes along, to be taken from there."""
    for path in sorted((HERE / "notebooks").glob("*.ipynb")):
        own = path.relative_to(HERE).with_suffix(".md").as_posix()
        files.append(File.generated(config, own, content="\n\n".join(_page(path))))
    return files


def executed(path: Path) -> Any:
    """A notebook with its outputs. Commands are those of this Python."""
    own = str(Path(sys.executable).parent)
    os.environ["PATH"] = os.pathsep.join([own, os.environ.get("PATH", "")])
    notebook = nbformat.read(path, as_version=4)
    with TemporaryDirectory() as folder:
        there = {"metadata": {"path": folder}}
        NotebookClient(
            notebook, timeout=LONGEST, resources=there, extra_arguments=["--log-level=ERROR"]
        ).execute()
    return notebook


def _page(path: Path) -> Iterator[str]:
    for k, cell in enumerate(executed(path).cells):
        if cell.cell_type == "markdown":
            yield re.sub(r"\.ipynb\)", ".md)", cell.source)
            if k == 0:
                yield f'*This page is a notebook: <a href="{path.name}" download>take it</a>.*'
            continue
        yield f"```{_language(cell.source)}\n{cell.source}\n```"
        streams = "".join(each.text for each in cell.outputs if each.output_type == "stream")
        yield from _fenced(streams)
        for each in cell.outputs:
            if "data" in each:
                yield from _shown(each.data)


def _language(source: str) -> str:
    first = source.partition("\n")[0]
    return "sh" if first == "%%sh" else "yaml" if first.endswith(".yaml") else "python"


def _shown(data: dict[str, str]) -> Iterator[str]:
    """An output as a browser shows it best."""
    if "image/png" in data:
        picture = data["image/png"].replace("\n", "")
        yield f'<img alt="{escape(data["text/plain"])}" src="data:image/png;base64,{picture}">'
    elif "text/html" in data:
        yield f"<div>{' '.join(data['text/html'].split())}</div>"
    else:
        yield from _fenced(data["text/plain"])


def _fenced(text: str) -> Iterator[str]:
    """What was printed, without colours, and of lines that were written over the last state."""
    lines = (ANSI.sub("", line).rpartition("\r")[2] for line in text.splitlines())
    if shown := "\n".join(lines).strip("\n"):
        yield f"```text\n{shown}\n```"
