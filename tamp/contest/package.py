"""What contestants hand in: a single file, a folder, a zip or a wheel; unpacked so that it can reach nothing else."""

from __future__ import annotations

import shutil
import stat
import unicodedata
import zipfile
import zlib
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from tamp.contest.rules import Uploads
from tamp.contest.sandbox.isolation import visible
from tamp.errors import TampError

ENTRY = "solution"
"""The module or package that holds the class `Solution`, unless there is only one."""

LONGEST, LONGEST_PART = 200, 255
"""Of a path in a package [characters], and of a name in it [bytes]."""

COMPILED = "__pycache__"
"""Folders that are left out: what Python compiled elsewhere, it does not take for that of the files here."""

CHUNK = 1 << 16

PACKINGS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
"""How entries may be packed; of others, Python unpacks whole pieces of any size into memory."""

UNREADABLE = (
    zipfile.BadZipFile, zipfile.LargeZipFile, zlib.error, NotImplementedError, EOFError, ValueError, RuntimeError,
)  # fmt: skip
"""What Python raises where a zip is damaged, or made by another program's rules."""

SAID_TO_BE_UTF_8 = 1 << 11
"""The flag of a zip's entry by which its name is (APPNOTE 4.4.4)."""

ENTRY_BYTES = 2048
"""What an entry may take in a zip's directory, its name and extra fields included."""
END, END_SIZE, LONGEST_COMMENT = b"PK\x05\x06", 22, 1 << 16
END_64, END_64_SIZE = b"PK\x06\x07", 20
"""The record at the end of a zip, and what stands before it where the zip is for more than 4 GiB (APPNOTE 4.3)."""


class PackageError(TampError):
    """A package cannot be accepted: says which file is wrong, and what would be valid."""


@dataclass(frozen=True)
class Package:
    """An unpacked solution.

    Attributes:
        folder: what is put on Python's path.
        module: holds the class `Solution`.
    """

    folder: Path
    module: str

    @property
    def source(self) -> Path:
        """The file that Python reads when it imports the module."""
        package = self.folder / self.module / "__init__.py"
        return package if package.is_file() else self.folder / f"{self.module}.py"


def unpack(source: Path, folder: Path, limits: Uploads | None = None, called: str | None = None) -> Package:
    """Copy a solution into an empty folder.

    Args:
        source: a .py file, a folder, a .zip or a .whl.
        folder: made where it is absent.
        limits: of size and number of files; links and paths that lead elsewhere are refused in any case.
        called: what its owner calls it, for messages; as the source is called where it is None.

    Raises:
        PackageError: where it cannot be accepted.
    """
    limits, name = limits or Uploads(), called or source.name
    folder.mkdir(parents=True, exist_ok=True)
    if source.is_dir():
        _copy(source, folder, limits)
    elif source.suffix.lower() == ".py" and source.is_file():
        if source.stat().st_size > limits.size_kb << 10:
            raise PackageError(f"{name}: larger than {limits.size_kb} KiB")
        shutil.copyfile(source, folder / f"{ENTRY}.py")
    elif source.suffix.lower() in (".zip", ".whl") and source.is_file():
        _unzip(source, folder, limits, name)
    else:
        raise PackageError(f"{called or source}: expected a .py file, a folder, a .zip or a .whl that exists")
    return Package(folder, _entry(name, folder))


def _entry(name: str, folder: Path) -> str:
    """The module with the solution: `solution`, or the only one."""
    modules = _modules(folder)
    if ENTRY in modules:
        return ENTRY
    if len(modules) == 1:
        return modules[0]
    found = f"has {', '.join(map(visible, modules[:10]))}" if modules else f"has none at its top{_elsewhere(folder)}"
    if "__init__" in modules:
        found += f"; pack the folder that __init__.py is in, called {ENTRY}, not only what is in that folder"
    raise PackageError(f"{name}: expected a module {ENTRY}.py, a package {ENTRY}/, or one module only; it {found}")


def _modules(folder: Path) -> list[str]:
    """What can be imported from a folder, sorted."""
    files = (path.stem for path in _sources(folder) if path.is_file() and path.stem.isidentifier())
    return sorted([*files, *(path.name for path in _sources(folder) if path.is_dir() and "." not in path.name)])


def _sources(folder: Path) -> list[Path]:
    """Python's files in a folder, and packages."""
    return [path for path in folder.iterdir() if path.suffix == ".py" or (path / "__init__.py").is_file()]


def _elsewhere(folder: Path) -> str:
    """Of a folder that has no module: which file of it is called wrongly, or where below there is one."""
    misnamed = min(_sources(folder), default=None)
    if misnamed is not None:
        ending = ".py" if misnamed.is_file() else "/"
        return f", but {visible(misnamed.name)}, a name that cannot be imported: call it {ENTRY}{ending}"
    below = [(path, _modules(path)) for path in folder.rglob("*") if path.is_dir()]
    found = [(ENTRY not in modules, len(path.parts), path, modules) for path, modules in below if modules]
    if not found:
        return ""
    other, _, path, modules = min(found)
    module = modules[0] if other else ENTRY
    file = f"{module}.py" if (path / f"{module}.py").is_file() else f"the package {module}/"
    place = visible(path.relative_to(folder).as_posix())
    return f", but {visible(file)} in its folder {place!r}: pack what is in that folder, not the folder itself"


