/**
 * @file posterior.hpp
 * Destinations of predictions, and immutable posteriors, which own an #egosieve_posterior.
 */
#ifndef EGOSIEVE_POSTERIOR_HPP_
#define EGOSIEVE_POSTERIOR_HPP_

#include <cstdint>

#include "arrays.hpp"
#include "device_call.h"
#include "gaussian_process.h"
#include "result.hpp"

namespace egosieve {

/** Arithmetic of a prediction; see #egosieve_precision. */
enum class Precision : int64_t {
  kAuto = EGOSIEVE_AUTO_PRECISION, /**< Float32 where it suffices, otherwise float64. */
  kFloat64 = EGOSIEVE_IN_FLOAT64,  /**< Float64 throughout. */
  kFloat32 = EGOSIEVE_IN_FLOAT32,  /**< Float32, whatever its errors. */
};

/** Destinations of the results; a default Array is not wanted. */
struct Prediction {
  Array mean{};                           /**< Of f. */
  Array variance{};                       /**< Of f, or of an observation. */
  Array probability{};                    /**< Of y = +1 against -1. */
  bool of_observation = false;            /**< The variance is that of an observation. */
  Precision precision = Precision::kAuto; /**< Arithmetic. */
};

/** Counts of a prediction. */
struct PredictionCounts {
  int64_t clamped_variances = 0; /**< Variances that rounding made negative, set to 0. */
  int64_t in_float64 = 0;        /**< Places with a result that was computed in float64. */
};

/** Errors of float32 results; see egosieve_posterior_float32_error(). */
struct Float32Error {
  double mean = 0.0;      /**< Of the means. */
  double variance = 0.0;  /**< Of the variances. */
  double deviation = 0.0; /**< The least deviation of f at the places of the measurement. */
};

/** A prediction on an OpenCL queue; by default without queries. See device_call.h. */
class DeviceCall {
 public:
  DeviceCall() { egosieve_device_call_init(&call_); }
  /** The fields, of egosieve_device_call. */
  egosieve_device_call* operator->() { return &call_; }
  /** The struct of the C interface. */
  const egosieve_device_call* c() const { return &call_; }

 private:
  egosieve_device_call call_;
};

/** A matrix of float64 in an OpenCL buffer; see #egosieve_device_matrix. */
using DeviceMatrix = egosieve_device_matrix;

/** Points on a regular grid; see #egosieve_grid. */
using Grid = egosieve_grid;

/** Predictions, which a model and a posterior have in common; the parameters are their C calls. */
template <typename Handle, egosieve_status (*kFree)(Handle*),
          egosieve_status (*kPredict)(Handle*, const egosieve_const_array*, egosieve_prediction*),
          egosieve_status (*kPredictGrid)(Handle*, const egosieve_grid*, egosieve_prediction*),
          egosieve_status (*kPredictImage)(Handle*, const egosieve_image*, int32_t,
                                           egosieve_prediction*)>
class Predictor : public Owner<Handle, kFree> {
 public:
  using Owner<Handle, kFree>::Owner;

  /** At M x D points. */
  Result<PredictionCounts> Predict(const ConstArray& x, const Prediction& prediction) const {
    return PredictBy(prediction, kPredict, x.c());
  }
  /** Predicts on a grid in the plane; needs D = 2. */
  Result<PredictionCounts> PredictGrid(const Grid& grid, const Prediction& prediction) const {
    return PredictBy(prediction, kPredictGrid, &grid);
  }
  /** Predicts at every `stride`-th pixel; needs D = 6. See egosieve_gp_predict_image(). */
  Result<PredictionCounts> PredictImage(const Image& image, int32_t stride,
                                        const Prediction& prediction) const {
    const egosieve_image c_image = image.c();
    return PredictBy(prediction, kPredictImage, &c_image, stride);
  }

 private:
  template <typename Function, typename... Places>
  Result<PredictionCounts> PredictBy(const Prediction& prediction, Function function,
                                     Places... places) const {
    egosieve_prediction c;
    egosieve_prediction_init(&c);
    c.mean = prediction.mean.c();
    c.variance = prediction.variance.c();
    c.probability = prediction.probability.c();
    c.of_observation = prediction.of_observation ? 1 : 0;
    c.precision = static_cast<egosieve_precision>(prediction.precision);
    Status status = this->Call(function, places..., &c);
    if (!status.ok()) return status;
    return PredictionCounts{c.clamped_variances, c.float64_count};
  }
};

/** The posterior of a model at one moment. Immutable: any number of threads may predict. */
class Posterior
    : public Predictor<egosieve_posterior, egosieve_posterior_free, egosieve_posterior_predict,
                       egosieve_posterior_predict_grid, egosieve_posterior_predict_image> {
 public:
  using Predictor::Predictor;

  /** The errors of float32 results, which those of Enqueue() have. */
  Result<Float32Error> ErrorOfFloat32() const {
    Float32Error error;
    return internal::Given(
        egosieve_posterior_float32_error(handle_, &error.mean, &error.variance, &error.deviation),
        error);
  }

  /** Enqueues a prediction and returns. The value: a cl_event, which the caller releases. */
  Result<void*> Enqueue(const DeviceCall& call) const {
    void* event = nullptr;
    return internal::Given(egosieve_posterior_enqueue(handle_, call.c(), &event), event);
  }
  /** The posterior's cl_context; it lives as long as the posterior does. */
  Result<void*> OpenClContext() const {
    void* context = nullptr;
    return internal::Given(egosieve_posterior_opencl(handle_, &context, nullptr), context);
  }
  /** The posterior's cl_device_id. */
  Result<void*> OpenClDevice() const {
    void* device = nullptr;
    return internal::Given(egosieve_posterior_opencl(handle_, nullptr, &device), device);
  }
};

}  // namespace egosieve

#endif  // EGOSIEVE_POSTERIOR_HPP_
