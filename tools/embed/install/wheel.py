"""Makes a wheel of the tree that pack.sh packs: wheel.py ARCHIVE.tar FOLDER; prints its path.

The module calls the C interface by ctypes, so one wheel serves every Python 3 and NumPy; the program egosieve is in it. The
system's libraries that ours need are not: `auditwheel repair` copies them in.
"""

import base64
import hashlib
import sys
import tarfile
import zipfile
from pathlib import Path

MOMENT = (2020, 1, 1, 0, 0, 0)  # equal files give equal wheels

METADATA = """\
Metadata-Version: 2.1
Name: egosieve
Version: {version}
Summary: Gaussian processes on OpenCL devices, and the segmentation of moving objects in video of a moving camera
License: Apache-2.0
Requires-Python: >=3.8
Requires-Dist: numpy
Provides-Extra: view
Requires-Dist: rerun-sdk; extra == "view"
Requires-Dist: opencv-python-headless; extra == "view"
Description-Content-Type: text/markdown

{description}"""

WHEEL = """\
Wheel-Version: 1.0
Generator: egosieve
Root-Is-Purelib: false
Tag: {tag}
"""

# A module beside the package: importing that would load its libraries first.
PROGRAM = b"""\
import os
import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parent / "egosieve"


def main():
    os.execv(FOLDER / "bin" / "egosieve", ["egosieve", *sys.argv[1:]])


def view():
    os.execv(sys.executable, [sys.executable, str(FOLDER / "tools" / "view" / "egosieve-view"), *sys.argv[1:]])


if __name__ == "__main__":
    main()
"""


def contents_of(archive):
    """The wheel's files by name, and the library's version."""
    files, version, description = {}, None, ""
    with tarfile.open(archive) as tree:
        for member in filter(tarfile.TarInfo.isfile, tree):
            name, content = Path(member.name), tree.extractfile(member).read()
            if "site-packages" in name.parts:
                files[f"egosieve/{name.name}"] = content
            elif name.parent.name == "lib" and ".so." in name.name:
                files[f"egosieve/{name.name}"] = content
            elif name.parts[-2] == "view" or name.match("evaluate/__init__.py") or name.match("evaluate/files.py") or name.match("evaluate/run_folder.py"):
                files[f"egosieve/tools/{name.parts[-2]}/{name.name}"] = content
            elif name.match("bin/egosieve"):
                files["egosieve/bin/egosieve"] = content
            elif name.name == "egosieve.pc":
                version = next(line.split()[1] for line in content.decode().splitlines() if line.startswith("Version:"))
            elif name.name == "python.md":
                description = content.decode()
    return files, version, description


def write_wheel(archive, folder):
    files, version, description = contents_of(archive)
    tag = "py3-none-linux_x86_64"
    information = f"egosieve-{version}.dist-info"
    files[f"{information}/METADATA"] = METADATA.format(version=version, description=description).encode()
    files[f"{information}/WHEEL"] = WHEEL.format(tag=tag).encode()
    files["egosieve_program.py"] = PROGRAM
    files[f"{information}/entry_points.txt"] = b"[console_scripts]\negosieve = egosieve_program:main\negosieve-view = egosieve_program:view\n"
    record = ""
    for name, content in sorted(files.items()):
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        record += f"{name},sha256={digest},{len(content)}\n"
    files[f"{information}/RECORD"] = (record + f"{information}/RECORD,,\n").encode()
    path = Path(folder) / f"egosieve-{version}-{tag}.whl"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as wheel:
        for name, content in sorted(files.items()):
            entry = zipfile.ZipInfo(name, MOMENT)
            entry.external_attr = (0o755 if ".so." in name or "/bin/" in name else 0o644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            wheel.writestr(entry, content)
    return path


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(f"usage: {sys.argv[0]} ARCHIVE.tar FOLDER")
    print(write_wheel(sys.argv[1], sys.argv[2]))
