// Throws damaged model files and senseless arguments at the C interface:
//
//   bazel run --config=asan //tests/tools/embed/fuzz:c_interface_fuzz -- --seconds=60 [--seed=N]
//
// Every call must return: a crash, a leak (at the end, under the address sanitizer) or a call that
// takes more than 20 s is a failure. Inputs are drawn from the seed, so that what fails can be
// repeated.
//
//   files       bytes of a valid file flipped, cut, spliced; and its arrays changed and packed
//   again, so
//               that they pass the checksums
//   arguments   arrays of random shape, stride and type; those that are in order lie in memory that
//   is
//               there, the others must be refused
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "egosieve/device_call.h"
#include "egosieve/gaussian_process.h"
#include "egosieve/joint_posterior.h"
#include "gp/io/array_file.h"

namespace egosieve::embed {
namespace {

constexpr char kDevice[] = "reference";
constexpr int kLimitSeconds = 20;

// Small integers, edges of ranges, and anything.
class Draw {
 public:
  explicit Draw(uint64_t seed) : random_(seed) {}

  uint64_t Below(uint64_t end) { return random_() % end; }
  bool OneIn(uint64_t n) { return Below(n) == 0; }
  int64_t Integer() {
    static constexpr int64_t kEdges[] = {
        0,  1,   -1,        2,         3,  4,   8,         12,        24,        -8,
        64, 255, INT32_MAX, INT32_MIN, 20, 160, INT64_MAX, INT64_MIN, 1LL << 40, 1LL << 48};
    switch (Below(4)) {
      case 0:
        return static_cast<int64_t>(random_());
      case 1:
        return static_cast<int64_t>(Below(12)) - 2;
      default:
        return kEdges[Below(std::size(kEdges))];
    }
  }
  double Real() {
    static const double kEdges[] = {
        0.0,    -0.0,   1.0,  -1.0, 0.5,
        1e-300, 1e300,  1e39, 1e-8, std::numeric_limits<double>::infinity(),
        NAN,    -1e308, 3.0};
    return OneIn(2) ? kEdges[Below(std::size(kEdges))]
                    : static_cast<double>(static_cast<int64_t>(random_())) / 9.3e18;
  }

