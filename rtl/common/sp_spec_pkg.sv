// Generated from model/spec/selfproj.json by model/spec/generate.py; do not edit.
// Refer to its names as sp_spec_pkg::Name; the one package of the project.
// verilator lint_off UNUSEDPARAM
package sp_spec_pkg;

  localparam logic [31:0] SpecHash = 32'h1A81A4C9;
  localparam logic [15:0] SpecVersion = 16'h0200;

  localparam int PixelBits = 8;
  localparam int PixelsPerBeat = 4;
  localparam int MaxColumns = 2048;
  localparam int MaxRows = 1023;
  localparam int PacketBeatBytes = 16;

  localparam logic [1:0] ModeBinary = 2'd0;
  localparam logic [1:0] ModeGrey = 2'd1;
  localparam logic [1:0] ModeGreyOver = 2'd2;
  localparam int ModeBits = 2;
  localparam logic [0:0] SelectAll = 1'd0;
  localparam logic [0:0] SelectStrongest = 1'd1;
  localparam int SelectBits = 1;
  localparam logic [7:0] KindMoments = 8'd1;
  localparam logic [7:0] KindCodes = 8'd2;
  localparam logic [7:0] KindImage = 8'd3;
  localparam logic [7:0] KindCompact = 8'd4;

  localparam int BinaryWordBits = 32;
  localparam int BinaryM1Lsb = 0;
  localparam int BinaryM1Bits = 20;
  localparam int BinaryM0Lsb = 20;
  localparam int BinaryM0Bits = 12;
  localparam int GreyWordBits = 64;
  localparam int GreyM1Lsb = 0;
  localparam int GreyM1Bits = 27;
  localparam int GreyM0Lsb = 27;
  localparam int GreyM0Bits = 18;
  localparam int GreyNLsb = 45;
  localparam int GreyNBits = 10;
  localparam int BinaryRunWordBits = 32;
  localparam int BinaryRunM1Lsb = 0;
  localparam int BinaryRunM1Bits = 19;
  localparam int BinaryRunSecondLsb = 19;
  localparam int BinaryRunSecondBits = 1;
  localparam int BinaryRunM0Lsb = 20;
  localparam int BinaryRunM0Bits = 10;
  localparam int BinaryRunRunsLsb = 30;
  localparam int BinaryRunRunsBits = 2;
  localparam int GreyRunWordBits = 64;
  localparam int GreyRunM1Lsb = 0;
  localparam int GreyRunM1Bits = 27;
  localparam int GreyRunM0Lsb = 27;
  localparam int GreyRunM0Bits = 18;
  localparam int GreyRunNLsb = 45;
  localparam int GreyRunNBits = 10;
  localparam int GreyRunRunsLsb = 55;
  localparam int GreyRunRunsBits = 2;
  localparam int GreyRunSecondLsb = 57;
  localparam int GreyRunSecondBits = 5;
  localparam int CodeWordBits = 16;
  localparam int CodeCodeLsb = 0;
  localparam int CodeCodeBits = 12;
  localparam int CodeMeasurableLsb = 15;
  localparam int CodeMeasurableBits = 1;
  localparam int CompactWordBits = 32;
  localparam int CompactCentroidLsb = 0;
  localparam int CompactCentroidBits = 20;
  localparam int CompactNLsb = 20;
  localparam int CompactNBits = 6;
  localparam int CompactQualityLsb = 26;
  localparam int CompactQualityBits = 6;

  localparam logic [31:0] Magic = 32'h50464C53;
  localparam int HeaderBytes = 64;
  localparam int TrailerBytes = 16;
  localparam int HeaderBits = 512;
  localparam int PacketBeatBits = 128;
  localparam int HeaderMagicLsb = 0;
  localparam int HeaderMagicBits = 32;
  localparam int HeaderSpecHashLsb = 32;
  localparam int HeaderSpecHashBits = 32;
  localparam int HeaderVersionLsb = 64;
  localparam int HeaderVersionBits = 16;
  localparam int HeaderKindLsb = 80;
  localparam int HeaderKindBits = 8;
  localparam int HeaderStreamLsb = 88;
  localparam int HeaderStreamBits = 8;
  localparam int HeaderPatternLsb = 96;
  localparam int HeaderPatternBits = 16;
  localparam int HeaderModeLsb = 112;
  localparam int HeaderModeBits = 8;
  localparam int HeaderThresholdLsb = 120;
  localparam int HeaderThresholdBits = 8;
  localparam int HeaderSequenceLsb = 128;
  localparam int HeaderSequenceBits = 64;
  localparam int HeaderTimeStampLsb = 192;
  localparam int HeaderTimeStampBits = 64;
  localparam int HeaderEncoderLsb = 256;
  localparam int HeaderEncoderBits = 32;
  localparam int HeaderLostLsb = 288;
  localparam int HeaderLostBits = 32;
  localparam int HeaderColumnsLsb = 320;
  localparam int HeaderColumnsBits = 16;
  localparam int HeaderRowsLsb = 336;
  localparam int HeaderRowsBits = 16;
  localparam int HeaderPayloadSizeLsb = 352;
  localparam int HeaderPayloadSizeBits = 32;
  localparam int HeaderFirstLineLsb = 384;
  localparam int HeaderFirstLineBits = 16;
  localparam int HeaderLinesLsb = 400;
  localparam int HeaderLinesBits = 16;
  localparam int HeaderFlagsLsb = 416;
  localparam int HeaderFlagsBits = 8;
  localparam int HeaderSelectLsb = 424;
  localparam int HeaderSelectBits = 8;
  localparam int HeaderFirstRowLsb = 432;
  localparam int HeaderFirstRowBits = 16;
  localparam int HeaderLastRowLsb = 448;
  localparam int HeaderLastRowBits = 16;
  localparam int HeaderGapLsb = 464;
  localparam int HeaderGapBits = 8;
  localparam int HeaderReservedLsb = 472;
  localparam int HeaderReservedBits = 8;
  localparam int HeaderRegionRowLsb = 480;
  localparam int HeaderRegionRowBits = 16;
  localparam int HeaderRegionColumnLsb = 496;
  localparam int HeaderRegionColumnBits = 16;
  localparam int TrailerSequenceLsb = 0;
  localparam int TrailerSequenceBits = 64;
  localparam int TrailerStatusLsb = 64;
  localparam int TrailerStatusBits = 32;
  localparam int TrailerCheckLsb = 96;
  localparam int TrailerCheckBits = 32;

  localparam int FlagStrayBeforeBit = 0;
  localparam int FlagBits = 1;
  localparam int StatusShortLineBit = 0;
  localparam int StatusLongLineBit = 1;
  localparam int StatusStartInFrameBit = 2;
  localparam int StatusLateMemoryBit = 3;
  localparam int StatusIncompleteBit = 4;
  localparam int StatusBits = 5;

  localparam logic [31:0] CheckInit = 32'hFFFFFFFF;
  localparam logic [31:0] CheckPolynomial = 32'h04C11DB7;

  localparam logic [15:0] DatagramMagic = 16'h4C53;
  localparam int DatagramHeaderBytes = 16;
  localparam int DatagramMagicLsb = 0;
  localparam int DatagramMagicBits = 16;
  localparam int DatagramSessionLsb = 16;
  localparam int DatagramSessionBits = 16;
  localparam int DatagramSequenceLsb = 32;
  localparam int DatagramSequenceBits = 32;
  localparam int DatagramPacketLsb = 64;
  localparam int DatagramPacketBits = 32;
  localparam int DatagramOffsetLsb = 96;
  localparam int DatagramOffsetBits = 16;
  localparam int DatagramLengthLsb = 112;
  localparam int DatagramLengthBits = 16;

  localparam logic [7:0] RegId = 8'h00;
  localparam int RegIdIdLsb = 0;
  localparam int RegIdIdBits = 32;
  localparam logic [7:0] RegVersion = 8'h04;
  localparam int RegVersionVersionLsb = 0;
  localparam int RegVersionVersionBits = 16;
  localparam logic [7:0] RegSpecHash = 8'h08;
  localparam int RegSpecHashHashLsb = 0;
  localparam int RegSpecHashHashBits = 32;
  localparam logic [7:0] RegCapability = 8'h0C;
  localparam int RegCapabilityMaxColumnsLsb = 0;
  localparam int RegCapabilityMaxColumnsBits = 12;
  localparam int RegCapabilityMaxRowsLsb = 12;
  localparam int RegCapabilityMaxRowsBits = 10;
  localparam int RegCapabilityGreyLsb = 22;
  localparam int RegCapabilityGreyBits = 1;
  localparam int RegCapabilityImageLsb = 23;
  localparam int RegCapabilityImageBits = 1;
  localparam int RegCapabilityCodesLsb = 24;
  localparam int RegCapabilityCodesBits = 1;
  localparam int RegCapabilityMedianLsb = 25;
  localparam int RegCapabilityMedianBits = 1;
  localparam int RegCapabilityRunsLsb = 26;
  localparam int RegCapabilityRunsBits = 1;
  localparam int RegCapabilityRegionLsb = 27;
  localparam int RegCapabilityRegionBits = 1;
  localparam int RegCapabilityCodeBitsLsb = 28;
  localparam int RegCapabilityCodeBitsBits = 4;
  localparam logic [7:0] RegControl = 8'h10;
  localparam logic [31:0] RegControlReset = 32'h00000000;
  localparam int RegControlRunLsb = 0;
  localparam int RegControlRunBits = 1;
  localparam int RegControlHoldLsb = 1;
  localparam int RegControlHoldBits = 1;
  localparam int RegControlImageLsb = 2;
  localparam int RegControlImageBits = 1;
  localparam logic [7:0] RegSize = 8'h14;
  localparam logic [31:0] RegSizeReset = 32'h00600200;
  localparam int RegSizeColumnsLsb = 0;
  localparam int RegSizeColumnsBits = 12;
  localparam int RegSizeRowsLsb = 16;
  localparam int RegSizeRowsBits = 10;
  localparam logic [7:0] RegMeasure = 8'h18;
  localparam logic [31:0] RegMeasureReset = 32'h00000080;
  localparam int RegMeasureThresholdLsb = 0;
  localparam int RegMeasureThresholdBits = 8;
  localparam int RegMeasureModeLsb = 8;
  localparam int RegMeasureModeBits = 2;
  localparam int RegMeasureSelectLsb = 10;
  localparam int RegMeasureSelectBits = 1;
  localparam int RegMeasureGapLsb = 12;
  localparam int RegMeasureGapBits = 2;
  localparam int RegMeasureStreamLsb = 16;
  localparam int RegMeasureStreamBits = 8;
  localparam logic [7:0] RegTimeout = 8'h1C;
  localparam logic [31:0] RegTimeoutReset = 32'h00E6B680;
  localparam int RegTimeoutClocksLsb = 0;
  localparam int RegTimeoutClocksBits = 24;
  localparam logic [7:0] RegTriggerControl = 8'h20;
  localparam logic [31:0] RegTriggerControlReset = 32'h00000000;
  localparam int RegTriggerControlRunLsb = 0;
  localparam int RegTriggerControlRunBits = 1;
  localparam int RegTriggerControlOnFrameLsb = 1;
  localparam int RegTriggerControlOnFrameBits = 1;
  localparam int RegTriggerControlLastPatternLsb = 16;
  localparam int RegTriggerControlLastPatternBits = 8;
  localparam logic [7:0] RegTriggerPeriod = 8'h24;
  localparam logic [31:0] RegTriggerPeriodReset = 32'h00003B10;
  localparam int RegTriggerPeriodClocksLsb = 0;
  localparam int RegTriggerPeriodClocksBits = 24;
  localparam logic [7:0] RegTriggerCamera = 8'h28;
  localparam logic [31:0] RegTriggerCameraReset = 32'h00000010;
  localparam int RegTriggerCameraClocksLsb = 0;
  localparam int RegTriggerCameraClocksBits = 24;
  localparam logic [7:0] RegTriggerWidth = 8'h2C;
  localparam logic [31:0] RegTriggerWidthReset = 32'h00000097;
  localparam int RegTriggerWidthClocksLsb = 0;
  localparam int RegTriggerWidthClocksBits = 16;
  localparam logic [7:0] RegStatus = 8'h30;
  localparam int RegStatusFrameOpenLsb = 0;
  localparam int RegStatusFrameOpenBits = 1;
  localparam int RegStatusPendingLsb = 1;
  localparam int RegStatusPendingBits = 1;
  localparam int RegStatusCompactLsb = 31;
  localparam int RegStatusCompactBits = 1;
  localparam logic [7:0] RegFrames = 8'h34;
  localparam int RegFramesCountLsb = 0;
  localparam int RegFramesCountBits = 32;
  localparam logic [7:0] RegBroken = 8'h38;
  localparam int RegBrokenCountLsb = 0;
  localparam int RegBrokenCountBits = 32;
  localparam logic [7:0] RegStray = 8'h3C;
  localparam int RegStrayCountLsb = 0;
  localparam int RegStrayCountBits = 32;
  localparam logic [7:0] RegLostMoments = 8'h40;
  localparam int RegLostMomentsCountLsb = 0;
  localparam int RegLostMomentsCountBits = 32;
  localparam logic [7:0] RegLostImage = 8'h44;
  localparam int RegLostImageCountLsb = 0;
  localparam int RegLostImageCountBits = 32;
  localparam logic [7:0] RegTimeLow = 8'h48;
  localparam int RegTimeLowLowLsb = 0;
  localparam int RegTimeLowLowBits = 32;
  localparam logic [7:0] RegTimeHigh = 8'h4C;
  localparam int RegTimeHighHighLsb = 0;
  localparam int RegTimeHighHighBits = 32;
  localparam logic [7:0] RegEncoder = 8'h50;
  localparam int RegEncoderCountLsb = 0;
  localparam int RegEncoderCountBits = 32;
  localparam logic [7:0] RegEncoderErrors = 8'h54;
  localparam int RegEncoderErrorsCountLsb = 0;
  localparam int RegEncoderErrorsCountBits = 16;
  localparam logic [7:0] RegDecode = 8'h58;
  localparam logic [31:0] RegDecodeReset = 32'h00000805;
  localparam int RegDecodeThresholdLsb = 0;
  localparam int RegDecodeThresholdBits = 8;
  localparam int RegDecodeBitsLsb = 8;
  localparam int RegDecodeBitsBits = 4;
  localparam int RegDecodeCodesLsb = 16;
  localparam int RegDecodeCodesBits = 1;
  localparam int RegDecodeMedianLsb = 17;
  localparam int RegDecodeMedianBits = 1;
  localparam logic [7:0] RegLostCodes = 8'h5C;
  localparam int RegLostCodesCountLsb = 0;
  localparam int RegLostCodesCountBits = 32;
  localparam logic [7:0] RegAbandoned = 8'h60;
  localparam int RegAbandonedCountLsb = 0;
  localparam int RegAbandonedCountBits = 32;
  localparam logic [7:0] RegWindow = 8'h64;
  localparam logic [31:0] RegWindowReset = 32'h00000000;
  localparam int RegWindowFirstLsb = 0;
  localparam int RegWindowFirstBits = 10;
  localparam int RegWindowLastLsb = 16;
  localparam int RegWindowLastBits = 10;
  localparam logic [7:0] RegRegion = 8'h68;
  localparam logic [31:0] RegRegionReset = 32'h00000000;
  localparam int RegRegionRowLsb = 0;
  localparam int RegRegionRowBits = 16;
  localparam int RegRegionColumnLsb = 16;
  localparam int RegRegionColumnBits = 16;
  localparam logic [7:0] RegCompact = 8'h6C;
  localparam logic [31:0] RegCompactReset = 32'h00000000;
  localparam int RegCompactOnLsb = 0;
  localparam int RegCompactOnBits = 1;
  // Words of the register file's address space in which there is a register
  localparam logic [31:0] RegisterWords = 32'h0FFFFFFF;

  // Registers of the link, for boards on the network
  localparam logic [31:0] LinkId = 32'h00000100;
  localparam logic [31:0] LinkIdReset = 32'h4B4E4C53;
  localparam int LinkIdIdLsb = 0;
  localparam int LinkIdIdBits = 32;
  localparam logic [31:0] LinkTicket = 32'h00000104;
  localparam int LinkTicketNumberLsb = 0;
  localparam int LinkTicketNumberBits = 32;
  localparam logic [31:0] LinkAddress = 32'h00000108;
  localparam int LinkAddressBytesLsb = 0;
  localparam int LinkAddressBytesBits = 9;
  localparam logic [31:0] LinkValue = 32'h0000010C;
  localparam int LinkValueWordLsb = 0;
  localparam int LinkValueWordBits = 32;
  localparam logic [31:0] LinkAnswer = 32'h00000110;
  localparam logic [31:0] LinkAnswerReset = 32'h00000000;
  localparam int LinkAnswerRefusedLsb = 0;
  localparam int LinkAnswerRefusedBits = 1;
  localparam logic [31:0] LinkSource = 32'h00000114;
  localparam int LinkSourceVideoLsb = 0;
  localparam int LinkSourceVideoBits = 2;
  localparam logic [31:0] LinkReplaySession = 32'h00000118;
  localparam int LinkReplaySessionNumberLsb = 0;
  localparam int LinkReplaySessionNumberBits = 16;
  localparam logic [31:0] LinkVideo = 32'h0000011C;
  localparam logic [31:0] LinkVideoReset = 32'h00000000;
  localparam int LinkVideoReplayColumnsLsb = 0;
  localparam int LinkVideoReplayColumnsBits = 12;
  localparam int LinkVideoReplayRowsLsb = 16;
  localparam int LinkVideoReplayRowsBits = 10;
  localparam int LinkVideoSourcesLsb = 28;
  localparam int LinkVideoSourcesBits = 4;
  localparam logic [31:0] LinkReplayFrame = 32'h00000120;
  localparam logic [31:0] LinkReplayFrameReset = 32'h00000000;
  localparam int LinkReplayFrameNumberLsb = 0;
  localparam int LinkReplayFrameNumberBits = 32;
  localparam logic [31:0] LinkReplayOffset = 32'h00000124;
  localparam logic [31:0] LinkReplayOffsetReset = 32'h00000000;
  localparam int LinkReplayOffsetBytesLsb = 0;
  localparam int LinkReplayOffsetBytesBits = 32;
  localparam logic [31:0] LinkReplayFrames = 32'h00000128;
  localparam logic [31:0] LinkReplayFramesReset = 32'h00000000;
  localparam int LinkReplayFramesCountLsb = 0;
  localparam int LinkReplayFramesCountBits = 32;
  localparam logic [31:0] LinkReplayDropped = 32'h0000012C;
  localparam logic [31:0] LinkReplayDroppedReset = 32'h00000000;
  localparam int LinkReplayDroppedCountLsb = 0;
  localparam int LinkReplayDroppedCountBits = 32;
  localparam logic [31:0] LinkReplayIgnored = 32'h00000130;
  localparam logic [31:0] LinkReplayIgnoredReset = 32'h00000000;
  localparam int LinkReplayIgnoredCountLsb = 0;
  localparam int LinkReplayIgnoredCountBits = 32;
  localparam logic [1:0] SourceCamera = 2'd0;
  localparam logic [1:0] SourceTestCamera = 2'd1;
  localparam logic [1:0] SourceReplay = 2'd2;
  localparam logic [1:0] SourcePatterns = 2'd3;

  // Datagrams of replay: port, and the header's fields
  localparam logic [15:0] ReplayPort = 16'd1236;
  localparam logic [15:0] ReplayMagic = 16'h5253;
  localparam int ReplayHeaderBytes = 20;
  localparam int ReplayMagicLsb = 0;
  localparam int ReplayMagicBits = 16;
  localparam int ReplaySessionLsb = 16;
  localparam int ReplaySessionBits = 16;
  localparam int ReplayFrameLsb = 32;
  localparam int ReplayFrameBits = 32;
  localparam int ReplayOffsetLsb = 64;
  localparam int ReplayOffsetBits = 32;
  localparam int ReplayLengthLsb = 96;
  localparam int ReplayLengthBits = 16;
  localparam int ReplayColumnsLsb = 112;
  localparam int ReplayColumnsBits = 16;
  localparam int ReplayRowsLsb = 128;
  localparam int ReplayRowsBits = 16;
  localparam int ReplayReservedLsb = 144;
  localparam int ReplayReservedBits = 16;

  // Bits of a header that tell of the frame; columns have column_bits, rows and lines row_bits,
  // the place of a region region_bits
  function automatic logic [HeaderBits-1:0] frame_mask(input int column_bits, input int row_bits,
                                                     input int region_bits);
    frame_mask = ~({HeaderBits{1'b1}} << HeaderStreamBits) << HeaderStreamLsb |
                 ~({HeaderBits{1'b1}} << HeaderPatternBits) << HeaderPatternLsb |
                 ~({HeaderBits{1'b1}} << ModeBits) << HeaderModeLsb |
                 ~({HeaderBits{1'b1}} << HeaderThresholdBits) << HeaderThresholdLsb |
                 ~({HeaderBits{1'b1}} << HeaderSequenceBits) << HeaderSequenceLsb |
                 ~({HeaderBits{1'b1}} << HeaderTimeStampBits) << HeaderTimeStampLsb |
                 ~({HeaderBits{1'b1}} << HeaderEncoderBits) << HeaderEncoderLsb |
                 ~({HeaderBits{1'b1}} << column_bits) << HeaderColumnsLsb |
                 ~({HeaderBits{1'b1}} << row_bits) << HeaderRowsLsb |
                 ~({HeaderBits{1'b1}} << row_bits) << HeaderLinesLsb |
                 ~({HeaderBits{1'b1}} << FlagBits) << HeaderFlagsLsb |
                 ~({HeaderBits{1'b1}} << SelectBits) << HeaderSelectLsb |
                 ~({HeaderBits{1'b1}} << row_bits) << HeaderFirstRowLsb |
                 ~({HeaderBits{1'b1}} << row_bits) << HeaderLastRowLsb |
                 ~({HeaderBits{1'b1}} << RegMeasureGapBits) << HeaderGapLsb |
                 ~({HeaderBits{1'b1}} << region_bits) << HeaderRegionRowLsb |
                 ~({HeaderBits{1'b1}} << region_bits) << HeaderRegionColumnLsb;
  endfunction

endpackage
