#include "host/driver/control.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/driver/etherbone.h"
#include "host/driver/litepcie.h"
#include "host/driver/register_port.h"
#include "model/register_file.h"
#include "selfproj/files/user_error.h"

namespace selfproj::driver {
namespace {

constexpr int kHighLsb = spec::kRegMeasureThresholdHighLsb;
constexpr int kHighBits = spec::kRegMeasureThresholdHighBits;

std::string hex(std::uint32_t value) {
  std::array<char, 11> text{};
  static_cast<void>(std::snprintf(text.data(), text.size(), "0x%08X", value));
  return text.data();
}

const spec::Register& at(std::uint32_t address) {
  return *std::find_if(spec::kRegisters.begin(), spec::kRegisters.end(),
                       [&](const spec::Register& one) { return one.address == address; });
}

bool flag(std::uint32_t word, int lsb) { return field_of(word, lsb, 1) != 0; }

// "/dev/xdma0_user" of "/dev/xdma0_c2h_0"; empty for any other path.
std::string registers_beside(const std::string& path) {
  const std::size_t channel = path.find("_c2h_");
  const std::size_t name = path.rfind('/') + 1;  // 0 if there is no slash
  return channel == std::string::npos || path.compare(name, 4, "xdma") != 0 ? "" : path.substr(0, channel) + "_user";
}

}  // namespace

RegisterPart register_part(std::string_view name) {
  const std::string_view in = name.substr(0, name.find('.'));
  for (const spec::Register& one : spec::kRegisters) {
    if (one.name != in) {
      continue;
    }
    if (in == name) {
      return {&one, nullptr};
    }
    for (const spec::RegisterField& field : one.fields) {
      if (field.name == name.substr(in.size() + 1)) {
        return {&one, &field};
      }
    }
    throw UserError(std::string(name), "register " + std::string(in) + " has no such field");
  }
  throw UserError(std::string(name), "there is no such register");
}

Control::Control(std::unique_ptr<RegisterPort> port) : port_(std::move(port)) {
  const std::array<std::uint32_t, 5> addresses{spec::kRegId, spec::kRegVersion, spec::kRegSpecHash,
                                               spec::kRegCapability, spec::kRegStatus};
  const std::vector<std::uint32_t> words = port_->read(addresses);
  if (words[0] != spec::kMagic) {
    throw UserError(uri(), "no selfproj board is there: its first register is " + hex(words[0]));
  }
  const bool earlier = std::ranges::any_of(spec::kEarlierVersions, [&](const spec::EarlierVersion& one) {
    return one.control && words[1] == one.version && words[2] == one.hash;
  });
  if (!earlier && (words[1] != spec::kVersion || words[2] != spec::kHash)) {
    throw UserError(uri(), "the board was built from another specification: version " + std::to_string(words[1] >> 8U) +
                               "." + std::to_string(words[1] & 0xFFU) + ", hash " + hex(words[2]) + ", not " +
                               hex(spec::kHash));
  }
  const std::uint32_t can = words[3];
  const auto max_columns =
      static_cast<int>(field_of(can, spec::kRegCapabilityMaxColumnsLsb, spec::kRegCapabilityMaxColumnsBits));
  const auto max_rows =
      static_cast<int>(field_of(can, spec::kRegCapabilityMaxRowsLsb, spec::kRegCapabilityMaxRowsBits));
  build_ = {
      .max_columns = max_columns == 0 ? spec::kColumnLimit : max_columns,
      .max_rows = max_rows == 0 ? spec::kRowLimit : max_rows,
      .pixel_bits = spec::kPixelBits +
                    static_cast<int>(field_of(words[4], spec::kRegStatusMoreBitsLsb, spec::kRegStatusMoreBitsBits)),
      .lanes = spec::kPixelsPerBeat << field_of(words[4], spec::kRegStatusLanesLsb, spec::kRegStatusLanesBits),
      .grey = flag(can, spec::kRegCapabilityGreyLsb),
      .image = flag(can, spec::kRegCapabilityImageLsb),
      .codes = flag(can, spec::kRegCapabilityCodesLsb),
      .median = flag(can, spec::kRegCapabilityMedianLsb),
      .runs = flag(can, spec::kRegCapabilityRunsLsb),
      .region = flag(can, spec::kRegCapabilityRegionLsb),
      .compact = flag(words[4], spec::kRegStatusCompactLsb),
      .code_bits = static_cast<int>(field_of(can, spec::kRegCapabilityCodeBitsLsb, spec::kRegCapabilityCodeBitsBits)),
  };
  if (flag(words[4], spec::kRegStatusVerdictLsb)) {
    build_.verdict_log_sections =
        static_cast<int>(field_of(port_->word(spec::kRegVerdictState), spec::kRegVerdictStateLogSectionsLsb,
                                  spec::kRegVerdictStateLogSectionsBits));
  }
}

void Control::need(const spec::Register& one) const {
  if (!model::has_register(build_, one.address)) {
    throw UserError(uri(), "this board has no register " + std::string(one.name) +
                               (one.address == spec::kRegRegion || one.address >= spec::kRegCompact
                                    ? ": it was built without it"
                                    : ": it has no Gray-code decoder"));
  }
}

std::uint32_t Control::read(const RegisterPart& part) {
  need(*part.in);
  return value_in(port_->word(part.in->address), part);
}

std::uint32_t Control::value_in(std::uint32_t word, const RegisterPart& part) const {
  if (part.field == nullptr) {
    return word;
  }
  const std::uint32_t high = in_two_fields(part) ? field_of(word, kHighLsb, kHighBits) << part.field->bits : 0;
  return field_of(word, part.field->lsb, part.field->bits) | high;
}

// The threshold of pixels of more than 8 bits.
bool Control::in_two_fields(const RegisterPart& part) const {
  return build_.pixel_bits > spec::kPixelBits && part.in->address == spec::kRegMeasure && part.field != nullptr &&
         part.field->lsb == spec::kRegMeasureThresholdLsb;
}

bool Control::is_in_another(const RegisterPart& part) {
  return part.in->address == spec::kRegMeasure && part.field != nullptr && part.field->lsb == kHighLsb;
}

// The word with this value in this part of it.
std::uint32_t Control::word_with(std::uint32_t word, const RegisterPart& part, std::uint32_t value) const {
  if (part.field == nullptr) {
    return value;
  }
  if (is_in_another(part) && (value != 0 || build_.pixel_bits > spec::kPixelBits)) {
    throw UserError(uri(), build_.pixel_bits > spec::kPixelBits
                               ? "measure.threshold_high is part of measure.threshold, which holds all bits"
                               : "measure.threshold_high is 0 on this board, whose pixels have 8 bits");
  }
  const int bits = in_two_fields(part) ? build_.pixel_bits : part.field->bits;
  if ((std::uint64_t{value} >> bits) != 0) {
    throw UserError(uri(), std::string(part.in->name) + "." + std::string(part.field->name) + " cannot hold " +
                               std::to_string(value) + ": it has " + std::to_string(bits) + " bits");
  }
  std::uint32_t fields = part.field->mask();
  std::uint32_t parts = (value << part.field->lsb) & fields;
  if (in_two_fields(part)) {
    fields |= ((1U << kHighBits) - 1) << kHighLsb;
    parts |= value >> part.field->bits << kHighLsb;
  }
  return (word & ~fields) | parts;
}

void Control::write_word(const spec::Register& one, std::uint32_t value) {
  need(one);
  if (!one.writable) {
    throw UserError(uri(), "register " + std::string(one.name) + " can only be read");
  }
  if (one.address == spec::kRegWindow) {  // a board with fewer rows than these ignores their highest bit
    const auto last = std::max(field_of(value, spec::kRegWindowFirstLsb, spec::kRegWindowFirstBits),
                               field_of(value, spec::kRegWindowLastLsb, spec::kRegWindowLastBits));
    if (last > static_cast<std::uint32_t>(build_.max_rows)) {
      throw UserError(
          uri(), "window: " + std::to_string(last) + " is a row beyond the board's " + std::to_string(build_.max_rows));
    }
  }
  const Written written = port_->write(one.address, value);
  const std::uint32_t mask = one.address == spec::kRegSize ? ~0U : one.mask();  // bits that are not ignored
  if (written == Written::refused || (written == Written::unknown && port_->word(one.address) != (value & mask))) {
    throw UserError(uri(), "the board refuses " + hex(value) + " in register " + std::string(one.name));
  }
}

void Control::write(const RegisterPart& part, std::uint32_t value) {
  std::uint32_t whole = value;
  if (part.field != nullptr) {
    whole = word_with(part.in->fields.size() > 1 ? read({part.in, nullptr}) & part.in->mask() : 0, part, value);
  }
  write_word(*part.in, whole);
}

void Control::write_together(std::vector<std::pair<RegisterPart, std::uint32_t>> values) {
  std::stable_sort(values.begin(), values.end(), [](const auto& one, const auto& other) {
    const auto rank = [](const RegisterPart& part) {
      return part.in->address == spec::kRegControl ? ~0U : part.in->address;
    };
    return rank(one.first) < rank(other.first);
  });
  // One word a register, so that fields of one register change in one write.
  std::vector<std::pair<const spec::Register*, std::uint32_t>> words;
  for (const auto& [part, value] : values) {
    need(*part.in);
    if (!part.in->writable) {
      throw UserError(uri(), "register " + std::string(part.in->name) + " can only be read");
    }
    if (words.empty() || words.back().first != part.in) {
      words.emplace_back(part.in, read({part.in, nullptr}) & part.in->mask());
    }
    std::uint32_t& word_of = words.back().second;
    word_of = word_with(word_of, part, value);
  }
  const spec::Register& control = at(spec::kRegControl);
  const std::uint32_t before = port_->word(control.address) & control.mask();
  const bool settings = std::any_of(words.begin(), words.end(), [](const auto& one) { return one.first->setting; });
  if (settings) {
    write_word(control, before | 1U << spec::kRegControlHoldLsb);
  }
  try {
    for (const auto& [one, value] : words) {
      write_word(*one, value);
    }
  } catch (const UserError&) {
    if (settings) {
      write_word(control, before);
    }
    throw;
  }
  if (settings && (words.empty() || words.back().first != &control)) {
    write_word(control, before);
  }
}

void Control::need_columns(int columns) const {
  if (columns % build_.lanes != 0) {
    throw UserError(uri(), "this board takes " + std::to_string(build_.lanes) +
                               " pixels a clock: " + std::to_string(columns) + " columns are no multiple of them");
  }
}

void Control::set(const model::BoardSettings& settings) {
  const auto bit = [](bool set, int lsb) { return static_cast<std::uint32_t>(set ? 1U : 0U) << lsb; };
  const auto need_in_build = [&](bool wanted, bool there, const char* what) {
    if (wanted && !there) {
      throw UserError(uri(), std::string("this board ") + what);
    }
  };
  need_in_build(settings.codes, build_.codes, "has no Gray-code decoder");
  need_in_build(settings.region_row != 0 || settings.region_column != 0, build_.region,
                "has no register for the region of the sensor");
  need_columns(settings.columns);
  need_in_build(settings.threshold >> build_.pixel_bits != 0, false, "has no pixels as bright as the threshold");
  need_in_build(settings.compact, build_.compact, "has no compact columns");
  need_in_build(settings.verdict, build_.verdict_log_sections >= 0, "gives no verdicts");
  const std::uint32_t control =
      bit(settings.run, spec::kRegControlRunLsb) | bit(settings.image, spec::kRegControlImageLsb);
  write_word(at(spec::kRegControl), control | 1U << spec::kRegControlHoldLsb);
  for (const auto& [address, data] : model::setting_words(settings)) {
    const bool there = address == spec::kRegWindow   ? port_->word(spec::kRegWindow) != data  // not in boards of before
                       : address == spec::kRegRegion ? build_.region
                       : address == spec::kRegCompact ? build_.compact
                       : address == spec::kRegDecode  ? build_.codes
                                                      : true;
    if (there) {
      write_word(at(address), data);
    }
  }
  if (build_.verdict_log_sections >= 0) {
    set_verdict(settings);
  }
  write_word(at(spec::kRegControl), control | bit(settings.hold, spec::kRegControlHoldLsb));
}

void Control::set_verdict(const model::BoardSettings& settings) {
  need(at(spec::kRegVerdictControl));
  const spec::Register& control = at(spec::kRegVerdictControl);
  if (settings.verdict) {
    // What changes together is held together.
    write_word(control, port_->word(control.address) | 1U << spec::kRegVerdictControlHoldLsb);
    for (const auto& [address, data] : model::verdict_writes(settings.verdict_settings, settings.part_rule)) {
      write_word(at(address), data);
    }
  }
  write_word(control, model::verdict_control_word(settings.verdict, settings.verdict_hold,
                                                  settings.part_rule.by_encoder, settings.verdict_packets));
}

void Control::set_limits(int bank, std::span<const model::SectionLimits> sections) {
  need(at(spec::kRegVerdictTable));
  const int board_sections = 1 << build_.verdict_log_sections;
  if (static_cast<int>(sections.size()) > board_sections) {
    throw UserError(uri(), "the table has " + std::to_string(sections.size()) + " sections, but this board has " +
                               std::to_string(board_sections));
  }
  for (const model::SectionLimits& section : sections) {
    const auto wrong = std::ranges::find_if(section.limits, [](const model::ColumnLimits& limits) {
      return limits.low > limits.high || limits.high - limits.low > model::kMaxBand;
    });
    if (wrong != section.limits.end()) {
      throw UserError(uri(), "the limits of column " + std::to_string(wrong - section.limits.begin() + 1) +
                                 " are not in order, or 128 rows and more apart");
    }
  }
  for (const auto& [address, data] : model::limits_writes(bank, sections, build_.max_columns, board_sections)) {
    write_word(at(address), data);
  }
}

void Control::set_ejector(std::uint32_t delay, std::uint32_t length) {
  write_word(at(spec::kRegEjectorDelay), delay);
  write_word(at(spec::kRegEjectorLength), length);
}

void Control::count_patterns_on_frames(int patterns) {
  write_word(at(spec::kRegTriggerControl),
             1U << spec::kRegTriggerControlOnFrameLsb | static_cast<std::uint32_t>(patterns - 1)
                                                            << spec::kRegTriggerControlLastPatternLsb);
}

model::BoardState Control::state() {
  // The low word first: reading it holds the high one.
  const std::array<std::uint32_t, 2> clock{spec::kRegTimeLow, spec::kRegTimeHigh};
  const std::vector<std::uint32_t> time = port_->read(clock);
  const std::uint32_t verdict = build_.verdict_log_sections >= 0 ? port_->word(spec::kRegVerdictState) : 0;
  return {
      .frame_open = flag(port_->word(spec::kRegStatus), spec::kRegStatusFrameOpenLsb),
      .frames = port_->word(spec::kRegFrames),
      .broken = port_->word(spec::kRegBroken),
      .stray = port_->word(spec::kRegStray),
      .lost_moments = port_->word(spec::kRegLostMoments),
      .lost_image = port_->word(spec::kRegLostImage),
      .lost_codes = build_.codes ? port_->word(spec::kRegLostCodes) : 0,
      .abandoned = build_.codes ? port_->word(spec::kRegAbandoned) : 0,
      .time = time[0] | std::uint64_t{time[1]} << 32U,
      .encoder = port_->word(spec::kRegEncoder),
      .encoder_errors = static_cast<std::uint16_t>(port_->word(spec::kRegEncoderErrors)),
      .verdict_missed = static_cast<std::uint8_t>(
          field_of(verdict, spec::kRegVerdictStateMissedLsb, spec::kRegVerdictStateMissedBits)),
      .ejector_lost = static_cast<std::uint8_t>(
          field_of(verdict, spec::kRegVerdictStateEjectorLostLsb, spec::kRegVerdictStateEjectorLostBits)),
  };
}

std::string control_uri(const std::string& uri) {
  if (uri.starts_with("bar:") || uri.starts_with("litepcie:")) {
    return uri;
  }
  if (uri.starts_with("udp:")) {
    return uri.substr(0, uri.find(':', 4));  // a device's port is that of its packets
  }
  if (uri.starts_with("file:")) {
    const std::string path = registers_beside(uri.substr(5));
    return path.empty() ? "" : "bar:" + path;
  }
  return "";
}

std::unique_ptr<Control> open_control(const std::string& uri) {
  const std::string control = control_uri(uri);
  if (control.starts_with("bar:") && control.size() > 4) {
    return std::make_unique<Control>(make_bar_port(control.substr(4)));
  }
  if (uri.starts_with("udp:")) {
    return std::make_unique<Control>(make_etherbone_port(uri.substr(4)));
  }
  constexpr std::string_view kLitePcie = "litepcie:";
  if (uri.starts_with(kLitePcie) && uri.size() > kLitePcie.size()) {
    return std::make_unique<Control>(make_litepcie_port(uri.substr(kLitePcie.size())));
  }
  if (uri == "bar:" || uri == kLitePcie) {
    throw UserError(uri, "the path of the file is missing");
  }
  const bool device = uri.starts_with("ring:") || uri.starts_with("file:");
  throw UserError(uri, device ? "has no control of a board beside it; use bar:PATH, litepcie:PATH or udp:HOST"
                              : "is not the control of a board; use bar:PATH, litepcie:PATH or udp:HOST");
}

}  // namespace selfproj::driver
