from __future__ import annotations

import json
from dataclasses import asdict

import pytest

from tamp.cli import main
from tamp.errors import TampError
from tamp.generate.run import copy_library, make_tasks, recipes, refuse_to_overwrite
from tamp.scenarios.library.model import FOLDER


def test_trial_and_contest_in_the_papers_proportion():
    wanted = recipes(1400, 0)
    assert [sum(recipe.set == name for recipe in wanted) for name in ("trial", "contest")] == [1100, 300]
    for name in ("trial", "contest"):
        pairs = [(recipe.level, recipe.family) for recipe in wanted if recipe.set == name]
        assert len(set(pairs)) == 20
        assert {pairs.count(pair) for pair in set(pairs)} <= {len(pairs) // 20}
    assert len({recipe.name for recipe in wanted}) == 1400


def test_files_do_not_depend_on_who_makes_them(tmp_path, capsys):
    """Two workers with a job each, and this process."""
    wanted = recipes(11, 4, level=1, family="mixed")
    options = ["-n", "11", "--seed", "4", "--level", "1", "--family", "mixed", "--workers", "2"]
    assert main(["generate", *options, "-o", str(tmp_path / "set")]) == 0
    assert "trial, level 1" in capsys.readouterr().out
    names = [path.stem for path in sorted((tmp_path / "set").glob("*.yaml"))]
    assert names == sorted(recipe.name for recipe in wanted)
    rows = json.loads((tmp_path / "set" / "tasks.json").read_text())
    assert [row["name"] for row in rows] == [recipe.name for recipe in wanted]
    copy_library(FOLDER, tmp_path)
    make_tasks(str(tmp_path), [asdict(wanted[-1]), asdict(wanted[1])])
    for name in (wanted[-1].name, wanted[1].name):
        assert (tmp_path / f"{name}.yaml").read_bytes() == (tmp_path / "set" / f"{name}.yaml").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--level", "6"], "there is no level 6; valid are 1, 2, 3, 4, 5"),
        (["--family", "garden"], "there is no family 'garden'; valid are food, tableware, stationery, mixed"),
        (["--library", "/nowhere"], "objects.yaml"),
    ],
)
def test_what_cannot_be_made_is_said_in_one_sentence(tmp_path, capsys, arguments, said):
    assert main(["generate", "-n", "1", "-o", str(tmp_path), *arguments]) == 2
    assert said in capsys.readouterr().err


def test_a_list_of_tasks_is_not_shortened(tmp_path):
    listed = tmp_path / "tasks.json"
    listed.write_text(json.dumps([{"name": recipe.name} for recipe in recipes(4, 0)]))
    refuse_to_overwrite(tmp_path, recipes(4, 0))
    with pytest.raises(TampError, match=r"lists 4 tasks, of which [23] would not be made again, .*ask for them"):
        refuse_to_overwrite(tmp_path, recipes(2, 0))
    listed.write_text('{"mine": 1}')
    with pytest.raises(TampError, match=r"tasks.json is there already and is no list of tasks; choose another"):
        refuse_to_overwrite(tmp_path, recipes(4, 0))


def test_other_tasks_and_another_library_are_not_written_over(tmp_path, capsys):
    made = ["generate", "-n", "1", "--level", "1", "-o", str(tmp_path)]
    assert main(made) == 0
    (task,) = tmp_path.glob("*.yaml")
    files = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert main([*made, "--seed", "1"]) == 2
    assert f"{task} is there already and is another task" in capsys.readouterr().err
    assert main(made) == 0, "the same may be made again"
    assert files == {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    library = tmp_path / "objects" / "objects.yaml"
    library.write_text("# another\n" + library.read_text())
    capsys.readouterr()
    assert main(made) == 2
    assert f"{library} is of another library" in capsys.readouterr().err
