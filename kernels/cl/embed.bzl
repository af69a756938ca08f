"""Embeds OpenCL sources in a C++ library."""

def embedded_cl_sources(name, srcs, header, visibility = None):
    """A cc_library whose function Text("file.cl") returns the text of each of `srcs`."""
    native.genrule(
        name = name + "_cc",
        srcs = srcs,
        outs = [name + ".cc"],
        cmd = " && ".join([
            "exec > $@",
            "echo '#include \"%s\"'" % (native.package_name() + "/" + header),
            "echo 'namespace egosieve::kernels::cl_sources {'",
            "echo 'std::string_view Text(std::string_view file) {'",
            "for f in $(SRCS); do " +
            "echo \"if (file == \\\"$$(basename $$f)\\\") return R\\\"cl_text(\"; cat $$f; echo ')cl_text\";'; done",
            "echo 'return {};'",
            "echo '}'",
            "echo '}'",
        ]),
    )
    native.cc_library(
        name = name,
        srcs = [name + ".cc"],
        hdrs = [header],
        visibility = visibility,
    )
