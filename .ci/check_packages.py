"""Assert that the sdist and the wheel hold every module and data file of the checkout, and nothing that is not ours."""

from __future__ import annotations

import sys
import tarfile
import zipfile
from pathlib import Path

CONTENT = ("streams", "domains", "robots", "scenarios")
SUFFIXES = {".py", ".typed", ".pddl", ".yaml", ".urdf", ".srdf", ".obj", ".stl", ".html", ".css", ".js"}


def expected() -> set[str]:
    """The files of tamp/ with the content folders inside it, as an installed package has them."""
    found = set()
    for folder in ("tamp", *CONTENT):
        for path in Path(folder).rglob("*"):
            # The links inside tamp/ are seen through their targets, once.
            linked = path.parts[:1] == ("tamp",) and path.parts[1] in CONTENT
            if path.is_file() and path.suffix in SUFFIXES and not linked:
                found.add(path.as_posix() if folder == "tamp" else f"tamp/{path.as_posix()}")
    return found


def main(folder: Path) -> None:
    """Compare both archives in `folder` with the checkout."""
    wanted = expected()
    (wheel,) = folder.glob("*.whl")
    (sdist,) = folder.glob("*.tar.gz")
    with zipfile.ZipFile(wheel) as archive:
        compare(wheel.name, wanted, {name for name in archive.namelist() if ".dist-info/" not in name})
    with tarfile.open(sdist) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    packed = {name for name in names if name.startswith("tamp/") and Path(name).suffix in SUFFIXES}
    compare(sdist.name, wanted, packed)
    for suffix in (".pddl", ".yaml", ".obj"):
        assert any(name.endswith(suffix) for name in wanted), f"no {suffix} file in the checkout"
    print(f"{wheel.name} and {sdist.name}: {len(wanted)} files each")


def compare(archive: str, wanted: set[str], packed: set[str]) -> None:
    """Exit with the difference where there is one."""
    if packed != wanted:
        sys.exit(f"{archive}: missing {sorted(wanted - packed)}, unexpected {sorted(packed - wanted)}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
