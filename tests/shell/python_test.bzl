"""Tests in Python."""

def python_test(name, main, args = [], srcs = [], data = [], **kwargs):
    """Runs `main`, which may import `srcs` of its own folder, with `args`."""
    native.sh_test(
        name = name,
        srcs = ["//tests/shell:python_test.sh"],
        args = ["$(rootpath %s)" % main] + args,
        data = [main] + srcs + data,
        **kwargs
    )
