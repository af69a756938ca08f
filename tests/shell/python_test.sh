#!/usr/bin/env bash
# A test in Python, run by Debian's interpreter, which has its packages. Bazel's own rule asks for a
# program `python`, which Debian does not install.
exec /usr/bin/python3 -B "$@"
