"""The C interface by ctypes: another way to the model, with which the Python package is compared."""

import ctypes
import os

import numpy

LIBRARY = ctypes.CDLL(os.environ["SELFPROJ_C_LIBRARY"])
LIBRARY.selfproj_last_error.restype = ctypes.c_char_p


class Image(ctypes.Structure):
    _fields_ = [("pixels", ctypes.c_void_p), ("rows", ctypes.c_int32), ("columns", ctypes.c_int32),
                ("stride", ctypes.c_ssize_t)]


class Measure(ctypes.Structure):
    _fields_ = [("size", ctypes.c_uint32), *((name, ctypes.c_int32) for name in
                                             ("mode", "threshold", "select", "gap", "first_row", "last_row"))]


class Header(ctypes.Structure):
    _fields_ = [("size", ctypes.c_uint32), ("kind", ctypes.c_uint32), ("stream", ctypes.c_uint32),
                ("lost", ctypes.c_uint32), ("sequence", ctypes.c_uint64), ("time_stamp", ctypes.c_uint64),
                *((name, ctypes.c_uint32) for name in
                  ("encoder", "columns", "rows", "pattern", "mode", "threshold", "first_line", "lines", "flags",
                   "select", "gap", "first_row", "last_row")),
                ("region_row", ctypes.c_uint16), ("region_column", ctypes.c_uint16)]


class Profile(ctypes.Structure):
    _fields_ = [("size", ctypes.c_uint32), ("columns", ctypes.c_uint32),
                *((name, ctypes.c_void_p) for name in ("centroid", "x", "y", "z", "dx", "dy", "dz", "validity"))]


def call(name, *arguments):
    result = getattr(LIBRARY, f"selfproj_{name}")(*arguments)
    assert result >= 0, f"{name}: {LIBRARY.selfproj_last_error().decode()}"
    return result


def pointer(array):
    return ctypes.c_void_p(array.ctypes.data)


def image_of(array):
    return Image(array.ctypes.data, array.shape[0], array.shape[1], array.strides[0])


def measure_of(how):
    return Measure(ctypes.sizeof(Measure), how["mode"].value, how["threshold"], how["select"].value, how["gap"],
                   how["first_row"], how["last_row"])


def moments(image, how):
    """M0, M1, N, runs, second; the last two are 0 unless the strongest run is measured."""
    arrays = [numpy.zeros(image.shape[1], kind) for kind in ("uint32",) * 3 + ("uint8",) * 2]
    call("moments", ctypes.byref(image_of(image)), ctypes.byref(measure_of(how)), *map(pointer, arrays))
    return arrays


def packet(image, how, **fields):
    out, written = numpy.zeros(20000, "uint8"), ctypes.c_size_t()
    header = Header(size=ctypes.sizeof(Header), **fields)
    call("moments_packet", ctypes.byref(image_of(image)), ctypes.byref(measure_of(how)), ctypes.byref(header),
         pointer(out), ctypes.c_size_t(out.size), ctypes.byref(written))
    return out[:written.value]


def built(payload, status, **fields):
    out, written = numpy.zeros(payload.size + 100, "uint8"), ctypes.c_size_t()
    header = Header(size=ctypes.sizeof(Header), **fields)
    call("build_packet", ctypes.byref(header), pointer(payload), ctypes.c_size_t(payload.size), status, pointer(out),
         ctypes.c_size_t(out.size), ctypes.byref(written))
    return out[:written.value]


class Gray:
    def __init__(self, rows, columns, bits, threshold):
        self.handle, self.codes = ctypes.c_void_p(), numpy.zeros((rows, columns), "uint16")
        call("gray_create", rows, columns, bits, threshold, ctypes.byref(self.handle))

    def take(self, image, pattern, good):
        due = ctypes.c_int32()
        call("gray_take", self.handle, ctypes.byref(image_of(image)), pattern, int(good), pointer(self.codes),
             ctypes.byref(due))
        return self.codes.copy() if due.value else None

    def __del__(self):
        LIBRARY.selfproj_gray_destroy(self.handle)


def median3x3(codes):
    out = numpy.zeros_like(codes)
    call("median3x3", pointer(codes), *codes.shape, pointer(out))
    return out


def match(codes, table):
    out = numpy.zeros_like(codes)
    call("match", pointer(codes), ctypes.c_size_t(codes.size), table.shape[-1].bit_length() - 1, pointer(table),
         pointer(out))
    return out


def profile(rig, m0, m1, n):
    """The arrays of a profile of moments, by name."""
    handle = ctypes.c_void_p()
    call("profiler_create", rig.encode(), None, ctypes.byref(handle))
    arrays = {name: numpy.zeros(m0.size, "uint8" if name == "validity" else "float32")
              for name, _ in Profile._fields_[2:]}
    out = Profile(ctypes.sizeof(Profile), m0.size, *(array.ctypes.data for array in arrays.values()))
    call("profile_of_moments", handle, pointer(m0), pointer(m1), pointer(n), ctypes.byref(out))
    LIBRARY.selfproj_profiler_destroy(handle)
    return arrays
