// Generated from model/spec/selfproj.json by model/spec/generate.py; do not edit.
#ifndef SELFPROJ_SPEC_GENERATED_REGISTER_TABLE_H
#define SELFPROJ_SPEC_GENERATED_REGISTER_TABLE_H

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace selfproj::spec {

struct RegisterField {
  std::string_view name;
  int lsb = 0;
  int bits = 0;
  std::string_view description;

  // Its bits in the register's word.
  [[nodiscard]] constexpr std::uint32_t mask() const {
    return static_cast<std::uint32_t>(((std::uint64_t{1} << bits) - 1) << lsb);
  }
};

struct Register {
  std::string_view name;
  std::uint32_t address = 0;  // bytes
  bool writable = false;
  bool setting = false;  // takes effect at a frame start
  std::uint32_t reset = 0;
  std::string_view description;
  std::span<const RegisterField> fields;

  // The bits of all fields.
  [[nodiscard]] constexpr std::uint32_t mask() const {
    std::uint32_t bits = 0;
    for (const RegisterField& field : fields) {
      bits |= field.mask();
    }
    return bits;
  }
};

inline constexpr std::array<RegisterField, 1> kFieldsOfId{{
    {"id", 0, 32, "the letters SLFP, S in 7..0"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfVersion{{
    {"version", 0, 16, "the major number in 15..8, the minor one in 7..0"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfSpecHash{{
    {"hash", 0, 32, "its hash, the same as in every packet header"},
}};
inline constexpr std::array<RegisterField, 9> kFieldsOfCapability{{
    {"max_columns", 0, 12, "largest image width; 0: 4,096"},
    {"max_rows", 12, 10, "largest image height; 0: 2,047"},
    {"grey", 22, 1, "1: modes grey and grey_over are built in"},
    {"image", 23, 1, "1: raw-image packets are built in"},
    {"codes", 24, 1, "1: the Gray-code decoder is built in"},
    {"median", 25, 1, "1: the 3 x 3 median of its codes is built in"},
    {"runs", 26, 1, "1: the strongest run of a column is built in"},
    {"region", 27, 1, "1: the register region is built in"},
    {"code_bits", 28, 4, "largest number of code bits; 0 without the decoder"},
}};
inline constexpr std::array<RegisterField, 3> kFieldsOfControl{{
    {"run", 0, 1, "1: frame starts are accepted; 0: no new frame begins, an open one is taken to its end, other beats are discarded and not counted"},
    {"hold", 1, 1, "1: the settings in force stay in force; 0: the next frame start takes over all that was written, so that several settings change together"},
    {"image", 2, 1, "1: send raw-image packets too; refused in a build without them"},
}};
inline constexpr std::array<RegisterField, 2> kFieldsOfSize{{
    {"columns", 0, 13, "a multiple of the pixels in a beat, up to the build's maximum"},
    {"rows", 16, 11, "from 1 to the build's maximum"},
}};
inline constexpr std::array<RegisterField, 6> kFieldsOfMeasure{{
    {"threshold", 0, 8, "a pixel is lit where it is greater; bits 7..0 where pixels have more than 8"},
    {"mode", 8, 2, "0 binary, 1 grey, 2 grey_over; a binary build refuses all but 0"},
    {"select", 10, 1, "0 all, 1 strongest; a build without runs refuses 1"},
    {"gap", 12, 2, "dark rows that two lit pixels of one run may have between them; a build without runs refuses all but 0"},
    {"stream", 16, 8, "stream number, repeated in every packet header"},
    {"threshold_high", 24, 4, "bits 11..8 of the threshold in a build for pixels of more than 8 bits; what its pixels have not is refused; ignored where they have 8"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfTimeout{{
    {"clocks", 0, 24, "an open frame ends as incomplete after this many clocks without a beat; 0: never"},
}};
inline constexpr std::array<RegisterField, 3> kFieldsOfTriggerControl{{
    {"run", 0, 1, "1: the sequencer gives pulses, the first one four clocks later; 0: no pulses"},
    {"on_frame", 1, 1, "1, while run is 0: no pulses; the first frame that starts after this was written has pattern index 0, and every further frame the next one"},
    {"last_pattern", 16, 8, "number of patterns minus 1: the pattern index counts from 0 to this value and begins again at 0, with run and with on_frame"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfTriggerPeriod{{
    {"clocks", 0, 24, "pixel clocks from one projector pulse to the next; at least 1, 0 is refused"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfTriggerCamera{{
    {"clocks", 0, 24, "pixel clocks from the projector pulse to the camera pulse; below the period, else there is no camera pulse"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfTriggerWidth{{
    {"clocks", 0, 16, "pixel clocks that a pulse lasts; 0: no pulses; a pulse that lasts until the next one of its kind runs into it"},
}};
inline constexpr std::array<RegisterField, 6> kFieldsOfStatus{{
    {"frame_open", 0, 1, "1: a frame is being taken"},
    {"pending", 1, 1, "1: settings were written that no frame start has taken over yet; also after reset, until the first take-over"},
    {"lanes", 25, 2, "pixels in a beat, and columns in a group: 0: 4, 1: 8, 2: 16"},
    {"more_bits", 27, 3, "bits of a pixel, less 8"},
    {"verdict", 30, 1, "1: the registers verdict_… and ejector_… are built in"},
    {"compact", 31, 1, "1: the register compact is built in"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfFrames{{
    {"count", 0, 32, "since reset; the low word of the next sequence number"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfBroken{{
    {"count", 0, 32, "since reset; wraps"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfStray{{
    {"count", 0, 32, "since reset; wraps"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfLostMoments{{
    {"count", 0, 32, "since reset; wraps"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfLostImage{{
    {"count", 0, 32, "since reset; wraps"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfTimeLow{{
    {"low", 0, 32, "edges of the pixel clock after reset, less six"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfTimeHigh{{
    {"high", 0, 32, "the high word that the last read of time_low held"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfEncoder{{
    {"count", 0, 32, "quarter periods, rising where A leads B, in two's complement; wraps"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfEncoderErrors{{
    {"count", 0, 16, "times that A and B changed together; wraps"},
}};
inline constexpr std::array<RegisterField, 4> kFieldsOfDecode{{
    {"threshold", 0, 8, "a pixel of a pair is ambiguous where its two values differ by no more than this"},
    {"bits", 8, 4, "m, the code bits: from 1 to the build's maximum, else the write is refused"},
    {"codes", 16, 1, "1: decode and send code packets"},
    {"median", 17, 1, "1: send their 3 x 3 median; refused in a build without it"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfLostCodes{{
    {"count", 0, 32, "since reset; wraps"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfAbandoned{{
    {"count", 0, 32, "since reset; wraps"},
}};
inline constexpr std::array<RegisterField, 2> kFieldsOfWindow{{
    {"first", 0, 11, "first row that counts, from 1; 0: the first"},
    {"last", 16, 11, "last row that counts, from 1; 0: the last"},
}};
inline constexpr std::array<RegisterField, 2> kFieldsOfRegion{{
    {"row", 0, 16, "row of the sensor, from 1; 0: it is not said"},
    {"column", 16, 16, "column of the sensor, from 1; 0: it is not said"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfCompact{{
    {"on", 0, 1, "1: frames of modes grey and grey_over give packets of kind compact in place of kind moments; mode binary has words of 32 bits already, and keeps them"},
}};
inline constexpr std::array<RegisterField, 4> kFieldsOfVerdictControl{{
    {"on", 0, 1, "1: frames are judged; 0: they are not, and no part passes"},
    {"hold", 1, 1, "1: verdict_defect and verdict_shift in force stay in force; 0: the next part takes over what was written, so that both change together"},
    {"by_encoder", 2, 1, "1: parts begin and end by the encoder, 0: by light"},
    {"packets", 4, 2, "while on is 1: 0: packets as without a verdict; 1: with 16 bytes more, the verdict; 2: of kind verdict, without the columns; 3 is refused"},
}};
inline constexpr std::array<RegisterField, 7> kFieldsOfVerdictDefect{{
    {"width", 0, 8, "neighbouring columns of a defect, at least; 0 is refused"},
    {"history", 8, 3, "the frames that count for hits, less 1"},
    {"hits", 12, 4, "of these frames, those in which a column of a defect was out, at least; 0 is refused, and more than history + 1 make no defect possible"},
    {"above", 16, 1, "1: columns above their limits are out"},
    {"below", 17, 1, "1: columns below their limits are out"},
    {"bank", 18, 1, "bank of limits"},
    {"most_unlit", 20, 12, "judged columns that may lack light; 4095: light is not judged"},
}};
inline constexpr std::array<RegisterField, 2> kFieldsOfVerdictShift{{
    {"columns", 0, 8, "columns further right, in two's complement; -128 has no meaning"},
    {"rows", 16, 14, "1/128 rows, in two's complement, that are added to the centroids before they are compared: less than 0 for a part that lies further down; -8192 has no meaning"},
}};
inline constexpr std::array<RegisterField, 2> kFieldsOfVerdictLight{{
    {"lit", 0, 12, "lit columns of a frame that belongs to a part; 0 is refused"},
    {"dark_frames", 16, 8, "frames in a row with fewer after which a part has ended; 0 is refused"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfVerdictStart{{
    {"count", 0, 24, "count of the encoder, modulo 2^24"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfVerdictLength{{
    {"counts", 0, 24, "counts of the encoder; 0 is refused"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfVerdictPitch{{
    {"counts", 0, 24, "counts of the encoder, more than verdict_length; 0 is refused"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfEjectorDelay{{
    {"counts", 0, 23, "counts of the encoder; 0: at once"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfEjectorLength{{
    {"counts", 0, 16, "counts of the encoder; 0: no pulses"},
}};
inline constexpr std::array<RegisterField, 3> kFieldsOfVerdictTable{{
    {"column", 0, 12, "column, from 0"},
    {"section", 16, 6, "section of a part"},
    {"bank", 24, 1, "bank of limits"},
}};
inline constexpr std::array<RegisterField, 3> kFieldsOfVerdictLimits{{
    {"low", 0, 17, "least row of the centroid, in 1/128 rows, row 1 being 128"},
    {"band", 17, 14, "from there to the greatest row, likewise"},
    {"judged", 31, 1, "1: the column is judged"},
}};
inline constexpr std::array<RegisterField, 1> kFieldsOfVerdictBegin{{
    {"counts", 0, 24, "counts of the encoder behind the part's beginning"},
}};
inline constexpr std::array<RegisterField, 6> kFieldsOfVerdictState{{
    {"in_part", 0, 1, "1: a part passes"},
    {"bank", 1, 1, "bank of limits in force, of the last part"},
    {"log_sections", 4, 3, "log2 of the sections of a bank"},
    {"section", 8, 6, "section of the part, of the last part"},
    {"missed", 16, 8, "frames that came too soon to be judged and were lost, since reset; wraps"},
    {"ejector_lost", 24, 8, "pulses that had no place in the queue, since reset; wraps"},
}};
inline constexpr std::array<RegisterField, 2> kFieldsOfVerdictParts{{
    {"begun", 0, 16, "that have begun, since reset; wraps"},
    {"bad", 16, 16, "of which a frame had a defect or lacked light, since reset; wraps"},
}};

// In the order of their addresses.
inline constexpr std::array<Register, 42> kRegisters{{
    {"id", 0x00, false, false, 0x50464C53U, "marks a selfproj board", kFieldsOfId},
    {"version", 0x04, false, false, 0x00000200U, "version of the specification", kFieldsOfVersion},
    {"spec_hash", 0x08, false, false, 0x1A81A4C9U, "specification that the board was built from", kFieldsOfSpecHash},
    {"capability", 0x0C, false, false, 0x00000000U, "what this build can do", kFieldsOfCapability},
    {"control", 0x10, true, false, 0x00000000U, "starts and stops the board", kFieldsOfControl},
    {"size", 0x14, true, true, 0x00600200U, "image size; a size that the build cannot do is refused, and so is a word whose other bits are not 0; in a build smaller than 512 x 96 the reset value is limited to the build's maxima", kFieldsOfSize},
    {"measure", 0x18, true, true, 0x00000080U, "what the moments measure", kFieldsOfMeasure},
    {"timeout", 0x1C, true, false, 0x00E6B680U, "ends a frame whose beats stop coming", kFieldsOfTimeout},
    {"trigger_control", 0x20, true, false, 0x00000000U, "trigger sequencer and pattern index; while run or on_frame is 1, a write that does not clear both is refused", kFieldsOfTriggerControl},
    {"trigger_period", 0x24, true, false, 0x00003B10U, "period of the sequencer; refused while trigger_control.run is 1", kFieldsOfTriggerPeriod},
    {"trigger_camera", 0x28, true, false, 0x00000010U, "delay of the camera pulse; refused while trigger_control.run is 1", kFieldsOfTriggerCamera},
    {"trigger_width", 0x2C, true, false, 0x00000097U, "length of both pulses; refused while trigger_control.run is 1", kFieldsOfTriggerWidth},
    {"status", 0x30, false, false, 0x00000000U, "what the board is doing", kFieldsOfStatus},
    {"frames", 0x34, false, false, 0x00000000U, "accepted frame starts", kFieldsOfFrames},
    {"broken", 0x38, false, false, 0x00000000U, "frames that broke", kFieldsOfBroken},
    {"stray", 0x3C, false, false, 0x00000000U, "beats that belonged to no frame and were discarded while control.run was 1", kFieldsOfStray},
    {"lost_moments", 0x40, false, false, 0x00000000U, "moments packets lost", kFieldsOfLostMoments},
    {"lost_image", 0x44, false, false, 0x00000000U, "image packets lost", kFieldsOfLostImage},
    {"time_low", 0x48, false, false, 0x00000000U, "time, low word; reading it holds the high word", kFieldsOfTimeLow},
    {"time_high", 0x4C, false, false, 0x00000000U, "time, high word", kFieldsOfTimeHigh},
    {"encoder", 0x50, false, false, 0x00000000U, "position of the encoder", kFieldsOfEncoder},
    {"encoder_errors", 0x54, false, false, 0x00000000U, "steps of the encoder that were missed", kFieldsOfEncoderErrors},
    {"decode", 0x58, true, true, 0x00000805U, "Gray-code decoder; not there in a build without it; in a build of fewer than 8 code bits the reset value of bits is limited to them", kFieldsOfDecode},
    {"lost_codes", 0x5C, false, false, 0x00000000U, "code packets lost; not there in a build without the decoder", kFieldsOfLostCodes},
    {"abandoned", 0x60, false, false, 0x00000000U, "good frames after which the decoder waits for plane 0, because its memory was late or the frame came too soon after the one before; not there in a build without the decoder", kFieldsOfAbandoned},
    {"window", 0x64, true, true, 0x00000000U, "rows that count for the moments; pixels of other rows are dark for them; codes and images do not change; where no row of the frame counts, all columns are dark; a row above the build's max_rows is refused", kFieldsOfWindow},
    {"region", 0x68, true, true, 0x00000000U, "where on the sensor the camera's frames begin: only reported, in the header of each packet; not there in a build without it", kFieldsOfRegion},
    {"compact", 0x6C, true, true, 0x00000000U, "how a packet tells of its columns; not there in a build without compact columns", kFieldsOfCompact},
    {"verdict_control", 0x80, true, false, 0x00000000U, "verdicts; this register and the ones that follow are not there in a build without verdicts; on is refused before all registers from verdict_defect to ejector_length have been written", kFieldsOfVerdictControl},
    {"verdict_defect", 0x88, true, false, 0x00000000U, "what a defect is; taken over where a part begins", kFieldsOfVerdictDefect},
    {"verdict_shift", 0x8C, true, false, 0x00000000U, "where parts lie; taken over where a part begins", kFieldsOfVerdictShift},
    {"verdict_light", 0x90, true, false, 0x00000000U, "parts by light", kFieldsOfVerdictLight},
    {"verdict_start", 0x94, true, false, 0x00000000U, "parts by the encoder: where the first one begins", kFieldsOfVerdictStart},
    {"verdict_length", 0x98, true, false, 0x00000000U, "parts by the encoder: their length", kFieldsOfVerdictLength},
    {"verdict_pitch", 0x9C, true, false, 0x00000000U, "parts by the encoder: from one to the next", kFieldsOfVerdictPitch},
    {"ejector_delay", 0xA0, true, false, 0x00000000U, "from the first bad frame of a part to the pulse for the ejector", kFieldsOfEjectorDelay},
    {"ejector_length", 0xA4, true, false, 0x00000000U, "length of the pulse for the ejector", kFieldsOfEjectorLength},
    {"verdict_table", 0xA8, true, false, 0x00000000U, "where verdict_limits and verdict_begin write to; what the build does not have is refused", kFieldsOfVerdictTable},
    {"verdict_limits", 0xAC, true, false, 0x00000000U, "limits of the column that verdict_table names; while on is 1, refused for the bank that verdict_defect names, and for the bank in force while a part passes or settings are held; limits beyond the build's rows are refused", kFieldsOfVerdictLimits},
    {"verdict_begin", 0xB0, true, false, 0x00000000U, "where the section begins that verdict_table names; that of section 0 has no meaning; refused as verdict_limits", kFieldsOfVerdictBegin},
    {"verdict_state", 0xC0, false, false, 0x00000000U, "what the verdict is doing", kFieldsOfVerdictState},
    {"verdict_parts", 0xC4, false, false, 0x00000000U, "parts", kFieldsOfVerdictParts},
}};

// The registers of the link, for boards on the network.
inline constexpr std::uint32_t kLinkId = 0x100;  // ro
inline constexpr std::uint32_t kLinkIdReset = 0x4B4E4C53U;
inline constexpr int kLinkIdIdLsb = 0;
inline constexpr int kLinkIdIdBits = 32;
inline constexpr std::uint32_t kLinkTicket = 0x104;  // rw
inline constexpr int kLinkTicketNumberLsb = 0;
inline constexpr int kLinkTicketNumberBits = 32;
inline constexpr std::uint32_t kLinkAddress = 0x108;  // rw
inline constexpr int kLinkAddressBytesLsb = 0;
inline constexpr int kLinkAddressBytesBits = 9;
inline constexpr std::uint32_t kLinkValue = 0x10C;  // rw
inline constexpr int kLinkValueWordLsb = 0;
inline constexpr int kLinkValueWordBits = 32;
inline constexpr std::uint32_t kLinkAnswer = 0x110;  // ro
inline constexpr std::uint32_t kLinkAnswerReset = 0x00000000U;
inline constexpr int kLinkAnswerRefusedLsb = 0;
inline constexpr int kLinkAnswerRefusedBits = 1;
inline constexpr std::uint32_t kLinkSource = 0x114;  // rw
inline constexpr int kLinkSourceVideoLsb = 0;
inline constexpr int kLinkSourceVideoBits = 2;
inline constexpr std::uint32_t kLinkReplaySession = 0x118;  // rw
inline constexpr int kLinkReplaySessionNumberLsb = 0;
inline constexpr int kLinkReplaySessionNumberBits = 16;
inline constexpr std::uint32_t kLinkVideo = 0x11C;  // ro
inline constexpr std::uint32_t kLinkVideoReset = 0x00000000U;
inline constexpr int kLinkVideoReplayColumnsLsb = 0;
inline constexpr int kLinkVideoReplayColumnsBits = 12;
inline constexpr int kLinkVideoReplayRowsLsb = 16;
inline constexpr int kLinkVideoReplayRowsBits = 10;
inline constexpr int kLinkVideoSourcesLsb = 28;
inline constexpr int kLinkVideoSourcesBits = 4;
inline constexpr std::uint32_t kLinkReplayFrame = 0x120;  // ro
inline constexpr std::uint32_t kLinkReplayFrameReset = 0x00000000U;
inline constexpr int kLinkReplayFrameNumberLsb = 0;
inline constexpr int kLinkReplayFrameNumberBits = 32;
inline constexpr std::uint32_t kLinkReplayOffset = 0x124;  // ro
inline constexpr std::uint32_t kLinkReplayOffsetReset = 0x00000000U;
inline constexpr int kLinkReplayOffsetBytesLsb = 0;
inline constexpr int kLinkReplayOffsetBytesBits = 32;
inline constexpr std::uint32_t kLinkReplayFrames = 0x128;  // ro
inline constexpr std::uint32_t kLinkReplayFramesReset = 0x00000000U;
inline constexpr int kLinkReplayFramesCountLsb = 0;
inline constexpr int kLinkReplayFramesCountBits = 32;
inline constexpr std::uint32_t kLinkReplayDropped = 0x12C;  // ro
inline constexpr std::uint32_t kLinkReplayDroppedReset = 0x00000000U;
inline constexpr int kLinkReplayDroppedCountLsb = 0;
inline constexpr int kLinkReplayDroppedCountBits = 32;
inline constexpr std::uint32_t kLinkReplayIgnored = 0x130;  // ro
inline constexpr std::uint32_t kLinkReplayIgnoredReset = 0x00000000U;
inline constexpr int kLinkReplayIgnoredCountLsb = 0;
inline constexpr int kLinkReplayIgnoredCountBits = 32;

// Where the frames come from: values of the register source.
inline constexpr std::uint32_t kSourceCamera = 0;  // the camera of the build
inline constexpr std::uint32_t kSourceTestCamera = 1;  // the test camera
inline constexpr std::uint32_t kSourceReplay = 2;  // frames that the host sends
inline constexpr std::uint32_t kSourcePatterns = 3;  // Gray-code patterns that the test camera sees, one with each trigger of the camera

}  // namespace selfproj::spec

#endif  // SELFPROJ_SPEC_GENERATED_REGISTER_TABLE_H
