"""Pictures as files: PNG, GIF and what else Pillow writes."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tamp.errors import TampError
from tamp.versions import how_to_install

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Image = NDArray[np.uint8]


def save_image(image: Image | NDArray[np.uint16], path: Path) -> None:
    """Write a picture, shape (height, width, 3), or (height, width) in 16 bits; the path's ending says the format."""
    from PIL import Image as Pillow

    path.parent.mkdir(parents=True, exist_ok=True)
    Pillow.fromarray(image).save(path)


def save_animation(images: Sequence[Image], path: Path, *, frame_s: float = 0.1) -> None:
    """Write pictures of one size with `frame_s` seconds a picture: an MP4, or else an endless GIF.

    Raises:
        ValueError: for no pictures.
        TampError: for an MP4 without the extra that writes it.
    """
    from PIL import Image as Pillow

    if not images:
        raise ValueError("an animation needs at least one picture")
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".mp4":
        _save_video(images, path, frame_s)
        return
    first, *rest = (Pillow.fromarray(image).quantize(128) for image in images)
    first.save(path, save_all=True, append_images=rest, duration=round(frame_s * 1000), loop=0)


def _save_video(images: Sequence[Image], path: Path, frame_s: float) -> None:
    try:
        import imageio_ffmpeg
    except ModuleNotFoundError:
        raise TampError(f"{path}: MP4 needs an extra: {how_to_install('video')}; GIF does not") from None
    height, width = images[0].shape[:2]
    writer = imageio_ffmpeg.write_frames(str(path), (width, height), fps=1 / frame_s, macro_block_size=2)
    writer.send(None)
    for image in images:
        writer.send(image.tobytes())
    writer.close()


def read_image(path: Path) -> Image:
    """A picture from a file, shape (height, width, 3)."""
    import numpy as np
    from PIL import Image as Pillow

    with Pillow.open(path) as image:
        return np.asarray(image.convert("RGB"))


def data_uri(image: Image) -> str:
    """A picture, shape (height, width, 3), as a JPEG that stands in a page."""
    from PIL import Image as Pillow

    file = io.BytesIO()
    Pillow.fromarray(image).save(file, format="JPEG", quality=82)
    return f"data:image/jpeg;base64,{base64.b64encode(file.getvalue()).decode()}"