 private:
  std::mt19937_64 random_;
};

[[noreturn]] void Fail(const char* what) {
  std::fprintf(stderr, "c_interface_fuzz: %s; last error: %s\n", what, egosieve_last_error());
  std::abort();
}

constexpr egosieve_approximation kApproximations[] = {EGOSIEVE_EXACT, EGOSIEVE_DTC, EGOSIEVE_FITC};

egosieve_gp* NewModel(int points, egosieve_approximation approximation) {
  egosieve_gp_options options;
  egosieve_gp_options_init(&options);
  options.dimension = 2;
  options.approximation = approximation;
  options.inducing_points = 5;
  options.device = kDevice;
  egosieve_gp* gp = nullptr;
  if (egosieve_gp_create(&options, &gp) != EGOSIEVE_OK) Fail("no model to start from");
  std::vector<double> x, y;
  for (int i = 0; i < points; ++i) {
    x.insert(x.end(), {std::cos(1.1 * i), std::sin(0.7 * i)});
    y.push_back(i % 2 ? 1.0 : -1.0);
  }
  const egosieve_const_array inputs = {x.data(), points, 2, 0, 0, EGOSIEVE_FLOAT64};
  const egosieve_const_array targets = {y.data(), points, 1, 0, 0, EGOSIEVE_FLOAT64};
  if (egosieve_gp_condition(gp, &inputs, &targets) != EGOSIEVE_OK) Fail("no points to start from");
  return gp;
}

std::string FileOf(egosieve_gp* gp) {
  int64_t size = 0;
  egosieve_gp_serialize(gp, nullptr, 0, &size);
  std::string bytes(size, '\0');
  if (egosieve_gp_serialize(gp, bytes.data(), size, &size) != EGOSIEVE_OK) Fail("no file");
  return bytes;
}

// A model that loads must also work.
void Load(const std::string& bytes) {
  egosieve_gp* gp = nullptr;
  if (egosieve_gp_deserialize(bytes.data(), static_cast<int64_t>(bytes.size()), kDevice, &gp) !=
      EGOSIEVE_OK) {
    if (gp != nullptr) Fail("a handle in spite of an error");
    if (*egosieve_last_error() == '\0') Fail("an error without a text");
    return;
  }
  egosieve_gp_info info;
  egosieve_gp_info_init(&info);
  if (egosieve_gp_describe(gp, &info) != EGOSIEVE_OK) Fail("a loaded model that does not tell");
  const std::vector<double> x(info.dimension, 0.25);
  double value = 0.0;
  const egosieve_const_array point = {x.data(), 1, info.dimension, 0, 0, EGOSIEVE_FLOAT64};
  egosieve_prediction prediction;
  egosieve_prediction_init(&prediction);
  prediction.variance = {&value, 1, 1, 0, 0, EGOSIEVE_FLOAT64};
  egosieve_gp_predict(gp, &point, &prediction);
  egosieve_gp_calibrate(gp);
  if (egosieve_gp_free(gp) != EGOSIEVE_OK) Fail("a model that cannot be freed");
}

std::string DamagedBytes(std::string bytes, Draw& draw) {
  for (uint64_t times = 1 + draw.Below(6); times > 0 && !bytes.empty(); --times) {
    const size_t at = draw.Below(bytes.size());
    switch (draw.Below(4)) {
      case 0:
        bytes[at] = static_cast<char>(draw.Below(256));
        break;
      case 1:
        bytes.resize(at);
        break;
      case 2:
        bytes.insert(at, bytes.substr(draw.Below(bytes.size()), draw.Below(64)));
        break;
      default: {
        const int64_t number = draw.Integer();
        const size_t width = size_t{1} << draw.Below(4);
        if (at + width <= bytes.size()) std::memcpy(&bytes[at], &number, width);
      }
    }
  }
  return bytes;
}

// The valid file's arrays with other elements, sizes, shapes and names.
std::string DamagedArrays(const std::string& valid, Draw& draw) {
  absl::StatusOr<gp::ArrayMap> arrays = gp::ParseArrays(valid);
  if (!arrays.ok()) Fail("the valid file does not parse");
  for (uint64_t times = 1 + draw.Below(3); times > 0; --times) {
    auto chosen = arrays->begin();
    std::advance(chosen, draw.Below(arrays->size()));
    gp::NamedArray& array = chosen->second;
    std::visit(
        [&](auto& elements) {
          using Element = typename std::decay_t<decltype(elements)>::value_type;
          if (draw.OneIn(3)) elements.resize(draw.Below(2 * elements.size() + 3));
          if (!elements.empty()) {
            Element& element = elements[draw.Below(elements.size())];
            if constexpr (std::is_same_v<Element, double>) {
              element = draw.Real();
            } else {
              element = static_cast<Element>(draw.Integer());
            }
          }
          const int64_t count = static_cast<int64_t>(elements.size());
          const int64_t columns = draw.OneIn(2) ? 1 + static_cast<int64_t>(draw.Below(4)) : 1;
          if (draw.OneIn(2) || array.shape.empty()) {
            array.shape = {count};
          } else {
            elements.resize(count / columns * columns);
            array.shape = {count / columns, columns};
          }
        },
        array.elements);
    if (draw.OneIn(12)) arrays->erase(chosen);
    if (arrays->empty()) break;
  }
  const absl::StatusOr<std::string> bytes = gp::SerializeArrays(*arrays);
  return bytes.ok() ? *bytes : valid;
}

// Memory for arrays: what is in order must fit around its middle.
alignas(64) char memory[1 << 16];

// Whether the array's elements all lie in `memory`. Otherwise only a refusal is right.
template <typename Array>
bool LiesInMemory(const Array& array) {
  if (array.type != EGOSIEVE_FLOAT32 && array.type != EGOSIEVE_FLOAT64) return false;
  if (array.rows <= 0 || array.columns <= 0 || array.rows > 4096 || array.columns > 4096)
    return false;
  __int128 row = array.row_stride, column = array.column_stride;
  const int size = array.type == EGOSIEVE_FLOAT32 ? 4 : 8;
  if (row == 0 && column == 0) {
    row = array.columns * size;
    column = size;
  }
  const __int128 down = row * (array.rows - 1), along = column * (array.columns - 1);
  const __int128 low = (down < 0 ? down : 0) + (along < 0 ? along : 0);
  const __int128 high = (down > 0 ? down : 0) + (along > 0 ? along : 0) + size;
  return low >= -(1 << 15) && high <= (1 << 15);
}

// Whether the rules of types.h, stated once more, forbid the array whatever is behind it.
template <typename Array>
bool MustBeRefused(const Array& array) {
  if (array.type != EGOSIEVE_FLOAT32 && array.type != EGOSIEVE_FLOAT64) return true;
  return array.rows < 0 || array.columns < 0;
}

template <typename Array>
Array RandomArray(Draw& draw) {
  Array array{};
  array.data = draw.OneIn(12) ? nullptr : memory + (1 << 15) + draw.Below(9);
  array.rows = draw.Integer();
  array.columns = draw.OneIn(2) ? 2 : draw.Integer();
  array.row_stride = draw.OneIn(2) ? 0 : draw.Integer();
  array.column_stride = draw.OneIn(2) ? 0 : draw.Integer();
  array.type = draw.OneIn(8) ? static_cast<int32_t>(draw.Integer())
                             : static_cast<int32_t>(1 + draw.Below(2));
  return array;
}

// Arrays that are not in memory and not certainly refused would be the caller's own fault.
template <typename Array>
bool IsFair(const Array& array) {
  return array.data == nullptr || LiesInMemory(array) || MustBeRefused(array) || array.rows == 0 ||
         array.columns == 0;
}

// A prediction on up to two devices, or a list of them that must be refused.
egosieve_status PredictOnDevices(egosieve_gp* gp, const egosieve_const_array* x,
                                 egosieve_prediction* prediction, Draw& draw) {
  const char* const names[] = {kDevice, kDevice, "none"};
  egosieve_posterior* posterior = nullptr;
  const int64_t count = static_cast<int64_t>(draw.Below(5)) - 1;
  egosieve_status status = egosieve_gp_posterior_on_devices(gp, names, count, &posterior);
  if ((status == EGOSIEVE_OK) != (posterior != nullptr)) Fail("a handle in spite of an error");
  if (status != EGOSIEVE_OK) return status;
  if (count < 1 || count > 2) Fail("devices that nobody has were taken");
  status = egosieve_posterior_predict(posterior, x, prediction);
  egosieve_posterior_free(posterior);
  return status;
}

// One of the calls; what is not fair is left out and counts as taken.
egosieve_status Call(egosieve_gp* gp, const egosieve_const_array& x, const egosieve_const_array& y,
                     egosieve_array out, Draw& draw) {
  const auto* x_pointer = draw.OneIn(20) ? nullptr : &x;
  egosieve_prediction prediction;
  egosieve_prediction_init(&prediction);
  (draw.OneIn(2) ? prediction.mean : prediction.probability) = out;
  if (draw.OneIn(20)) prediction.struct_size = draw.Below(300);
  egosieve_array none{};
  switch (draw.Below(14)) {
    case 0:
      return egosieve_gp_condition(gp, x_pointer, &y);
    case 5:
      return egosieve_gp_condition_noisy(gp, x_pointer, &y, draw.OneIn(8) ? nullptr : &y);
    case 6:
      if (draw.OneIn(2)) std::swap(out.rows, out.columns);
      return egosieve_gp_predict_joint(gp, x_pointer, 0, &none, draw.OneIn(9) ? nullptr : &out);
    case 7:
      if (draw.OneIn(2)) return egosieve_gp_sample_paths(gp, x_pointer, 1, draw.Below(9), 1, &out);
      return egosieve_gp_sample(gp, x_pointer, draw.Below(9), 1, &out, nullptr);
    case 8:
      return egosieve_gp_gradients(gp, x_pointer, &none, &out);
    case 9:
      return egosieve_gp_leave_one_out(gp, &out, &none, &none);
    case 10:
      return PredictOnDevices(gp, x_pointer, &prediction, draw);
    case 11:
      return egosieve_gp_covariances(gp, x_pointer, draw.OneIn(2) ? nullptr : &x, &out, &none,
                                     draw.OneIn(9) ? nullptr : &none);
    case 12:
      return egosieve_gp_classify(gp, x_pointer, &y, draw.OneIn(2) ? nullptr : &y, nullptr,
                                  nullptr);
    case 1: {
      const int64_t rows[3] = {draw.Integer(), draw.Integer(), draw.Integer()};
      return egosieve_gp_remove(gp, rows, static_cast<int64_t>(draw.Below(4)));
    }
    case 2: {
      const egosieve_grid grid = {draw.Real(), draw.Real(), draw.Real(),
                                  draw.Real(), out.rows,    out.columns};
      if (out.data == nullptr || out.rows > 4096 || out.columns > 4096) return EGOSIEVE_OK;
      return egosieve_gp_predict_grid(gp, &grid, &prediction);
    }
    case 3:
      return egosieve_gp_points(gp, &out, draw.OneIn(2) ? nullptr : &out);
    case 4: {
      const double scales[3] = {draw.Real(), draw.Real(), draw.Real()};
      return egosieve_gp_set_hyperparameters(gp, scales, static_cast<int64_t>(draw.Below(4)),
                                             draw.Real(), draw.Real());
    }
    default: {
      const egosieve_status status = egosieve_gp_predict(gp, x_pointer, &prediction);
      if (x_pointer != nullptr && MustBeRefused(x) && status == EGOSIEVE_OK) {
        Fail("an array that breaks the rules was taken");
      }
      return status;
    }
  }
}

void Ask(egosieve_gp* gp, Draw& draw) {
  auto x = RandomArray<egosieve_const_array>(draw);
  auto y = RandomArray<egosieve_const_array>(draw);
  auto out = RandomArray<egosieve_array>(draw);
  if (!draw.OneIn(4)) {  // shapes that go together, so that what is wrong stands alone
    x.rows = y.rows = out.rows = 1 + static_cast<int64_t>(draw.Below(9));
    y.columns = out.columns = 1;
  }
  if (!IsFair(x) || !IsFair(y) || !IsFair(out)) return;
  for (size_t i = 0; i + 8 <= sizeof memory; i += 8) {
    const double value = draw.OneIn(50) ? draw.Real() : 0.001 * static_cast<double>(i % 977);
    std::memcpy(memory + i, &value, sizeof value);
  }
  const egosieve_status status = Call(gp, x, y, out, draw);
  if (status != EGOSIEVE_OK && *egosieve_last_error() == '\0') Fail("an error without a text");
  if (status == EGOSIEVE_INTERNAL) Fail("an internal error");
}

int Run(double seconds, int64_t rounds, uint64_t seed) {
  egosieve_gp* models[std::size(kApproximations)];
  std::string files[std::size(kApproximations)];
  for (size_t i = 0; i < std::size(models); ++i) {
    models[i] = NewModel(12, kApproximations[i]);
    files[i] = FileOf(models[i]);
  }
  const auto start = std::chrono::steady_clock::now();
  int64_t round = 0;
  for (;; ++round) {
    const double elapsed =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (rounds > 0 ? round == rounds : elapsed > seconds) break;
    alarm(kLimitSeconds);
    Draw draw(seed * 1000003 + static_cast<uint64_t>(round));
    const size_t kind = draw.Below(std::size(models));
    egosieve_gp*& gp = models[kind];
    const std::string& valid = files[kind];
    switch (draw.Below(3)) {
      case 0:
        Load(DamagedBytes(valid, draw));
        break;
      case 1:
        Load(DamagedArrays(valid, draw));
        break;
      default:
        Ask(gp, draw);
    }
    egosieve_gp_info info;
    egosieve_gp_info_init(&info);
    if (egosieve_gp_describe(gp, &info) != EGOSIEVE_OK) Fail("the model is gone");
    if (info.size > 200) {  // what was conditioned on stays small
      egosieve_gp_free(gp);
      gp = NewModel(12, kApproximations[kind]);
    }
  }
  for (egosieve_gp* gp : models) egosieve_gp_free(gp);
  std::printf("%lld inputs, no failure\n", static_cast<long long>(round));
  return 0;
}

}  // namespace
}  // namespace egosieve::embed

int main(int argc, char** argv) {
  double seconds = 60.0;
  int64_t rounds = 0;
  uint64_t seed = 1;
  for (int i = 1; i < argc; ++i) {
    if (std::strncmp(argv[i], "--seconds=", 10) == 0) seconds = std::atof(argv[i] + 10);
    if (std::strncmp(argv[i], "--rounds=", 9) == 0) rounds = std::atoll(argv[i] + 9);
    if (std::strncmp(argv[i], "--seed=", 7) == 0) seed = std::strtoull(argv[i] + 7, nullptr, 10);
  }
  return egosieve::embed::Run(seconds, rounds, seed);
}
