// OpenCL's handle types as CL/cl.h declares them, for headers that do not include it.
#ifndef EGOSIEVE_KERNELS_RUNTIME_OPENCL_HANDLES_H_
#define EGOSIEVE_KERNELS_RUNTIME_OPENCL_HANDLES_H_

typedef struct _cl_command_queue* cl_command_queue;
typedef struct _cl_event* cl_event;
typedef struct _cl_mem* cl_mem;

#endif  // EGOSIEVE_KERNELS_RUNTIME_OPENCL_HANDLES_H_
