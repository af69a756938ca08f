"""Text files and tables."""

import json
import os
from pathlib import Path


def write_file(path, text):
    """The whole file, or none."""
    scratch = Path(f"{path}.{os.getpid()}.tmp")
    scratch.write_text(text, encoding="utf-8", errors="replace")
    scratch.replace(path)


def to_json(value):
    return json.dumps(value, indent=2, ensure_ascii=False) + "\n"


def to_text(table, decimals=4):
    """A table for people, its first column to the left; "-": no value."""
    table = table.astype(object).where(table.notna(), "-")
    first = table.columns[0]
    width = max(len(str(text)) for text in (first, *table[first]))
    table[first] = [str(text).ljust(width) for text in table[first]]
    table = table.rename(columns={first: first.ljust(width)})
    return table.to_string(index=False, float_format=f"{{:.{decimals}f}}".format) + "\n"
