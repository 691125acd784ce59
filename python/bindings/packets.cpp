// selfproj.packets: packets as boards send them.
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "python/bindings/arrays.h"
#include "python/bindings/moments_result.h"
#include "python/bindings/packet_view.h"
#include "selfproj/model/board.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/packet_payload.h"

namespace selfproj::python {
namespace {

using Bytes = In<std::uint8_t, nb::ndim<1>, nb::c_contig>;

// A packet, or the reason why there is none.
PacketHandle parse(const nb::object& owner, const std::uint8_t* data, std::size_t count) {
  model::PacketView view;
  const model::PacketError fault = without_gil([&] { return model::parse_packet({data, count}, view); });
  if (fault != model::PacketError::none) {
    throw std::invalid_argument(std::string("no packet: ") + model::to_string(fault));
  }
  return {view, owner, std::make_shared<Place>()};
}

PacketHandle parse_bytes(const Bytes& data, std::size_t offset) {
  require(offset <= data.size(), "offset: beyond the end of the bytes");
  return parse(nb::cast(data), data.data() + offset, data.size() - offset);
}

Out<std::uint8_t> array_of_packet(const std::vector<std::uint8_t>& packet) {
  auto array = new_array<std::uint8_t>({packet.size()});
  std::memcpy(array.data(), packet.data(), packet.size());
  return array;
}

PacketHandle copy(const PacketHandle& packet) {
  auto array = new_array<std::uint8_t>({packet.size()});
  std::memcpy(array.data(), packet.view().bytes().data(), packet.size());
  return parse(nb::cast(array), array.data(), packet.size());
}

Out<std::uint8_t> build(const model::PacketHeader& header, const Bytes& payload, std::uint32_t status) {
  std::vector<std::uint8_t> packet;
  without_gil([&] { model::append_packet(header, {payload.data(), payload.size()}, status, packet); });
  return array_of_packet(packet);
}

Out<std::uint8_t> moments_packet(const In<std::uint8_t>& image, int threshold, model::Mode mode, model::Select select,
                                 int gap, int first_row, int last_row, const model::PacketHeader& header) {
  const model::ImageView view = image_of(image);
  require(view.columns % spec::kPixelsPerBeat == 0 && view.columns <= spec::kColumnLimit,
          "image: a board takes multiples of 4 columns up to 4096");
  require(first_row >= 0 && first_row <= spec::kRowLimit && last_row >= 0 && last_row <= spec::kRowLimit,
          "first_row, last_row: must be in 0..2047");
  const model::Measure measure{.mode = mode,
                               .threshold = threshold,
                               .select = select,
                               .gap = gap,
                               .window = {.first = first_row, .last = last_row}};
  std::vector<std::uint8_t> packet;
  without_gil([&] { model::append_moments_packet(view, measure, header, packet); });
  return array_of_packet(packet);
}

MomentsResult moments_of(const PacketHandle& packet) {
  const model::PacketView& view = packet.view();
  require(model::has_columns(view.header.kind) && !view.payload.empty(), "the packet has no moments");
  const auto select = static_cast<model::Select>(view.header.select);
  MomentsResult result(select, std::nullopt, view.header.columns);
  const PacketHandle::Use use(packet);
  without_gil([&] { model::unpack_columns(view.header, view.payload.data(), result.view(0)); });
  return result;
}

Out<std::uint16_t> codes_of(const PacketHandle& packet) {
  const model::PacketView& view = packet.view();
  require(view.header.kind == spec::kKindCodes && !view.payload.empty(), "the packet has no codes");
  auto codes = new_array<std::uint16_t>({view.header.columns});
  model::unpack_codes(view.header.columns, view.payload.data(), codes.data());
  return codes;
}

std::string text_of_header(const model::PacketHeader& header) {
  return "kind=" + std::to_string(header.kind) + ", sequence=" + std::to_string(header.sequence) +
         ", columns=" + std::to_string(header.columns) + ", rows=" + std::to_string(header.rows);
}

std::string text_of(const PacketHandle& packet) {
  return "Packet(" + text_of_header(packet.header()) + ", status=" + std::to_string(packet.status()) + ")";
}

// All fields.
template <class Header>
auto fields_of(Header& h) {
  return std::tie(h.kind, h.stream, h.lost, h.sequence, h.time_stamp, h.encoder, h.payload_size, h.columns, h.rows,
                  h.pattern, h.mode, h.threshold, h.first_line, h.lines, h.flags, h.select, h.first_row, h.last_row,
                  h.gap, h.region_row, h.region_column, h.pixel_bits, h.tall);
}

template <class... Fields>
std::tuple<Fields...> copies_of(const std::tuple<Fields&...>& fields) {
  return fields;
}

using HeaderState = decltype(copies_of(fields_of(std::declval<model::PacketHeader&>())));

void bind_header(nb::module_& module) {
  nb::class_<model::PacketHeader>(module, "Header",
                                  "The fields of a packet's header; docs/packet-reference.md explains them.")
      .def(nb::init<>())
      .def_rw("kind", &model::PacketHeader::kind)
      .def_rw("stream", &model::PacketHeader::stream)
      .def_rw("lost", &model::PacketHeader::lost)
      .def_rw("sequence", &model::PacketHeader::sequence)
      .def_rw("time_stamp", &model::PacketHeader::time_stamp)
      .def_rw("encoder", &model::PacketHeader::encoder)
      .def_ro("payload_size", &model::PacketHeader::payload_size)
      .def_rw("columns", &model::PacketHeader::columns)
      .def_rw("rows", &model::PacketHeader::rows)
      .def_rw("pattern", &model::PacketHeader::pattern)
      .def_rw("mode", &model::PacketHeader::mode)
      .def_rw("threshold", &model::PacketHeader::threshold)
      .def_rw("pixel_bits", &model::PacketHeader::pixel_bits)
      .def_rw("tall", &model::PacketHeader::tall)
      .def_rw("first_line", &model::PacketHeader::first_line)
      .def_rw("lines", &model::PacketHeader::lines)
      .def_rw("flags", &model::PacketHeader::flags)
      .def_rw("select", &model::PacketHeader::select)
      .def_rw("first_row", &model::PacketHeader::first_row)
      .def_rw("last_row", &model::PacketHeader::last_row)
      .def_rw("gap", &model::PacketHeader::gap)
      .def_rw("region_row", &model::PacketHeader::region_row)
      .def_rw("region_column", &model::PacketHeader::region_column)
      .def("__eq__", [](const model::PacketHeader& one, const model::PacketHeader& other) { return one == other; })
      .def("__copy__", [](const model::PacketHeader& header) { return header; })
      .def("__repr__", [](const model::PacketHeader& header) { return "Header(" + text_of_header(header) + ")"; })
      .def("__getstate__", [](model::PacketHeader& header) { return copies_of(fields_of(header)); })
      .def("__setstate__", [](model::PacketHeader& header, const HeaderState& state) {
        new (&header) model::PacketHeader();
        fields_of(header) = state;
      });
}

}  // namespace

void bind_packets(nb::module_& module) {
  module.attr("KIND_MOMENTS") = spec::kKindMoments;
  module.attr("KIND_COMPACT") = spec::kKindCompact;
  module.attr("KIND_VERDICT") = spec::kKindVerdict;
  module.attr("KIND_CODES") = spec::kKindCodes;
  module.attr("KIND_IMAGE") = spec::kKindImage;
  bind_header(module);
  nb::class_<PacketHandle>(module, "Packet", "A packet that was found right. Its arrays lead to where its bytes are.")
      .def_prop_ro(
          "header", [](const PacketHandle& packet) { return packet.header(); }, "A copy of its header.")
      .def_prop_ro("status", &PacketHandle::status, "0 = good; otherwise what was wrong with the frame.")
      .def_prop_ro("size", &PacketHandle::size, "Bytes of the whole packet.")
      .def_prop_ro("bytes", &PacketHandle::bytes, nb::rv_policy::reference,
                   "The whole packet, uint8, in place and read-only.")
      .def_prop_ro("payload", &PacketHandle::payload, nb::rv_policy::reference,
                   "Its payload, uint8, in place and read-only.")
      .def("moments", &moments_of, "Its moments as arrays. ValueError if it has none.")
      .def("codes", &codes_of, "Its line of code words, uint16. ValueError if it has none.")
      .def("copy", &copy, "The same packet in memory of its own.")
      .def("__repr__", &text_of)
      .def(
          "__getstate__",
          [](const PacketHandle& packet) { return nb::make_tuple(nb::cast(packet.bytes(), nb::rv_policy::reference)); })
      .def("__setstate__", [](PacketHandle& packet, const nb::tuple& state) {
        require(state.size() == 1, "state: is none of a Packet");
        new (&packet) PacketHandle(parse_bytes(nb::cast<Bytes>(state[0]), 0));
      });
  module.def(
      "parse", &parse_bytes, nb::arg("data").noconvert(), nb::arg("offset") = 0,
      "The packet that begins at `offset` of the bytes (uint8, or bytes). They are not copied, and live as long\n"
      "as the packet. ValueError with the fault if there is none.");
  module.def("build", &build, nb::arg("header"), nb::arg("payload").noconvert(), nb::arg("status") = 0,
             "A whole packet, uint8: header, payload (uint8, a multiple of 16), trailer. The header is not checked.");
  module.def("moments_packet", &moments_packet, nb::arg("image").noconvert(), nb::arg("threshold"),
             nb::arg("mode") = model::Mode::grey_over, nb::arg("select") = model::Select::all, nb::arg("gap") = 0,
             nb::arg("first_row") = 0, nb::arg("last_row") = 0, nb::arg("header") = model::PacketHeader{},
             "The packet that a board sends for a good frame, uint8. Of the header it takes stream, lost, sequence,\n"
             "time_stamp, encoder, pattern and flags. Other arguments as those of selfproj.model.moments.");
}

}  // namespace selfproj::python
