from __future__ import annotations

import hashlib
import json
from pathlib import Path

from tamp.pipeline.solving.run import save_poses, save_run
from tamp.results import from_json
from tamp.task import Pose
from tamp.task.files.plan_file import load_plan, plan_sha256
from tamp.task.files.poses_file import load_poses


def test_a_run_is_kept_as_a_folder(run, one_object, tmp_path):
    (tmp_path / "plan-7.json").write_text("of an earlier run")
    save_run(run, one_object, {"seed": 0, "timeout": None}, tmp_path)
    assert not (tmp_path / "plan-7.json").exists()
    assert from_json((tmp_path / "result.json").read_text()) == run.result
    assert plan_sha256(load_plan(tmp_path / "plan-0.json")) == run.result.plan_sha256
    assert load_poses(tmp_path / "poses.json") == dict(run.final_poses)
    report = (tmp_path / "report.txt").read_text()
    assert "one_object, seed 0: solved" in report
    assert "pick(red, table)" in report


def test_the_manifest_names_all_that_a_run_depends_on(run, one_object, tmp_path):
    save_run(run, one_object, {"seed": 0}, tmp_path)
    manifest = json.loads((tmp_path / "manifest.json").read_text())
    assert manifest["seed"] == 0
    assert manifest["configuration"] == {"seed": 0}
    assert manifest["plan_sha256"] == run.result.plan_sha256
    assert manifest["versions"] == dict(run.result.versions)
    assert manifest["inputs"] == {str(one_object.path): hashlib.sha256(one_object.path.read_bytes()).hexdigest()}


def test_the_manifest_has_a_hash_of_each_file_of_the_packages_that_the_run_names(run, one_object, tmp_path):
    own = {"strategy": f"{__name__}:MINE", "samplers": {"sample-grasp": "json.decoder:JSONDecoder"}, "search": "ff"}
    save_run(run, one_object, own, tmp_path)
    inputs = json.loads((tmp_path / "manifest.json").read_text())["inputs"]
    package = {str(path) for path in Path(__file__).parent.rglob("*.py")}
    assert inputs.keys() == {str(one_object.path), *package, *map(str, Path(json.__file__).parent.rglob("*.py"))}
    assert inputs[__file__] == hashlib.sha256(Path(__file__).read_bytes()).hexdigest()


def test_poses_go_through_a_file_unchanged(tmp_path):
    poses = {"a": Pose((0.1, 0.2, 0.3), (0.1, 0.2, 0.3, 0.9)), "b": Pose()}
    save_poses(poses, tmp_path / "poses.json")
    assert load_poses(tmp_path / "poses.json") == poses
