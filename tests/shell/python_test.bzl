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

def python_tests(name, srcs, data = [], **kwargs):
    """Runs every *_test.py of this folder."""
    native.sh_test(
        name = name,
        srcs = ["//tests/shell:python_test.sh"],
        args = ["-m", "unittest", "discover", "-s", native.package_name(), "-p", "'*_test.py'"],
        data = srcs + data,
        **kwargs
    )
