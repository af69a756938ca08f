// Blocked linear algebra of row-major matrices, used by kernels/ops/device_linear_algebra.h. Macros
// in addition to common.cl's, whose VEC is 1:
//   TILE   rows and columns of a tile, and of a diagonal block
//   ITEM   a work-item holds ITEM x ITEM values of a tile: GROUP = TILE / ITEM work-items side by
//          side in each direction
//   DEPTH  columns of a product staged in local memory at once
//
// Element (i, j) of a matrix is at first + i row_step + j column_step, so that a transpose only
// exchanges the steps. Traffic per multiply-add of multiply_tiles: 2 / TILE values of global
// memory, 2 / ITEM of local memory.
#define GROUP (TILE / ITEM)
// Distance between staged columns: no two elements of a fetch are in one bank.
#define STAGED (TILE + 1)
#define LOWER_TILES 1
#define FROM_THE_ROW 2
#define TO_THE_ROW 4

// C := sign A B, or C += sign A B with `add`; A: rows x depth, B: depth x columns. With LOWER_TILES
// the tiles above the diagonal stay unchanged; with FROM_THE_ROW the sum begins at the tile's first
// row, with TO_THE_ROW it ends at its last. C may be A if it is one tile wide, and B if it is one tile high: a work-group finishes its
// reads before it writes.
__kernel __attribute__((reqd_work_group_size(GROUP, GROUP, 1))) void multiply_tiles(
    const long rows, const long columns, const long depth, const REAL sign, const int add, const int parts,
    __global const REAL* a, const long a_first, const long a_row_step, const long a_column_step, __global const REAL* b,
    const long b_first, const long b_row_step, const long b_column_step, __global REAL* c, const long c_first,
    const long c_row_step) {
  __local REAL a_stage[DEPTH * STAGED], b_stage[DEPTH * STAGED];
  const int x = get_local_id(0), y = get_local_id(1);
  const long row = (long)get_group_id(1) * TILE, column = (long)get_group_id(0) * TILE;
  const bool left_out = (parts & LOWER_TILES) && column > row;
  const long end = left_out ? 0 : parts & TO_THE_ROW ? min(depth, row + TILE) : depth;
  REAL sums[ITEM][ITEM];
  for (int i = 0; i < ITEM; ++i) {
    for (int j = 0; j < ITEM; ++j) sums[i][j] = (REAL)0;
  }
  for (long k0 = parts & FROM_THE_ROW ? row : 0; k0 < end; k0 += DEPTH) {
    barrier(CLK_LOCAL_MEM_FENCE);
    for (int s = y * GROUP + x; s < DEPTH * TILE; s += GROUP * GROUP) {
      // Neighbouring work-items fetch neighbouring elements.
      const int a_k = a_column_step == 1 ? s % DEPTH : s / TILE, a_i = a_column_step == 1 ? s / DEPTH : s % TILE;
      const bool a_inside = row + a_i < rows && k0 + a_k < end;
      a_stage[a_k * STAGED + a_i] =
          a_inside ? a[a_first + (row + a_i) * a_row_step + (k0 + a_k) * a_column_step] : (REAL)0;
      const int b_k = b_row_step == 1 ? s % DEPTH : s / TILE, b_j = b_row_step == 1 ? s / DEPTH : s % TILE;
      const bool b_inside = column + b_j < columns && k0 + b_k < end;
      b_stage[b_k * STAGED + b_j] =
          b_inside ? b[b_first + (k0 + b_k) * b_row_step + (column + b_j) * b_column_step] : (REAL)0;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (int k = 0; k < DEPTH; ++k) {
      REAL right[ITEM];
      for (int j = 0; j < ITEM; ++j) right[j] = b_stage[k * STAGED + x + j * GROUP];
      for (int i = 0; i < ITEM; ++i) {
        const REAL left = a_stage[k * STAGED + y + i * GROUP];
        for (int j = 0; j < ITEM; ++j) sums[i][j] = fma(left, right[j], sums[i][j]);
      }
    }
  }
  barrier(CLK_GLOBAL_MEM_FENCE);  // if C is A or B, all reads are done here
  for (int i = 0; i < ITEM; ++i) {
    const long r = row + y + i * GROUP;
    for (int j = 0; j < ITEM; ++j) {
      const long k = column + x + j * GROUP;
      if (left_out || r >= rows || k >= columns) continue;
      __global REAL* target = c + c_first + r * c_row_step + k;
      *target = add ? fma(sign, sums[i][j], *target) : sign * sums[i][j];
    }
  }
}

// In the `size` x `size` block of A at `first`, the lower triangle becomes its Cholesky factor L.
// `inverse`, TILE x TILE, becomes L^-1, with ones on the diagonal from `size` on. If `bad` was
// negative, it becomes the first row, counted from `row`, whose pivot is not above its floor or not
// finite. One work-group; its lower triangle is stored row by row in local memory, half of the 32
// KiB that every device has.
#define AT(i, j) ((i) * ((i) + 1) / 2 + (j))
__kernel __attribute__((reqd_work_group_size(TILE, 1, 1))) void factor_diagonal(
    __global REAL* a, const long first, const long row_step, const int size, __global const REAL* floors, const int row,
    __global REAL* inverse, const long inverse_first, __global int* bad) {
  __local REAL l[TILE * (TILE + 1) / 2];
  const int i = get_local_id(0);
  for (int j = 0; j <= i; ++j) l[AT(i, j)] = i < size ? a[first + i * row_step + j] : (REAL)(i == j);
  barrier(CLK_LOCAL_MEM_FENCE);
  for (int c = 0; c < size; ++c) {
    if (i == c) {
      const REAL pivot = l[AT(c, c)];
      if (!(pivot > floors[row + c] && pivot < (REAL)INFINITY) && *bad < 0) *bad = row + c;
      l[AT(c, c)] = sqrt(pivot);
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    if (i > c) l[AT(i, c)] /= l[AT(c, c)];
    barrier(CLK_LOCAL_MEM_FENCE);
    for (int j = c + 1; j <= i; ++j) l[AT(i, j)] = fma(-l[AT(i, c)], l[AT(j, c)], l[AT(i, j)]);
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  for (int j = 0; j <= i && i < size; ++j) a[first + i * row_step + j] = l[AT(i, j)];
  // Column i of the inverse, by forward substitution.
  REAL x[TILE];
  for (int r = 0; r < TILE; ++r) {
    REAL sum = (REAL)(r == i);
    for (int k = i; k < r; ++k) sum = fma(-l[AT(r, k)], x[k], sum);
    x[r] = r < i ? (REAL)0 : sum / l[AT(r, r)];
    inverse[inverse_first + r * TILE + i] = x[r];
  }
}

// A(i, i) += noise + variances[i]; floors[i] = relative A(i, i).
__kernel void add_noise(__global REAL* a, const long row_step, const long count, const REAL noise,
                        __global const REAL* variances, const REAL relative, __global REAL* floors) {
  const long i = get_global_id(0);
  if (i >= count) return;
  const REAL value = a[i * row_step + i] + noise + variances[i];
  a[i * row_step + i] = value;
  floors[i] = relative * value;
}

// The identity.
__kernel void set_identity(__global REAL* a, const long row_step, const long count) {
  const long j = get_global_id(0), i = get_global_id(1);
  if (j < count) a[i * row_step + j] = (REAL)(i == j);
}

// diagonal[i] = A(i, i).
__kernel void get_diagonal(__global const REAL* a, const long row_step, const long count, __global REAL* diagonal) {
  const long i = get_global_id(0);
  if (i < count) diagonal[i] = a[i * row_step + i];
}

// In the lower triangle, W := sum_c u_ic u_jc - outputs W; u: count x outputs.
__kernel void likelihood_weights(__global REAL* w, const long row_step, const long count, __global const REAL* u,
                                 const int outputs) {
  const long j = get_global_id(0), i = get_global_id(1);
  if (j > i) return;
  REAL sum = (REAL)0;
  for (int c = 0; c < outputs; ++c) sum = fma(u[i * outputs + c], u[j * outputs + c], sum);
  w[i * row_step + j] = fma((REAL)-outputs, w[i * row_step + j], sum);
}

// norms[j] = sum_i A(i, j)^2.
__kernel void column_norms(__global const REAL* a, const long rows, const long columns, __global REAL* norms) {
  const long j = get_global_id(0);
  if (j >= columns) return;
  REAL sum = (REAL)0;
  for (long i = 0; i < rows; ++i) sum = fma(a[i * columns + j], a[i * columns + j], sum);
  norms[j] = sum;
}
