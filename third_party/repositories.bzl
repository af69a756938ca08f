"""Every repository that the build needs, taken from Debian's packages: nothing is downloaded."""

def bazel_repositories():
    """Overrides what `bazel test` would otherwise fetch."""
    native.local_repository(
        name = "rules_cc",
        path = "third_party/bazel/rules_cc",
    )
    native.local_repository(
        name = "remote_coverage_tools",
        path = "third_party/bazel/remote_coverage_tools",
    )
    native.local_repository(
        name = "rules_java",
        path = "/usr/share/bazel/rules/java",
    )
    native.local_repository(
        name = "rules_proto",
        path = "/usr/share/bazel/rules/proto",
    )
    native.local_repository(
        name = "bazel_skylib",
        path = "/usr/share/bazel/tools/skylib",
    )
    native.local_repository(
        name = "platforms",
        path = "/usr/share/bazel/platforms",
    )

# Those that a version lacks are parts of others there.
_ABSEIL_LIBRARIES = [
    "status",
    "statusor",
    "strings",
    "string_view",
    "str_format_internal",
    "cord",
    "synchronization",
    "time",
    "hash",
    "raw_hash_set",
    "int128",
    "base",
    "throw_delegate",
    "raw_logging_internal",
]

def _debian_abseil(context):
    present = [
        name
        for name in _ABSEIL_LIBRARIES
        if context.execute(["pkg-config", "--exists", "absl_" + name]).return_code == 0
    ]
    if not present:
        fail("pkg-config knows no Abseil; install pkg-config and libabsl-dev")
    context.file("BUILD")
    context.file("linkopts.bzl", "ABSEIL_LINKOPTS = {}\n".format(["-labsl_" + name for name in present]))

debian_abseil = repository_rule(
    implementation = _debian_abseil,
    local = True,
)

def _debian_python(context):
    version = "python{}.{}".format(*_run(context, ["/usr/bin/python3", "-c", "import sys; print(*sys.version_info[:2])"]).split(" "))
    context.file("name", version + "\n", executable = False)
    context.file("BUILD", "exports_files([\"name\"])\n")

def _run(context, command):
    result = context.execute(command)
    if result.return_code != 0:
        fail("{}: {}".format(" ".join(command), result.stderr))
    return result.stdout.strip()

# The system's own Python, whichever version that is: `name`, a file that says "python3.11".
debian_python = repository_rule(
    implementation = _debian_python,
    local = True,
)

def debian_libraries():
    """Libraries whose headers are not on the compiler's default path."""
    native.new_local_repository(
        name = "debian_eigen",
        build_file = "//third_party:eigen.BUILD",
        path = "/usr/include/eigen3",
    )
    native.new_local_repository(
        name = "debian_opencv",
        build_file = "//third_party:opencv.BUILD",
        path = "/usr/include/opencv4",
    )
    native.new_local_repository(
        name = "debian_dygraphs",
        build_file = "//third_party:dygraphs.BUILD",
        path = "/usr/share/javascript/dygraphs",
    )
    debian_abseil(name = "debian_abseil")
    debian_python(name = "debian_python")
