"""The layouts that a data set may be written in, by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from tamp.errors import TampError, TaskError
from tamp.perception.dataset import bop, ocrtoc
from tamp.perception.dataset.frames import LabelledFrame
from tamp.perception.rendering.surface import Surface


@dataclass(frozen=True)
class Layout:
    """How a data set lies on disk.

    Attributes:
        write_models: writes the meshes and the names of all objects, once.
        scene_folder: where a scene of a number is; it is there when the scene is complete.
        write_scene: writes the pictures of a scene.
        read_scene: the pictures of a scene as they were written.
        depth_step: what depths are whole numbers of, in steps of 0.1 mm.
    """

    write_models: Callable[[Mapping[str, Surface], Path], None]
    scene_folder: Callable[[Path, int], Path]
    write_scene: Callable[[Sequence[LabelledFrame], Path, int], Path]
    read_scene: Callable[[Path, int], Iterator[LabelledFrame]]
    depth_step: int = 1


LAYOUTS: Mapping[str, Layout] = MappingProxyType(
    {
        "bop": Layout(bop.write_models, bop.scene_folder, bop.write_scene, bop.read_scene),
        "ocrtoc": Layout(
            ocrtoc.write_models, ocrtoc.scene_folder, ocrtoc.write_scene, ocrtoc.read_scene, ocrtoc.MILLIMETRE
        ),
    }
)


def layout(name: str) -> Layout:
    """The layout of a name.

    Raises:
        TampError: where it is unknown; says which there are.
    """
    if name not in LAYOUTS:
        raise TampError(f"unknown format {name!r}; valid are {', '.join(LAYOUTS)}")
    return LAYOUTS[name]


def read_scene(folder: Path | str, scene: int) -> Iterator[LabelledFrame]:
    """The pictures of a scene of a data set as they were written, in whichever layout it is.

    Args:
        folder: the data set's.
        scene: its number, from 0.

    Raises:
        TaskError: where no layout has such a scene there.
    """
    folder = Path(folder)
    for how in LAYOUTS.values():
        if how.scene_folder(folder, scene).is_dir():
            return how.read_scene(folder, scene)
    places = " nor ".join(str(how.scene_folder(folder, scene)) for how in LAYOUTS.values())
    raise TaskError(f"{folder}: there is no scene {scene}: neither {places} is there")
