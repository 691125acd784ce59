// selfproj.driver: devices that bring packets, and images from packets of lines.
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "host/files/text.h"
#include "python/bindings/arrays.h"
#include "python/bindings/packet_view.h"
#include "selfproj/driver/device.h"
#include "selfproj/driver/image_assembler.h"

namespace selfproj::python {
namespace {

// A device, for one thread at a time. The packet that it gave last stays where it is until the next one is asked for.
class DeviceHandle {
 public:
  explicit DeviceHandle(std::unique_ptr<driver::Device> device) : device_(std::move(device)) {}

  [[nodiscard]] driver::Device& device() const {
    require(device_ != nullptr, "the device is closed");
    return *device_;
  }

  // The next packet; nothing after `timeout` seconds or at the end. Without a timeout it waits until Ctrl-C.
  std::optional<PacketHandle> next(const nb::object& self, std::optional<double> timeout) {
    const Busy::Entered entered(busy_);
    require(!timeout || *timeout >= 0, "timeout: must be 0 or more seconds");
    driver::Device& from = device();
    leave_packet();
    const auto begin = std::chrono::steady_clock::now();
    for (;;) {
      model::PacketView view;
      const driver::Next got = without_gil([&] { return from.next(view, slice_of(begin, timeout)); });
      if (got == driver::Next::packet) {
        place_ = std::make_shared<Place>();
        return PacketHandle(view, self, place_);
      }
      ended_ = got == driver::Next::end;
      if (ended_ || (timeout && seconds_since(begin) >= *timeout)) {
        return std::nullopt;
      }
      if (PyErr_CheckSignals() != 0) {
        throw nb::python_error();
      }
    }
  }

  [[nodiscard]] bool ended() const { return ended_; }

  [[nodiscard]] std::string text() const {
    return device_ == nullptr ? "Device(closed)" : "Device('" + files::shown(device_->uri()) + "')";
  }

  void release() {
    const Busy::Entered entered(busy_);
    leave_packet();
    device().release();
  }

  void close() {
    const Busy::Entered entered(busy_);
    leave_packet();
    device_.reset();
  }

 private:
  static double seconds_since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }

  // How long to wait before Python looks for signals.
  static std::chrono::nanoseconds slice_of(std::chrono::steady_clock::time_point begin, std::optional<double> timeout) {
    constexpr double kLongest = 0.1;
    const double left = timeout ? std::clamp(*timeout - seconds_since(begin), 0.0, kLongest) : kLongest;
    return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(left));
  }

  void leave_packet() {
    if (place_ == nullptr) {
      return;
    }
    if (place_->uses > 0) {
      throw nb::buffer_error("arrays still lead to the device's packet; copy or delete them first");
    }
    place_->current = false;
    place_.reset();
  }

  std::unique_ptr<driver::Device> device_;
  std::shared_ptr<Place> place_;  // of the newest packet
  bool ended_ = false;
  Busy busy_;
};

std::unique_ptr<DeviceHandle> open(const Path& uri, driver::Wait wait, bool wait_for_board, bool discard_backlog) {
  driver::DeviceOptions options;
  options.wait = wait;
  options.wait_for_board = wait_for_board;
  options.discard_backlog = discard_backlog;
  return std::make_unique<DeviceHandle>(without_gil([&] { return driver::open_device(uri.string(), options); }));
}

// The name of a file in it may be in any encoding.
nb::str uri_of(const driver::Device& device) {
  const std::string uri = device.uri();
  return nb::steal<nb::str>(PyUnicode_DecodeFSDefaultAndSize(uri.data(), static_cast<Py_ssize_t>(uri.size())));
}

std::map<std::string, std::uint64_t> counters_of(const DeviceHandle& handle) {
  const driver::Counters counters = handle.device().counters();
  std::map<std::string, std::uint64_t> out;
  for (const driver::CounterName& name : driver::kCounterNames) {
    out[name.key] = counters.*name.field;
  }
  return out;
}

// Puts images together, for one thread at a time.
class Assembler {
 public:
  Assembler(int kind, int stream) : assembler_(kind_of(kind), stream) {}

  std::optional<nb::object> add(const PacketHandle& packet) {
    if (!assembler_.add(packet.view())) {
      return std::nullopt;
    }
    const std::vector<std::size_t> shape{assembler_.header().rows, assembler_.header().columns};
    return assembler_.header().kind == spec::kKindCodes ? copy_of(assembler_.codes(), shape)
                                                        : copy_of(assembler_.pixels(), shape);
  }

