"""Makes docs/bookshelf.png and docs/talos.png: `pip install '.[bench]' && python docs/pictures.py`, with Chromium.

Left a configuration that is valid, with the plane that keeps the nearest pair apart; right one that is not, with what
collides in red and the points that are shared. The pages are those of `plannercheck view --html`.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

import plannercheck as pc

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


def main() -> None:
    """Writes both."""
    here = Path(__file__).parent
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
