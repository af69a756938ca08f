/* The C interface of the segmenter, from C99, on a square that moves over a still background. */
#include "egosieve/segmenter.h"

#include <math.h>
#include <stdlib.h>

#include "tests/tools/embed/c/check.h"

enum { WIDTH = 160, HEIGHT = 120, STRIDE = 5, ROWS = 25, COLUMNS = 33, FRAMES = 4 };

static uint8_t frames[FRAMES][HEIGHT][WIDTH][3];

static uint32_t noise(uint32_t a, uint32_t b) {
  uint32_t h = (a * 73856093u) ^ (b * 19349663u);
  h = (h ^ (h >> 13)) * 0x5bd1e995u;
  return h ^ (h >> 15);
}

static void make_frames(void) {
  for (int t = 0; t < FRAMES; ++t) {
    for (int v = 0; v < HEIGHT; ++v) {
      for (int u = 0; u < WIDTH; ++u) {
        const int left = 30 + 6 * t, inside = u >= left && u < left + 40 && v >= 40 && v < 80;
        const uint32_t cell = inside ? noise((uint32_t)(u - left) / 4 + 900, (uint32_t)v / 4)
                                     : noise((uint32_t)u / 4, (uint32_t)v / 4);
        for (int c = 0; c < 3; ++c) {
          frames[t][v][u][c] = (uint8_t)(inside ? 128 + cell % 128 : cell % 128);
        }
      }
    }
  }
}

static egosieve_image image_of(int t) {
  egosieve_image image = {NULL, WIDTH, HEIGHT, 0, EGOSIEVE_BGR};
  image.data = &frames[t][0][0][0];
  return image;
}

static egosieve_status process(egosieve_segmenter* segmenter, int t, float* probability,
                               egosieve_frame_report* report) {
  const egosieve_image image = image_of(t);
  egosieve_map map;
  egosieve_map_init(&map);
  egosieve_frame_report_init(report);
  map.probability = floats_out(probability, ROWS, COLUMNS);
  return egosieve_segmenter_process(segmenter, &image, 0.1 * t, &map, report);
}

/* A segmenter that was saved and loaded gives the same bytes as one that went on. */
static void test_frames_and_file(const char* folder) {
  egosieve_segmenter_options options;
  egosieve_segmenter *segmenter = NULL, *loaded = NULL;
  egosieve_frame_report report;
  static float probability[ROWS][COLUMNS], again[ROWS][COLUMNS], full[HEIGHT][WIDTH];
  egosieve_map map;
  int64_t rows = 0, columns = 0, count = -1;
  char path[1024];
  snprintf(path, sizeof path, "%s/segmenter.npz", folder);
  egosieve_segmenter_options_init(&options);
  options.stride = STRIDE;
  options.budget = 300;
  CHECK_OK(egosieve_segmenter_create(&options, &segmenter));
  CHECK_OK(egosieve_segmenter_grid_size(segmenter, WIDTH, HEIGHT, &rows, &columns));
  CHECK(rows == ROWS && columns == COLUMNS);
  for (int t = 0; t < FRAMES - 1; ++t) {
    CHECK_OK(process(segmenter, t, &probability[0][0], &report));
    CHECK(report.frame == t);
    CHECK(report.learnt == (t > 0));
    CHECK((report.reason[0] != '\0') == (t == 0));
  }
  CHECK(report.model_size > 50 && report.model_size <= 300);
  CHECK(report.dynamic_labels > 0 && report.static_labels > report.dynamic_labels);
  CHECK_OK(egosieve_segmenter_save(segmenter, path));
  CHECK_OK(egosieve_segmenter_load(path, NULL, &loaded));
  CHECK_OK(egosieve_segmenter_frame_count(loaded, &count));
  CHECK(count == FRAMES - 1);
  CHECK_OK(process(segmenter, FRAMES - 1, &probability[0][0], &report));
  CHECK_OK(process(loaded, FRAMES - 1, &again[0][0], &report));
  CHECK(report.frame == FRAMES - 1 && report.learnt);
  CHECK(memcmp(probability, again, sizeof probability) == 0);
  /* The square's middle moves, the picture's corner does not. */
  CHECK(probability[60 / STRIDE][68 / STRIDE] > 0.5f);
  CHECK(probability[0][COLUMNS - 1] < 0.5f);

  egosieve_map_init(&map);
  map.probability = floats_out(&full[0][0], HEIGHT, WIDTH);
  {
    const egosieve_image image = image_of(FRAMES - 1);
    CHECK_OK(egosieve_segmenter_process(loaded, &image, 1.0, &map, NULL));
    CHECK_OK(egosieve_segmenter_process(segmenter, &image, 1.0, NULL, NULL));
  }
  for (int v = 0; v < HEIGHT; ++v) {
    for (int u = 0; u < WIDTH; ++u) CHECK(full[v][u] >= 0.0f && full[v][u] <= 1.0f);
  }
  CHECK_OK(egosieve_segmenter_free(segmenter));
  CHECK_OK(egosieve_segmenter_free(loaded));
}

