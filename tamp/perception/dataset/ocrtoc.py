"""A scene in the layout of OCRTOC's own data set, as its toolkit reads it (github.com/OCRTOC/OCRTOC_dataset_toolkit).

    object_name_list.txt                                           an object's number is its line, from 1
    rgb_pcd/NAME.ply                                               meshes, in metres
    scenes/000000/object_list.txt, object_poses/NAME.npy           T_world_object, shape (4, 4), metres
    scenes/000000/color_camK.npy, pcd_camK.npy                     K, shape (3, 3)
    scenes/000000/camera_poses/0000.npy                            T_world_camera, optical frame
    scenes/000000/rgb_undistort/0000.png, depth_undistort/0000.png depth in millimetres, 16 bits
    scenes/000000/seg_masks/0000.npy, vis_masks/0000.png           the number of what each pixel shows, 0: no object

whole_masks/0000.npz is ours: what each object would cover if nothing stood before it. There are no end_effector_pose
files: no arm carries the camera. A scene's folder gets its name when everything in it is written.
"""

from __future__ import annotations

import colorsys
import shutil
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tamp.errors import TaskError
from tamp.perception.cameras.camera import Intrinsics
from tamp.perception.dataset.frames import DEPTH_UNIT, Label, LabelledFrame, load_image, save_image
from tamp.perception.rendering.surface import Surface, write_ply

if TYPE_CHECKING:
    from numpy.typing import NDArray

MILLIMETRE = round(0.001 / DEPTH_UNIT)
"""A millimetre in steps of depth: depths of this layout are multiples of it."""

FOLDERS = ("camera_poses", "rgb_undistort", "depth_undistort", "seg_masks", "vis_masks", "whole_masks", "object_poses")


def write_models(objects: Mapping[str, Surface], folder: Path) -> None:
    """Write the meshes in metres, and the list of their names."""
    models = folder / "rgb_pcd"
    models.mkdir(parents=True, exist_ok=True)
    for name, surface in objects.items():
        write_ply(surface, models / f"{name}.ply", scale=1.0)
    _write_lines(folder / "object_name_list.txt", objects)


def object_numbers(folder: Path) -> dict[str, int]:
    """Object name -> its number in a data set, from 1.

    Raises:
        TaskError: where the folder holds no data set in this layout.
    """
    path = folder / "object_name_list.txt"
    if not path.is_file():
        raise TaskError(f"{folder}: holds no object_name_list.txt, so it is no data set in OCRTOC's layout")
    return {name: number for number, name in enumerate(_lines(path), start=1)}


def scene_folder(folder: Path, scene: int) -> Path:
    """Where a scene is."""
    return folder / "scenes" / f"{scene:06}"


def write_scene(frames: Sequence[LabelledFrame], folder: Path, scene: int) -> Path:
    """Write a scene beside the models; what an interrupted run left half written is replaced.

    Args:
        frames: its pictures, all by one camera; depths in whole millimetres.
        folder: the data set, with its models.
        scene: its number.
    """
    numbers, target = object_numbers(folder), scene_folder(folder, scene)
    work = target.with_name(f".{target.name}")
    shutil.rmtree(work, ignore_errors=True)
    for name in FOLDERS:
        (work / name).mkdir(parents=True)
    for index, frame in enumerate(frames):
        _write_frame(frame, index, work, numbers)
    first = frames[0]
    for label in first.labels:
        np.save(work / "object_poses" / f"{label.name}.npy", first.T_world_camera @ label.T_camera_object)
    _write_lines(work / "object_list.txt", [label.name for label in first.labels])
    for name in ("color_camK", "pcd_camK"):
        np.save(work / f"{name}.npy", first.intrinsics.matrix)
    shutil.rmtree(target, ignore_errors=True)
    work.rename(target)
    return target


def _write_frame(frame: LabelledFrame, index: int, work: Path, numbers: Mapping[str, int]) -> None:
    if (frame.depth % MILLIMETRE).any():
        raise ValueError("this layout has depths in whole millimetres")
    masks = np.zeros(frame.depth.shape, dtype=np.uint8 if max(numbers.values()) < 256 else np.uint16)
    for label in frame.labels:
        masks[label.visible] = numbers[label.name]
    np.save(work / "camera_poses" / f"{index:04}.npy", frame.T_world_camera)
    save_image(work / "rgb_undistort" / f"{index:04}.png", frame.color)
    save_image(work / "depth_undistort" / f"{index:04}.png", frame.depth // MILLIMETRE)
    np.save(work / "seg_masks" / f"{index:04}.npy", masks)
    save_image(work / "vis_masks" / f"{index:04}.png", _painted(frame.color, masks))
    whole = np.array([label.whole for label in frame.labels], dtype=bool)
    np.savez_compressed(work / "whole_masks" / f"{index:04}.npz", whole=np.packbits(whole))


def _painted(color: NDArray[np.uint8], masks: NDArray[Any]) -> NDArray[np.uint8]:
    """A picture with its masks over it, for people."""
    paint = color.copy()
    for number in np.unique(masks[masks > 0]).tolist():
        shade = 255 * np.array(colorsys.hsv_to_rgb((0.618 * number) % 1.0, 1.0, 1.0))
        paint[masks == number] = paint[masks == number] // 2 + (shade / 2).astype(np.uint8)
    return paint


def read_scene(folder: Path, scene: int) -> Iterator[LabelledFrame]:
    """The pictures of a scene as they were written.

    Raises:
        TaskError: where there is no such scene.
    """
    source = scene_folder(folder, scene)
    if not source.is_dir():
        raise TaskError(f"{source}: there is no such scene")
    numbers, K = object_numbers(folder), np.load(source / "color_camK.npy")
    poses = {name: np.load(source / "object_poses" / f"{name}.npy") for name in _lines(source / "object_list.txt")}
    for index in range(len(list((source / "rgb_undistort").glob("*.png")))):
        color = load_image(source / "rgb_undistort" / f"{index:04}.png")
        depth = load_image(source / "depth_undistort" / f"{index:04}.png").astype(np.uint16)
        T = np.load(source / "camera_poses" / f"{index:04}.npy")
        masks = np.load(source / "seg_masks" / f"{index:04}.npy")
        packed = np.load(source / "whole_masks" / f"{index:04}.npz")["whole"]
        shape = (len(poses), *depth.shape)
        whole = np.unpackbits(packed, count=int(np.prod(shape))).reshape(shape).astype(bool)
        labels = tuple(
            Label(name, np.linalg.inv(T) @ poses[name], whole[place], masks == numbers[name])
            for place, name in enumerate(poses)
        )
        height, width = depth.shape
        k = Intrinsics(width, height, float(K[0, 0]), float(K[1, 1]), float(K[0, 2]), float(K[1, 2]))
        yield LabelledFrame(k, T, color, depth * np.uint16(MILLIMETRE), labels)


def _lines(path: Path) -> list[str]:
    return path.read_text(encoding="utf-8").split()


def _write_lines(path: Path, lines: Sequence[str] | Mapping[str, Any]) -> None:
    path.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
