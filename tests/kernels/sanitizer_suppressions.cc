// What the sanitizers are told to leave out: allocations and accesses of the OpenCL driver (PoCL,
// LLVM, clang), which is not built with them. A test that opens a device on PoCL depends on this
// library.
extern "C" {

// The driver keeps its compiler's tables until the process ends.
const char* __lsan_default_suppressions() {
  return "leak:libpocl\n"
         "leak:libLLVM\n"
         "leak:libclang\n";
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
