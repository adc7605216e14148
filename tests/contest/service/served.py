"""A service in a folder, without a socket."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("fastapi", reason="the web service needs the extra 'contest'")
pytest.importorskip("sqlalchemy", reason="the web service needs the extra 'contest'")

from fastapi.testclient import TestClient

from tamp.contest.service import queue
from tamp.contest.service.contest import load_contest
from tamp.contest.service.store import open_store
from tamp.contest.service.teams import add_team
from tamp.contest.service.web.app import make_app
from tamp.results import Result, to_json

CODE = b"class Solution:\n    def run(self, goal, robot): ...\n"
TASK = """\
name: {name}
objects:
  - name: red
    shape: {{box: [0.04, 0.04, 0.06]}}
    pose: {{xyz: [0, 0.1, 0.03]}}
    goal: {{pose: {{xyz: [0, -0.1, 0.03]}}}}
"""
RULES = """\
name: cup
contest: [hidden_*.yaml]
trial: [open.yaml]
runs: 2
uploads: {size_kb: 4, unpacked_kb: 64, a_month: 3, a_minute: 50}
"""


class Service:
    """A service in a folder, and two teams."""

    def __init__(self, data: Path) -> None:
        (data / "contest.yaml").write_text(RULES)
        for name in ("hidden_a", "hidden_b", "open"):
            (data / f"{name}.yaml").write_text(TASK.format(name=f"{name}_secret" if "hidden" in name else name))
        self.data, self.store, self.contest = data, open_store(data), load_contest(data / "contest.yaml")
        self.tokens = {
            name: add_team(self.store, name) for name in ("ours", "<script>alert(1)</script>'; DROP TABLE teams")
        }
        self.ours, self.theirs = self.tokens.values()
        self.client = TestClient(make_app(self.store, self.contest, data), raise_server_exceptions=False)

    def hand_in(self, token: str, code: bytes = CODE, name: str = "solution.py", kind: str = "contest"):  # type: ignore[no-untyped-def]
        headers = {"Authorization": f"Bearer {token}"}
        return self.client.post("/api/submissions", params={"name": name, "kind": kind}, headers=headers, content=code)

    def get(self, path: str, token: str | None = None):  # type: ignore[no-untyped-def]
        return self.client.get(path, headers={} if token is None else {"Authorization": f"Bearer {token}"})

    def evaluate(self, ede_m: float = 0.1, log: str = "printed") -> int:
        """Do all runs as a worker would; how many there were."""
        count = 0
        while (held := queue.claim(self.store)) is not None:
            result = Result(
                held.task, held.run, "failed", ede_m=ede_m, do_nothing_ede_m=0.2, mean_ueb_m=0.3, execution_sim_s=3.0,
                simulator=held.simulator, objects=({"name": "red_secret", "ede_m": ede_m},),
                goals_met={"red_secret": False},
            )  # fmt: skip
            assert queue.finish(self.store, held, to_json(result), log)
            count += 1
        return count
