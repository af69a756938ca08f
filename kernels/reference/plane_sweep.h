// The plane sweep in plain float64, by the formulas of kernels/ops/plane_sweep.h. Arguments must be
// valid: the public operation checks them.
#ifndef EGOSIEVE_KERNELS_REFERENCE_PLANE_SWEEP_H_
#define EGOSIEVE_KERNELS_REFERENCE_PLANE_SWEEP_H_

#include "kernels/base/matrix_view.h"
#include "kernels/base/plane_sweep_inputs.h"

namespace egosieve::kernels::reference {

// out: grid.size() x kSweepColumns.
void PlaneSweep(const PlaneSweepInputs& inputs, MatrixView<float> out);

}  // namespace egosieve::kernels::reference

#endif  // EGOSIEVE_KERNELS_REFERENCE_PLANE_SWEEP_H_
