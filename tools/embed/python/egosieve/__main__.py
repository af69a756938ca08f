"""The program egosieve, as `pip install` puts it on the path, or as `python -m egosieve`."""

import os
import sys
from pathlib import Path


def main():
    # In bin/ beside this file in a wheel, in bin/ above lib/python3.*/site-packages/egosieve where installed.
    here = Path(__file__).resolve().parent
    paths = [folder / "bin" / "egosieve" for folder in (here, here.parents[3])]
    program = next((path for path in paths if path.exists()), None)
    if program is None:
        sys.exit(f"egosieve: the program is neither of {', '.join(map(str, paths))}")
    os.execv(program, ["egosieve", *sys.argv[1:]])


if __name__ == "__main__":
    main()
