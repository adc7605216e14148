"""Packages: what is handed in is unpacked into its folder and nowhere else, or refused by name."""

from __future__ import annotations

import stat
import struct
import zipfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tamp.contest.package import PackageError, unpack
from tamp.contest.rules import Uploads

SMALL = Uploads(size_kb=64, unpacked_kb=64, files=20)
CODE = "class Solution:\n    def run(self, goal, robot): ...\n"


def _zip(path: Path, entries: dict[str, bytes | str], **attributes: int) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in entries.items():
            info = zipfile.ZipInfo(name)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.external_attr = attributes.get("mode", 0o644 | stat.S_IFREG) << 16
            archive.writestr(info, data)
    return path


def test_a_zip_a_file_a_folder_and_a_wheel_are_the_same(tmp_path: Path) -> None:
    (tmp_path / "solution.py").write_text(CODE)
    wheel = _zip(tmp_path / "mine-1.0-py3-none-any.whl", {"mine/__init__.py": CODE, "mine-1.0.dist-info/METADATA": "x"})
    plain = _zip(tmp_path / "mine.zip", {"solution.py": CODE, "helper.py": "x = 1\n", "data/weights.bin": b"\0" * 100})
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "only.py").write_text(CODE)
    modules = [
        unpack(p, tmp_path / f"out{i}").module for i, p in enumerate((tmp_path / "solution.py", wheel, plain, folder))
    ]
    assert modules == ["solution", "mine", "solution", "only"]
    assert (tmp_path / "out2" / "data" / "weights.bin").read_bytes() == b"\0" * 100


@pytest.mark.parametrize(
    ("name", "complaint"),
    [
        ("../outside.py", "leads out"),
        ("a/../../outside.py", "leads out"),
        ("/etc/outside.py", "leads out"),
        ("a\\..\\outside.py", "leads out"),
        ("C:/outside.py", "colon"),
        ("x" * 300, "longer"),
    ],
)
def test_names_that_lead_elsewhere_are_refused(tmp_path: Path, name: str, complaint: str) -> None:
    source = _zip(tmp_path / "bad.zip", {"solution.py": CODE, name: "was here"})
    with pytest.raises(PackageError, match=complaint):
        unpack(source, tmp_path / "out")
    assert list((tmp_path / "out").iterdir()) == []
    assert not (tmp_path / "outside.py").exists()


@pytest.mark.parametrize("file", ["solution.py", "agent_builder.py"])
def test_who_packed_the_folder_itself_is_told_so(tmp_path: Path, file: str) -> None:
    source = _zip(tmp_path / "mine.zip", {"__MACOSX/._x": "", f"mine/{file}": CODE, "mine/tools.py": ""})
    with pytest.raises(PackageError, match=f"none at its top, but {file} in its folder 'mine': pack what is in that"):
        unpack(source, tmp_path / "out")


@pytest.mark.parametrize(
    ("files", "said"),
    [
        (("mine/solution/__init__.py", "mine/tests/__init__.py"), "but the package solution/ in its folder 'mine'"),
        (("mine-main/README.md", "mine-main/src/solution.py"), "but solution.py in its folder 'mine-main/src'"),
        (("a/b.py", "a/c/solution.py"), "but solution.py in its folder 'a/c'"),
        (("my-solution.py",), "but my-solution.py, a name that cannot be imported: call it solution.py"),
        (("mine.v2/__init__.py",), "but mine.v2, a name that cannot be imported: call it solution/"),
        (("__init__.py", "core.py"), "it has __init__, core; pack the folder that __init__.py is in, called solution"),
        (("solution.ipynb",), "it has none at its top$"),
    ],
)
def test_where_the_solution_is_instead_is_told(tmp_path: Path, files: tuple[str, ...], said: str) -> None:
    source = _zip(tmp_path / "mine.zip", dict.fromkeys(files, CODE))
    with pytest.raises(PackageError, match=said):
        unpack(source, tmp_path / "out")


