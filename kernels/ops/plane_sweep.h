// Plane sweep: how well the patch around each place of a picture fits in a second picture at the
// positions of a static point of any depth, against the position that flow gives.
//
// A place x of the first picture, homogeneous, has the positions
//
//   x_j = (y_1 / y_3, y_2 / y_3),   y = H x + w_j e,   y_3 > 0                               (SW1)
//
// For a calibrated camera, X_2 = R X_1 + t: H = K R K^-1, e = K t, w_j = 1 / Z_1. With P, S patches
// of N = (2 radius + 1)^2 pixels around the place and a position, each less its mean,
//
//   |P - S|^2 = sum d^2 - (sum d)^2 / N,   d their difference                                (SW2)
//   static: min_j |P - S_j|^2,   found: |P - Q|^2                                            (SW3)
//
// S_j is around x_j with pixels s_j apart, Q around x + flow with pixels one apart, both sampled
// bilinearly. A patch lies in a picture of width W if x - s radius >= 0 and x + s radius < W - 1;
// likewise for rows. With (g_x, g_y) the gradient by central differences at the (2 radius - 1)^2
// inner pixels of P,
//
//   T = mean of (g_x, g_y)^T (g_x, g_y)                                                      (SW4)
//
// A patch without texture has |P|^2 = 0; one that is a straight edge has T with one eigenvalue 0.
// The caller decides what is enough.
//
// Cost for radius 3: each of the J + 1 positions of a place takes 0.6 kflop and reads 8 rows of 8
// bytes, 0.8 kflop and 14 rows of 14 bytes where s_j is not 1. These come from the cache: in memory
// a place of a grid with stride 2 has 8 bytes of pixels, 8 of flow and 24 of results. So the sweep
// is bound by arithmetic. A row of a patch is a vector of 8 lanes on CPUs; on GPUs a work-item has
// a place, its P in registers. On paper: 1242 x 375 pixels, stride 2, J = 16 are 117,000 places, 1.2
// Gflop and 127 million loads of a byte, 20 us of the arithmetic and 15 us of the loads of an H200
// (67 Tflop/s, 132 x 32 loads per clock); its 5 MB take longer across the bus.
//
// After an error in the arguments, or a device error before the computation began, `out` is
// unchanged; after a device is lost during the computation `out` may be partly written.
// Reference: Collins (1996), A space-sweep approach to true multi-image matching.
#ifndef EGOSIEVE_KERNELS_OPS_PLANE_SWEEP_H_
#define EGOSIEVE_KERNELS_OPS_PLANE_SWEEP_H_

#include "absl/status/status.h"
#include "kernels/base/matrix_view.h"
#include "kernels/base/plane_sweep_inputs.h"
#include "kernels/runtime/context.h"

namespace egosieve::kernels {

// out: grid.size() x kSweepColumns, row-major over the grid's rows and columns; all NaN where P
// leaves the first picture.
absl::Status PlaneSweep(Context& context, const PlaneSweepInputs& inputs, MatrixView<float> out);

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_OPS_PLANE_SWEEP_H_
