/* Kriging in C99: as cpp/kriging.cc, to the last bit. What it does stands there.
 *
 *   cc -std=c99 kriging.c $(pkg-config --cflags --libs egosieve) -lm -o kriging
 *   ./kriging [--wells=N] [--side=PIXELS] [--device=NAME] [--out=FILE]
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "egosieve/gaussian_process.h"

static uint64_t state = 1;

static double uniform(void) {
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (double)(state >> 11) / 9007199254740992.0;
}

static double field(double x, double y) {
  return sin(3.0 * x) * cos(2.0 * y) + 0.4 * sin(7.0 * x + 4.0 * y);
}

/* Ends the program with the library's own words. */
static void must(egosieve_status status) {
  if (status == EGOSIEVE_OK) return;
  fprintf(stderr, "%s\n", egosieve_last_error());
  exit(1);
}

static egosieve_const_array packed(const double* data, int64_t rows, int64_t columns) {
  egosieve_const_array array = {NULL, 0, 0, 0, 0, EGOSIEVE_FLOAT64};
  array.data = data;
  array.rows = rows;
  array.columns = columns;
  return array;
}

static egosieve_array map_of(float* data, int64_t side) {
  egosieve_array array = {NULL, 0, 0, 0, 0, EGOSIEVE_FLOAT32};
  array.data = data;
  array.rows = array.columns = side;
  return array;
}

static egosieve_gp* learn_wells(int64_t wells, const char* device) {
  double* places = malloc((size_t)(2 * wells) * sizeof *places);
  double* values = malloc((size_t)wells * sizeof *values);
  egosieve_gp_options options;
  egosieve_gp* gp = NULL;
  if (places == NULL || values == NULL) exit(1);
  for (int64_t i = 0; i < wells; ++i) {
    const double x = 2.0 * uniform() - 1.0, y = 2.0 * uniform() - 1.0;
    double noise = uniform();
    noise = 0.1 * (noise + uniform() - 1.0);
    places[2 * i] = x;
    places[2 * i + 1] = y;
    values[i] = field(x, y) + noise;
  }
  egosieve_gp_options_init(&options);
  options.covariance = EGOSIEVE_SQUARED_EXPONENTIAL;
  options.dimension = 2;
  options.device = device;
  must(egosieve_gp_create(&options, &gp));
  {
    const egosieve_const_array x = packed(places, wells, 2), y = packed(values, wells, 1);
    must(egosieve_gp_condition(gp, &x, &y));
  }
  must(egosieve_gp_optimize(gp, NULL, NULL));
  free(places);
  free(values);
  return gp;
}

struct flags {
  int64_t wells, side;
  const char *device, *out;
};

/* Not 0 where a flag is not known or a number too small. */
static int read_flags(int argc, char** argv, struct flags* flags) {
  for (int i = 1; i < argc; ++i) {
    if (strncmp(argv[i], "--wells=", 8) == 0) {
      flags->wells = atoll(argv[i] + 8);
    } else if (strncmp(argv[i], "--side=", 7) == 0) {
      flags->side = atoll(argv[i] + 7);
    } else if (strncmp(argv[i], "--device=", 9) == 0) {
      flags->device = argv[i] + 9;
    } else if (strncmp(argv[i], "--out=", 6) == 0) {
      flags->out = argv[i] + 6;
    } else {
      return 1;
    }
  }
  return flags->wells < 2 || flags->side < 2;
}

/* Not 0 where the file cannot be written. */
static int write_maps(const char* path, const float* mean, const float* deviation, size_t count) {
  FILE* file = fopen(path, "wb");
  if (file == NULL) return 1;
  const int complete = fwrite(mean, sizeof *mean, count, file) == count &&
                       fwrite(deviation, sizeof *deviation, count, file) == count;
  return fclose(file) != 0 || !complete;
}

int main(int argc, char** argv) {
  struct flags flags = {400, 200, NULL, NULL};
  int64_t side, count;
  egosieve_gp* gp;
  egosieve_gp_info info;
  egosieve_prediction prediction;
  egosieve_grid grid;
  float *mean, *deviation;
  double squares = 0.0;
  if (read_flags(argc, argv, &flags)) {
    fprintf(stderr, "usage: kriging [--wells=N] [--side=PIXELS] [--device=NAME] [--out=FILE]\n");
    return 2;
  }
  side = flags.side;
  count = side * side;
  gp = learn_wells(flags.wells, flags.device);
  egosieve_gp_info_init(&info);
  must(egosieve_gp_describe(gp, &info));
  printf("%lld wells: length-scales %.3f and %.3f, noise %.3f\n", (long long)info.size,
         info.scales[0], info.scales[1], info.noise_stddev);

  mean = malloc((size_t)count * sizeof *mean);
  deviation = malloc((size_t)count * sizeof *deviation);
  if (mean == NULL || deviation == NULL) return 1;
  grid.x0 = grid.y0 = -1.0;
  grid.dx = grid.dy = 2.0 / (double)(side - 1);
  grid.rows = grid.columns = side;
  egosieve_prediction_init(&prediction);
  prediction.mean = map_of(mean, side);
  prediction.variance = map_of(deviation, side);
  must(egosieve_gp_predict_grid(gp, &grid, &prediction));
  must(egosieve_gp_free(gp));

  for (int64_t k = 0; k < count; ++k) {
    const double x = grid.x0 + (double)(k % side) * grid.dx;
    const double y = grid.y0 + (double)(k / side) * grid.dy;
    const double error = mean[k] - field(x, y);
    squares += error * error;
    deviation[k] = sqrtf(deviation[k]);
  }
  printf("%lld points, error %.4f (root mean square)\n", (long long)count,
         sqrt(squares / (double)count));
  if (flags.out != NULL && write_maps(flags.out, mean, deviation, (size_t)count)) {
    fprintf(stderr, "%s cannot be written\n", flags.out);
    return 1;
  }
  free(mean);
  free(deviation);
  return 0;
}
