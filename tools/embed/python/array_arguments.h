// NumPy arrays as arguments of the C interface, without a copy, and its statuses as exceptions.
#ifndef EGOSIEVE_TOOLS_EMBED_PYTHON_ARRAY_ARGUMENTS_H_
#define EGOSIEVE_TOOLS_EMBED_PYTHON_ARRAY_ARGUMENTS_H_

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <string>

#include "egosieve/types.h"

namespace egosieve::python {

namespace py = pybind11;

// ValueError for bad arguments and damaged files, FileNotFoundError, MemoryError, RuntimeError for
// the rest.
inline void Check(egosieve_status status) {
  if (status == EGOSIEVE_OK) return;
  const char* text = egosieve_last_error();
  switch (status) {
    case EGOSIEVE_INVALID_ARGUMENT:
    case EGOSIEVE_DATA_LOSS:
      throw py::value_error(text);
    case EGOSIEVE_NOT_FOUND:
      PyErr_SetString(PyExc_FileNotFoundError, text);
      throw py::error_already_set();
    case EGOSIEVE_OUT_OF_MEMORY:
      PyErr_SetString(PyExc_MemoryError, text);
      throw py::error_already_set();
    default:
      throw std::runtime_error(text);
  }
}

// `call` without the interpreter's lock, then Check.
template <typename Call>
void CheckUnlocked(Call&& call) {
  egosieve_status status;
  {
    // The last error belongs to the thread, which stays the same.
    py::gil_scoped_release unlocked;
    status = call();
  }
  Check(status);
}

inline egosieve_type TypeOf(const char* name, const py::array& array) {
  if (py::isinstance<py::array_t<float>>(array)) return EGOSIEVE_FLOAT32;
  if (py::isinstance<py::array_t<double>>(array)) return EGOSIEVE_FLOAT64;
  throw py::type_error(std::string(name) + " has dtype " +
                       py::str(array.dtype()).cast<std::string>() +
                       "; it must be float32 or float64 in the machine's byte order");
}

// One or two dimensions; one is a column. NumPy's strides are bytes, as the C interface's are.
template <typename View, typename Pointer>
View ViewOf(const char* name, const py::array& array, Pointer data) {
  if (array.ndim() != 1 && array.ndim() != 2) {
    throw py::value_error(std::string(name) + " has " + std::to_string(array.ndim()) +
                          " dimensions; it must have 1 or 2");
  }
  View view{};
  view.data = data;
  view.rows = array.shape(0);
  view.columns = array.ndim() == 2 ? array.shape(1) : 1;
  view.row_stride = array.strides(0);
  view.column_stride =
      array.ndim() == 2 ? array.strides(1) : static_cast<int64_t>(array.itemsize());
  view.type = TypeOf(name, array);
  return view;
}

inline egosieve_const_array Input(const char* name, const py::array& array) {
  return ViewOf<egosieve_const_array>(name, array, array.data());
}

// None: not wanted.
inline egosieve_array Output(const char* name, const py::object& object) {
  if (object.is_none()) return egosieve_array{};
  if (!py::isinstance<py::array>(object)) {
    throw py::type_error(std::string(name) + " is no numpy array");
  }
  auto array = py::reinterpret_borrow<py::array>(object);
  if (!array.writeable()) throw py::value_error(std::string(name) + " is read-only");
  return ViewOf<egosieve_array>(name, array, array.mutable_data());
}

// Height x width, or height x width x 3, of uint8; a copy where pixels are not neighbours.
// `order`: "bgr" or "rgb".
inline egosieve_image ImageOf(const char* name, py::array& pixels, const std::string& order) {
  if (!py::isinstance<py::array_t<uint8_t>>(pixels)) {
    throw py::type_error(std::string(name) + " has dtype " +
                         py::str(pixels.dtype()).cast<std::string>() + "; it must be uint8");
  }
  const bool colour = pixels.ndim() == 3 && pixels.shape(2) == 3;
  if (!colour && pixels.ndim() != 2) {
    throw py::value_error(std::string(name) + " must be height x width, or height x width x 3");
  }
  if (order != "bgr" && order != "rgb") {
    throw py::value_error("order = '" + order + "'; it must be 'bgr' or 'rgb'");
  }
  const py::ssize_t pixel = colour ? 3 : 1;
  if (pixels.strides(1) != pixel || (colour && pixels.strides(2) != 1) ||
      pixels.strides(0) < pixels.shape(1) * pixel) {
    pixels = py::array_t<uint8_t, py::array::c_style | py::array::forcecast>(pixels);
  }
  if (pixels.shape(0) > INT32_MAX || pixels.shape(1) > INT32_MAX) {
    throw py::value_error(std::string(name) + " is too large");
  }
  egosieve_image image{};
  image.data = static_cast<const uint8_t*>(pixels.data());
  image.width = static_cast<int32_t>(pixels.shape(1));
  image.height = static_cast<int32_t>(pixels.shape(0));
  image.row_stride = pixels.strides(0);
  image.channels = !colour ? EGOSIEVE_GREY : order == "bgr" ? EGOSIEVE_BGR : EGOSIEVE_RGB;
  return image;
}

}  // namespace egosieve::python

#endif  // EGOSIEVE_TOOLS_EMBED_PYTHON_ARRAY_ARGUMENTS_H_
