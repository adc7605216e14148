import pytest

from tamp.streams.workspace import Workspace
from tests.streams.tables import CRATE, CUBE, CUP, RED, SLAB, workspace_of


@pytest.fixture(scope="session")
def table() -> Workspace:
    """A box with a goal, a flat slab and a cube, far from each other."""
    return workspace_of(RED, SLAB, CUBE)


@pytest.fixture(scope="session")
def kitchen() -> Workspace:
    """An open box, a cup and a cube."""
    return workspace_of(CRATE, CUP, CUBE)
