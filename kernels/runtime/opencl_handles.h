// OpenCL's handle types as CL/cl.h declares them, for headers that do not include it.
#pragma once

typedef struct _cl_command_queue* cl_command_queue;
typedef struct _cl_event* cl_event;
typedef struct _cl_mem* cl_mem;
