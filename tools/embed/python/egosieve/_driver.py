"""The OpenCL driver of PyPI's package pocl-binary-distribution, for machines that have none."""

import importlib.util
import os
from pathlib import Path

VENDORS = Path("/etc/OpenCL/vendors")


def use_packaged_driver():
    """Names the package's library to OpenCL's loader, unless the machine or the user names a driver."""
    if any(os.environ.get(name) for name in ("OCL_ICD_VENDORS", "OCL_ICD_FILENAMES")) or any(VENDORS.glob("*.icd")):
        return
    package = importlib.util.find_spec("pocl_binary_distribution")
    if package is not None and package.origin:
        for library in Path(package.origin).parents[1].glob("pyopencl/.libs/libpocl*.so"):
            os.environ["OCL_ICD_FILENAMES"] = str(library)
