"""A picture in the browser through viser, for looking around, stepping through frames and moving joints.

In: a `Drawing`, the robot's `Joints` if there shall be sliders. Out: a running server, which only its own page can talk
to. Needs `pip install 'plannercheck[view]'`.
"""

from __future__ import annotations

import threading
import time
from typing import Any

import numpy as np

from plannercheck.common.errors import PlannercheckError
from plannercheck.common.transforms import quaternion_of_rotation
from plannercheck.view.joints import Joints
from plannercheck.view.model import PLANE, Drawing, Mesh, checked_drawing
from plannercheck.view.origins import own_pages_only

DEFAULT_PORT = 8080
# Time a frame is shown, s: of an animation, and of a set of configurations.
_ANIMATION_STEP, _SET_STEP = 1 / 30, 0.8
# How long the end of a trajectory is shown, s.
_PAUSE = 1.0
# Where one looks from at first, seen from the centre, in radii: from behind robots that look along x.
_EYE = np.array([-1.6, -2.2, 1.2])
# By which sliders move joints, rad and m.
_SLIDER_STEP = 1e-3
# Radius of drawn points and thickness of lines as parts of the radius of what is looked at.
_POINT_PART, _LINE_PART = 0.008, 0.004


def serve(picture: Drawing, port: int = DEFAULT_PORT, host: str = "localhost", joints: Joints | None = None) -> Stage:
    """Starts a viser server that shows a picture.

    Args:
        picture: The picture.
        port: Port to listen on.
        host: On which of this machine's addresses to listen; "0.0.0.0" is all of them.
        joints: What `joints_of` gives for the same configurations: sliders for them, with the verdict at once.

    Returns:
        The stage; its `server.stop()` ends it, its `play()` plays frames as long as the box is ticked.

    Raises:
        PlannercheckError: If it is no picture, or viser is not installed.
        RuntimeError: If pages of others can't be refused with the viser that is installed.
    """
    checked_drawing(picture)
    try:
        import viser
    except ImportError:
        raise PlannercheckError(
            "viser is not installed: pip install 'plannercheck[view]', or write a page by --html FILE (write_page)"
        ) from None
    with own_pages_only(host):
        server = viser.ViserServer(host=host, port=port, verbose=False)
    return Stage(server, picture, joints)


