"""What commands print: tables, and lines of text as they are."""

from __future__ import annotations

from rich.console import Console, RenderableType


def show(*parts: RenderableType) -> None:
    """Tables, and lines as they are: no markup, no colours, not broken."""
    out = Console()
    for part in parts:
        if isinstance(part, str):
            out.print(part, markup=False, highlight=False, soft_wrap=True)
        else:
            out.print(part)
