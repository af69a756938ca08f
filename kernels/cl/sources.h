// The OpenCL sources, embedded at build time.
#pragma once

#include <string_view>

namespace egosieve::kernels::cl_sources {

// The text of a file of kernels/cl, for instance "common.cl"; empty if there is no such file.
std::string_view Text(std::string_view file);

}  // namespace egosieve::kernels::cl_sources
