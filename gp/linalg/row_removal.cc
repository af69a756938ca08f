#include "gp/linalg/row_removal.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>
#include <vector>

#include "gp/linalg/aligned_matrix.h"
#include "gp/linalg/cholesky.h"
#include "gp/linalg/tile_operations.h"
#include "kernels/base/parallel_for.h"

namespace egosieve::gp {
namespace {

using tile::Block;
using tile::ConstView;
using tile::View;

constexpr int64_t kBlockRows = 64;
// Columns whose reflectors act together, which is the size of T: wide panels suit wide removals.
constexpr int64_t kWidePanel = 32;
constexpr int64_t kNarrowPanel = 16;
constexpr int64_t kNarrowRemoval = 16;  // rows
// If |c2|^2 / c1^2 is below this, the row needs no reflector. It is far below rounding, and far
// above the values for which v0^2, of the order of its square, underflows and gives 0 / 0.
constexpr double kNegligibleSquare = 1e-100;

class Removal {
 public:
  Removal(View l, absl::Span<const int64_t> rows)
      : l_(l),
        removed_(rows),
        first_(rows.front()),
        size_(l.rows - static_cast<int64_t>(rows.size())),
        blocks_((size_ - first_ + kBlockRows - 1) / kBlockRows),
        reflectors_(size_ - first_, static_cast<int64_t>(rows.size())),
        panel_(static_cast<int64_t>(rows.size()) <= kNarrowRemoval ? kNarrowPanel : kWidePanel),
        triangles_(size_ - first_, panel_),
        aside_(size_ - first_, static_cast<int64_t>(rows.size())),
        work_(size_ - first_, 2 * panel_),
        finished_(blocks_) {
    kept_.reserve(size_ - first_);
    size_t next = 0;
    for (int64_t row = first_; row < l.rows; ++row) {
      if (next < rows.size() && rows[next] == row) {
        ++next;
      } else {
        kept_.push_back(row);
        active_.push_back(static_cast<int64_t>(next));
      }
    }
    for (std::atomic<bool>& flag : finished_) flag = false;
  }

  void Run() {
    const double rows = static_cast<double>(size_ - first_);
    const double flops = rows * rows * static_cast<double>(2 * reflectors_.cols() + panel_);
    kernels::ParallelFor(blocks_, flops, [this](int64_t block) { ProcessBlock(block); });
  }

 private:
  // Number of removed rows above row `index` (counted from first_), and therefore of leading
  // non-zero columns of C2.
  int64_t Active(int64_t index) const { return active_[index]; }

  template <typename Condition>
  static void WaitUntil(const Condition& condition) {
    while (!condition()) std::this_thread::yield();
  }

  // Moves the block's rows to their new places and their removed columns to c2. In place: rows move
  // towards the front, and earlier blocks have already been moved.
  void MoveRows(int64_t begin, int64_t end, View c2) {
    for (int64_t index = begin; index < end; ++index) {
      const double* source = l_.row(kept_[index]);
      double* target = l_.row(first_ + index);
      double* aside = c2.row(index - begin);
      const int64_t active = Active(index);
      std::copy(source, source + first_, target);
      int64_t place = first_;
      for (int64_t s = 0; s < active; ++s) {
        aside[s] = source[removed_[s]];
        const int64_t segment = removed_[s] + 1;
        const int64_t segment_end = s + 1 < active ? removed_[s + 1] : kept_[index] + 1;
        std::copy(source + segment, source + segment_end, target + place);
        place += segment_end - segment;
      }
      std::fill(aside + active, aside + c2.cols, 0.0);
    }
  }

  // Throws nothing: another block may wait for this one, and L is partly moved.
  void ProcessBlock(int64_t block) {
    const int64_t begin = block * kBlockRows;
    const int64_t end = std::min(begin + kBlockRows, size_ - first_);
    const View aside = Block(aside_.view(), begin, 0, end - begin, aside_.cols());
    const View work = Block(work_.view(), begin, 0, end - begin, work_.cols());
    WaitUntil([&] { return moved_.load(std::memory_order_acquire) == block; });
    MoveRows(begin, end, aside);
    moved_.store(block + 1, std::memory_order_release);

    for (int64_t left = 0; left < block; ++left) {
      WaitUntil([&] { return finished_[left].load(std::memory_order_acquire); });
      for (int64_t panel = left * kBlockRows; panel < (left + 1) * kBlockRows; panel += panel_) {
        ApplyPanel(panel, begin, end, begin, aside, work);
      }
    }
    for (int64_t panel = begin; panel < end; panel += panel_) {
      FactorPanel(panel, begin, aside);
      ApplyPanel(panel, std::min(panel + panel_, end), end, begin, aside, work);
    }
    finished_[block].store(true, std::memory_order_release);
  }

