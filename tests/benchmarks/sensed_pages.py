"""How large pages of sensed scenes are, and how fast a browser draws them: `python tests/benchmarks/sensed_pages.py`.

A cloud of a million points and a map of a building of a million cells are written as pages of `plannercheck view`.
Chromium without a window turns each picture around, frame by frame, and waits for every frame's pixels: all parts in
one frame; all in slices, one a frame, as at rest; or what is drawn while the view moves. It draws by software
(SwiftShader) on the processor, since a test machine has no graphics card: a card takes less. What a frame takes is the
processor time of all of Chromium for many frames, less that for few: other work does not count, but for the page's own
clock, by which it draws less when the processor is busy.
"""

from __future__ import annotations

import argparse
import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from browser import BROWSER, browser_flags

import plannercheck as pc
from plannercheck.evaluation.bench.clouds import NAME, sensed_scene
from plannercheck.evaluation.bench.records import write_record
from plannercheck.evaluation.sensing.buildings import building
from plannercheck.view import picture
from plannercheck.view.page import page_of

# Goes before the end of a page: turned frames, then a word for the dumped page.
_TURN = """
const pixel = new Uint8Array(4), drawn = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
let slices = 0, parts_ = 0;
for (let k = 0; k < COUNT; k++) {
  camera.azimuth += 0.1;
  DRAW
  drawn();
  slices += layer.slices;
  parts_ += layer.chosen.slice(0, layer.next).reduce((sum, each) => sum + each.count, 0);
}
document.documentElement.innerHTML = `<pre>drawn ${slices / COUNT} ${parts_ / COUNT}</pre>`;
</script>
</body>"""
# How a frame is drawn.
_WAYS = {
    "still": "draw(true);",
    "sliced": "do { prepare(); drawLayer(false); } while (unfinished()); prepare(); paintAll();",
    "moving": "moving = true; draw();",
}
_END = "</script>\n</body>"
# Frames that are drawn in either run, and what a run may take, s.
_FEW, _PATIENCE = 2, 900
# So many times the frames where each takes less: loading a page varies by more than a frame takes.
_MORE = {"still": 1, "sliced": 1, "moving": 8}


def cloud_scene(count: int) -> pc.Scene:
    """A bookshelf as cameras see it."""
    return sensed_scene(pc.Scene.load("bookshelf"), count, 0)


def bare_scene() -> pc.Scene:
    """The robot and one point: what all else takes."""
    return cloud_scene(1)


def map_scene(length: float, storeys: int) -> pc.Scene:
    """A building."""
    cells, scene = building(length, length / 2, storeys, seed=0), pc.Scene("building")
    scene.add(NAME, pc.Octree.from_cells(cells.keys, cells.resolution, cells.sizes))
    return scene


def measured(name: str, scene: pc.Scene, count: int, size: tuple[int, int]) -> dict[str, object]:
    """Size of the page of a scene, and milliseconds of its frames."""
    robot = pc.Robot.load("panda")
    parts = scene.object(NAME).parts[0].shape.count
    began = time.process_time()
    page = page_of(picture(pc.Checker(robot, scene), robot.reference, planes=0))
    seconds = time.process_time() - began
    row = {"scene": name, "parts": parts, "megabytes": len(page.encode()) / 1e6, "seconds": seconds}
    taken, slices, shown = zip(*(frame_of(page, count, size, way) for way in _WAYS), strict=True)
    row |= dict(zip(_WAYS, taken, strict=True))
    return row | {"slices": slices[1], "moving share": shown[2] / shown[0], "pixels": f"{size[0]} x {size[1]}"}


def frame_of(page: str, count: int, size: tuple[int, int], way: str) -> tuple[float, float, float]:
    """Milliseconds of the processor that a frame of a page takes, its slices and parts; NaN without a browser."""
    if not BROWSER:
        return (float("nan"),) * 3
    script = _TURN.replace("DRAW", _WAYS[way])
    few, _, _ = drawing(page, script, _FEW, size)
    count *= _MORE[way]
    spent, slices, parts = drawing(page, script, _FEW + count, size)
    return 1e3 * (spent - few) / count, slices, parts


def drawing(page: str, script: str, count: int, size: tuple[int, int]) -> tuple[float, float, float]:
    """Seconds of the processor in which Chromium loads a page and draws so many frames; slices and parts of one."""
    at = page.rindex(_END)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        path = Path(folder) / "page.html"
        path.write_text(page[:at] + script.replace("COUNT", str(count)) + page[at + len(_END) :], encoding="utf-8")
        flags = [flag for flag in browser_flags(*size) if not flag.startswith("--virtual-time")]
        command = [
            str(BROWSER),
            *flags,
            "--in-process-gpu",
            f"--user-data-dir={folder}/profile",
            "--dump-dom",
            path.as_uri(),
        ]
        before = of_children()
        shown = subprocess.run(command, check=True, capture_output=True, text=True, timeout=_PATIENCE).stdout
        found = re.search(r"<pre>drawn (\S+) (\S+)</pre>", shown)
        assert found, shown[:500]
        return of_children() - before, float(found[1]), float(found[2])


def of_children() -> float:
    """Seconds of the processor of all processes that have ended under this one."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> None:
    """Prints a row of each page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--length", type=float, default=40, help="of the building, m")
    parser.add_argument("--storeys", type=int, default=3)
    parser.add_argument("--frames", type=int, default=6)
    parser.add_argument("--size", type=int, nargs=2, default=[1280, 720], help="of the window, pixels")
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    rows, size = [], (options.size[0], options.size[1])
    for name, scene in (
        ("a robot before one point", bare_scene()),
        ("cloud", cloud_scene(options.points)),
        ("octomap", map_scene(options.length, options.storeys)),
    ):
        rows.append(measured(name, scene, options.frames, size))
        print(
            ", ".join(
                f"{key} {value:,.4g}" if isinstance(value, float) else f"{key} {value}"
                for key, value in rows[-1].items()
            ),
            flush=True,
        )
    if options.output:
        write_record(options.output, rows)


if __name__ == "__main__":
    main()
