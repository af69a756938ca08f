// What the device's driver and its compiler never free is not ours to report.
extern "C" const char* __lsan_default_suppressions() { return "leak:libpocl\nleak:libLLVM\n"; }
