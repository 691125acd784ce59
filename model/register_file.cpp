#include "model/register_file.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/spec/generated/register_table.h"

namespace selfproj::model {
namespace {

constexpr std::uint32_t bits_of(std::uint32_t word, int lsb, int bits) {
  return static_cast<std::uint32_t>((word >> lsb) & ((std::uint64_t{1} << bits) - 1));
}

const spec::Register* register_at(std::uint32_t address) {
  const auto* const found = std::find_if(spec::kRegisters.begin(), spec::kRegisters.end(),
                                         [&](const spec::Register& one) { return one.address == address; });
  return found == spec::kRegisters.end() ? nullptr : &*found;
}

}  // namespace

bool has_register(const BoardBuild& build, std::uint32_t address) {
  const bool decoder = address == spec::kRegDecode || address == spec::kRegLostCodes || address == spec::kRegAbandoned;
  return register_at(address) != nullptr && (build.codes || !decoder) &&
         (build.region || address != spec::kRegRegion) && (build.compact || address != spec::kRegCompact) &&
         (build.verdict_log_sections >= 0 || address < spec::kRegVerdictControl);
}

namespace {

// The registers that have to be written before a verdict is switched on.
constexpr std::uint64_t words_between(std::uint32_t first, std::uint32_t last) {
  return (std::uint64_t{1} << (last / 4 + 1)) - (std::uint64_t{1} << first / 4);
}
// The greater limit in a word of verdict_limits.
std::uint32_t high_of(std::uint32_t word) {
  return bits_of(word, spec::kRegVerdictLimitsLowLsb, spec::kRegVerdictLimitsLowBits) +
         bits_of(word, spec::kRegVerdictLimitsBandLsb, spec::kRegVerdictLimitsBandBits);
}

// The upper bits of the threshold in a word of measure.
std::uint32_t high_threshold(std::uint32_t word) {
  return bits_of(word, spec::kRegMeasureThresholdHighLsb, spec::kRegMeasureThresholdHighBits);
}

constexpr std::uint64_t kNeeded = words_between(spec::kRegVerdictDefect, spec::kRegEjectorLength);

}  // namespace

RegisterFile::RegisterFile(const BoardBuild& build) : build_(build) {
  for (const spec::Register& one : spec::kRegisters) {
    if (one.writable && has_register(build, one.address)) {
      values_[one.address / 4] = one.reset;
    }
  }
  const std::uint32_t size = values_[spec::kRegSize / 4];
  const std::uint32_t columns = std::min(bits_of(size, spec::kRegSizeColumnsLsb, spec::kRegSizeColumnsBits),
                                         static_cast<std::uint32_t>(build.max_columns));
  const std::uint32_t rows = std::min(bits_of(size, spec::kRegSizeRowsLsb, spec::kRegSizeRowsBits),
                                      static_cast<std::uint32_t>(build.max_rows));
  values_[spec::kRegSize / 4] = columns << spec::kRegSizeColumnsLsb | rows << spec::kRegSizeRowsLsb;
  if (build.codes) {
    std::uint32_t& decode = values_[spec::kRegDecode / 4];
    const std::uint32_t code_bits = bits_of(decode, spec::kRegDecodeBitsLsb, spec::kRegDecodeBitsBits);
    const std::uint32_t most = std::min(code_bits, static_cast<std::uint32_t>(build.code_bits));
    decode = (decode & ~(code_bits << spec::kRegDecodeBitsLsb)) | most << spec::kRegDecodeBitsLsb;
  }
}

std::uint32_t RegisterFile::capability() const {
  const auto bit = [](bool set, int lsb) { return static_cast<std::uint32_t>(set ? 1U : 0U) << lsb; };
  constexpr int kColumns = 1 << spec::kRegCapabilityMaxColumnsBits;  // as 0
  return static_cast<std::uint32_t>(build_.max_columns % kColumns) << spec::kRegCapabilityMaxColumnsLsb |
         static_cast<std::uint32_t>(build_.max_rows > spec::kMaxRows ? 0 : build_.max_rows)
             << spec::kRegCapabilityMaxRowsLsb |
         bit(build_.grey, spec::kRegCapabilityGreyLsb) | bit(build_.image, spec::kRegCapabilityImageLsb) |
         bit(build_.codes, spec::kRegCapabilityCodesLsb) |
         bit(build_.codes && build_.median, spec::kRegCapabilityMedianLsb) |
         bit(build_.runs, spec::kRegCapabilityRunsLsb) | bit(build_.region, spec::kRegCapabilityRegionLsb) |
         static_cast<std::uint32_t>(build_.codes ? build_.code_bits : 0) << spec::kRegCapabilityCodeBitsLsb;
}

RegisterAnswer RegisterFile::read(std::uint32_t address, const BoardState& state) {
  if (!has_register(build_, address)) {
    return {.error = true, .data = 0};
  }
  const auto answer = [](std::uint32_t data) { return RegisterAnswer{.error = false, .data = data}; };
  switch (address) {
    case spec::kRegId:
      return answer(spec::kMagic);
    case spec::kRegVersion:
      return answer(spec::kVersion);
    case spec::kRegSpecHash:
      return answer(spec::kHash);
    case spec::kRegCapability:
      return answer(capability());
    case spec::kRegStatus:
      return answer(static_cast<std::uint32_t>(build_.lanes / (2 * spec::kPixelsPerBeat)) << spec::kRegStatusLanesLsb |
                    static_cast<std::uint32_t>(build_.pixel_bits - spec::kPixelBits) << spec::kRegStatusMoreBitsLsb |
                    static_cast<std::uint32_t>(build_.compact ? 1U : 0U) << spec::kRegStatusCompactLsb |
                    static_cast<std::uint32_t>(build_.verdict_log_sections >= 0 ? 1U : 0U)
                        << spec::kRegStatusVerdictLsb |
                    static_cast<std::uint32_t>(state.frame_open ? 1U : 0U) << spec::kRegStatusFrameOpenLsb |
                    static_cast<std::uint32_t>(pending_ ? 1U : 0U) << spec::kRegStatusPendingLsb);
    case spec::kRegFrames:
      return answer(state.frames);
    case spec::kRegBroken:
      return answer(state.broken);
    case spec::kRegStray:
      return answer(state.stray);
    case spec::kRegLostMoments:
      return answer(state.lost_moments);
    case spec::kRegLostImage:
      return answer(state.lost_image);
    case spec::kRegLostCodes:
      return answer(state.lost_codes);
    case spec::kRegAbandoned:
      return answer(state.abandoned);
    case spec::kRegTimeLow:
      time_high_ = static_cast<std::uint32_t>(state.time >> 32U);
      return answer(static_cast<std::uint32_t>(state.time));
    case spec::kRegTimeHigh:
      return answer(time_high_);
    case spec::kRegEncoder:
      return answer(state.encoder);
    case spec::kRegEncoderErrors:
      return answer(state.encoder_errors);
    case spec::kRegVerdictState:
      return answer(verdict_state(state));
    case spec::kRegVerdictParts:
      return answer(verdict_ == nullptr ? 0
                                        : (verdict_->parts() & 0xFFFF) << spec::kRegVerdictPartsBegunLsb |
                                              (verdict_->bad_parts() & 0xFFFF) << spec::kRegVerdictPartsBadLsb);
    default:
      return answer(values_[address / 4]);
  }
}

std::uint32_t RegisterFile::verdict_state(const BoardState& state) const {
  std::uint32_t word = static_cast<std::uint32_t>(build_.verdict_log_sections) << spec::kRegVerdictStateLogSectionsLsb |
                       std::uint32_t{state.verdict_missed} << spec::kRegVerdictStateMissedLsb |
                       std::uint32_t{state.ejector_lost} << spec::kRegVerdictStateEjectorLostLsb;
  if (verdict_ != nullptr) {
    word |= static_cast<std::uint32_t>(verdict_->in_part() ? 1U : 0U) << spec::kRegVerdictStateInPartLsb |
            static_cast<std::uint32_t>(verdict_->bank()) << spec::kRegVerdictStateBankLsb |
            static_cast<std::uint32_t>(verdict_->section()) << spec::kRegVerdictStateSectionLsb;
  }
  return word;
}

// Whether the bank that verdict_table names neither judges nor may judge next.
bool RegisterFile::bank_is_free() const {
  const std::uint32_t bank = field(spec::kRegVerdictTable, spec::kRegVerdictTableBankLsb, 1);
  const bool named = bank == field(spec::kRegVerdictDefect, spec::kRegVerdictDefectBankLsb, 1);
  // While settings are held, the next part keeps the bank in force.
  const bool held = field(spec::kRegVerdictControl, spec::kRegVerdictControlHoldLsb, 1) != 0;
  const bool judges =
      verdict_ != nullptr && (verdict_->in_part() || held) && bank == static_cast<std::uint32_t>(verdict_->bank());
  return field(spec::kRegVerdictControl, spec::kRegVerdictControlOnLsb, 1) == 0 || (!named && !judges);
}

bool RegisterFile::good_verdict(std::uint32_t address, std::uint32_t data) const {
  switch (address) {
    case spec::kRegVerdictControl:
      return bits_of(data, spec::kRegVerdictControlPacketsLsb, spec::kRegVerdictControlPacketsBits) != 3 &&
             (bits_of(data, spec::kRegVerdictControlOnLsb, 1) == 0 || (written_ & kNeeded) == kNeeded);
    case spec::kRegVerdictDefect:
      return bits_of(data, spec::kRegVerdictDefectWidthLsb, spec::kRegVerdictDefectWidthBits) != 0 &&
             bits_of(data, spec::kRegVerdictDefectHitsLsb, spec::kRegVerdictDefectHitsBits) != 0;
    case spec::kRegVerdictLight:
      return bits_of(data, spec::kRegVerdictLightLitLsb, spec::kRegVerdictLightLitBits) != 0 &&
             bits_of(data, spec::kRegVerdictLightDarkFramesLsb, spec::kRegVerdictLightDarkFramesBits) != 0;
    case spec::kRegVerdictLength:
    case spec::kRegVerdictPitch:
      return bits_of(data, 0, spec::kRegVerdictLengthCountsBits) != 0;
    case spec::kRegVerdictTable:
      return bits_of(data, spec::kRegVerdictTableColumnLsb, spec::kRegVerdictTableColumnBits) <
                 static_cast<std::uint32_t>(build_.max_columns) &&
             bits_of(data, spec::kRegVerdictTableSectionLsb, spec::kRegVerdictTableSectionBits) >>
                     build_.verdict_log_sections ==
                 0;
    case spec::kRegVerdictLimits:
      return bank_is_free() && high_of(data) >> (std::bit_width(static_cast<unsigned>(build_.max_rows)) + 7) == 0;
    case spec::kRegVerdictBegin:
      return bank_is_free();
    default:
      return true;
  }
}

void RegisterFile::write_limits(std::uint32_t address, std::uint32_t data) {
  const auto bank = static_cast<int>(field(spec::kRegVerdictTable, spec::kRegVerdictTableBankLsb, 1));
  const auto section = static_cast<int>(
      field(spec::kRegVerdictTable, spec::kRegVerdictTableSectionLsb, spec::kRegVerdictTableSectionBits));
  if (address == spec::kRegVerdictLimits) {
    const auto column = static_cast<int>(
        field(spec::kRegVerdictTable, spec::kRegVerdictTableColumnLsb, spec::kRegVerdictTableColumnBits));
    verdict_->write(bank, section, column,
                    {.low = bits_of(data, spec::kRegVerdictLimitsLowLsb, spec::kRegVerdictLimitsLowBits),
                     .high = high_of(data),
                     .judged = bits_of(data, spec::kRegVerdictLimitsJudgedLsb, 1) != 0});
  } else if (section > 0) {
    verdict_->begin_section(bank, section, bits_of(data, 0, spec::kRegVerdictBeginCountsBits));
  }
}

// Whether this build, in this state, can do the value.
bool RegisterFile::good(std::uint32_t address, std::uint32_t data) const {
  if (address >= spec::kRegVerdictControl) {
    return good_verdict(address, data);
  }
  const bool runs = field(spec::kRegTriggerControl, spec::kRegTriggerControlRunLsb, 1) != 0;
  const bool on_frame = field(spec::kRegTriggerControl, spec::kRegTriggerControlOnFrameLsb, 1) != 0;
  switch (address) {
    case spec::kRegControl:
      return build_.image || bits_of(data, spec::kRegControlImageLsb, 1) == 0;
    case spec::kRegSize: {
      // The bits above a field must be 0, so they count to it.
      const std::uint32_t columns = bits_of(data, 0, spec::kRegSizeRowsLsb);
      const std::uint32_t rows = data >> spec::kRegSizeRowsLsb;
      return columns != 0 && columns % static_cast<std::uint32_t>(build_.lanes) == 0 &&
             columns <= static_cast<std::uint32_t>(build_.max_columns) && rows != 0 &&
             rows <= static_cast<std::uint32_t>(build_.max_rows);
    }
    case spec::kRegMeasure: {
      const std::uint32_t mode = bits_of(data, spec::kRegMeasureModeLsb, spec::kRegMeasureModeBits);
      const bool plain = bits_of(data, spec::kRegMeasureSelectLsb, spec::kRegMeasureSelectBits) == spec::kSelectAll &&
                         bits_of(data, spec::kRegMeasureGapLsb, spec::kRegMeasureGapBits) == 0;
      return (mode == spec::kModeBinary || (build_.grey && mode <= spec::kModeGreyOver)) && (build_.runs || plain) &&
             (build_.pixel_bits == spec::kPixelBits ||
              high_threshold(data) >> (build_.pixel_bits - spec::kPixelBits) == 0);
    }
    case spec::kRegWindow: {
      const auto most = static_cast<std::uint32_t>(build_.max_rows);
      return bits_of(data, spec::kRegWindowFirstLsb, spec::kRegWindowFirstBits) <= most &&
             bits_of(data, spec::kRegWindowLastLsb, spec::kRegWindowLastBits) <= most;
    }
    case spec::kRegTriggerControl: {
      const bool starts = bits_of(data, spec::kRegTriggerControlRunLsb, 1) != 0 ||
                          bits_of(data, spec::kRegTriggerControlOnFrameLsb, 1) != 0;
      return !((runs || on_frame) && starts);
    }
    case spec::kRegTriggerPeriod:
      return !runs && bits_of(data, spec::kRegTriggerPeriodClocksLsb, spec::kRegTriggerPeriodClocksBits) != 0;
    case spec::kRegTriggerCamera:
    case spec::kRegTriggerWidth:
      return !runs;
    case spec::kRegDecode: {
      const std::uint32_t code_bits = bits_of(data, spec::kRegDecodeBitsLsb, spec::kRegDecodeBitsBits);
      return code_bits != 0 && code_bits <= static_cast<std::uint32_t>(build_.code_bits) &&
             (build_.median || bits_of(data, spec::kRegDecodeMedianLsb, 1) == 0);
    }
    default:
      return true;
  }
}

RegisterAnswer RegisterFile::write(std::uint32_t address, std::uint32_t data) {
  const spec::Register* const one = register_at(address);
  if (address == spec::kRegWindow && build_.max_rows <= spec::kMaxRows) {  // no such bits
    constexpr std::uint32_t kHighest = 1U << (spec::kRegWindowFirstBits - 1);
    data &= ~(kHighest << spec::kRegWindowFirstLsb | kHighest << spec::kRegWindowLastLsb);
  }
  if (!has_register(build_, address) || !one->writable || !good(address, data)) {
    return {.error = true, .data = 0};
  }
  const bool of_verdict = address >= spec::kRegVerdictControl;
  values_[address / 4] = of_verdict ? data : data & one->mask();
  if (address == spec::kRegMeasure && build_.pixel_bits == spec::kPixelBits) {
    values_[address / 4] &= ~(high_threshold(data) << spec::kRegMeasureThresholdHighLsb);  // no such field
  }
  written_ |= std::uint64_t{1} << address / 4;
  if (verdict_ != nullptr && (address == spec::kRegVerdictLimits || address == spec::kRegVerdictBegin)) {
    write_limits(address, data);
  }
  pending_ = pending_ || one->setting || address == spec::kRegControl;
  return {};
}

std::uint32_t RegisterFile::value(std::uint32_t address) const {
  return address / 4 < kWords ? values_[address / 4] : 0;
}

std::uint32_t RegisterFile::field(std::uint32_t address, int lsb, int bits) const {
  return bits_of(value(address), lsb, bits);
}

BoardSettings RegisterFile::settings() const {
  const auto number = [this](std::uint32_t address, int lsb, int bits) {
    return static_cast<int>(field(address, lsb, bits));
  };
  const bool verdict = field(spec::kRegVerdictControl, spec::kRegVerdictControlOnLsb, 1) != 0;
  return {
      .run = field(spec::kRegControl, spec::kRegControlRunLsb, 1) != 0,
      .hold = field(spec::kRegControl, spec::kRegControlHoldLsb, 1) != 0,
      .image = field(spec::kRegControl, spec::kRegControlImageLsb, 1) != 0,
      .columns = number(spec::kRegSize, spec::kRegSizeColumnsLsb, spec::kRegSizeColumnsBits),
      .rows = number(spec::kRegSize, spec::kRegSizeRowsLsb, spec::kRegSizeRowsBits),
      .mode = static_cast<Mode>(field(spec::kRegMeasure, spec::kRegMeasureModeLsb, spec::kRegMeasureModeBits)),
      .threshold =
          static_cast<int>(field(spec::kRegMeasure, spec::kRegMeasureThresholdLsb, spec::kRegMeasureThresholdBits) |
                           high_threshold(value(spec::kRegMeasure)) << spec::kRegMeasureThresholdBits),
      .select = static_cast<Select>(field(spec::kRegMeasure, spec::kRegMeasureSelectLsb, spec::kRegMeasureSelectBits)),
      .gap = number(spec::kRegMeasure, spec::kRegMeasureGapLsb, spec::kRegMeasureGapBits),
      .window = {.first = number(spec::kRegWindow, spec::kRegWindowFirstLsb, spec::kRegWindowFirstBits),
                 .last = number(spec::kRegWindow, spec::kRegWindowLastLsb, spec::kRegWindowLastBits)},
      .stream = number(spec::kRegMeasure, spec::kRegMeasureStreamLsb, spec::kRegMeasureStreamBits),
      .region_row = number(spec::kRegRegion, spec::kRegRegionRowLsb, spec::kRegRegionRowBits),
      .region_column = number(spec::kRegRegion, spec::kRegRegionColumnLsb, spec::kRegRegionColumnBits),
      .compact = field(spec::kRegCompact, spec::kRegCompactOnLsb, 1) != 0,
      .verdict = verdict,
      .verdict_packets =
          number(spec::kRegVerdictControl, spec::kRegVerdictControlPacketsLsb, spec::kRegVerdictControlPacketsBits),
      .verdict_hold = field(spec::kRegVerdictControl, spec::kRegVerdictControlHoldLsb, 1) != 0,
      .verdict_settings = verdict ? settings_of_words({.defect = value(spec::kRegVerdictDefect),
                                                       .shift = value(spec::kRegVerdictShift),
                                                       .light = value(spec::kRegVerdictLight)})
                                  : VerdictSettings{},
      .part_rule =
          !verdict
              ? PartRule{}
              : PartRule{.by_encoder = field(spec::kRegVerdictControl, spec::kRegVerdictControlByEncoderLsb, 1) != 0,
                         .lit = number(spec::kRegVerdictLight, spec::kRegVerdictLightLitLsb,
                                       spec::kRegVerdictLightLitBits),
                         .dark_frames = number(spec::kRegVerdictLight, spec::kRegVerdictLightDarkFramesLsb,
                                               spec::kRegVerdictLightDarkFramesBits),
                         .start = field(spec::kRegVerdictStart, 0, spec::kRegVerdictStartCountBits),
                         .length = field(spec::kRegVerdictLength, 0, spec::kRegVerdictLengthCountsBits),
                         .pitch = field(spec::kRegVerdictPitch, 0, spec::kRegVerdictPitchCountsBits)},
      .codes = field(spec::kRegDecode, spec::kRegDecodeCodesLsb, 1) != 0,
      .median = field(spec::kRegDecode, spec::kRegDecodeMedianLsb, 1) != 0,
      .code_bits = number(spec::kRegDecode, spec::kRegDecodeBitsLsb, spec::kRegDecodeBitsBits),
      .code_threshold = number(spec::kRegDecode, spec::kRegDecodeThresholdLsb, spec::kRegDecodeThresholdBits),
      .timeout = number(spec::kRegTimeout, spec::kRegTimeoutClocksLsb, spec::kRegTimeoutClocksBits),
  };
}

std::vector<RegisterWrite> setting_words(const BoardSettings& settings) {
  const auto bit = [](bool set, int lsb) { return static_cast<std::uint32_t>(set ? 1U : 0U) << lsb; };
  const auto number = [](int value, int lsb) { return static_cast<std::uint32_t>(value) << lsb; };
  return {{spec::kRegSize,
           number(settings.columns, spec::kRegSizeColumnsLsb) | number(settings.rows, spec::kRegSizeRowsLsb)},
          {spec::kRegMeasure,
           number(settings.threshold & 0xFF, spec::kRegMeasureThresholdLsb) |
               number(settings.threshold >> spec::kRegMeasureThresholdBits, spec::kRegMeasureThresholdHighLsb) |
               number(static_cast<int>(settings.mode), spec::kRegMeasureModeLsb) |
               number(static_cast<int>(settings.select), spec::kRegMeasureSelectLsb) |
               number(settings.gap, spec::kRegMeasureGapLsb) | number(settings.stream, spec::kRegMeasureStreamLsb)},
          {spec::kRegWindow, number(settings.window.first, spec::kRegWindowFirstLsb) |
                                 number(settings.window.last, spec::kRegWindowLastLsb)},
          {spec::kRegTimeout, number(settings.timeout, spec::kRegTimeoutClocksLsb)},
          {spec::kRegRegion, number(settings.region_row, spec::kRegRegionRowLsb) |
                                 number(settings.region_column, spec::kRegRegionColumnLsb)},
          {spec::kRegCompact, bit(settings.compact, spec::kRegCompactOnLsb)},
          {spec::kRegDecode, number(settings.code_threshold, spec::kRegDecodeThresholdLsb) |
                                 number(settings.code_bits, spec::kRegDecodeBitsLsb) |
                                 bit(settings.codes, spec::kRegDecodeCodesLsb) |
                                 bit(settings.median, spec::kRegDecodeMedianLsb)}};
}

std::vector<RegisterWrite> setting_writes(const BoardSettings& settings, const BoardSettings& before, bool decodes) {
  const auto bit = [](bool set, int lsb) { return static_cast<std::uint32_t>(set ? 1U : 0U) << lsb; };
  const std::uint32_t control =
      bit(settings.run, spec::kRegControlRunLsb) | bit(settings.image, spec::kRegControlImageLsb);
  std::vector<RegisterWrite> writes{{spec::kRegControl, control | bit(true, spec::kRegControlHoldLsb)}};
  const std::vector<RegisterWrite> words = setting_words(settings);
  const std::vector<RegisterWrite> words_before = setting_words(before);
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::uint32_t address = words[i].address;
    const bool in_some = address == spec::kRegRegion || address == spec::kRegCompact;
    if (address == spec::kRegDecode ? decodes : !in_some || words[i].data != words_before[i].data) {
      writes.push_back(words[i]);
    }
  }
  if (settings.verdict || before.verdict) {
    const std::vector<RegisterWrite> verdict = verdict_writes(settings.verdict_settings, settings.part_rule);
    writes.insert(writes.end(), verdict.begin(), verdict.end());
    writes.push_back(
        {spec::kRegVerdictControl, verdict_control_word(settings.verdict, settings.verdict_hold,
                                                        settings.part_rule.by_encoder, settings.verdict_packets)});
  }
  writes.push_back({spec::kRegControl, control | bit(settings.hold, spec::kRegControlHoldLsb)});
  return writes;
}

}  // namespace selfproj::model
