"""What the benchmarks in Python share: the machine, environments, workers, tables."""

import json
import os
import platform
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "bench" / "results"
PROGRAM = Path(os.environ.get("EGOSIEVE_PROGRAM", ROOT / "bazel-bin" / "tools" / "egosieve"))
CACHE = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "egosieve"


def machine():
    """The processor's name as the system gives it, its cores, and whether it has AVX-512."""
    cpu = Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""
    name = re.search(r"model name\s*: (.*)", cpu)
    return f"{os.cpu_count()} cores, {name.group(1) if name else platform.machine()}, {'AVX-512' if 'avx512f' in cpu else 'no AVX-512'}"


def say(text):
    """Progress, beside the results."""
    print(f"{Path(sys.argv[0]).stem}: {text}", file=sys.stderr, flush=True)


def call(*words):
    """What a command prints; RuntimeError with the end of its complaint where it fails."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, words))}: {done.stderr.strip()[-500:]}")
    return done.stdout


def environment(name, packages):
    """The interpreter of a virtual environment with packages of PyPI in the user's cache folder, made where it is not there."""
    folder = CACHE / name
    python = folder / "bin" / "python"
    if not (folder / "complete").exists():
        say(f"making {folder}")
        call("/usr/bin/python3", "-m", "venv", folder)
        call(python, "-m", "pip", "install", "-q", "--prefer-binary", *packages)
        (folder / "complete").touch()
    return python


def work(*words):
    """The last line of JSON that a worker prints, whatever its libraries print and however they end."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=3600)
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if not lines:
        raise RuntimeError(f"{' '.join(map(str, words))}: {done.stderr.strip()[-500:]}")
    return json.loads(lines[-1])


def markdown(columns, rows):
    """A table. columns: titles; numbers, in columns whose title begins with ">", stand to the right."""
    titles = [title.lstrip(">") for title in columns]
    rules = ["---:" if title.startswith(">") else "---" for title in columns]
    lines = [f"| {' | '.join(titles)} |", f"|{'|'.join(rules)}|"]
    lines += [f"| {' | '.join(map(str, row))} |" for row in rows]
    return "\n".join(lines) + "\n"
