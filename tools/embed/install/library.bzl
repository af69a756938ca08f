"""Libraries for programs outside this repository: whole, with nothing but their interface visible.

`installed_library` makes, from C++ targets and all that they depend on within the repository,

    lib<name>.so.<abi>   with a soname; only the symbols of `exports` are visible; it is never unloaded, since
                         its threads stay (kernels/base/parallel_for.h)
    lib<name>.a          one object file; all other symbols are local in it, so that it meets no other
                         library's, and COMDAT groups are dissolved for the same reason
    <name>.libs          what either needs of the system's libraries, as linker flags
"""

load("@bazel_tools//tools/cpp:toolchain_utils.bzl", "find_cpp_toolchain")

# Where the compiler finds its linker.
_SHELL = {"PATH": "/usr/bin:/bin"}

_PRINT_UNIQUE = "awk '!seen[$0]++'"

def _collect(deps):
    """Archives to take whole, archives to take from, loose objects, and the system's libraries."""
    whole, lazy, flags = [], [], []
    for dep in deps:
        for linked in dep[CcInfo].linking_context.linker_inputs.to_list():
            flags += [flag for flag in linked.user_link_flags if flag.startswith("-l")]
            for library in linked.libraries:
                archive = library.pic_static_library or library.static_library
                if archive == None:
                    fail("{} has no static library".format(linked.owner))
                (whole if library.alwayslink else lazy).append(archive)
    return whole, lazy, flags

def _merged_object(ctx, toolchain, name, exports):
    """One relocatable object of everything, with all but `exports` local."""
    whole, lazy, flags = _collect(ctx.attr.deps)
    merged = ctx.actions.declare_file(name + ".o")
    ctx.actions.run_shell(
        outputs = [merged],
        inputs = depset(whole + lazy, transitive = [toolchain.all_files]),
        command = "set -e; {ld} -r --force-group-allocation -o {out} --whole-archive {whole} --no-whole-archive --start-group {lazy} --end-group; {objcopy} --wildcard {keep} {out}".format(
            ld = toolchain.ld_executable,
            objcopy = toolchain.objcopy_executable,
            out = merged.path,
            whole = " ".join([file.path for file in whole]),
            lazy = " ".join([file.path for file in lazy]),
            keep = " ".join(["--keep-global-symbol='{}'".format(symbol) for symbol in exports]),
        ),
        env = _SHELL,
        mnemonic = "MergeObjects",
    )
    return merged, flags

def _link_shared(ctx, toolchain, merged, flags, out, extra_inputs, extra_flags):
    ctx.actions.run_shell(
        outputs = [out],
        inputs = depset([merged] + extra_inputs, transitive = [toolchain.all_files]),
        command = "{gcc} -shared -pthread -o {out} {merged} -Wl,-z,relro,-z,now,-z,nodelete -Wl,--gc-sections -Wl,--as-needed {extra} {flags} -lstdc++ -lm".format(
            gcc = toolchain.compiler_executable,
            out = out.path,
            merged = merged.path,
            extra = " ".join(extra_flags),
            flags = " ".join(flags + ctx.fragments.cpp.linkopts),
        ),
        env = _SHELL,
        mnemonic = "LinkInstalled",
    )

def _installed_library_impl(ctx):
    toolchain = find_cpp_toolchain(ctx)
    name, abi = ctx.label.name, ctx.attr.abi
    merged, flags = _merged_object(ctx, toolchain, name, ctx.attr.exports)

    script = ctx.actions.declare_file(name + ".map")
    ctx.actions.write(script, "{node} {{\n  global: {symbols};\n  local: *;\n}};\n".format(
        node = "EGOSIEVE_{}".format(abi),
        symbols = "; ".join(ctx.attr.exports),
    ))
    shared = ctx.actions.declare_file("lib{}.so.{}".format(name, abi))
    extra_flags = ["-Wl,-soname," + shared.basename, "-Wl,--version-script=" + script.path, "-Wl,-rpath,'$ORIGIN'"]
    _link_shared(ctx, toolchain, merged, [file.path for file in ctx.files.links] + flags, shared, [script] + ctx.files.links, extra_flags)

    archive = ctx.actions.declare_file("lib{}.a".format(name))
    ctx.actions.run_shell(
        outputs = [archive],
        inputs = depset([merged], transitive = [toolchain.all_files]),
        command = "rm -f {out} && {ar} rcsD {out} {merged}".format(ar = toolchain.ar_executable, out = archive.path, merged = merged.path),
        env = _SHELL,
        mnemonic = "ArchiveInstalled",
    )

    libraries = ctx.actions.declare_file(name + ".libs")
    ctx.actions.run_shell(
        outputs = [libraries],
        command = "printf '%s\\n' {} -lstdc++ -lpthread -lm | {} | tr '\\n' ' ' >{}".format(" ".join(flags), _PRINT_UNIQUE, libraries.path),
        env = _SHELL,
    )
    return [
        DefaultInfo(files = depset([shared, archive, libraries])),
        OutputGroupInfo(shared = depset([shared])),
    ]

installed_library = rule(
    implementation = _installed_library_impl,
    attrs = {
        "deps": attr.label_list(providers = [CcInfo]),
        "abi": attr.int(mandatory = True),
        # The symbols that stay visible; wildcards are allowed.
        "exports": attr.string_list(mandatory = True),
        # Shared libraries of ours that this one needs.
        "links": attr.label_list(allow_files = True),
        "_cc_toolchain": attr.label(default = Label("@bazel_tools//tools/cpp:current_cc_toolchain")),
    },
    fragments = ["cpp"],
    toolchains = ["@bazel_tools//tools/cpp:toolchain_type"],
)
