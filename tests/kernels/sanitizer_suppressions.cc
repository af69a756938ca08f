// What the sanitizers leave out: allocations and accesses of the OpenCL driver (PoCL, LLVM, clang)
// and tables of OpenCV, which are not built with them. A test that opens a device on PoCL, or
// converts colours to CIELAB, depends on this library.
extern "C" {

// The driver keeps its compiler's tables until the process ends, and OpenCV those of its first
// conversion to CIELAB. Its stacks end at fastMalloc; a cv::Mat that leaks still shows by its
// header, which is allocated by new.
const char* __lsan_default_suppressions() {
  return "leak:libpocl\n"
         "leak:libLLVM\n"
         "leak:libclang\n"
         "leak:cv::fastMalloc\n";
}

// Its worker threads and locks are not seen by the instrumentation.
const char* __tsan_default_suppressions() {
  return "race:libpocl\n"
         "race:libLLVM\n"
         "race:libclang\n"
         "deadlock:libpocl\n"
         "mutex:libpocl\n";
}

const char* __tsan_default_options() { return "ignore_noninstrumented_modules=1"; }

}  // extern "C"