def test_zips_of_other_systems_are_unpacked_as_they_were_packed(tmp_path: Path) -> None:
    """Backslashes, folders by them; UTF-8 that is not said to be, in decomposed form; endings in capitals."""
    names = ("mine\\", "mine\\__init__.py", "mine\\de___ja.txt")
    source = _zip(tmp_path / "MINE.ZIP", dict.fromkeys(names, CODE))
    source.write_bytes(source.read_bytes().replace(b"de___ja.txt", "de\u0301 ja.txt".encode()))
    package = unpack(source, tmp_path / "out")
    assert package.module == "mine"
    assert sorted(path.name for path in (tmp_path / "out" / "mine").iterdir()) == ["__init__.py", "d\u00e9 ja.txt"]


def test_a_name_longer_than_file_systems_take_is_refused(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        archive.writestr("solution.py", CODE)
        archive.writestr("\u00e4" * 150, "")
    with pytest.raises(PackageError, match="255 bytes"):
        unpack(tmp_path / "a.zip", tmp_path / "out")


def test_links_are_refused(tmp_path: Path) -> None:
    source = _zip(tmp_path / "link.zip", {"solution.py": "/etc/passwd"}, mode=0o777 | stat.S_IFLNK)
    with pytest.raises(PackageError, match="is a link"):
        unpack(source, tmp_path / "out")
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "solution.py").symlink_to("/etc/passwd")
    with pytest.raises(PackageError, match="is a link"):
        unpack(tmp_path / "folder", tmp_path / "out2")
    (tmp_path / "folder" / "solution.py").unlink()
    (tmp_path / "folder" / "solution.py").write_text(CODE)
    (tmp_path / "folder" / "weights").symlink_to(tmp_path)  # a folder, which would just not be there
    with pytest.raises(PackageError, match="weights: is a link"):
        unpack(tmp_path / "folder", tmp_path / "out3")


def test_bombs_are_refused_however_they_lie(tmp_path: Path) -> None:
    bomb = _zip(tmp_path / "bomb.zip", {"solution.py": CODE, "zeros": bytes(1 << 20)})
    with pytest.raises(PackageError, match="larger than 64 KiB"):
        unpack(bomb, tmp_path / "out", SMALL)
    data = bytearray(bomb.read_bytes())
    for place in range(len(data) - 4):  # the size that the archive promises, in both of its headers
        if data[place : place + 4] == (1 << 20).to_bytes(4, "little"):
            data[place : place + 4] = (100).to_bytes(4, "little")
    bomb.write_bytes(data)
    with pytest.raises(PackageError):
        unpack(bomb, tmp_path / "out2", SMALL)
    assert sum(f.stat().st_size for f in (tmp_path / "out2").rglob("*") if f.is_file()) <= 64 << 10
    many = _zip(tmp_path / "many.zip", {f"f{i}.py": "" for i in range(30)})
    with pytest.raises(PackageError, match="more than 20 files"):
        unpack(many, tmp_path / "out3", SMALL)


def test_a_directory_of_countless_entries_is_refused_before_it_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    entry = b"PK\x01\x02" + struct.pack("<6H3I5H2I", 20, 20, 0, 0, 0, 33, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0) + b"a"
    directory = entry * 1000
    end = struct.pack("<4s4H2IH", b"PK\x05\x06", 0, 0, 1000, 1000, len(directory), 0, 0)
    locator = struct.pack("<4sIQI", b"PK\x06\x07", 0, 0, 1)
    monkeypatch.setattr(zipfile, "ZipFile", lambda *_: pytest.fail("it was read"))
    for number, (data, complaint) in enumerate(
        (
            (directory + end, "more than 20 files"),
            (directory + end[:-2] + b"\x03\0xyz", "more than 20 files"),
            (directory + locator + end, "ZIP64"),
            (directory + locator + end[:-2] + b"\xff\xff" + bytes(0xFFFF), "ZIP64"),
            (directory, "no directory"),
        )
    ):
        source = tmp_path / f"{number}.zip"
        source.write_bytes(data)
        with pytest.raises(PackageError, match=complaint):
            unpack(source, tmp_path / f"out{number}", Uploads(size_kb=256, files=20))


@pytest.mark.parametrize("packing", [zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2])
def test_packings_whose_bombs_go_off_in_memory_are_refused(tmp_path: Path, packing: int) -> None:
    with zipfile.ZipFile(tmp_path / "odd.zip", "w", packing) as archive:
        archive.writestr("solution.py", CODE)
    with pytest.raises(PackageError, match="neither stored nor deflated"):
        unpack(tmp_path / "odd.zip", tmp_path / "out", SMALL)