def _copy(source: Path, folder: Path, limits: Uploads) -> None:
    total = count = 0
    for path in sorted(source.rglob("*")):
        if COMPILED in path.parts or (path.is_dir() and not path.is_symlink()):
            continue
        if path.is_symlink() or not path.is_file():
            raise PackageError(f"{path}: is a link or a device; a package holds files only")
        count, total = count + 1, total + path.stat().st_size
        _within(source.name, total, count, limits)
        target = folder / path.relative_to(source)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, target)


def _unzip(source: Path, folder: Path, limits: Uploads, name: str) -> None:
    if source.stat().st_size > limits.size_kb << 10:
        raise PackageError(f"{name}: larger than {limits.size_kb} KiB")
    try:
        if _directory_size(source, name) > limits.files * ENTRY_BYTES:
            raise PackageError(f"{name}: holds more than {limits.files} files and folders")
        with zipfile.ZipFile(source) as archive:
            entries = [e for e in archive.infolist() if COMPILED not in PurePosixPath(_name_of(e)).parts]
            total = 0
            for target, entry in _checked(name, entries, limits, source.stat().st_size).items():
                total = _write(archive, entry, folder / target, total, limits, name)
    except UNREADABLE as error:
        raise PackageError(f"{name}: is no zip that can be read: {error}") from None
    except (FileExistsError, NotADirectoryError, IsADirectoryError):
        raise PackageError(f"{name}: a file has the name of a folder") from None


def _directory_size(source: Path, name: str) -> int:
    """The size of a zip's directory [bytes]: it is read into memory whole, an object an entry.

    Raises:
        PackageError: where there is none, or one for more than 4 GiB or 65,535 files, which no package needs.
    """
    size = source.stat().st_size
    with source.open("rb") as file:
        file.seek(max(0, size - END_64_SIZE - END_SIZE - LONGEST_COMMENT))
        tail = file.read()
    # The same record that Python's zipfile takes: one without a comment, else the last one there is.
    at = len(tail) - END_SIZE if tail[-END_SIZE:-18] == END and tail[-2:] == b"\0\0" else tail.rfind(END)
    if at < 0 or len(tail) - at < END_SIZE:
        raise PackageError(f"{name}: is no zip that can be read: it has no directory")
    if tail[max(0, at - END_64_SIZE) : at].startswith(END_64):
        raise PackageError(f"{name}: is a zip for more than 4 GiB or 65,535 files (ZIP64); pack it anew without")
    return int.from_bytes(tail[at + 12 : at + 16], "little")


def _checked(
    name: str, entries: Sequence[zipfile.ZipInfo], limits: Uploads, size: int
) -> dict[PurePosixPath, zipfile.ZipInfo]:
    """Where each file of a zip of a size [bytes] goes; nothing has been written yet. Folders count as files do."""
    _within(name, sum(entry.file_size for entry in entries), len(entries), limits)
    seen: dict[str, str] = {}
    folders: set[PurePosixPath] = set()
    files = {}
    for entry in entries:
        called, mode = _name_of(entry), entry.external_attr >> 16
        path = PurePosixPath(called)
        wrong = ""
        if not path.parts or path.is_absolute() or ".." in path.parts:
            wrong = "leads out of the package"
        elif "\0" in entry.orig_filename or ":" in called or len(called) > LONGEST:
            wrong = f"has a name that is longer than {LONGEST} characters, or holds a colon or a zero"
        elif max(len(part.encode()) for part in path.parts) > LONGEST_PART:
            wrong = f"has a name of more than {LONGEST_PART} bytes"
        elif stat.S_IFMT(mode) not in (0, stat.S_IFREG, stat.S_IFDIR):
            wrong = "is a link or a device"
        elif not 0 <= entry.header_offset < size:
            wrong = "is said to be outside of the file, which is damaged"
        elif entry.flag_bits & 1:
            wrong = "is encrypted"
        elif entry.compress_type not in PACKINGS:
            wrong = "is neither stored nor deflated"
        elif (other := seen.get(str(path).casefold())) is not None:
            wrong = "comes twice" if other == str(path) else f"differs from {other!r} by capitals only"
        if wrong:
            raise PackageError(f"{name}: {entry.filename[:LONGEST]!r} {wrong}; nothing was unpacked")
        seen[str(path).casefold()] = str(path)
        if not called.endswith("/"):
            files[path] = entry
            folders.update(list(path.parents)[:-1])  # the last one is the package's own
            _within(name, 0, len(seen) + len(folders), limits)
    return files


def _name_of(entry: zipfile.ZipInfo) -> str:
    """What an entry is called by who packed it, with slashes, and in the composed form in which code is typed.

    Old programs of Windows write backslashes. macOS does not say that it writes UTF-8, and parts letters from accents.
    """
    name = entry.filename
    if not entry.flag_bits & SAID_TO_BE_UTF_8:
        with suppress(UnicodeError):
            name = name.encode("cp437").decode("utf-8")  # as Python's zipfile read it; hardly any other text is UTF-8
    return unicodedata.normalize("NFC", name.replace("\\", "/"))


def _write(
    archive: zipfile.ZipFile, entry: zipfile.ZipInfo, target: Path, total: int, limits: Uploads, name: str
) -> int:
    """Unpack one file, counting what comes and not what was promised; the total so far."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with archive.open(entry) as packed, target.open("xb") as file:
        while piece := packed.read(CHUNK):
            total += len(piece)
            _within(name, total, 0, limits)
            file.write(piece)
    return total


def _within(name: str, total: int, count: int, limits: Uploads) -> None:
    if total > limits.unpacked_kb << 10:
        raise PackageError(f"{name}: unpacked it is larger than {limits.unpacked_kb} KiB")
    if count > limits.files:
        raise PackageError(f"{name}: holds more than {limits.files} files and folders")
