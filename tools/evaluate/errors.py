"""Errors that end the program with one line and an exit code (tools/cli/exit_code.h)."""


class UsageError(Exception):
    """A flag, a value or a folder does not fit."""

    code = 2


class InputError(Exception):
    """A file is missing or damaged."""

    code = 3
