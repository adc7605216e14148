"""Convex decomposition in a process of its own: the library can run for minutes on a spoilt mesh, or crash.

CoACD: Wei et al., "Approximate convex decomposition for 3D meshes with collision-aware concavity and tree search",
SIGGRAPH 2022.
"""

from __future__ import annotations

import io
import signal
import subprocess
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Points = NDArray[np.float64]
    Faces = NDArray[np.int64]

LIMIT_S = 60
"""How much processor time a decomposition may take [s]; what is sound takes 5 to 20."""


def decompose(vertices: Points, faces: Faces) -> list[Points]:
    """Vertices of convex parts that together approximate a closed surface to 5 % of its size; fixed seed.

    Args:
        vertices: shape (n, 3) [m].
        faces: shape (m, 3), indices into `vertices`.

    Raises:
        ValueError: where the library fails or takes longer than `LIMIT_S`.
    """
    import numpy as np

    given = io.BytesIO()
    np.savez(given, vertices=vertices, faces=faces)
    # Not by -m, which would look for modules where the user stands: the folder may be a stranger's.
    program = f"import sys; sys.path[:] = {sys.path!r}; from tamp.task.mesh.decompose import serve; serve()"
    command = [sys.executable, "-c", program]
    child = subprocess.run(command, input=given.getvalue(), capture_output=True, check=False)
    if child.returncode == -signal.SIGXCPU:
        raise ValueError(f"it cannot be decomposed into convex parts in {LIMIT_S} s")
    if child.returncode != 0:
        raise ValueError("it cannot be decomposed into convex parts")
    with np.load(io.BytesIO(child.stdout), allow_pickle=False) as found:
        return [found[name] for name in sorted(found.files)]


def serve() -> None:
    """Read a mesh from standard input and write its parts to standard output, both as .npz."""
    import os
    import resource

    import coacd
    import numpy as np

    resource.setrlimit(resource.RLIMIT_CPU, (LIMIT_S, LIMIT_S + 1))
    answer = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # the library prints to standard output
    with np.load(io.BytesIO(sys.stdin.buffer.read()), allow_pickle=False) as given:
        mesh = coacd.Mesh(given["vertices"], given["faces"])
    coacd.set_log_level("error")
    parts = coacd.run_coacd(mesh, threshold=0.05, max_convex_hull=32, seed=0)
    np.savez(answer, allow_pickle=False, **{f"{i:04d}": vertices for i, (vertices, _) in enumerate(parts)})
    answer.close()
