"""Pictures of `docs/gallery.md`: a still of the replay of each case, and one of its channels.

``python docs/gallery.py FOLDER`` keeps the runs in FOLDER and writes `docs/gallery/NAME.png`. It
needs the extra `report` and Chromium.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
import xarray as xr
from PIL import Image

import hydrosim as hs

ROOT = Path(__file__).parents[1]
PICTURES = Path(__file__).parent / "gallery"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
OPTIONS = ("--headless", "--no-sandbox", "--hide-scrollbars", "--use-angle=swiftshader")
WINDOW = (1000, 800)  # pixels of the browser
CANVAS = (17, 17, 983, 535)  # pixels of the window that the replay fills
SIZE = (7.6, 2.33)  # inches at 100 dots each
COLOURS = 96  # of the palette of a picture
STILL = """<script>addEventListener("load", () => {
  const slider = document.querySelector("input[type=range]");
  slider.min = 0; slider.max = 1e9; slider.value = "%s";
  slider.dispatchEvent(new Event("input"));
  document.querySelector("canvas.names").style.display = "none";
  const canvas = document.querySelector("canvas");
  canvas.dispatchEvent(new WheelEvent("wheel", {deltaY: %s, ctrlKey: true, cancelable: true}));
  for (let part = canvas; part !== document.body; part = part.parentElement)
    for (let above = part; above = above.previousElementSibling;) above.style.display = "none";
});</script>"""
"""Sets the time of a replay, and how much further away one looks."""


class Entry(NamedTuple):
    """A case, what its chart shows, and the time of the still [s]; no still if None."""

    case: str
    channels: str | tuple[str, ...]
    time: float | None = None
    span: tuple[float, float] | None = None
    wheel: float = 0.0
    names: tuple[str, ...] = ()


ENTRIES = (
    Entry("reverse_float_over/base", "position.barge.surge", 910.0, wheel=-300.0),
    Entry(
        "topside_removal/removal",
        ("clearance.deck_to_keel", "clearance.legs"),
        5000.0,
        names=("barge to topside", "topside to legs"),
    ),
    Entry(
        "mating/mating",
        ("fender_normal_force.legs", "fender_normal_force.interface"),
        5400.0,
        names=("legs on their seats", "topside on the barge"),
    ),
    Entry("lock_in/pins", "position.barge.surge", 900.0, wheel=-300.0),
    Entry(
        "lift_over_the_side/over_the_side",
        ("position.barge.sway", "position.load.sway"),
        200.0,
        wheel=-300.0,
        names=("barge", "load"),
    ),
    Entry("tender_alongside/alongside", "spring_tension.bow_breast", 300.0, (200.0, 400.0)),
    Entry("turret_tanker/storm", "line_tension.line_1", 1800.0, (1200.0, 2400.0)),
    Entry("hinged_barges/irregular", "joint_position.*", 300.0, (200.0, 400.0), 300.0),
    Entry("flap/irregular", "joint_position.*", 300.0, (200.0, 400.0)),
    Entry(
        "point_absorber/irregular",
        "position.*.heave",
        300.0,
        (200.0, 400.0),
        wheel=200.0,
        names=("spar", "float"),
    ),
    Entry("sphere/irregular", "position.sphere.heave", None, (200.0, 400.0)),
    Entry("flume/free", "position.section.roll"),
    Entry("chain/circle", "line_tension.chain"),
    Entry("friction_block/exact", "position.block.surge", None, (0.0, 300.0)),
    Entry("one_dimensional/base", "position.barge.surge"),
    Entry("numerical_oscillation/base", "position.barge.surge"),
)


def open_result(entry: Entry, folder: Path) -> xr.Dataset:
    """The run of a case, made if ``folder`` does not have it."""
    path = folder / f"{entry.case.replace('/', '_')}.nc"
    if not path.exists():
        hs.simulate(hs.load_case(ROOT / "cases" / f"{entry.case}.yaml"), output=path)
    return hs.open_run(path)


def take_still(run: xr.Dataset, entry: Entry, folder: Path) -> Image.Image:
    """The replay of a run at the time of its ``entry``, as Chromium draws it."""
    page = folder / "replay.html"
    run.hydrosim.report(page, replay=True, overwrite=True)
    text = re.sub(r"<meta[^>]*Content-Security-Policy[^>]*>", "", page.read_text("utf-8"))
    script = STILL % (entry.time, entry.wheel)
    page.write_text(text.replace("</body>", f"{script}</body>"), "utf-8")
    picture = folder / "still.png"
    shot = (f"--screenshot={picture}", f"--window-size={WINDOW[0]},{WINDOW[1]}")
    command = (CHROMIUM, *OPTIONS, *shot, "--virtual-time-budget=5000", page.as_uri())
    subprocess.run(command, check=True, capture_output=True)
    return Image.open(picture).convert("RGB").crop(CANVAS)


def draw_entry(entry: Entry, folder: Path) -> None:
    """Writes the picture of an ``entry``."""
    run = open_result(entry, folder)
    figure = plt.figure(figsize=SIZE, dpi=100)
    if entry.time is None:
        axes = figure.add_axes((0.1, 0.19, 0.88, 0.78))
    else:
        still = figure.add_axes((0.0, 0.0, 0.57, 1.0))
        still.imshow(take_still(run, entry, folder))
        still.axis("off")
        axes = figure.add_axes((0.675, 0.19, 0.315, 0.78))
    start, end = entry.span or (0.0, float(run.time[-1]))
    run.sel(time=slice(start, end)).hydrosim.plot.channels(entry.channels, ax=axes)
    for line, name in zip(axes.lines, entry.names, strict=False):
        line.set_label(name)
    axes.legend(
        fontsize=7, handlelength=1.2, framealpha=0.6
    ) if entry.names else axes.legend_.remove()
    stream = BytesIO()
    figure.savefig(stream, format="png")
    plt.close(figure)
    picture = Image.open(stream).convert("RGB").quantize(COLOURS)
    picture.save(PICTURES / f"{entry.case.partition('/')[0]}.png", optimize=True)


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    names = sys.argv[2:]
    for entry in ENTRIES:
        if not names or entry.case.partition("/")[0] in names:
            draw_entry(entry, folder)
