// What every function of the C interface does: no exception leaves it, the last error of the thread is kept as text,
// and structures become those of the model and back.
#ifndef SELFPROJ_CAPI_CONVERT_H
#define SELFPROJ_CAPI_CONVERT_H

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>
#include <type_traits>

#include "selfproj.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"

namespace selfproj::capi {

// Keeps the text for selfproj_last_error(), cut off if it is very long. Returns `result`.
std::int32_t failed(std::int32_t result, const char* text) noexcept;

// Throws std::invalid_argument with the text unless `good`.
inline void require(bool good, const char* text) {
  if (!good) {
    throw std::invalid_argument(text);
  }
}

// Calls `work`, which returns what the C function returns, or nothing for SELFPROJ_OK; turns exceptions into results.
template <typename Work>
std::int32_t guarded(const Work& work) noexcept {
  try {
    if constexpr (std::is_void_v<decltype(work())>) {
      work();
      return SELFPROJ_OK;
    } else {
      return work();
    }
  } catch (const std::bad_alloc&) {
    return failed(SELFPROJ_NO_MEMORY, "there is not enough memory");
  } catch (const std::invalid_argument& error) {
    return failed(SELFPROJ_BAD_ARGUMENT, error.what());
  } catch (const UserError& error) {
    return failed(SELFPROJ_BAD_INPUT, error.what());
  } catch (const std::exception& error) {
    return failed(SELFPROJ_INTERNAL, error.what());
  } catch (...) {
    return failed(SELFPROJ_INTERNAL, "unknown exception");
  }
}

// A structure of the caller, who may have an older or newer version of it: fields that he does not have are 0. `oldest`
// is the size that the first version had.
template <typename Struct>
Struct copy_of(const Struct* from, std::size_t oldest, const char* text) {
  Struct copy{};
  require(from != nullptr && from->size >= oldest, text);
  std::memcpy(&copy, from, std::min<std::size_t>(from->size, sizeof copy));
  return copy;
}

// Writes the fields that the caller has; his `size` stays.
template <typename Struct>
void copy_to(Struct& value, Struct* to) {
  value.size = to->size;
  std::memcpy(to, &value, std::min<std::size_t>(value.size, sizeof value));
}

// The sizes of the structures in their first version.
inline constexpr std::uint32_t kOldestMeasure = 28;
inline constexpr std::uint32_t kOldestHeader = 88;

// Throws std::invalid_argument unless rows and columns are in 1..32768.
void check_sides(std::int32_t rows, std::int32_t columns);

// Throws std::invalid_argument if the image is null, has a null pointer, a size below 1, more than 32768 rows or
// columns, or rows that overlap.
model::ImageView image_of(const selfproj_image* image);

// Throw std::invalid_argument if the value is no mode, or no select.
model::Mode mode_of(std::int32_t mode);

model::Select select_of(std::int32_t select);

// Throws std::invalid_argument if the measure is null, or a field is out of range.
model::Measure measure_of(const selfproj_measure* measure);

// Arrays of the caller for what `select` says. Throws std::invalid_argument if one that is needed is null.
model::RunsView runs_of(model::Select select, const model::MomentsView& moments, std::uint8_t* runs,
                        std::uint8_t* second);

// Throws std::invalid_argument if `header` is null or a field does not fit its bits. payload_size stays 0.
model::PacketHeader header_of(const selfproj_header* header);

selfproj_header header_from(const model::PacketHeader& header);

// Fills the caller's packet, whose size must be set; throws std::invalid_argument if it is null or too small.
void write_packet(const model::PacketView& packet, selfproj_packet* out);
void check_packet(const selfproj_packet* out);

}  // namespace selfproj::capi

#endif  // SELFPROJ_CAPI_CONVERT_H
