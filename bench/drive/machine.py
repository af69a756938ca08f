"""The machine on which something is measured."""

import os
import platform
import re
from pathlib import Path


def machine():
    """The processor's name as the system gives it, its cores, and whether it has AVX-512."""
    cpu = Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""
    name = re.search(r"model name\s*: (.*)", cpu)
    return f"{os.cpu_count()} cores, {name.group(1) if name else platform.machine()}, {'AVX-512' if 'avx512f' in cpu else 'no AVX-512'}"
