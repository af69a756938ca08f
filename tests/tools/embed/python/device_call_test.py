"""Predictions on an OpenCL queue from Python, with OpenCL by ctypes in place of PyOpenCL."""

import copy
import ctypes
import ctypes.util
import os
import pickle
import unittest
from ctypes import byref, c_int32, c_size_t, c_uint32, c_uint64, c_void_p

import egosieve
import numpy as np

COUNT, FEATURES = 70, 2


class Handle:
    """As PyOpenCL's objects: an address in int_ptr."""

    def __init__(self, address):
        self.int_ptr = address


class OpenCl:
    """The few calls of OpenCL that a test needs."""

    def __init__(self):
        self.library = ctypes.CDLL(ctypes.util.find_library("OpenCL"))
        for function in ("clCreateBuffer", "clCreateCommandQueue", "clCreateContext"):
            getattr(self.library, function).restype = c_void_p

    def context(self, device):
        error = c_int32()
        address = self.library.clCreateContext(None, c_uint32(1), byref(c_void_p(device)), None, None, byref(error))
        assert error.value == 0
        return Handle(address)

    def buffer(self, context, array):
        copy_host_pointer = 1 << 5
        error = c_int32()
        address = self.library.clCreateBuffer(
            c_void_p(context), c_uint64(copy_host_pointer), c_size_t(array.nbytes), c_void_p(array.ctypes.data), byref(error)
        )
        assert error.value == 0
        return Handle(address)

    def queue(self, context, device):
        error = c_int32()
        address = self.library.clCreateCommandQueue(c_void_p(context), c_void_p(device), c_uint64(0), byref(error))
        assert error.value == 0
        return Handle(address)

    def read(self, queue, buffer, count, event, kind=np.float32):
        values = np.empty(count, kind)
        status = self.library.clEnqueueReadBuffer(
            c_void_p(queue.int_ptr), c_void_p(buffer.int_ptr), 1, c_size_t(0), c_size_t(values.nbytes),
            c_void_p(values.ctypes.data), 1, byref(c_void_p(event)), None,
        )  # fmt: skip
        assert status == 0
        return values