class Stage:
    """The picture's handles in viser, and the controls that move them.

    Attributes:
        server: viser's server.
        meshes: viser's handle of each of the picture's meshes.
        sliders: viser's handle of each joint's slider.
        verdict: viser's handle of the words above the controls.
    """

    def __init__(self, server: Any, picture: Drawing, joints: Joints | None = None) -> None:
        self.server, self._picture, self._joints = server, picture, joints
        self._drawing = threading.RLock()  # viser calls from several threads
        self._at: list[float] | None = None  # the sliders' values that are shown; None while they are put there
        self._marks: list[Any] = []
        self._instant = 0.0 if picture.times is None else float(picture.times[0])
        server.scene.set_up_direction("+z")
        server.scene.world_axes.visible = False
        self.meshes = [self._added(k, mesh) for k, mesh in enumerate(picture.meshes)]
        self.verdict = server.gui.add_markdown("")
        self._slider = server.gui.add_slider("frame", 0, max(picture.frames - 1, 1), 1, 0, disabled=picture.frames == 1)
        self._slider.on_update(lambda _: self.show(int(self._slider.value)))
        self._playing = server.gui.add_checkbox("play", False, disabled=picture.frames == 1)
        self._add_plot(picture)
        for layer in dict.fromkeys(mesh.layer for mesh in picture.meshes):
            self._add_switch(layer)
        self.sliders = self._added_sliders(joints) if joints is not None else []
        server.initial_camera.look_at = picture.centre
        server.initial_camera.position = picture.centre + picture.radius * _EYE
        self.show(0)

    def _added(self, k: int, mesh: Mesh) -> Any:
        return self.server.scene.add_mesh_simple(
            f"/{mesh.layer}/{k} {mesh.name.replace('/', ' ')}",
            vertices=mesh.vertices.astype(np.float32),
            faces=mesh.faces.astype(np.uint32),
            color=_bytes(mesh.colour(0)),
            opacity=None if mesh.opacity == 1 else mesh.opacity,
            flat_shading=True,
        )

    def _add_switch(self, layer: str) -> None:
        box = self.server.gui.add_checkbox(layer, True)
        handles = [h for mesh, h in zip(self._picture.meshes, self.meshes, strict=True) if mesh.layer == layer]

        def switch(_: Any) -> None:
            for handle in handles:
                handle.visible = bool(box.value)

        box.on_update(switch)

    def play(self) -> None:
        """Steps through the frames as long as the box is ticked, in real time if they have times; never returns."""
        before = time.monotonic()
        while True:
            time.sleep(_ANIMATION_STEP if self._picture.animated else _SET_STEP)
            now = time.monotonic()
            if self._playing.value:
                self._slider.value = self.next_frame(int(self._slider.value), now - before)
            before = now

    def next_frame(self, frame: int, elapsed: float) -> int:
        """The frame to show some time after another one, s; after the last one comes the first."""
        picture, times = self._picture, self._picture.times
        if times is None:
            return (frame + 1) % picture.frames
        if picture.frame_at(self._instant) != frame:  # someone has moved the slider
            self._instant = float(times[frame])
        self._instant += elapsed
        if self._instant > times[-1] + _PAUSE:
            self._instant = float(times[0])
        return picture.frame_at(self._instant)

    def _add_plot(self, picture: Drawing) -> None:
        """The least clearance over time."""
        from viser import uplot

        if picture.times is not None and picture.clearances is not None:
            series = (uplot.Series(label="s"), uplot.Series(label="least clearance, m", stroke="#1d5fae"))
            self.server.gui.add_uplot((picture.times, picture.clearances), series, aspect=2.0)

    def show(self, frame: int) -> None:
        """Shows a frame; the sliders follow."""
        with self._drawing:
            self._draw(self._picture, frame)
            if self._joints is not None:
                self._put_sliders(self._joints.rows[frame].tolist())

    def _put_sliders(self, q: list[float]) -> None:
        """Puts the sliders where the joints are; viser calls for each, as if someone had moved it."""
        self._at = None
        for slider, value in zip(self.sliders, q, strict=True):
            slider.value = value
        self._at = self._slider_values()

    def _slider_values(self) -> list[float]:
        return [float(slider.value) for slider in self.sliders]

    def _added_sliders(self, joints: Joints) -> list[Any]:
        with self.server.gui.add_folder("joints"):
            ranges = zip(
                joints.names, joints.lower.tolist(), joints.upper.tolist(), joints.rows[0].tolist(), strict=True
            )
            sliders = [
                self.server.gui.add_slider(name, low, max(high, low + _SLIDER_STEP), _SLIDER_STEP, value)
                for name, low, high, value in ranges
            ]
        for slider in sliders:
            slider.on_update(lambda _: self.follow_sliders())
        return sliders

    def follow_sliders(self) -> None:
        """Shows the joints where the sliders are; of several calls in a row, the first one does it for all."""
        with self._drawing:
            wanted = self._slider_values()
            if self._joints is None or self._at in (None, wanted):
                return
            self._at = wanted
            self._draw(self._joints.picture_of(wanted), 0)

    def _draw(self, picture: Drawing, frame: int) -> None:
        with self.server.atomic():
            for mesh, handle in zip(picture.meshes, self.meshes, strict=True):
                x, y, z, w = quaternion_of_rotation(mesh.pose(frame)[:3, :3])
                handle.position, handle.wxyz = mesh.pose(frame)[:3, 3], (w, x, y, z)
                handle.color = _bytes(mesh.colour(frame))
            for mark in self._marks:
                mark.remove()
            self._marks = [*self._drawn_witnesses(picture, frame), *self._drawn_planes(picture, frame)]
        clearance = "" if picture.clearances is None else f"; least clearance {1000 * picture.clearances[frame]:.3g} mm"
        self.verdict.content = f"**{picture.labels[frame]}**: {picture.verdict(frame)}{clearance}"

    def _drawn_witnesses(self, picture: Drawing, frame: int) -> list[Any]:
        return [
            self.server.scene.add_icosphere(
                f"/witness/{k}", radius=self._picture.radius * _POINT_PART, color=(20, 20, 20), position=each.point
            )
            for k, each in enumerate(picture.witnesses)
            if each.frame == frame
        ]

    def _drawn_planes(self, picture: Drawing, frame: int) -> list[Any]:
        drawn, scene, blue, thick = [], self.server.scene, _bytes(PLANE), self._picture.radius * _LINE_PART
        for k, plane in enumerate(picture.planes):
            if plane.frame == frame:
                corners, faces = square(plane.centre, plane.normal, plane.size)
                drawn.append(
                    scene.add_mesh_simple(
                        f"/plane/{k}", vertices=corners, faces=faces, color=blue, opacity=0.4, side="double"
                    )
                )
                drawn.append(
                    scene.add_line_segments(f"/nearest/{k}", plane.nearest[None], colors=blue, thickness=thick)
                )
        return drawn


def square(centre: Any, normal: Any, size: float) -> tuple[Any, Any]:
    """Corners (4, 3) and triangles of a square about a centre, in the plane with a normal."""
    away = np.array([0.0, 0.0, 1.0]) if abs(normal[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    u = np.cross(normal, away)
    u = u / np.linalg.norm(u) * size / 2
    v = np.cross(normal, u)
    return np.stack([centre - u - v, centre + u - v, centre + u + v, centre - u + v]), np.array([[0, 1, 2], [0, 2, 3]])


def _bytes(colour: tuple[float, float, float]) -> tuple[int, int, int]:
    red, green, blue = (round(255 * part) for part in colour)
    return red, green, blue