/* With a lag the first frame's map comes with the third frame, the last ones' from finish. */
static void test_lag(void) {
  egosieve_segmenter_options options;
  egosieve_segmenter* segmenter = NULL;
  egosieve_frame_report report;
  static float probability[ROWS][COLUMNS], objects[ROWS][COLUMNS];
  int64_t waiting = -1;
  int32_t width = 0, height = 0;
  egosieve_map map;
  egosieve_segmenter_options_init(&options);
  options.budget = 300;
  options.lag = 2;
  options.focal_ratio = 0.8;
  CHECK_OK(egosieve_segmenter_create(&options, &segmenter));
  for (int t = 0; t < FRAMES; ++t) {
    probability[0][0] = -1.0f;
    CHECK_OK(process(segmenter, t, &probability[0][0], &report));
    CHECK(report.frame == (t < 2 ? -1 : t - 2));
    CHECK((probability[0][0] == -1.0f) == (t < 2));
  }
  CHECK_OK(egosieve_segmenter_waiting(segmenter, &waiting, &width, &height));
  CHECK(waiting == 2 && width == WIDTH && height == HEIGHT);
  egosieve_map_init(&map);
  map.probability = floats_out(&probability[0][0], ROWS, COLUMNS);
  map.objects = floats_out(&objects[0][0], ROWS, COLUMNS);
  for (int t = FRAMES - 2; t <= FRAMES; ++t) {
    CHECK_OK(egosieve_segmenter_finish(segmenter, &map, &report));
    CHECK(report.frame == (t < FRAMES ? t : -1));
  }
  CHECK(objects[60 / STRIDE][68 / STRIDE] >= 1.0f);
  CHECK(objects[0][COLUMNS - 1] == 0.0f);
  CHECK_OK(egosieve_segmenter_free(segmenter));
}

/* The order of the channels is told, not guessed. */
static void test_channels(void) {
  egosieve_segmenter_options options;
  egosieve_frame_report report;
  static uint8_t swapped[FRAMES][HEIGHT][WIDTH][3];
  static float expected[ROWS][COLUMNS], actual[ROWS][COLUMNS];
  egosieve_segmenter *bgr = NULL, *rgb = NULL;
  egosieve_map map;
  egosieve_map_init(&map);
  map.probability = floats_out(&actual[0][0], ROWS, COLUMNS);
  egosieve_segmenter_options_init(&options);
  options.budget = 300;
  CHECK_OK(egosieve_segmenter_create(&options, &bgr));
  CHECK_OK(egosieve_segmenter_create(&options, &rgb));
  for (int t = 0; t < 2; ++t) {
    egosieve_image image = image_of(t);
    for (int v = 0; v < HEIGHT; ++v) {
      for (int u = 0; u < WIDTH; ++u) {
        frames[t][v][u][0] /= 2; /* less blue, so that the order matters */
        for (int c = 0; c < 3; ++c) swapped[t][v][u][c] = frames[t][v][u][2 - c];
      }
    }
    CHECK_OK(process(bgr, t, &expected[0][0], &report));
    image.data = &swapped[t][0][0][0];
    image.channels = EGOSIEVE_RGB;
    CHECK_OK(egosieve_segmenter_process(rgb, &image, 0.1 * t, &map, NULL));
    CHECK(memcmp(expected, actual, sizeof expected) == 0);
  }
  CHECK_OK(egosieve_segmenter_free(bgr));
  CHECK_OK(egosieve_segmenter_free(rgb));
}