class DeviceCall(unittest.TestCase):
    def setUp(self):
        random = np.random.default_rng(5)
        self.X = X = random.uniform(-1, 1, (40, FEATURES))
        self.y = y = np.where(X[:, 0] > X[:, 1], 1.0, -1.0)
        self.queries = random.uniform(-1, 1, (COUNT, FEATURES)).astype(np.float32)
        self.model = egosieve.GaussianProcess("matern52", optimize=False).fit(X, y)
        self.frozen = self.model.freeze()
        try:
            self.context, self.device = self.frozen.opencl()
        except RuntimeError as error:
            self.skipTest(str(error))

    def test_gives_what_predict_gives(self):
        opencl = OpenCl()
        queue = opencl.queue(self.context, self.device)
        at = opencl.buffer(self.context, self.queries)
        out = opencl.buffer(self.context, np.zeros(2 * COUNT, np.float32))
        event = self.frozen.enqueue(queue, at, COUNT, mean=out, variance=(out, COUNT))
        found = opencl.read(queue, out, 2 * COUNT, event)
        mean, variance = self.frozen.predict(self.queries, return_var=True)
        np.testing.assert_array_equal(found[:COUNT], mean)
        np.testing.assert_array_equal(found[COUNT:], variance)
        event = self.frozen.enqueue(queue, at, COUNT - 1, mean=out, first=FEATURES, wait_for=[event])
        found = opencl.read(queue, out, COUNT - 1, event)
        np.testing.assert_array_equal(found, mean[1:])

    def test_gives_the_kernel_matrix(self):
        opencl = OpenCl()
        queue = opencl.queue(self.context, self.device)
        inputs = opencl.buffer(self.context, self.X)
        queries = self.queries.astype(np.float64)
        at = opencl.buffer(self.context, queries)
        count = len(self.X) * (COUNT - 1)
        out = opencl.buffer(self.context, np.full(count + 3, -7.0))
        event = self.model.enqueue_covariance(queue, inputs, len(self.X), (out, 2), (at, FEATURES), COUNT - 1)
        found = opencl.read(queue, out, count + 3, event, np.float64)
        np.testing.assert_array_equal(found[[0, 1, -1]], -7.0)
        expected = self.model.covariance(self.X, queries[1:])
        np.testing.assert_allclose(found[2:-1].reshape(expected.shape), expected, rtol=0, atol=1e-14)
        event = self.model.enqueue_covariance(queue, at, 3, out, wait_for=[event])
        found = opencl.read(queue, out, 9, event, np.float64)
        np.testing.assert_allclose(found.reshape(3, 3), self.model.covariance(queries[:3]), rtol=0, atol=1e-14)
        with self.assertRaisesRegex(ValueError, "k has .* bytes"):
            self.model.enqueue_covariance(queue, inputs, len(self.X), out, at, COUNT)
        with self.assertRaisesRegex(ValueError, "not fitted"):
            egosieve.GaussianProcess().enqueue_covariance(queue, inputs, 1, out)

    def test_lies_on_the_callers_context(self):
        opencl = OpenCl()
        own = opencl.context(self.device)
        model = egosieve.GaussianProcess(
            "matern52", optimize=False, opencl_context=own, opencl_device=Handle(self.device), memory_cap_bytes=1
        ).fit(self.X, self.y)  # fmt: skip
        expected = self.model.predict(self.queries)
        np.testing.assert_array_equal(model.predict(self.queries), expected)
        frozen = model.freeze()
        self.assertEqual(frozen.opencl(), (own.int_ptr, self.device))
        queue = opencl.queue(own.int_ptr, self.device)
        at = opencl.buffer(own.int_ptr, self.queries)
        out = opencl.buffer(own.int_ptr, np.zeros(COUNT, np.float32))
        event = frozen.enqueue(queue, at, COUNT, mean=out)
        np.testing.assert_array_equal(opencl.read(queue, out, COUNT, event), expected)
        path = os.path.join(os.getcwd(), "on_a_context.npz")
        model.save(path)
        for twin in (copy.deepcopy(model), pickle.loads(pickle.dumps(model)), egosieve.GaussianProcess.load(path)):
            self.assertIsNone(twin.opencl_context)
            self.assertIsNone(twin.opencl_device)
            self.assertEqual(twin.memory_cap_bytes, 1)
            self.assertNotEqual(twin.freeze().opencl()[0], own.int_ptr)
            np.testing.assert_array_equal(twin.predict(self.queries), model.predict(self.queries))
        with self.assertRaisesRegex(TypeError, "opencl_context is no OpenCL object"):
            egosieve.GaussianProcess(opencl_context="own").fit(self.X, self.y)
        self.assertEqual(self.model.memory_cap_bytes, 0)
        with self.assertRaisesRegex(ValueError, "memory_cap_bytes = -1"):
            egosieve.GaussianProcess(memory_cap_bytes=-1).fit(self.X, self.y)

    def test_refuses_what_it_cannot_take(self):
        opencl = OpenCl()
        queue = opencl.queue(self.context, self.device)
        at = opencl.buffer(self.context, self.queries)
        with self.assertRaisesRegex(TypeError, "queue"):
            self.frozen.enqueue(None, at, COUNT)
        with self.assertRaisesRegex(TypeError, "mean"):
            self.frozen.enqueue(queue, at, COUNT, mean=self.queries)
        with self.assertRaisesRegex(ValueError, "queries"):
            self.frozen.enqueue(queue, at, COUNT + 1)
        normalized = egosieve.GaussianProcess(optimize=False, normalize_y=True).fit(self.queries, self.queries[:, 0])
        with self.assertRaisesRegex(RuntimeError, "normalize_y"):
            normalized.freeze().enqueue(queue, at, COUNT)


if __name__ == "__main__":
    unittest.main()
