"""Draws docs/bookshelf.png for the README: `pip install matplotlib && python docs/picture.py`.

A Panda in the shipped bookshelf at the scene's goal and, with what collides in red, at one of its sample
configurations.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import plannercheck as pc

COLOURS = {"robot": "#c9d3dc", "obstacle": "#d9b382", "collision": "#d43d2f"}


def draw(axes: plt.Axes, checker: pc.Checker, q: np.ndarray, title: str) -> None:
    """Draws all bodies of a checker at one configuration."""
    poses = checker.body_poses(q)[0]
    hit = {name for v in checker.explain(q).collisions for name in (v.first_body, v.second_body)}
    for body, polytope, pose in zip(checker.bodies, checker.polytopes, poses, strict=True):
        if polytope is None or body.name == "floor":
            continue
        corners = (polytope.vertices @ pose[:3, :3].T + pose[:3, 3])[polytope.faces]
        kind = "collision" if body.name in hit else "robot" if body.link else "obstacle"
        alpha = 0.25 if kind == "obstacle" else 1.0
        colours = [(*(np.array(plt.matplotlib.colors.to_rgb(COLOURS[kind])) * v), alpha) for v in shade(corners)]
        axes.add_collection3d(Poly3DCollection(corners, facecolors=colours, edgecolors="none"))
    axes.set(xlim=(-0.5, 0.9), ylim=(-0.7, 0.7), zlim=(0, 1.4))
    axes.set_title(title, y=0.93)
    axes.set_box_aspect((1, 1, 1), zoom=1.55)
    axes.view_init(elev=18, azim=-125)
    axes.set_axis_off()


LIGHT = np.array([-0.4, -0.5, 0.77])


def shade(corners: np.ndarray) -> np.ndarray:
    """Brightness (m,) of triangles (m, 3, 3) under a lamp."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return 0.65 + 0.35 * np.clip(normals @ LIGHT, -0.6, 1)


def main() -> None:
    """Writes the picture."""
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    checker = pc.Checker(robot, scene)
    samples = scene.samples("panda")
    shelf = [len({v.second for v in checker.explain(q).collisions if v.second == "shelf"}) for q in samples[:200]]
    alone = [k for k, n in enumerate(shelf) if n and len(checker.explain(samples[k]).collisions) <= 3]
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.6), subplot_kw={"projection": "3d"})
    draw(axes[0], checker, scene.goal("panda"), "valid")
    names = sorted({f"{v.first} – {v.second}" for v in checker.explain(samples[alone[0]]).collisions})
    draw(axes[1], checker, samples[alone[0]], "invalid: " + ", ".join(names))
    figure.tight_layout()
    figure.savefig(Path(__file__).with_name("bookshelf.png"), dpi=90)


if __name__ == "__main__":
    main()