  int64_t PanelEnd(int64_t panel) const { return std::min(panel + panel_, size_ - first_); }

  // (2) for rows [begin, end), whose C2 starts at row begin - block_begin of `aside`.
  void ApplyPanel(int64_t panel, int64_t begin, int64_t end, int64_t block_begin, View aside,
                  View work) {
    if (begin >= end) return;
    const int64_t rows = end - begin;
    const int64_t width = PanelEnd(panel) - panel;
    const int64_t active = Active(panel + width - 1);
    const View c1 = Block(l_, first_ + begin, first_ + panel, rows, width);
    const View c2 = Block(aside, begin - block_begin, 0, rows, active);
    const ConstView v = Block(reflectors_.view(), panel, 0, width, active);
    const ConstView t = Block(triangles_.view(), panel, 0, width, width);
    const View w = Block(work, 0, 0, rows, width);
    const View wt = Block(work, 0, panel_, rows, width);
    for (int64_t i = 0; i < rows; ++i) {
      std::copy(c1.row(i), c1.row(i) + width, w.row(i));
      std::fill(wt.row(i), wt.row(i) + width, 0.0);
    }
    tile::AddProductTransposed(c2, v, w);
    tile::AddProduct(w, t, wt);
    for (int64_t i = 0; i < rows; ++i) {
      for (int64_t j = 0; j < width; ++j) c1(i, j) -= wt(i, j);
    }
    tile::SubtractProduct(wt, v, c2);
  }

  // (1) for the rows of a panel, one after another, and the triangle T of their product.
  void FactorPanel(int64_t panel, int64_t block_begin, View aside) {
    const int64_t width = PanelEnd(panel) - panel;
    const int64_t active = Active(panel + width - 1);
    const View c1 = Block(l_, first_ + panel, first_ + panel, width, width);
    const View c2 = Block(aside, panel - block_begin, 0, width, active);
    const View v = Block(reflectors_.view(), panel, 0, width, active);
    const View t = Block(triangles_.view(), panel, 0, width, width);
    for (int64_t j = 0; j < width; ++j) {
      const double diagonal = c1(j, j);
      const double square = LaneDot(c2.row(j), c2.row(j), active);
      double tau = 0.0;
      std::fill(v.row(j), v.row(j) + active, 0.0);
      if (square > kNegligibleSquare * diagonal * diagonal) {
        const double norm = std::sqrt(diagonal * diagonal + square);
        const double v0 = -square / (diagonal + norm);
        tau = 2.0 * v0 * v0 / (square + v0 * v0);
        for (int64_t s = 0; s < active; ++s) v(j, s) = c2(j, s) / v0;
        c1(j, j) = norm;
        for (int64_t i = j + 1; i < width; ++i) {
          const double w = tau * (c1(i, j) + LaneDot(c2.row(i), v.row(j), active));
          c1(i, j) -= w;
          for (int64_t s = 0; s < active; ++s) c2(i, s) -= w * v(j, s);
        }
      }
      FillTriangleColumn(v, t, j, tau);
    }
  }

  // Column j of T: T_jj = tau_j, T_<j,j = -tau_j T_<j,<j V_<j v_j; zero below the diagonal.
  static void FillTriangleColumn(ConstView v, View t, int64_t j, double tau) {
    double products[kWidePanel];
    for (int64_t i = 0; i < j; ++i) products[i] = LaneDot(v.row(i), v.row(j), v.cols);
    for (int64_t i = 0; i < j; ++i) {
      double sum = 0.0;
      for (int64_t p = i; p < j; ++p) sum += t(i, p) * products[p];
      t(i, j) = -tau * sum;
    }
    t(j, j) = tau;
    for (int64_t i = j + 1; i < t.rows; ++i) t(i, j) = 0.0;
  }

  View l_;
  absl::Span<const int64_t> removed_;
  int64_t first_;  // the first removed row: rows before it do not change
  int64_t size_;   // remaining rows
  int64_t blocks_;
  std::vector<int64_t> kept_;    // old index of each row from first_ on
  std::vector<int64_t> active_;  // returned by Active
  AlignedMatrix reflectors_;     // V, one row per row from first_ on
  int64_t panel_;                // columns of a panel; divides kBlockRows
  AlignedMatrix triangles_;      // T, one panel_ x panel_ block per panel
  AlignedMatrix aside_;          // C2, one row per row from first_ on
  AlignedMatrix work_;           // W and W T of a block, in its rows
  std::atomic<int64_t> moved_{0};
  std::vector<std::atomic<bool>> finished_;
};

}  // namespace

void RemoveRows(View l, absl::Span<const int64_t> rows) {
  if (rows.empty()) return;
  Removal(l, rows).Run();
}

}  // namespace egosieve::gp
