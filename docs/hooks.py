"""What the site is made of besides `docs/`.

Pages of the keys and commands from the program itself; READMEs of cases, databases, benchmarks with
their pictures; links that hold in both places.
"""

from __future__ import annotations

import re
from os.path import relpath
from pathlib import Path
from typing import Any

from key_pages import pages_of
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
BESIDE = ("cases", "hydro_db", "benchmarks")
SHOWN = {".md", ".png", ".yaml"}
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s#]+)(#[^)\s]*)?\)")
READING = """A number without a unit is in the unit of the third column. A text may carry any other
unit of that kind, such as `"12.4 m"`. `NAME` stands for a name that you choose. A key without a
default may be left out unless it is needed. `hydrosim new --schema {kind}` prints the
same for editors.
"""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the pages that are made, and those beside `docs/`."""
    made = {"keys.md": keys, "studies_keys.md": study_keys, "recipes_keys.md": recipe_keys}
    made["commands.md"] = commands
    for name, text in made.items():
        files.append(File.generated(config, name, content=text()))
    files.append(File.generated(config, "index.md", abs_src_path=str(ROOT / "README.md")))
    for path in (p for folder in BESIDE for p in sorted((ROOT / folder).rglob("*"))):
        if path.suffix in SHOWN:
            own = path.relative_to(ROOT).as_posix()
            files.append(File.generated(config, own, abs_src_path=str(path)))
    return files


def on_page_markdown(text: str, page: Page, files: Files, **_: Any) -> str:
    """Links as they hold in the repository, changed to hold in the site; those to files that the
    site has not become plain text. PluginError where a link leads nowhere."""
    real = Path(page.file.abs_src_path or DOCS / page.file.src_uri)

    def changed(found: re.Match[str]) -> str:
        picture, words, target, anchor = found.groups()
        if "://" in target or target.startswith("mailto:"):
            return found[0]
        place = (real.parent / target).resolve()
        own = place.relative_to(ROOT).as_posix().removeprefix("docs/")
        there = files.get_file_from_path(own) is not None
        if not (place.exists() or there):
            raise PluginError(f"{page.file.src_uri}: a link leads to {target}, which is not there")
        if not there:
            return words
        way = relpath(own, Path(page.file.src_uri).parent)
        return f"{picture}[{words}]({way}{anchor or ''})"

    return LINK.sub(changed, text)


def keys() -> str:
    """The keys of case files, from their schema."""
    from hydrosim.interface.new import FileKind

    return _keys(
        FileKind.CASE,
        "# Keys of a case file\n\nA case says what is simulated: bodies, their surroundings,"
        " forces, and how long. `hydrosim new` writes one to begin with. `hydrosim check` names the"
        " line of a mistake.\n",
    )


def study_keys() -> str:
    """The keys of study files."""
    from hydrosim.interface.new import FileKind

    return _keys(
        FileKind.STUDY,
        "# Keys of a study file\n\nA study runs a case many times: `hydrosim study`"
        " takes it. What it is for is told with [many runs](studies.md).\n",
    )


def recipe_keys() -> str:
    """The keys of recipes of databases."""
    from hydrosim.interface.new import FileKind

    return _keys(
        FileKind.RECIPE,
        "# Keys of a recipe\n\nA recipe says which hull `hydrosim db build` computes a database of."
        " [Recipes](recipes.md) shows whole ones.\n",
    )


def _keys(kind: Any, title: str) -> str:
    """A page of keys below its ``title``."""
    from hydrosim.interface.new import schema_of

    return f"{title}\n{READING.format(kind=kind.value)}\n{pages_of(schema_of(kind))}"


def commands() -> str:
    """The commands with their options, as `--help` says them."""
    from typer.main import get_command

    from hydrosim.__main__ import app

    return "# Commands\n" + "".join(_command(get_command(app), "hydrosim"))


def _command(command: Any, name: str) -> list[str]:
    if hasattr(command, "commands"):
        each = command.commands.items()  # in the order of use
        return [part for own, one in each for part in _command(one, f"{name} {own}")]
    table = "| option | what it does | if not given |\n| --- | --- | --- |\n"
    lines = [f"\n## {name}\n\n{command.help}\n\n{table}"]
    for option in command.params:
        names = ", ".join(f"`{x}`" for x in getattr(option, "opts", [option.name]))
        default = option.default
        told = "" if default in (None, False, [], ()) or callable(default) else f"`{default}`"
        text = (getattr(option, "help", "") or "").replace("|", "or")
        lines.append(f"| {names} | {text} | {'needed' if option.required else told} |\n")
    return lines
