from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from tests.contest.service.served import Service


@pytest.fixture
def service(tmp_path: Path) -> Iterator[Service]:
    from tests.contest.service.served import Service  # needs an extra

    made = Service(tmp_path)
    yield made
    made.store.close()
