"""Installs what commands and tests need from Python's package index, in recorded versions, each with its hash.

    python3 setup.py environment FOLDER LIST     a virtual environment with the packages of a list
    python3 setup.py dxc FOLDER LIST             DXC's library, FOLDER/libdxcompiler.so

A folder that the same list filled before is left as it is.
"""

import platform
import shutil
import subprocess
import sys
import tarfile
import tempfile
import venv
from pathlib import Path

STAMP = "installed.txt"
# where the package compushady has the library, by system and processor
LIBRARIES = {
    ("Linux", "x86_64"): "libdxcompiler_x86_64.so.3.7",
    ("Linux", "aarch64"): "libdxcompiler_aarch64.so.3.7",
    ("Linux", "armv7l"): "libdxcompiler_armv7l.so.3.7",
    ("Darwin", "x86_64"): "libdxcompiler.3.7.dylib",
    ("Darwin", "arm64"): "libdxcompiler.3.7.dylib",
}


def pip(python, *arguments):
    words = [str(python), "-m", "pip", *arguments]
    print("==", " ".join(words), file=sys.stderr, flush=True)
    if subprocess.run(words, stdin=subprocess.DEVNULL, stdout=sys.stderr).returncode != 0:
        sys.exit("pip failed, see above; Python 3.11 or later and access to a package index are needed")


def make(folder):
    """An empty virtual environment; path of its Python."""
    venv.EnvBuilder(with_pip=True, clear=True).create(folder)
    return folder / "bin" / "python"


def environment(folder, wanted):
    pip(make(folder), "install", "-q", "--only-binary", ":all:", "--require-hashes", "-r", str(wanted))


def dxc(folder, wanted):
    here = platform.system(), platform.machine()
    name = LIBRARIES.get(here) or sys.exit(f"there is no library of DXC for {' '.join(here)}")
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder) as place:
        place = Path(place)
        python = make(place / "environment")
        # the list has one package in source form; the others read its description, so that nothing else is fetched for that
        source, rest = divide(wanted.read_text(), "compushady")
        (place / "source.txt").write_text(source)
        (place / "rest.txt").write_text(rest)
        pip(python, "install", "-q", "--only-binary", ":all:", "--require-hashes", "-r", str(place / "rest.txt"))
        pip(python, "download", "-q", "--no-deps", "--no-binary", ":all:", "--no-build-isolation", "--require-hashes",
            "-r", str(place / "source.txt"), "-d", str(place))
        (archive,) = place.glob("compushady-*.tar.gz")
        with tarfile.open(archive) as package:
            (member,) = [m for m in package.getmembers() if m.isfile() and m.name.endswith("/" + name)]
            with package.extractfile(member) as library, open(place / "library", "wb") as out:
                shutil.copyfileobj(library, out)
        (place / "library").replace(folder / "libdxcompiler.so")


def divide(text, name):
    """The entry of a package, and the others."""
    entries = text.replace("\\\n", "\\ ").splitlines(keepends=True)
    own = [entry for entry in entries if entry.startswith(name + "==")]
    return ["".join(part).replace("\\ ", "\\\n") for part in (own, [e for e in entries if e not in own])]


def main(what, folder, wanted):
    folder, wanted = Path(folder), Path(wanted)
    stamp = folder / STAMP
    if stamp.exists() and stamp.read_bytes() == wanted.read_bytes():
        return
    {"environment": environment, "dxc": dxc}[what](folder, wanted)
    shutil.copyfile(wanted, stamp)


if __name__ == "__main__":
    main(*sys.argv[1:])
