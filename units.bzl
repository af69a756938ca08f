"""Libraries whose sources are compiled several at a time."""

_SOURCES_PER_UNIT = 12

def _unit_impl(ctx):
    unit = ctx.actions.declare_file(ctx.label.name + ".cc")
    ctx.actions.write(unit, "".join(['#include "%s"\n' % source.short_path for source in ctx.files.srcs]))
    return DefaultInfo(files = depset([unit]))

_unit = rule(
    implementation = _unit_impl,
    attrs = {"srcs": attr.label_list(allow_files = [".cc"])},
)

def unit_library(name, srcs, hdrs, deps, **attributes):
    """A cc_library: most of a source's time is that of reading headers, and a unit reads them once.

    Names of anonymous namespaces must differ within a library. attributes: others of cc_library.
    """
    sources = [source for source in srcs if source.endswith(".cc")]
    units = []
    for first in range(0, len(sources), _SOURCES_PER_UNIT):
        unit = "%s_unit_%d" % (name, first // _SOURCES_PER_UNIT)
        _unit(name = unit, srcs = sources[first:first + _SOURCES_PER_UNIT])
        units.append(unit)
    native.cc_library(
        name = name,
        srcs = units + [source for source in srcs if not source.endswith(".cc")],
        hdrs = hdrs,
        textual_hdrs = sources,
        deps = deps,
        **attributes
    )
