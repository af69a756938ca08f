// What a plane sweep (kernels/ops/plane_sweep.h) compares.
#ifndef EGOSIEVE_KERNELS_BASE_PLANE_SWEEP_INPUTS_H_
#define EGOSIEVE_KERNELS_BASE_PLANE_SWEEP_INPUTS_H_

#include <array>
#include <vector>

#include "kernels/base/image_grid.h"
#include "kernels/base/image_view.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::kernels {

// One position of the sweep: (SW1) with w_j, the patch there with pixels s_j apart.
struct SweepStep {
  float inverse_depth = 0.0f;  // w_j
  float scale = 1.0f;          // s_j, positive
};

struct PlaneSweepInputs {
  ImageView first, second;             // grey, of the grid's size
  ImageGrid grid;                      // the places of the first picture
  std::array<double, 9> homography{};  // H, row by row
  std::array<double, 3> epipole{};     // e
  std::vector<SweepStep> steps;        // at least one
  // grid.size() x 2, (x, y) in pixels from the place in the first picture to that in the second;
  // NaN: not known.
  ConstMatrixView<float> flow;
  int patch_radius = 3;  // 1 to 3
};

// Columns of the results.
enum SweepColumn {
  kStaticCost,     // the least |P - S_j|^2; NaN if no x_j is in front and S_j in the picture
  kStaticStep,     // its j; NaN likewise
  kFlowCost,       // |P - Q|^2; NaN if the flow is, or if Q leaves the picture
  kEnergy,         // |P|^2
  kGradient,       // trace of (SW4)
  kLeastGradient,  // its smaller eigenvalue
  kSweepColumns
};

}  // namespace egosieve::kernels

#endif  // EGOSIEVE_KERNELS_BASE_PLANE_SWEEP_INPUTS_H_
