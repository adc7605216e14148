"""A run in the browser: table, robot, objects, goals as ghosts, a time slider, and the action at each time."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.errors import TampError
from tamp.report.rendering.images import read_image
from tamp.report.rendering.playback import Moment
from tamp.report.rendering.scene import REGION_COLOR, TABLE_COLOR, palette
from tamp.report.runs import Sighting
from tamp.task import Pose, Task, task_robot
from tamp.task.mesh.parts import parts
from tamp.versions import how_to_install
from tamp.world.robot.model import RobotModel, robot_model

if TYPE_CHECKING:
    from numpy.typing import NDArray

GHOST = 0.35
"""Opacity of a goal."""

AXIS = 0.05
"""Length of an estimate's axes [m]."""

ROBOT_COLOR = (225, 228, 232)


class Viewer:
    """A scene that a browser shows, served from this process.

    Args:
        task: objects, regions, table and robot.
        goals: object -> goal pose (world frame), shown as ghosts.
        moments: what is played.
        port: of the web server.
        sights: what was seen, where poses were perceived: estimates stand in the scene as axes with their errors, and
            the pictures beside it.

    Raises:
        TampError: where the extra that serves it is not installed.
    """

    def __init__(
        self,
        task: Task,
        goals: Mapping[str, Pose],
        moments: Sequence[Moment],
        *,
        port: int = 8080,
        sights: Sequence[Sighting] = (),
    ) -> None:
        self._sights = tuple(sights)
        self._moments = tuple(moments)
        self._robot = robot_model(task_robot(task))
        self.server: Any = _viser().ViserServer(host="localhost", port=port, label=task.name, verbose=False)
        scene = self.server.scene
        scene.set_up_direction("+z")
        self.server.initial_camera.position = (1.3, 0.9, 1.1)
        self.server.initial_camera.look_at = (-0.1, 0.0, 0.1)
        _add_table(scene, task)
        self._links = _add_robot(scene, self._robot)
        self._objects = _add_objects(scene, task, "objects", 1.0)
        for name, ghost in _add_objects(scene, task, "goals", GHOST).items():
            ghost.visible = name in goals
            if name in goals:
                _place(ghost, goals[name].matrix)
        for sight in self._sights:
            _add_estimates(scene, sight)
        self.show(0)

    def show(self, index: int) -> None:
        """Put everything where it is at one moment."""
        frame = self._moments[index].frame
        states = np.array([frame.configuration])
        joints = self._robot.joint_poses(states, frame.opening)[0]
        with self.server.atomic():
            for handle, body in zip(self._links, self._robot.bodies, strict=True):
                _place(handle, joints[body.joint])
            for name, handle in self._objects.items():
                handle.visible = name in frame.poses
                if name in frame.poses:
                    _place(handle, frame.poses[name].matrix)

    def serve(self) -> None:
        """Play for whoever looks, until the process is interrupted."""
        gui, last = self.server.gui, len(self._moments) - 1
        said = gui.add_markdown(self._caption(0))
        slider = gui.add_slider("moment", min=0, max=last, step=1, initial_value=0)
        playing = gui.add_checkbox("play", initial_value=True)
        speed = gui.add_slider("speed", min=0.25, max=8.0, step=0.25, initial_value=2.0)
        self._add_pictures(gui)
        lock = threading.Lock()

        @slider.on_update  # type: ignore[untyped-decorator]
        def _(_: object) -> None:
            with lock:
                self.show(slider.value)
                said.content = self._caption(slider.value)

        while True:
            now = slider.value
            following = (now + 1) % len(self._moments)
            pause = self._moments[following].frame.time - self._moments[now].frame.time
            time.sleep(max(0.02, pause / speed.value))
            if playing.value:
                slider.value = following

    def _add_pictures(self, gui: Any) -> None:
        """What was seen, with the estimates drawn over it, to be chosen from a list."""
        pictures = {path.stem: path for sight in self._sights for path in sight.pictures}
        if not pictures:
            return
        chosen = gui.add_dropdown("seen", options=tuple(pictures), initial_value=next(iter(pictures)))
        shown = gui.add_image(read_image(pictures[chosen.value]), label="estimates")

        @chosen.on_update  # type: ignore[untyped-decorator]
        def _(_: object) -> None:
            shown.image = read_image(pictures[chosen.value])

    def record(self, path: Path) -> None:
        """Write everything as a page of its own (.html) that plays without a server, or as viser's own file (.viser).

        Raises:
            TampError: for another ending.
        """
        if path.suffix not in (".html", ".viser"):
            raise TampError(f"{path}: a recording ends in .html, a page of its own, or .viser")
        serializer = self.server.get_scene_serializer()
        for index, moment in enumerate(self._moments):
            self.show(index)
            if index + 1 < len(self._moments):
                serializer.insert_sleep(max(0.0, self._moments[index + 1].frame.time - moment.frame.time))
        serializer.insert_sleep(1.0)
        if path.suffix == ".html":
            path.write_text(serializer.as_html(), encoding="utf-8")
        else:
            path.write_bytes(serializer.serialize())

    def close(self) -> None:
        """Stop serving."""
        self.server.stop()

    def _caption(self, index: int) -> str:
        moment = self._moments[index]
        return f"**{moment.action}**  \n{moment.frame.time:.1f} s"