def test_the_same_name_twice_and_no_module_are_refused(tmp_path: Path) -> None:
    with pytest.raises(PackageError, match=r"'SOLUTION.py' differs from 'solution.py' by capitals only"):
        unpack(_zip(tmp_path / "capitals.zip", {"solution.py": CODE, "SOLUTION.py": CODE}), tmp_path / "out")
    composed, parted = "caf\u00e9.py", "cafe\u0301.py"
    with pytest.raises(PackageError, match="comes twice; nothing was unpacked"):
        unpack(_zip(tmp_path / "forms.zip", {composed: CODE, parted: CODE}), tmp_path / "out")
    with pytest.raises(PackageError, match="'data//x' comes twice"):
        unpack(_zip(tmp_path / "twice.zip", {"solution.py": CODE, "data/x": "", "data//x": ""}), tmp_path / "out")
    with pytest.raises(PackageError, match=r"expected a module solution\.py"):
        unpack(_zip(tmp_path / "two.zip", {"a.py": CODE, "b.py": CODE}), tmp_path / "out2")
    with pytest.raises(PackageError, match="has the name of a folder"):
        unpack(_zip(tmp_path / "clash.zip", {"solution.py": CODE, "solution.py/x": "y"}), tmp_path / "out3")


def test_what_python_compiled_is_left_out_and_does_not_count(tmp_path: Path) -> None:
    """`pip install --target` compiles: a zip of that held twice as many files."""
    compiled = {f"lib/__pycache__/m{n}.cpython-311.pyc": b"\0" * 4000 for n in range(30)}
    source = _zip(tmp_path / "mine.zip", {"solution.py": CODE, "lib/__init__.py": "", **compiled})
    unpack(source, tmp_path / "out", SMALL)
    assert sorted(path.name for path in (tmp_path / "out").rglob("*")) == ["__init__.py", "lib", "solution.py"]


def test_folders_count_as_files_do(tmp_path: Path) -> None:
    deep = {f"{number}/{'a/' * 90}x": "" for number in range(2)}
    with pytest.raises(PackageError, match="more than 20 files and folders"):
        unpack(_zip(tmp_path / "deep.zip", {"solution.py": CODE, **deep}), tmp_path / "out", SMALL)
    assert list((tmp_path / "out").iterdir()) == []
    flat = {f"f{i}": "" for i in range(SMALL.files - 1)}
    assert unpack(_zip(tmp_path / "flat.zip", {"solution.py": CODE, **flat}), tmp_path / "out2", SMALL)


def test_damaged_pieces_are_refused_in_a_sentence(tmp_path: Path) -> None:
    whole = _zip(tmp_path / "whole.zip", {"solution.py": CODE * 50}).read_bytes()
    for place in range(41, len(whole) - 100):  # behind the header of the only file
        source = tmp_path / "damaged.zip"
        source.write_bytes(whole[:place] + bytes([whole[place] ^ 0x55]) + whole[place + 1 :])
        with pytest.raises(PackageError):
            unpack(source, tmp_path / f"out{place}")


@given(st.binary(max_size=400))
def test_any_bytes_are_refused_in_a_sentence(data: bytes) -> None:
    import tempfile

    with tempfile.TemporaryDirectory() as name:
        source = Path(name) / "any.zip"
        source.write_bytes(data)
        with pytest.raises(PackageError):
            unpack(source, Path(name) / "out", SMALL)


def test_an_entry_that_is_said_to_stand_before_the_file_is_refused(tmp_path: Path) -> None:
    """Python asks the system for such a place, whose refusal looks as if the server's disk had failed."""
    whole = _zip(tmp_path / "whole.zip", {"solution.py": CODE}).read_bytes()
    place = whole.rindex(b"PK\5\6") + 16  # where the directory is said to begin; entries are moved by what is wrong
    source = tmp_path / "damaged.zip"
    source.write_bytes(whole[:place] + struct.pack("<I", 1 << 12) + whole[place + 4 :])
    with pytest.raises(PackageError, match=r"'solution\.py' is said to be outside of the file"):
        unpack(source, tmp_path / "out")
