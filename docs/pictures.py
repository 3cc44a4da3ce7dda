"""Makes docs/bookshelf.png, talos.png and key.png: `pip install '.[bench]' && python docs/pictures.py`, with Chromium.

Left a configuration that is valid, with the plane that keeps the nearest pair apart; right one that is not, with what
collides in red and the points that are shared. Of the key in its lock, left with hulls, then twice with solids: where
it starts, and on its way out. The pages are those of `plannercheck view --html`. Names of pictures choose some of them.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

import plannercheck as pc
from plannercheck.common.package_data import shipped_folder

SIZE = 560, 460
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--hide-scrollbars",
    "--virtual-time-budget=2000",
    f"--window-size={SIZE[0]},{SIZE[1]}",
)
SOFTWARE_GL = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


def photograph(picture: pc.view.Picture, view: str, folder: Path) -> Image.Image:
    """A page as Chromium shows it, at the place in its address that says how."""
    browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))))
    page, image = folder / "page.html", folder / "page.png"
    pc.view.write_page(picture, page)
    profile = f"--user-data-dir={folder / 'profile'}"
    command = [browser, *FLAGS, *SOFTWARE_GL, profile, f"--screenshot={image}", f"{page.as_uri()}#{view}"]
    subprocess.run(command, check=True, capture_output=True)
    return Image.open(image).convert("RGB")


def side_by_side(images: list[Image.Image], path: Path) -> None:
    """Writes images into one."""
    whole = Image.new("RGB", (sum(image.width for image in images), images[0].height))
    for k, image in enumerate(images):
        whole.paste(image, (k * image.width, 0))
    whole.save(path, optimize=True)


def key(folder: Path) -> list[Image.Image]:
    """The key in its lock, with hulls and with solids."""
    puzzles = shipped_folder("configs") / "puzzles"
    hulls = pc.Checker(pc.Robot.load(puzzles / "key.yaml", geometry="hull"), pc.Scene.load(puzzles / "lock.yaml"))
    solids = pc.Checker(pc.Robot.load(puzzles / "key.yaml"), pc.Scene.load(puzzles / "lock.yaml", meshes="solid"))
    start, in_the_slot = solids.scene.start("key"), np.array([0.245, 0, 0, 0, 0, 0, 1])
    view = "bare=1&distance=2.3&azimuth=-140&elevation=18&target=0.1,0,0"
    shots = (hulls, start), (solids, start), (solids, in_the_slot)
    return [photograph(pc.view.picture(checker, q), view, folder) for checker, q in shots]


def main() -> None:
    """Writes those that are asked for, or all."""
    here, asked = Path(__file__).parent, sys.argv[1:]
    if not asked or "key" in asked:
        with tempfile.TemporaryDirectory() as name:
            side_by_side(key(Path(name)), here / "key.png")
    if not asked or {"bookshelf", "talos"} & set(asked):
        _robots(here)


def _robots(here: Path) -> None:
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    shelf = pc.Checker(robot, scene)
    hit = next(
        q for q in scene.samples("panda") if _touches(shelf, q, {("panda_link7", "shelf"), ("panda_hand", "shelf")})
    )
    talos = pc.Checker(pc.Robot.load("talos"))
    q = talos.robot.random_configurations(3000, 0)
    crossed = next(
        row for row in q[~talos.check_states(q)] if _touches(talos, row, {("torso_2_link", "arm_left_5_link")})
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        camera = "bare=1&distance=2.2&elevation=16"
        shots = [("azimuth=-135&target=0.35,0,0.5", scene.goal("panda")), ("azimuth=-60&target=0.45,0,0.45", hit)]
        rows = [photograph(pc.view.picture(shelf, q, planes=1), f"{camera}&{view}", folder) for view, q in shots]
        side_by_side(rows, here / "bookshelf.png")
        view = "bare=1&distance=3.0&azimuth=-35&elevation=12"
        rows = [photograph(pc.view.picture(talos, row), view, folder) for row in (talos.robot.reference, crossed)]
        side_by_side(rows, here / "talos.png")


def _touches(checker: pc.Checker, q: np.ndarray, pairs: set[tuple[str, str]]) -> bool:
    """Whether pairs collide, and not many others."""
    found = {(v.first, v.second) for v in checker.explain(q).collisions}
    return pairs <= found and len(found) <= len(pairs) + 2


if __name__ == "__main__":
    main()