def _viser() -> ModuleType:
    try:
        import viser
    except ModuleNotFoundError:
        raise TampError(f"the viewer is an extra: {how_to_install('viewer')}") from None
    module: ModuleType = viser
    return module


def _add_table(scene: Any, task: Task) -> None:
    x, y = task.table.center
    size, z = (*task.table.size, task.table.thickness), -task.table.thickness / 2
    scene.add_box("/table", color=_rgb(TABLE_COLOR), dimensions=size, position=(x, y, z))
    for region in task.regions:
        sheet = {"dimensions": (*region.size, 0.002), "position": (*region.center, 0.0)}
        scene.add_box(f"/regions/{region.name}", color=_rgb(REGION_COLOR), **sheet)


def _add_robot(scene: Any, robot: RobotModel) -> list[Any]:
    """The hull of each link, as the planner sees the robot."""
    return [
        scene.add_mesh_simple(f"/robot/{i}", body.hull.vertices, body.hull.faces, color=ROBOT_COLOR)
        for i, body in enumerate(robot.bodies)
    ]


def _add_objects(scene: Any, task: Task, folder: str, opacity: float) -> dict[str, Any]:
    handles = {}
    for item, color in zip(task.objects, palette(len(task.objects)), strict=True):
        vertices, faces = _joined(item.shape)
        options = {"color": _rgb(color), "opacity": None if opacity == 1.0 else opacity, "flat_shading": True}
        handles[item.name] = scene.add_mesh_simple(f"/{folder}/{item.name}", vertices, faces, **options)
    return handles


def _add_estimates(scene: Any, sight: Sighting) -> None:
    """Axes where objects were thought to be, each with how far that is off; the first look's are shown."""
    folder = scene.add_frame(f"/look {sight.number}", show_axes=False)
    folder.visible = sight.number == 0
    for name, pose in sight.estimates.items():
        x, y, z, w = pose.quat
        path = f"/look {sight.number}/{name}"
        scene.add_frame(path, axes_length=AXIS, axes_radius=AXIS / 20, position=pose.xyz, wxyz=(w, x, y, z))
        said = f"{name}: {100 * sight.errors[name]:.1f} cm off, {sight.confidence[name]:.0%} sure"
        scene.add_label(f"{path}/said", said)


def _joined(shape: Any) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """One mesh of all convex parts."""
    pieces = parts(shape)
    starts = np.cumsum([0, *(len(piece.vertices) for piece in pieces)])
    faces = [np.asarray(piece.faces) + start for piece, start in zip(pieces, starts, strict=False)]
    return np.concatenate([piece.vertices for piece in pieces]), np.concatenate(faces)


def _place(handle: Any, T: NDArray[np.float64]) -> None:
    x, y, z, w = Pose.from_matrix(T).quat
    handle.position, handle.wxyz = T[:3, 3], (w, x, y, z)


def _rgb(color: Sequence[float]) -> tuple[int, int, int]:
    red, green, blue = (round(255 * value) for value in color[:3])
    return red, green, blue