static void test_bad_input(void) {
  egosieve_segmenter_options options;
  egosieve_segmenter* segmenter = NULL;
  egosieve_image image = image_of(0);
  egosieve_segmenter_options_init(&options);
  options.stride = 0;
  CHECK_CALL(egosieve_segmenter_create(&options, &segmenter), EGOSIEVE_INVALID_ARGUMENT,
             "options.stride");
  options.stride = 5;
  options.profile = 7;
  CHECK_CALL(egosieve_segmenter_create(&options, &segmenter), EGOSIEVE_INVALID_ARGUMENT,
             "options.profile");
  options.profile = EGOSIEVE_PROFILE_DEFAULT;
  options.budget = 3;
  CHECK_CALL(egosieve_segmenter_create(&options, &segmenter), EGOSIEVE_INVALID_ARGUMENT,
             "options.budget");
  CHECK_OK(egosieve_segmenter_create(NULL, &segmenter));
  CHECK_CALL(egosieve_segmenter_process(NULL, &image, 0.0, NULL, NULL), EGOSIEVE_INVALID_HANDLE,
             "segmenter is null");
  CHECK_CALL(egosieve_segmenter_process(segmenter, NULL, 0.0, NULL, NULL),
             EGOSIEVE_INVALID_ARGUMENT, "image is null");
  CHECK_CALL(egosieve_segmenter_process(segmenter, &image, NAN, NULL, NULL),
             EGOSIEVE_INVALID_ARGUMENT, "time_seconds");
  image.width = 0;
  CHECK_CALL(egosieve_segmenter_process(segmenter, &image, 0.0, NULL, NULL),
             EGOSIEVE_INVALID_ARGUMENT, "image: 0 x 120");
  image = image_of(0);
  image.channels = 4;
  CHECK_CALL(egosieve_segmenter_process(segmenter, &image, 0.0, NULL, NULL),
             EGOSIEVE_INVALID_ARGUMENT, "image.channels");
  CHECK_CALL(egosieve_segmenter_load("/nowhere/at/all", NULL, &segmenter), EGOSIEVE_NOT_FOUND,
             "/nowhere/at/all");
  CHECK_OK(egosieve_segmenter_free(segmenter));
  CHECK_CALL(egosieve_segmenter_free(segmenter), EGOSIEVE_INVALID_HANDLE, "segmenter was freed");
}

/* The right results of a call with a wrong one are not written either. */
static void test_untouched_results(void) {
  egosieve_segmenter* segmenter = NULL;
  const egosieve_image image = image_of(0);
  egosieve_map map;
  float small[4];
  static float right[ROWS][COLUMNS];
  egosieve_frame_report report, report_before;
  int64_t rows = -7, frames_waiting = -7, frames_counted = -7;
  int32_t width = -7;
  CHECK_OK(egosieve_segmenter_create(NULL, &segmenter));
  egosieve_map_init(&map);
  map.mean = floats_out(small, 2, 2);
  memset(&report, 0x5a, sizeof report);
  report.struct_size = sizeof report;
  report_before = report;
  right[0][0] = right[ROWS - 1][COLUMNS - 1] = -7.0f;
  map.probability = floats_out(&right[0][0], ROWS, COLUMNS);
  CHECK_CALL(egosieve_segmenter_process(segmenter, &image, 0.0, &map, &report),
             EGOSIEVE_INVALID_ARGUMENT, "map.mean: 2 x 2");
  CHECK(right[0][0] == -7.0f && right[ROWS - 1][COLUMNS - 1] == -7.0f);
  CHECK(memcmp(&report, &report_before, sizeof report) == 0);
  CHECK_CALL(egosieve_segmenter_grid_size(segmenter, WIDTH, HEIGHT, &rows, NULL),
             EGOSIEVE_INVALID_ARGUMENT, "columns is null");
  CHECK_CALL(egosieve_segmenter_waiting(segmenter, &frames_waiting, &width, NULL),
             EGOSIEVE_INVALID_ARGUMENT, "height is null");
  CHECK_CALL(egosieve_segmenter_frame_count(segmenter, NULL), EGOSIEVE_INVALID_ARGUMENT,
             "frames is null");
  CHECK_OK(egosieve_segmenter_frame_count(segmenter, &frames_counted));
  CHECK(rows == -7 && frames_waiting == -7 && width == -7 && frames_counted == 0);
  CHECK_OK(egosieve_segmenter_free(segmenter));
}

int main(void) {
  const char* folder = getenv("TEST_TMPDIR");
  make_frames();
  test_frames_and_file(folder != NULL ? folder : "/tmp");
  test_lag();
  test_channels();
  test_bad_input();
  test_untouched_results();
  printf("%d checks failed\n", failures);
  return failures == 0 ? 0 : 1;
}
