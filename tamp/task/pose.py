"""Rigid poses: a position in metres and a unit quaternion (x, y, z, w)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tamp.errors import ModelError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

NEEDED = "a pose needs three finite coordinates and a finite quaternion [x, y, z, w]"

RIGID = 1e-3
"""How far axes may be from unit length and right angles; single precision, and rounding in files, come nowhere near."""

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Pose:
    """Where a body stands, `T_world_body` unless a name says otherwise.

    Attributes:
        xyz: position [m].
        quat: orientation as (x, y, z, w); normalised on construction.

    Raises:
        ModelError: for another number of values, one that is not finite, or a quaternion of length zero.
    """

    xyz: Vector3 = (0.0, 0.0, 0.0)
    quat: Quaternion = (0.0, 0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        try:
            x, y, z = (float(v) for v in self.xyz)
            quat = [float(v) for v in self.quat]
        except (TypeError, ValueError):
            raise ModelError(f"{NEEDED}, not {self.xyz!r} and {self.quat!r}") from None
        norm = math.sqrt(sum(v * v for v in quat))
        if len(quat) != 4 or not all(map(math.isfinite, (x, y, z, norm))):
            raise ModelError(f"{NEEDED}, not {self.xyz!r} and {self.quat!r}")
        if norm < 1e-6:
            raise ModelError("a quaternion of length zero is no orientation")
        # An already normalised quaternion is kept to the last bit, so that poses survive files unchanged.
        scale = 1.0 if abs(norm - 1.0) < 1e-12 else 1.0 / norm
        object.__setattr__(self, "xyz", (x, y, z))
        object.__setattr__(self, "quat", tuple(v * scale for v in quat))

    @staticmethod
    def from_rpy(xyz: Vector3, rpy: Vector3) -> Pose:
        """The pose at `xyz` [m] turned by roll, pitch, yaw [rad] about the fixed axes x, y, z."""
        (sr, cr), (sp, cp), (sy, cy) = ((math.sin(a / 2), math.cos(a / 2)) for a in rpy)
        quat = (
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        )
        return Pose(xyz, quat)

    @staticmethod
    def from_matrix(T: NDArray[np.float64]) -> Pose:
        """The pose of a homogeneous transform, shape (4, 4).

        Raises:
            ModelError: for another shape, what is not finite, or a matrix that scales, shears or mirrors.
        """
        _check_rigid(T)
        return _of_rigid(T)

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The homogeneous transform, shape (4, 4); a new array at each call."""
        import numpy as np

        x, y, z, w = self.quat
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), self.xyz[0]],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), self.xyz[1]],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), self.xyz[2]],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )

    @property
    def rpy(self) -> Vector3:
        """Roll, pitch, yaw about the fixed axes x, y, z [rad]; see `from_rpy`."""
        x, y, z, w = self.quat
        pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
        if abs(abs(pitch) - math.pi / 2) < 1e-7:  # roll and yaw turn about one axis: roll takes it all
            return 2 * math.atan2(x, w), pitch, 0.0
        roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
        return roll, pitch, math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))

    def __matmul__(self, other: Pose) -> Pose:
        """Compose: `T_a_b @ T_b_c` is `T_a_c`."""
        return _of_rigid(self.matrix @ other.matrix)

    def inverse(self) -> Pose:
        """`T_b_a` of `T_a_b`."""
        T = self.matrix
        T[:3, :3] = T[:3, :3].T
        T[:3, 3] = -T[:3, :3] @ T[:3, 3]
        return _of_rigid(T)


def _check_rigid(T: NDArray[np.float64]) -> None:
    shape = getattr(T, "shape", None)
    if shape != (4, 4):
        raise ModelError(f"a pose is made of a matrix of shape (4, 4), not {shape or type(T).__name__}")
    R = T[:3, :3].tolist()
    # Each axis of a right-handed frame is the cross product of the next two; the first two need to be units, too.
    (a, b, c), (d, e, f), third = R
    crossed = (b * f - c * e, c * d - a * f, a * e - b * d)
    off = (a * a + b * b + c * c - 1, d * d + e * e + f * f - 1, a * d + b * e + c * f)
    if not all(abs(v) <= RIGID for v in (*off, *(v - w for v, w in zip(crossed, third, strict=True)))):
        raise ModelError(f"a pose is made of a rotation and a shift; {R} is no rotation: it scales, shears or mirrors")


def _of_rigid(T: NDArray[np.float64]) -> Pose:
    return Pose((float(T[0, 3]), float(T[1, 3]), float(T[2, 3])), _quaternion(T))


def _quaternion(T: NDArray[np.float64]) -> Quaternion:
    """Quaternion of a rotation matrix by Shepperd's method: divide by the largest of the four components."""
    m00, m11, m22 = float(T[0, 0]), float(T[1, 1]), float(T[2, 2])
    squares = (1 + m00 - m11 - m22, 1 - m00 + m11 - m22, 1 - m00 - m11 + m22, 1 + m00 + m11 + m22)
    largest = max(range(4), key=squares.__getitem__)
    s = 2.0 * math.sqrt(squares[largest])
    wx, wy, wz = (float(T[2, 1] - T[1, 2]), float(T[0, 2] - T[2, 0]), float(T[1, 0] - T[0, 1]))
    xy, xz, yz = (float(T[0, 1] + T[1, 0]), float(T[0, 2] + T[2, 0]), float(T[1, 2] + T[2, 1]))
    quat = ((s / 4, xy / s, xz / s, wx / s), (xy / s, s / 4, yz / s, wy / s), (xz / s, yz / s, s / 4, wz / s))
    return quat[largest] if largest < 3 else (wx / s, wy / s, wz / s, s / 4)
