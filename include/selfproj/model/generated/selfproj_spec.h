// Generated from model/spec/selfproj.json by model/spec/generate.py; do not edit.
#ifndef SELFPROJ_SPEC_GENERATED_SELFPROJ_SPEC_H
#define SELFPROJ_SPEC_GENERATED_SELFPROJ_SPEC_H

#include <array>
#include <cstddef>
#include <cstdint>

namespace selfproj {
namespace spec {

constexpr std::uint32_t kHash = 0x1A81A4C9U;
constexpr std::uint16_t kVersion = 0x0200;

// Earlier versions: their packets differ only in the header, whose bytes from `reserved_byte` on were 0. With
// `control` their registers are those of this version, but for what `capability` says.
struct EarlierVersion {
  std::uint32_t hash;
  std::uint16_t version;
  std::size_t reserved_byte;
  bool control;
};
constexpr std::array<EarlierVersion, 2> kEarlierVersions{{
    {0x08691C00U, 0x0100, 53, false},  // no rows that count, no gap, no strongest run: the fields from select on were 0
    {0xA3603834U, 0x0101, 59, true},  // no region of the sensor: frames were whole, or their place was not known
}};

// Sizes
constexpr int kPixelBits = 8;  // bits of a pixel
constexpr int kPixelsPerBeat = 4;  // pixels that come in one clock; the number of columns is a multiple of it
constexpr int kMaxColumns = 2048;  // largest image width of a build, unless it is given another
constexpr int kColumnLimit = 4096;  // largest image width that a build can have
constexpr int kMaxRows = 1023;  // largest image height of a build, unless it is given another
constexpr int kRowLimit = 2047;  // largest image height that a build can have; pixels of more than 10 bits: max_rows
constexpr int kPacketBeatBytes = 16;  // width of the packet stream; the length of every packet is a multiple of it

// Modes of the moments
constexpr std::uint8_t kModeBinary = 0;  // a lit pixel weighs 1
constexpr std::uint8_t kModeGrey = 1;  // a lit pixel weighs its value
constexpr std::uint8_t kModeGreyOver = 2;  // a lit pixel weighs its value minus the threshold

// What of a column the moments are taken of
constexpr std::uint8_t kSelectAll = 0;  // the moments of all lit pixels of the column
constexpr std::uint8_t kSelectStrongest = 1;  // the moments of the strongest run of the column

// Kinds of packet
constexpr std::uint8_t kKindMoments = 1;  // column moments, one packet per frame
constexpr std::uint8_t kKindCodes = 2;  // code image, one packet per line
constexpr std::uint8_t kKindImage = 3;  // raw image, one packet per line
constexpr std::uint8_t kKindCompact = 4;  // columns divided in the circuit, one packet per frame in place of kind moments
constexpr std::uint8_t kKindVerdict = 5;  // the verdict of a frame, one packet per frame in place of kinds moments and compact

// Payload words; the largest value that can occur fits its field
constexpr int kBinaryWordBits = 32;
constexpr int kBinaryM1Lsb = 0;
constexpr int kBinaryM1Bits = 20;
constexpr std::uint64_t kBinaryM1Max = 523776;  // rows*(rows+1)/2
static_assert(kBinaryM1Max >> kBinaryM1Bits == 0, "binary.m1 does not fit");
constexpr int kBinaryM0Lsb = 20;
constexpr int kBinaryM0Bits = 12;
constexpr std::uint64_t kBinaryM0Max = 1023;  // rows
static_assert(kBinaryM0Max >> kBinaryM0Bits == 0, "binary.m0 does not fit");
constexpr int kGreyWordBits = 64;
constexpr int kGreyM1Lsb = 0;
constexpr int kGreyM1Bits = 27;
constexpr std::uint64_t kGreyM1Max = 133562880;  // pixel*rows*(rows+1)/2
static_assert(kGreyM1Max >> kGreyM1Bits == 0, "grey.m1 does not fit");
constexpr int kGreyM0Lsb = 27;
constexpr int kGreyM0Bits = 18;
constexpr std::uint64_t kGreyM0Max = 260865;  // pixel*rows
static_assert(kGreyM0Max >> kGreyM0Bits == 0, "grey.m0 does not fit");
constexpr int kGreyNLsb = 45;
constexpr int kGreyNBits = 10;
constexpr std::uint64_t kGreyNMax = 1023;  // rows
static_assert(kGreyNMax >> kGreyNBits == 0, "grey.n does not fit");
constexpr int kBinaryRunWordBits = 32;
constexpr int kBinaryRunM1Lsb = 0;
constexpr int kBinaryRunM1Bits = 19;
constexpr std::uint64_t kBinaryRunM1Max = 523776;  // rows*(rows+1)/2
static_assert(kBinaryRunM1Max >> kBinaryRunM1Bits == 0, "binary_run.m1 does not fit");
constexpr int kBinaryRunSecondLsb = 19;
constexpr int kBinaryRunSecondBits = 1;
constexpr std::uint64_t kBinaryRunSecondMax = 1;  // 1
static_assert(kBinaryRunSecondMax >> kBinaryRunSecondBits == 0, "binary_run.second does not fit");
constexpr int kBinaryRunM0Lsb = 20;
constexpr int kBinaryRunM0Bits = 10;
constexpr std::uint64_t kBinaryRunM0Max = 1023;  // rows
static_assert(kBinaryRunM0Max >> kBinaryRunM0Bits == 0, "binary_run.m0 does not fit");
constexpr int kBinaryRunRunsLsb = 30;
constexpr int kBinaryRunRunsBits = 2;
constexpr std::uint64_t kBinaryRunRunsMax = 3;  // 3
static_assert(kBinaryRunRunsMax >> kBinaryRunRunsBits == 0, "binary_run.runs does not fit");
constexpr int kGreyRunWordBits = 64;
constexpr int kGreyRunM1Lsb = 0;
constexpr int kGreyRunM1Bits = 27;
constexpr std::uint64_t kGreyRunM1Max = 133562880;  // pixel*rows*(rows+1)/2
static_assert(kGreyRunM1Max >> kGreyRunM1Bits == 0, "grey_run.m1 does not fit");
constexpr int kGreyRunM0Lsb = 27;
constexpr int kGreyRunM0Bits = 18;
constexpr std::uint64_t kGreyRunM0Max = 260865;  // pixel*rows
static_assert(kGreyRunM0Max >> kGreyRunM0Bits == 0, "grey_run.m0 does not fit");
constexpr int kGreyRunNLsb = 45;
constexpr int kGreyRunNBits = 10;
constexpr std::uint64_t kGreyRunNMax = 1023;  // rows
static_assert(kGreyRunNMax >> kGreyRunNBits == 0, "grey_run.n does not fit");
constexpr int kGreyRunRunsLsb = 55;
constexpr int kGreyRunRunsBits = 2;
constexpr std::uint64_t kGreyRunRunsMax = 3;  // 3
static_assert(kGreyRunRunsMax >> kGreyRunRunsBits == 0, "grey_run.runs does not fit");
constexpr int kGreyRunSecondLsb = 57;
constexpr int kGreyRunSecondBits = 5;
constexpr std::uint64_t kGreyRunSecondMax = 16;  // 16
static_assert(kGreyRunSecondMax >> kGreyRunSecondBits == 0, "grey_run.second does not fit");
constexpr int kCodeWordBits = 16;
constexpr int kCodeCodeLsb = 0;
constexpr int kCodeCodeBits = 12;
constexpr std::uint64_t kCodeCodeMax = 4095;  // 4095
static_assert(kCodeCodeMax >> kCodeCodeBits == 0, "code.code does not fit");
constexpr int kCodeMeasurableLsb = 15;
constexpr int kCodeMeasurableBits = 1;
constexpr std::uint64_t kCodeMeasurableMax = 1;  // 1
static_assert(kCodeMeasurableMax >> kCodeMeasurableBits == 0, "code.measurable does not fit");
constexpr int kTallBinaryWordBits = 32;
constexpr int kTallBinaryM1Lsb = 0;
constexpr int kTallBinaryM1Bits = 21;
constexpr std::uint64_t kTallBinaryM1Max = 2096128;  // rows*(rows+1)/2
static_assert(kTallBinaryM1Max >> kTallBinaryM1Bits == 0, "tall_binary.m1 does not fit");
constexpr int kTallBinaryM0Lsb = 21;
constexpr int kTallBinaryM0Bits = 11;
constexpr std::uint64_t kTallBinaryM0Max = 2047;  // rows
static_assert(kTallBinaryM0Max >> kTallBinaryM0Bits == 0, "tall_binary.m0 does not fit");
constexpr int kWideGreyWordBits = 64;
constexpr int kWideGreyM1Lsb = 0;
constexpr int kWideGreyM1Bits = 31;
constexpr std::uint64_t kWideGreyM1Max = 2144862720;  // pixel*rows*(rows+1)/2
static_assert(kWideGreyM1Max >> kWideGreyM1Bits == 0, "wide_grey.m1 does not fit");
constexpr int kWideGreyM0Lsb = 31;
constexpr int kWideGreyM0Bits = 22;
constexpr std::uint64_t kWideGreyM0Max = 4189185;  // pixel*rows
static_assert(kWideGreyM0Max >> kWideGreyM0Bits == 0, "wide_grey.m0 does not fit");
constexpr int kWideGreyNLsb = 53;
constexpr int kWideGreyNBits = 11;
constexpr std::uint64_t kWideGreyNMax = 1023;  // rows
static_assert(kWideGreyNMax >> kWideGreyNBits == 0, "wide_grey.n does not fit");
constexpr int kWideGreyRunWordBits = 64;
constexpr int kWideGreyRunM1Lsb = 0;
constexpr int kWideGreyRunM1Bits = 31;
constexpr std::uint64_t kWideGreyRunM1Max = 2144862720;  // pixel*rows*(rows+1)/2
static_assert(kWideGreyRunM1Max >> kWideGreyRunM1Bits == 0, "wide_grey_run.m1 does not fit");
constexpr int kWideGreyRunM0Lsb = 31;
constexpr int kWideGreyRunM0Bits = 22;
constexpr std::uint64_t kWideGreyRunM0Max = 4189185;  // pixel*rows
static_assert(kWideGreyRunM0Max >> kWideGreyRunM0Bits == 0, "wide_grey_run.m0 does not fit");
constexpr int kWideGreyRunNLsb = 53;
constexpr int kWideGreyRunNBits = 6;
constexpr std::uint64_t kWideGreyRunNMax = 63;  // 63
static_assert(kWideGreyRunNMax >> kWideGreyRunNBits == 0, "wide_grey_run.n does not fit");
constexpr int kWideGreyRunSecondLsb = 59;
constexpr int kWideGreyRunSecondBits = 5;
constexpr std::uint64_t kWideGreyRunSecondMax = 16;  // 16
static_assert(kWideGreyRunSecondMax >> kWideGreyRunSecondBits == 0, "wide_grey_run.second does not fit");
constexpr int kTallGreyWordBits = 64;
constexpr int kTallGreyM1Lsb = 0;
constexpr int kTallGreyM1Bits = 31;
constexpr std::uint64_t kTallGreyM1Max = 2144338944;  // pixel*rows*(rows+1)/2
static_assert(kTallGreyM1Max >> kTallGreyM1Bits == 0, "tall_grey.m1 does not fit");
constexpr int kTallGreyM0Lsb = 31;
constexpr int kTallGreyM0Bits = 22;
constexpr std::uint64_t kTallGreyM0Max = 2094081;  // pixel*rows
static_assert(kTallGreyM0Max >> kTallGreyM0Bits == 0, "tall_grey.m0 does not fit");
constexpr int kTallGreyNLsb = 53;
constexpr int kTallGreyNBits = 11;
constexpr std::uint64_t kTallGreyNMax = 2047;  // rows
static_assert(kTallGreyNMax >> kTallGreyNBits == 0, "tall_grey.n does not fit");
constexpr int kHeaderPixelWordBits = 8;
constexpr int kHeaderPixelThresholdHighLsb = 0;
constexpr int kHeaderPixelThresholdHighBits = 4;
constexpr std::uint64_t kHeaderPixelThresholdHighMax = 15;  // 15
static_assert(kHeaderPixelThresholdHighMax >> kHeaderPixelThresholdHighBits == 0, "header_pixel.threshold_high does not fit");
constexpr int kHeaderPixelMoreBitsLsb = 4;
constexpr int kHeaderPixelMoreBitsBits = 3;
constexpr std::uint64_t kHeaderPixelMoreBitsMax = 4;  // 4
static_assert(kHeaderPixelMoreBitsMax >> kHeaderPixelMoreBitsBits == 0, "header_pixel.more_bits does not fit");
constexpr int kHeaderPixelTallLsb = 7;
constexpr int kHeaderPixelTallBits = 1;
constexpr std::uint64_t kHeaderPixelTallMax = 1;  // 1
static_assert(kHeaderPixelTallMax >> kHeaderPixelTallBits == 0, "header_pixel.tall does not fit");
constexpr int kCompactWordBits = 32;
constexpr int kCompactCentroidLsb = 0;
constexpr int kCompactCentroidBits = 20;
constexpr std::uint64_t kCompactCentroidMax = 523776;  // 512*rows
static_assert(kCompactCentroidMax >> kCompactCentroidBits == 0, "compact.centroid does not fit");
constexpr int kCompactNLsb = 20;
constexpr int kCompactNBits = 6;
constexpr std::uint64_t kCompactNMax = 63;  // 63
static_assert(kCompactNMax >> kCompactNBits == 0, "compact.n does not fit");
constexpr int kCompactQualityLsb = 26;
constexpr int kCompactQualityBits = 6;
constexpr std::uint64_t kCompactQualityMax = 63;  // 63
static_assert(kCompactQualityMax >> kCompactQualityBits == 0, "compact.quality does not fit");
constexpr int kVerdictWordBits = 128;
constexpr int kVerdictFirstColumnLsb = 0;
constexpr int kVerdictFirstColumnBits = 13;
constexpr std::uint64_t kVerdictFirstColumnMax = 4096;  // 4096
static_assert(kVerdictFirstColumnMax >> kVerdictFirstColumnBits == 0, "verdict.first_column does not fit");
constexpr int kVerdictColumnsLsb = 16;
constexpr int kVerdictColumnsBits = 13;
constexpr std::uint64_t kVerdictColumnsMax = 4096;  // 4096
static_assert(kVerdictColumnsMax >> kVerdictColumnsBits == 0, "verdict.columns does not fit");
constexpr int kVerdictUnlitLsb = 32;
constexpr int kVerdictUnlitBits = 13;
constexpr std::uint64_t kVerdictUnlitMax = 4096;  // 4096
static_assert(kVerdictUnlitMax >> kVerdictUnlitBits == 0, "verdict.unlit does not fit");
constexpr int kVerdictJudgedLsb = 72;
constexpr int kVerdictJudgedBits = 1;
constexpr std::uint64_t kVerdictJudgedMax = 1;  // 1
static_assert(kVerdictJudgedMax >> kVerdictJudgedBits == 0, "verdict.judged does not fit");
constexpr int kVerdictInPartLsb = 73;
constexpr int kVerdictInPartBits = 1;
constexpr std::uint64_t kVerdictInPartMax = 1;  // 1
static_assert(kVerdictInPartMax >> kVerdictInPartBits == 0, "verdict.in_part does not fit");
constexpr int kVerdictDefectLsb = 74;
constexpr int kVerdictDefectBits = 1;
constexpr std::uint64_t kVerdictDefectMax = 1;  // 1
static_assert(kVerdictDefectMax >> kVerdictDefectBits == 0, "verdict.defect does not fit");
constexpr int kVerdictLacksLightLsb = 75;
constexpr int kVerdictLacksLightBits = 1;
constexpr std::uint64_t kVerdictLacksLightMax = 1;  // 1
static_assert(kVerdictLacksLightMax >> kVerdictLacksLightBits == 0, "verdict.lacks_light does not fit");
constexpr int kVerdictBankLsb = 76;
constexpr int kVerdictBankBits = 1;
constexpr std::uint64_t kVerdictBankMax = 1;  // 1
static_assert(kVerdictBankMax >> kVerdictBankBits == 0, "verdict.bank does not fit");
constexpr int kVerdictSectionLsb = 80;
constexpr int kVerdictSectionBits = 6;
constexpr std::uint64_t kVerdictSectionMax = 63;  // 63
static_assert(kVerdictSectionMax >> kVerdictSectionBits == 0, "verdict.section does not fit");
constexpr int kVerdictPartLsb = 96;
constexpr int kVerdictPartBits = 16;
constexpr std::uint64_t kVerdictPartMax = 65535;  // 65535
static_assert(kVerdictPartMax >> kVerdictPartBits == 0, "verdict.part does not fit");

// Packet: byte offsets
constexpr std::uint32_t kMagic = 0x50464C53U;  // "SLFP"
constexpr std::size_t kHeaderBytes = 64;
constexpr std::size_t kTrailerBytes = 16;
constexpr std::size_t kHeaderMagic = 0;  // 32 bits
constexpr std::size_t kHeaderSpecHash = 4;  // 32 bits
constexpr std::size_t kHeaderVersion = 8;  // 16 bits
constexpr std::size_t kHeaderKind = 10;  // 8 bits
constexpr std::size_t kHeaderStream = 11;  // 8 bits
constexpr std::size_t kHeaderPattern = 12;  // 16 bits
constexpr std::size_t kHeaderMode = 14;  // 8 bits
constexpr std::size_t kHeaderThreshold = 15;  // 8 bits
constexpr std::size_t kHeaderSequence = 16;  // 64 bits
constexpr std::size_t kHeaderTimeStamp = 24;  // 64 bits
constexpr std::size_t kHeaderEncoder = 32;  // 32 bits
constexpr std::size_t kHeaderLost = 36;  // 32 bits
constexpr std::size_t kHeaderColumns = 40;  // 16 bits
constexpr std::size_t kHeaderRows = 42;  // 16 bits
constexpr std::size_t kHeaderPayloadSize = 44;  // 32 bits
constexpr std::size_t kHeaderFirstLine = 48;  // 16 bits
constexpr std::size_t kHeaderLines = 50;  // 16 bits
constexpr std::size_t kHeaderFlags = 52;  // 8 bits
constexpr std::size_t kHeaderSelect = 53;  // 8 bits
constexpr std::size_t kHeaderFirstRow = 54;  // 16 bits
constexpr std::size_t kHeaderLastRow = 56;  // 16 bits
constexpr std::size_t kHeaderGap = 58;  // 8 bits
constexpr std::size_t kHeaderPixel = 59;  // 8 bits
constexpr std::size_t kHeaderRegionRow = 60;  // 16 bits
constexpr std::size_t kHeaderRegionColumn = 62;  // 16 bits
constexpr std::size_t kTrailerSequence = 0;  // 64 bits
constexpr std::size_t kTrailerStatus = 8;  // 32 bits
constexpr std::size_t kTrailerCheck = 12;  // 32 bits

// Header flags and trailer status bits
constexpr std::uint8_t kFlagStrayBefore = 1U << 0;  // beats that belonged to no frame were discarded before this frame
constexpr std::uint8_t kFlagVerdict = 1U << 1;  // the payload ends with 16 bytes more, the verdict of the frame
constexpr std::uint32_t kStatusShortLine = 1U << 0;  // a line ended before its last column
constexpr std::uint32_t kStatusLongLine = 1U << 1;  // a line went on after its last column
constexpr std::uint32_t kStatusStartInFrame = 1U << 2;  // the next frame started before this one was complete
constexpr std::uint32_t kStatusLateMemory = 1U << 3;  // the memory of the Gray-code decoder answered too late
constexpr std::uint32_t kStatusIncomplete = 1U << 4;  // no beat came for the time set in the register timeout

// Check word
constexpr std::uint32_t kCheckInit = 0xFFFFFFFFU;
constexpr std::uint32_t kCheckPolynomial = 0x04C11DB7U;

// Registers: byte addresses, reset values, fields. docs/register-reference.md says what they do.
constexpr std::uint32_t kRegId = 0x00;  // ro
constexpr std::uint32_t kRegIdReset = 0x50464C53U;
constexpr int kRegIdIdLsb = 0;
constexpr int kRegIdIdBits = 32;
constexpr std::uint32_t kRegVersion = 0x04;  // ro
constexpr std::uint32_t kRegVersionReset = 0x00000200U;
constexpr int kRegVersionVersionLsb = 0;
constexpr int kRegVersionVersionBits = 16;
constexpr std::uint32_t kRegSpecHash = 0x08;  // ro
constexpr std::uint32_t kRegSpecHashReset = 0x1A81A4C9U;
constexpr int kRegSpecHashHashLsb = 0;
constexpr int kRegSpecHashHashBits = 32;
constexpr std::uint32_t kRegCapability = 0x0C;  // ro
constexpr std::uint32_t kRegCapabilityReset = 0x00000000U;
constexpr int kRegCapabilityMaxColumnsLsb = 0;
constexpr int kRegCapabilityMaxColumnsBits = 12;
constexpr int kRegCapabilityMaxRowsLsb = 12;
constexpr int kRegCapabilityMaxRowsBits = 10;
constexpr int kRegCapabilityGreyLsb = 22;
constexpr int kRegCapabilityGreyBits = 1;
constexpr int kRegCapabilityImageLsb = 23;
constexpr int kRegCapabilityImageBits = 1;
constexpr int kRegCapabilityCodesLsb = 24;
constexpr int kRegCapabilityCodesBits = 1;
constexpr int kRegCapabilityMedianLsb = 25;
constexpr int kRegCapabilityMedianBits = 1;
constexpr int kRegCapabilityRunsLsb = 26;
constexpr int kRegCapabilityRunsBits = 1;
constexpr int kRegCapabilityRegionLsb = 27;
constexpr int kRegCapabilityRegionBits = 1;
constexpr int kRegCapabilityCodeBitsLsb = 28;
constexpr int kRegCapabilityCodeBitsBits = 4;
constexpr std::uint32_t kRegControl = 0x10;  // rw
constexpr std::uint32_t kRegControlReset = 0x00000000U;
constexpr int kRegControlRunLsb = 0;
constexpr int kRegControlRunBits = 1;
constexpr int kRegControlHoldLsb = 1;
constexpr int kRegControlHoldBits = 1;
constexpr int kRegControlImageLsb = 2;
constexpr int kRegControlImageBits = 1;
constexpr std::uint32_t kRegSize = 0x14;  // rw
constexpr std::uint32_t kRegSizeReset = 0x00600200U;
constexpr int kRegSizeColumnsLsb = 0;
constexpr int kRegSizeColumnsBits = 13;
constexpr int kRegSizeRowsLsb = 16;
constexpr int kRegSizeRowsBits = 11;
constexpr std::uint32_t kRegMeasure = 0x18;  // rw
constexpr std::uint32_t kRegMeasureReset = 0x00000080U;
constexpr int kRegMeasureThresholdLsb = 0;
constexpr int kRegMeasureThresholdBits = 8;
constexpr int kRegMeasureModeLsb = 8;
constexpr int kRegMeasureModeBits = 2;
constexpr int kRegMeasureSelectLsb = 10;
constexpr int kRegMeasureSelectBits = 1;
constexpr int kRegMeasureGapLsb = 12;
constexpr int kRegMeasureGapBits = 2;
constexpr int kRegMeasureStreamLsb = 16;
constexpr int kRegMeasureStreamBits = 8;
constexpr int kRegMeasureThresholdHighLsb = 24;
constexpr int kRegMeasureThresholdHighBits = 4;
constexpr std::uint32_t kRegTimeout = 0x1C;  // rw
constexpr std::uint32_t kRegTimeoutReset = 0x00E6B680U;
constexpr int kRegTimeoutClocksLsb = 0;
constexpr int kRegTimeoutClocksBits = 24;
constexpr std::uint32_t kRegTriggerControl = 0x20;  // rw
constexpr std::uint32_t kRegTriggerControlReset = 0x00000000U;
constexpr int kRegTriggerControlRunLsb = 0;
constexpr int kRegTriggerControlRunBits = 1;
constexpr int kRegTriggerControlOnFrameLsb = 1;
constexpr int kRegTriggerControlOnFrameBits = 1;
constexpr int kRegTriggerControlLastPatternLsb = 16;
constexpr int kRegTriggerControlLastPatternBits = 8;
constexpr std::uint32_t kRegTriggerPeriod = 0x24;  // rw
constexpr std::uint32_t kRegTriggerPeriodReset = 0x00003B10U;
constexpr int kRegTriggerPeriodClocksLsb = 0;
constexpr int kRegTriggerPeriodClocksBits = 24;
constexpr std::uint32_t kRegTriggerCamera = 0x28;  // rw
constexpr std::uint32_t kRegTriggerCameraReset = 0x00000010U;
constexpr int kRegTriggerCameraClocksLsb = 0;
constexpr int kRegTriggerCameraClocksBits = 24;
constexpr std::uint32_t kRegTriggerWidth = 0x2C;  // rw
constexpr std::uint32_t kRegTriggerWidthReset = 0x00000097U;
constexpr int kRegTriggerWidthClocksLsb = 0;
constexpr int kRegTriggerWidthClocksBits = 16;
constexpr std::uint32_t kRegStatus = 0x30;  // ro
constexpr std::uint32_t kRegStatusReset = 0x00000000U;
constexpr int kRegStatusFrameOpenLsb = 0;
constexpr int kRegStatusFrameOpenBits = 1;
constexpr int kRegStatusPendingLsb = 1;
constexpr int kRegStatusPendingBits = 1;
constexpr int kRegStatusLanesLsb = 25;
constexpr int kRegStatusLanesBits = 2;
constexpr int kRegStatusMoreBitsLsb = 27;
constexpr int kRegStatusMoreBitsBits = 3;
constexpr int kRegStatusVerdictLsb = 30;
constexpr int kRegStatusVerdictBits = 1;
constexpr int kRegStatusCompactLsb = 31;
constexpr int kRegStatusCompactBits = 1;
constexpr std::uint32_t kRegFrames = 0x34;  // ro
constexpr std::uint32_t kRegFramesReset = 0x00000000U;
constexpr int kRegFramesCountLsb = 0;
constexpr int kRegFramesCountBits = 32;
constexpr std::uint32_t kRegBroken = 0x38;  // ro
constexpr std::uint32_t kRegBrokenReset = 0x00000000U;
constexpr int kRegBrokenCountLsb = 0;
constexpr int kRegBrokenCountBits = 32;
constexpr std::uint32_t kRegStray = 0x3C;  // ro
constexpr std::uint32_t kRegStrayReset = 0x00000000U;
constexpr int kRegStrayCountLsb = 0;
constexpr int kRegStrayCountBits = 32;
constexpr std::uint32_t kRegLostMoments = 0x40;  // ro
constexpr std::uint32_t kRegLostMomentsReset = 0x00000000U;
constexpr int kRegLostMomentsCountLsb = 0;
constexpr int kRegLostMomentsCountBits = 32;
constexpr std::uint32_t kRegLostImage = 0x44;  // ro
constexpr std::uint32_t kRegLostImageReset = 0x00000000U;
constexpr int kRegLostImageCountLsb = 0;
constexpr int kRegLostImageCountBits = 32;
constexpr std::uint32_t kRegTimeLow = 0x48;  // ro
constexpr std::uint32_t kRegTimeLowReset = 0x00000000U;
constexpr int kRegTimeLowLowLsb = 0;
constexpr int kRegTimeLowLowBits = 32;
constexpr std::uint32_t kRegTimeHigh = 0x4C;  // ro
constexpr std::uint32_t kRegTimeHighReset = 0x00000000U;
constexpr int kRegTimeHighHighLsb = 0;
constexpr int kRegTimeHighHighBits = 32;
constexpr std::uint32_t kRegEncoder = 0x50;  // ro
constexpr std::uint32_t kRegEncoderReset = 0x00000000U;
constexpr int kRegEncoderCountLsb = 0;
constexpr int kRegEncoderCountBits = 32;
constexpr std::uint32_t kRegEncoderErrors = 0x54;  // ro
constexpr std::uint32_t kRegEncoderErrorsReset = 0x00000000U;
constexpr int kRegEncoderErrorsCountLsb = 0;
constexpr int kRegEncoderErrorsCountBits = 16;
constexpr std::uint32_t kRegDecode = 0x58;  // rw
constexpr std::uint32_t kRegDecodeReset = 0x00000805U;
constexpr int kRegDecodeThresholdLsb = 0;
constexpr int kRegDecodeThresholdBits = 8;
constexpr int kRegDecodeBitsLsb = 8;
constexpr int kRegDecodeBitsBits = 4;
constexpr int kRegDecodeCodesLsb = 16;
constexpr int kRegDecodeCodesBits = 1;
constexpr int kRegDecodeMedianLsb = 17;
constexpr int kRegDecodeMedianBits = 1;
constexpr std::uint32_t kRegLostCodes = 0x5C;  // ro
constexpr std::uint32_t kRegLostCodesReset = 0x00000000U;
constexpr int kRegLostCodesCountLsb = 0;
constexpr int kRegLostCodesCountBits = 32;
constexpr std::uint32_t kRegAbandoned = 0x60;  // ro
constexpr std::uint32_t kRegAbandonedReset = 0x00000000U;
constexpr int kRegAbandonedCountLsb = 0;
constexpr int kRegAbandonedCountBits = 32;
constexpr std::uint32_t kRegWindow = 0x64;  // rw
constexpr std::uint32_t kRegWindowReset = 0x00000000U;
constexpr int kRegWindowFirstLsb = 0;
constexpr int kRegWindowFirstBits = 11;
constexpr int kRegWindowLastLsb = 16;
constexpr int kRegWindowLastBits = 11;
constexpr std::uint32_t kRegRegion = 0x68;  // rw
constexpr std::uint32_t kRegRegionReset = 0x00000000U;
constexpr int kRegRegionRowLsb = 0;
constexpr int kRegRegionRowBits = 16;
constexpr int kRegRegionColumnLsb = 16;
constexpr int kRegRegionColumnBits = 16;
constexpr std::uint32_t kRegCompact = 0x6C;  // rw
constexpr std::uint32_t kRegCompactReset = 0x00000000U;
constexpr int kRegCompactOnLsb = 0;
constexpr int kRegCompactOnBits = 1;
constexpr std::uint32_t kRegVerdictControl = 0x80;  // rw
constexpr std::uint32_t kRegVerdictControlReset = 0x00000000U;
constexpr int kRegVerdictControlOnLsb = 0;
constexpr int kRegVerdictControlOnBits = 1;
constexpr int kRegVerdictControlHoldLsb = 1;
constexpr int kRegVerdictControlHoldBits = 1;
constexpr int kRegVerdictControlByEncoderLsb = 2;
constexpr int kRegVerdictControlByEncoderBits = 1;
constexpr int kRegVerdictControlPacketsLsb = 4;
constexpr int kRegVerdictControlPacketsBits = 2;
constexpr std::uint32_t kRegVerdictDefect = 0x88;  // rw
constexpr std::uint32_t kRegVerdictDefectReset = 0x00000000U;
constexpr int kRegVerdictDefectWidthLsb = 0;
constexpr int kRegVerdictDefectWidthBits = 8;
constexpr int kRegVerdictDefectHistoryLsb = 8;
constexpr int kRegVerdictDefectHistoryBits = 3;
constexpr int kRegVerdictDefectHitsLsb = 12;
constexpr int kRegVerdictDefectHitsBits = 4;
constexpr int kRegVerdictDefectAboveLsb = 16;
constexpr int kRegVerdictDefectAboveBits = 1;
constexpr int kRegVerdictDefectBelowLsb = 17;
constexpr int kRegVerdictDefectBelowBits = 1;
constexpr int kRegVerdictDefectBankLsb = 18;
constexpr int kRegVerdictDefectBankBits = 1;
constexpr int kRegVerdictDefectMostUnlitLsb = 20;
constexpr int kRegVerdictDefectMostUnlitBits = 12;
constexpr std::uint32_t kRegVerdictShift = 0x8C;  // rw
constexpr std::uint32_t kRegVerdictShiftReset = 0x00000000U;
constexpr int kRegVerdictShiftColumnsLsb = 0;
constexpr int kRegVerdictShiftColumnsBits = 8;
constexpr int kRegVerdictShiftRowsLsb = 16;
constexpr int kRegVerdictShiftRowsBits = 14;
constexpr std::uint32_t kRegVerdictLight = 0x90;  // rw
constexpr std::uint32_t kRegVerdictLightReset = 0x00000000U;
constexpr int kRegVerdictLightLitLsb = 0;
constexpr int kRegVerdictLightLitBits = 12;
constexpr int kRegVerdictLightDarkFramesLsb = 16;
constexpr int kRegVerdictLightDarkFramesBits = 8;
constexpr std::uint32_t kRegVerdictStart = 0x94;  // rw
constexpr std::uint32_t kRegVerdictStartReset = 0x00000000U;
constexpr int kRegVerdictStartCountLsb = 0;
constexpr int kRegVerdictStartCountBits = 24;
constexpr std::uint32_t kRegVerdictLength = 0x98;  // rw
constexpr std::uint32_t kRegVerdictLengthReset = 0x00000000U;
constexpr int kRegVerdictLengthCountsLsb = 0;
constexpr int kRegVerdictLengthCountsBits = 24;
constexpr std::uint32_t kRegVerdictPitch = 0x9C;  // rw
constexpr std::uint32_t kRegVerdictPitchReset = 0x00000000U;
constexpr int kRegVerdictPitchCountsLsb = 0;
constexpr int kRegVerdictPitchCountsBits = 24;
constexpr std::uint32_t kRegEjectorDelay = 0xA0;  // rw
constexpr std::uint32_t kRegEjectorDelayReset = 0x00000000U;
constexpr int kRegEjectorDelayCountsLsb = 0;
constexpr int kRegEjectorDelayCountsBits = 23;
constexpr std::uint32_t kRegEjectorLength = 0xA4;  // rw
constexpr std::uint32_t kRegEjectorLengthReset = 0x00000000U;
constexpr int kRegEjectorLengthCountsLsb = 0;
constexpr int kRegEjectorLengthCountsBits = 16;
constexpr std::uint32_t kRegVerdictTable = 0xA8;  // rw
constexpr std::uint32_t kRegVerdictTableReset = 0x00000000U;
constexpr int kRegVerdictTableColumnLsb = 0;
constexpr int kRegVerdictTableColumnBits = 12;
constexpr int kRegVerdictTableSectionLsb = 16;
constexpr int kRegVerdictTableSectionBits = 6;
constexpr int kRegVerdictTableBankLsb = 24;
constexpr int kRegVerdictTableBankBits = 1;
constexpr std::uint32_t kRegVerdictLimits = 0xAC;  // rw
constexpr std::uint32_t kRegVerdictLimitsReset = 0x00000000U;
constexpr int kRegVerdictLimitsLowLsb = 0;
constexpr int kRegVerdictLimitsLowBits = 17;
constexpr int kRegVerdictLimitsBandLsb = 17;
constexpr int kRegVerdictLimitsBandBits = 14;
constexpr int kRegVerdictLimitsJudgedLsb = 31;
constexpr int kRegVerdictLimitsJudgedBits = 1;
constexpr std::uint32_t kRegVerdictBegin = 0xB0;  // rw
constexpr std::uint32_t kRegVerdictBeginReset = 0x00000000U;
constexpr int kRegVerdictBeginCountsLsb = 0;
constexpr int kRegVerdictBeginCountsBits = 24;
constexpr std::uint32_t kRegVerdictState = 0xC0;  // ro
constexpr std::uint32_t kRegVerdictStateReset = 0x00000000U;
constexpr int kRegVerdictStateInPartLsb = 0;
constexpr int kRegVerdictStateInPartBits = 1;
constexpr int kRegVerdictStateBankLsb = 1;
constexpr int kRegVerdictStateBankBits = 1;
constexpr int kRegVerdictStateLogSectionsLsb = 4;
constexpr int kRegVerdictStateLogSectionsBits = 3;
constexpr int kRegVerdictStateSectionLsb = 8;
constexpr int kRegVerdictStateSectionBits = 6;
constexpr int kRegVerdictStateMissedLsb = 16;
constexpr int kRegVerdictStateMissedBits = 8;
constexpr int kRegVerdictStateEjectorLostLsb = 24;
constexpr int kRegVerdictStateEjectorLostBits = 8;
constexpr std::uint32_t kRegVerdictParts = 0xC4;  // ro
constexpr std::uint32_t kRegVerdictPartsReset = 0x00000000U;
constexpr int kRegVerdictPartsBegunLsb = 0;
constexpr int kRegVerdictPartsBegunBits = 16;
constexpr int kRegVerdictPartsBadLsb = 16;
constexpr int kRegVerdictPartsBadBits = 16;

}  // namespace spec
}  // namespace selfproj

#endif  // SELFPROJ_SPEC_GENERATED_SELFPROJ_SPEC_H
