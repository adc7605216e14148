"""A scene in the layout of BOP, the benchmark for 6D object pose estimation (Hodan et al., ECCV 2018; "BOP format").

    models/obj_000001.ply, models_info.json, names.json            lengths in millimetres
    train/000000/rgb/000000.png, depth/000000.png                  depth in tenths of a millimetre, 16 bits
    train/000000/mask/000000_000000.png, mask_visib/...            one an object and picture: whole, or as seen
    train/000000/scene_camera.json, scene_gt.json, scene_gt_info.json

names.json is ours: object number -> name. A scene's folder gets its name when everything in it is written.
"""

from __future__ import annotations

import json
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

    Array = NDArray[np.float64]

SPLIT = "train"


def write_models(objects: Mapping[str, Surface], folder: Path) -> None:
    """Write the meshes in millimetres, numbered from 1 in order, and what BOP wants to know of them."""
    models = folder / "models"
    models.mkdir(parents=True, exist_ok=True)
    info = {}
    for number, surface in enumerate(objects.values(), start=1):
        write_ply(surface, models / f"obj_{number:06}.ply", scale=1000.0)
        lower, upper = 1000 * surface.vertices.min(axis=0), 1000 * surface.vertices.max(axis=0)
        corners = {f"min_{axis}": float(v) for axis, v in zip("xyz", lower, strict=True)}
        sizes = {f"size_{axis}": float(v) for axis, v in zip("xyz", upper - lower, strict=True)}
        info[str(number)] = {"diameter": float(np.linalg.norm(upper - lower)), **corners, **sizes}
    _write_json(models / "models_info.json", info)
    _write_json(models / "names.json", {str(i): name for i, name in enumerate(objects, start=1)})


def model_numbers(folder: Path) -> dict[str, int]:
    """Object name -> its number in a data set.

    Raises:
        TaskError: where the folder holds no data set of ours.
    """
    path = folder / "models" / "names.json"
    if not path.is_file():
        raise TaskError(f"{folder}: holds no models/names.json, so it is no data set written by `tamp dataset`")
    return {name: int(number) for number, name in json.loads(path.read_text(encoding="utf-8")).items()}


def scene_folder(folder: Path, scene: int) -> Path:
    """Where a scene is."""
    return folder / SPLIT / f"{scene:06}"


def write_scene(frames: Sequence[LabelledFrame], folder: Path, scene: int) -> Path:
    """Write a scene beside the models; what an interrupted run left half written is replaced.

    Args:
        frames: its pictures.
        folder: the data set, with its models.
        scene: its number.
    """
    numbers, target = model_numbers(folder), scene_folder(folder, scene)
    work = target.with_name(f".{target.name}")
    shutil.rmtree(work, ignore_errors=True)
    for name in ("rgb", "depth", "mask", "mask_visib"):
        (work / name).mkdir(parents=True)
    cameras, poses, infos = {}, {}, {}
    for index, frame in enumerate(frames):
        save_image(work / "rgb" / f"{index:06}.png", frame.color)
        save_image(work / "depth" / f"{index:06}.png", frame.depth)
        cameras[str(index)] = _camera(frame)
        poses[str(index)] = [_pose(label, numbers) for label in frame.labels]
        infos[str(index)] = [_info(label, frame.depth) for label in frame.labels]
        for place, label in enumerate(frame.labels):
            save_image(work / "mask" / f"{index:06}_{place:06}.png", label.whole.astype(np.uint8) * 255)
            save_image(work / "mask_visib" / f"{index:06}_{place:06}.png", label.visible.astype(np.uint8) * 255)
    for name, rows in (("scene_camera", cameras), ("scene_gt", poses), ("scene_gt_info", infos)):
        _write_json(work / f"{name}.json", rows)
    shutil.rmtree(target, ignore_errors=True)
    work.rename(target)
    return target


def read_scene(folder: Path, scene: int) -> Iterator[LabelledFrame]:
    """The pictures of a scene as they were written.

    Raises:
        TaskError: where there is no such scene.
    """
    source = scene_folder(folder, scene)
    if not source.is_dir():
        raise TaskError(f"{source}: there is no such scene")
    names = {number: name for name, number in model_numbers(folder).items()}
    cameras, poses = (_read_json(source / f"{name}.json") for name in ("scene_camera", "scene_gt"))
    for key, camera in cameras.items():
        index = int(key)
        color = load_image(source / "rgb" / f"{index:06}.png")
        K = camera["cam_K"]
        height, width = color.shape[:2]
        labels = tuple(
            Label(
                names[row["obj_id"]],
                _matrix(row["cam_R_m2c"], row["cam_t_m2c"]),
                load_image(source / "mask" / f"{index:06}_{place:06}.png") > 0,
                load_image(source / "mask_visib" / f"{index:06}_{place:06}.png") > 0,
            )
            for place, row in enumerate(poses[key])
        )
        yield LabelledFrame(
            Intrinsics(width, height, K[0], K[4], K[2], K[5]),
            _inverse(_matrix(camera["cam_R_w2c"], camera["cam_t_w2c"])),
            color,
            load_image(source / "depth" / f"{index:06}.png").astype(np.uint16),
            labels,
        )


def _camera(frame: LabelledFrame) -> dict[str, Any]:
    T = np.linalg.inv(frame.T_world_camera)
    return {
        "cam_K": frame.intrinsics.matrix.reshape(-1).tolist(),
        "depth_scale": 1000 * DEPTH_UNIT,
        "cam_R_w2c": T[:3, :3].reshape(-1).tolist(),
        "cam_t_w2c": (1000 * T[:3, 3]).tolist(),
    }


def _pose(label: Label, numbers: Mapping[str, int]) -> dict[str, Any]:
    T = label.T_camera_object
    R, t = T[:3, :3].reshape(-1).tolist(), (1000 * T[:3, 3]).tolist()
    return {"cam_R_m2c": R, "cam_t_m2c": t, "obj_id": numbers[label.name]}


def _info(label: Label, depth: NDArray[np.uint16]) -> dict[str, Any]:
    whole, visible = int(label.whole.sum()), int(label.visible.sum())
    return {
        "bbox_obj": _box(label.whole),
        "bbox_visib": _box(label.visible),
        "px_count_all": whole,
        "px_count_valid": int((label.whole & (depth > 0)).sum()),
        "px_count_visib": visible,
        "visib_fract": visible / whole if whole else 0.0,
    }


def _box(mask: NDArray[np.bool_]) -> list[int]:
    """Left, top, width, height; -1 of everything for an empty mask."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return [-1, -1, -1, -1]
    return [int(columns[0]), int(rows[0]), int(columns[-1] - columns[0] + 1), int(rows[-1] - rows[0] + 1)]


def _inverse(T: Array) -> Array:
    return np.asarray(np.linalg.inv(T), dtype=np.float64)


def _matrix(R: Sequence[float], t: Sequence[float]) -> Array:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = np.reshape(R, (3, 3)), np.array(t) / 1000
    return T


def _write_json(path: Path, value: Any) -> None:
    path.write_text(json.dumps(value) + "\n", encoding="utf-8")


def _read_json(path: Path) -> Any:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise TaskError(f"{path}: cannot be read as JSON: {error}") from error