  [[nodiscard]] const driver::ImageAssembler& assembler() const { return assembler_; }

 private:
  static std::uint8_t kind_of(int kind) {
    require(kind == spec::kKindCodes || kind == spec::kKindImage, "kind: must be KIND_CODES or KIND_IMAGE");
    return static_cast<std::uint8_t>(kind);
  }
  template <typename T>
  static nb::object copy_of(const std::vector<T>& values, const std::vector<std::size_t>& shape) {
    auto image = new_array<T>(shape);
    std::memcpy(image.data(), values.data(), image.size() * sizeof(T));
    return nb::cast(image);
  }

  driver::ImageAssembler assembler_;
};

void bind_device(nb::module_& module) {
  auto device = nb::class_<DeviceHandle>(module, "Device",
                                         "Brings packets, for one thread at a time. Iterate over it, or call next().");
  refuse_pickling(device, "holds an open device; pickle its packets, or its uri and open it again");
  device
      .def(
          "next",
          [](const nb::object& self, std::optional<double> timeout) {
            return nb::cast<DeviceHandle&>(self).next(self, timeout);
          },
          nb::arg("timeout") = nb::none(),
          "The next good packet in place; None after `timeout` seconds, or at the end (see `ended`). The packet "
          "before\n"
          "becomes invalid; BufferError if arrays still lead to it. InputError if a file cannot be read further.")
      .def("__iter__", [](const nb::object& self) { return self; })
      .def("__next__",
           [](const nb::object& self) {
             auto packet = nb::cast<DeviceHandle&>(self).next(self, std::nullopt);
             if (!packet) {
               throw nb::stop_iteration();
             }
             return *packet;
           })
      .def("__enter__", [](const nb::object& self) { return self; })
      .def(
          "__exit__", [](DeviceHandle& self, const nb::args&) { self.close(); }, "Closes the device.")
      .def_prop_ro("ended", &DeviceHandle::ended, "Whether no further packet will come.")
      .def_prop_ro(
          "uri", [](const DeviceHandle& self) { return uri_of(self.device()); }, "As it was opened.")
      .def("__repr__", &DeviceHandle::text)
      .def("counters", &counters_of, "What was delivered, lost, refused and so on, by name (docs/driver.md).")
      .def("release", &DeviceHandle::release, "Frees the place of the packet; it becomes invalid.")
      .def("close", &DeviceHandle::close, "Closes the device. BufferError if arrays still lead to its packet.");
}

}  // namespace

void bind_driver(nb::module_& module) {
  nb::enum_<driver::Wait>(module, "Wait", "How to wait for a packet.")
      .value("POLLING", driver::Wait::polling, "Shortest delay; occupies a processor.")
      .value("BLOCKING", driver::Wait::blocking, "Sleeps.")
      .value("POLLING_THEN_BLOCKING", driver::Wait::polling_then_blocking, "Polls for 50 us first.");
  bind_device(module);
  module.def("open", &open, nb::arg("uri"), nb::arg("wait") = driver::Wait::polling_then_blocking,
             nb::arg("wait_for_board") = false, nb::arg("discard_backlog") = false,
             "Opens a device: ring:NAME, file:PATH, udp:HOST[:PORT] or litepcie:PATH (docs/driver.md). InputError if "
             "there is none.");
  auto assembler = nb::class_<Assembler>(module, "ImageAssembler", "Images from packets of lines of one stream.");
  refuse_pickling(assembler, "is in the midst of a stream; pickle the images that it gave");
  assembler
      .def(nb::init<int, int>(), nb::arg("kind"), nb::arg("stream") = 0,
           "kind: packets.KIND_IMAGE or packets.KIND_CODES.")
      .def("add", &Assembler::add, nb::arg("packet"),
           "Takes a packet. Returns a new image (uint8, or uint16 for codes) when all its lines have come, else None.")
      .def_prop_ro(
          "complete", [](const Assembler& self) { return self.assembler().complete(); }, "Images given.")
      .def_prop_ro(
          "incomplete", [](const Assembler& self) { return self.assembler().incomplete(); },
          "Images with lines missing.")
      .def("__repr__", [](const Assembler& self) {
        return "ImageAssembler(complete=" + std::to_string(self.assembler().complete()) +
               ", incomplete=" + std::to_string(self.assembler().incomplete()) + ")";
      });
}

}  // namespace selfproj::python
