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
    native.new_local_repository(
        name = "debian_python",
        build_file = "//third_party:python.BUILD",
        path = "/usr/include/python3.11",
    )
