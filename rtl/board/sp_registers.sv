// Register file, video clock: addresses, fields and reset values are those of the specification.
//
// request_i lasts one clock; answer_o comes two clocks later, with error_o where the address is not a register, a read-only
// register is written, or a value is outside what this build can do (the register then keeps its value).
`default_nettype none

module sp_registers #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,
  parameter int MaxRows = sp_spec_pkg::MaxRows,
  parameter bit Grey = 1'b1,
  parameter bit Image = 1'b1,
  parameter bit Codes = 1'b0,  // Gray-code decoder
  parameter bit Median = 1'b0,
  parameter int MaxBits = sp_spec_pkg::CodeCodeBits,
  // derived, do not set
  parameter int ColumnBits = $clog2(MaxColumns + 1),
  parameter int RowBits = $clog2(MaxRows + 1)
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_i,

  input  wire logic                   request_i,
  input  wire logic                   write_i,
  input  wire logic [7:0]             address_i,
  input  wire logic [31:0]            data_i,
  output logic                        answer_o,
  output logic                        error_o,
  output logic [31:0]                 data_o,

  // Settings
  output logic                        run_o,
  output logic                        hold_o,  // also in the first clock of a new size
  output logic                        image_o,
  output logic      [ColumnBits-1:0]  columns_o,
  output logic      [RowBits-1:0]     rows_o,
  output logic      [1:0]             mode_o,
  output logic      [7:0]             threshold_o,
  output logic      [7:0]             stream_o,
  output logic      [23:0]            timeout_o,
  output logic                        trigger_run_o,
  output logic                        trigger_on_frame_o,
  output logic      [7:0]             trigger_last_pattern_o,
  output logic      [23:0]            trigger_period_o,
  output logic      [23:0]            trigger_camera_o,
  output logic      [15:0]            trigger_width_o,
  output logic                        decode_o,
  output logic                        median_o,
  output logic      [3:0]             bits_o,
  output logic      [7:0]             code_threshold_o,

  // State
  input  wire logic                   frame_open_i,
  input  wire logic                   take_i,  // the settings were taken over
  input  wire logic [31:0]            frames_i,
  input  wire logic [31:0]            broken_i,
  input  wire logic [31:0]            stray_i,
  input  wire logic [31:0]            lost_moments_i,
  input  wire logic [31:0]            lost_image_i,
  input  wire logic [31:0]            lost_codes_i,
  input  wire logic [31:0]            abandoned_i,
  input  wire logic [63:0]            time_i,
  input  wire logic [31:0]            encoder_i,
  input  wire logic [15:0]            encoder_errors_i
);

  localparam int SpecColumns = 32'(sp_spec_pkg::RegSizeReset[11:0]);
  localparam int SpecRows = 32'(sp_spec_pkg::RegSizeReset[25:16]);
  localparam logic [ColumnBits-1:0] ResetColumns = ColumnBits'(SpecColumns < MaxColumns ? SpecColumns : MaxColumns);
  localparam logic [RowBits-1:0] ResetRows = RowBits'(SpecRows < MaxRows ? SpecRows : MaxRows);

  // --- Request, one clock later, with the judgement of a write. data_i and address_i stay until the answer. ---
  logic        request_q, write_q, write_good_q;
  logic [7:0]  address_q;
  logic        size_good, measure_good, image_wanted, decode_good;

  assign size_good    = data_i[1:0] == 2'd0 && data_i[15:0] != 16'd0 && data_i[15:0] <= 16'(MaxColumns) &&
                        data_i[31:16] != 16'd0 && data_i[31:16] <= 16'(MaxRows);
  assign measure_good = data_i[9:8] == sp_spec_pkg::ModeBinary || Grey && data_i[9:8] != 2'd3;
  assign decode_good  = Codes && data_i[11:8] != 4'd0 && data_i[11:8] <= 4'(MaxBits) && (Median || !data_i[17]);
  assign image_wanted = data_i[sp_spec_pkg::RegControlImageLsb];

  // Without an access, and without a take-over, nothing moves.
  logic awake;
  assign awake = request_i || request_q || answer_o || take_i;

  always_ff @(posedge clk_i) begin
    if (rst_i) request_q <= 1'b0;
    else if (awake) request_q <= request_i;
    if (request_i) begin
      write_q   <= write_i;
      address_q <= address_i;
      case (address_i)
        sp_spec_pkg::RegControl:        write_good_q <= Image || !image_wanted;
        sp_spec_pkg::RegSize:           write_good_q <= size_good;
        sp_spec_pkg::RegMeasure:        write_good_q <= measure_good;
        sp_spec_pkg::RegTimeout:        write_good_q <= 1'b1;
        sp_spec_pkg::RegTriggerControl: write_good_q <= 1'b1;
        sp_spec_pkg::RegTriggerPeriod:  write_good_q <= data_i[23:0] != 24'd0;
        sp_spec_pkg::RegTriggerCamera:  write_good_q <= 1'b1;
        sp_spec_pkg::RegTriggerWidth:   write_good_q <= 1'b1;
        sp_spec_pkg::RegDecode:         write_good_q <= decode_good;
        default:                        write_good_q <= 1'b0;
      endcase
    end
  end

  // --- Writes ---
  logic hold_q;
  logic size_written_q;
  logic pending_q;  // settings written and not taken over
  logic write;

  assign write  = request_q && write_q && write_good_q;
  assign hold_o = hold_q || size_written_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      run_o                  <= sp_spec_pkg::RegControlReset[sp_spec_pkg::RegControlRunLsb];
      hold_q                 <= sp_spec_pkg::RegControlReset[sp_spec_pkg::RegControlHoldLsb];
      image_o                <= sp_spec_pkg::RegControlReset[sp_spec_pkg::RegControlImageLsb];
      columns_o              <= ResetColumns;
      rows_o                 <= ResetRows;
      threshold_o            <= sp_spec_pkg::RegMeasureReset[sp_spec_pkg::RegMeasureThresholdLsb+:8];
      mode_o                 <= sp_spec_pkg::RegMeasureReset[sp_spec_pkg::RegMeasureModeLsb+:2];
      stream_o               <= sp_spec_pkg::RegMeasureReset[sp_spec_pkg::RegMeasureStreamLsb+:8];
      timeout_o              <= sp_spec_pkg::RegTimeoutReset[23:0];
      trigger_run_o          <= sp_spec_pkg::RegTriggerControlReset[sp_spec_pkg::RegTriggerControlRunLsb];
      trigger_on_frame_o     <= sp_spec_pkg::RegTriggerControlReset[sp_spec_pkg::RegTriggerControlOnFrameLsb];
      trigger_last_pattern_o <= sp_spec_pkg::RegTriggerControlReset[sp_spec_pkg::RegTriggerControlLastPatternLsb+:8];
      trigger_period_o       <= sp_spec_pkg::RegTriggerPeriodReset[23:0];
      trigger_camera_o       <= sp_spec_pkg::RegTriggerCameraReset[23:0];
      trigger_width_o        <= sp_spec_pkg::RegTriggerWidthReset[15:0];
      size_written_q         <= 1'b1;
      pending_q              <= 1'b1;
    end else begin
      if (awake) begin
        size_written_q <= write && address_q == sp_spec_pkg::RegSize;
        if (write && (address_q == sp_spec_pkg::RegControl || address_q == sp_spec_pkg::RegSize ||
                      address_q == sp_spec_pkg::RegMeasure || address_q == sp_spec_pkg::RegDecode)) pending_q <= 1'b1;
        else if (take_i) pending_q <= 1'b0;
      end
      if (request_q) begin
        if (write) begin
          case (address_q)
            sp_spec_pkg::RegControl: begin
              run_o   <= data_i[sp_spec_pkg::RegControlRunLsb];
              hold_q  <= data_i[sp_spec_pkg::RegControlHoldLsb];
              image_o <= image_wanted;
            end
            sp_spec_pkg::RegSize: begin
              columns_o <= data_i[sp_spec_pkg::RegSizeColumnsLsb+:ColumnBits];
              rows_o    <= data_i[sp_spec_pkg::RegSizeRowsLsb+:RowBits];
            end
            sp_spec_pkg::RegMeasure: begin
              threshold_o <= data_i[sp_spec_pkg::RegMeasureThresholdLsb+:8];
              mode_o      <= data_i[sp_spec_pkg::RegMeasureModeLsb+:2];
              stream_o    <= data_i[sp_spec_pkg::RegMeasureStreamLsb+:8];
            end
            sp_spec_pkg::RegTimeout: timeout_o <= data_i[23:0];
            sp_spec_pkg::RegTriggerControl: begin
              trigger_run_o          <= data_i[sp_spec_pkg::RegTriggerControlRunLsb];
              trigger_on_frame_o     <= data_i[sp_spec_pkg::RegTriggerControlOnFrameLsb];
              trigger_last_pattern_o <= data_i[sp_spec_pkg::RegTriggerControlLastPatternLsb+:8];
            end
            sp_spec_pkg::RegTriggerPeriod: trigger_period_o <= data_i[23:0];
            sp_spec_pkg::RegTriggerCamera: trigger_camera_o <= data_i[23:0];
            sp_spec_pkg::RegTriggerWidth: trigger_width_o <= data_i[15:0];
            default: ;
          endcase
        end
      end
    end
  end

  // --- Reads ---
  logic [31:0] time_high_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      answer_o    <= 1'b0;
      time_high_q <= '0;
    end else begin
      if (awake) answer_o <= request_q;
      if (request_q) begin
        if (!write_q && address_q == sp_spec_pkg::RegTimeLow) time_high_q <= time_i[63:32];
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (request_q) begin
      error_o <= write_q && !write_good_q;
      case (address_q)
        sp_spec_pkg::RegId:         data_o <= sp_spec_pkg::Magic;
        sp_spec_pkg::RegVersion:    data_o <= {16'd0, sp_spec_pkg::SpecVersion};
        sp_spec_pkg::RegSpecHash:   data_o <= sp_spec_pkg::SpecHash;
        sp_spec_pkg::RegCapability: begin
          data_o <= {Codes ? 4'(MaxBits) : 4'd0, 2'd0, Codes && Median, Codes, Image, Grey, 10'(MaxRows), 12'(MaxColumns)};
        end
        sp_spec_pkg::RegControl: begin
          data_o <= 32'(run_o) << sp_spec_pkg::RegControlRunLsb | 32'(hold_q) << sp_spec_pkg::RegControlHoldLsb |
                 32'(image_o) << sp_spec_pkg::RegControlImageLsb;
        end
        sp_spec_pkg::RegSize: begin
          data_o <= 32'(columns_o) << sp_spec_pkg::RegSizeColumnsLsb | 32'(rows_o) << sp_spec_pkg::RegSizeRowsLsb;
        end
        sp_spec_pkg::RegMeasure: begin
          data_o <= 32'(threshold_o) << sp_spec_pkg::RegMeasureThresholdLsb |
                 32'(mode_o) << sp_spec_pkg::RegMeasureModeLsb | 32'(stream_o) << sp_spec_pkg::RegMeasureStreamLsb;
        end
        sp_spec_pkg::RegTimeout: data_o <= 32'(timeout_o);
        sp_spec_pkg::RegTriggerControl: begin
          data_o <= 32'(trigger_run_o) << sp_spec_pkg::RegTriggerControlRunLsb |
                 32'(trigger_on_frame_o) << sp_spec_pkg::RegTriggerControlOnFrameLsb |
                 32'(trigger_last_pattern_o) << sp_spec_pkg::RegTriggerControlLastPatternLsb;
        end
        sp_spec_pkg::RegTriggerPeriod: data_o <= 32'(trigger_period_o);
        sp_spec_pkg::RegTriggerCamera: data_o <= 32'(trigger_camera_o);
        sp_spec_pkg::RegTriggerWidth:  data_o <= 32'(trigger_width_o);
        sp_spec_pkg::RegStatus: begin
          data_o <= 32'(frame_open_i) << sp_spec_pkg::RegStatusFrameOpenLsb |
                 32'(pending_q) << sp_spec_pkg::RegStatusPendingLsb;
        end
        sp_spec_pkg::RegFrames:        data_o <= frames_i;
        sp_spec_pkg::RegBroken:        data_o <= broken_i;
        sp_spec_pkg::RegStray:         data_o <= stray_i;
        sp_spec_pkg::RegLostMoments:   data_o <= lost_moments_i;
        sp_spec_pkg::RegLostImage:     data_o <= lost_image_i;
        sp_spec_pkg::RegTimeLow:       data_o <= time_i[31:0];
        sp_spec_pkg::RegTimeHigh:      data_o <= time_high_q;
        sp_spec_pkg::RegEncoder:       data_o <= encoder_i;
        sp_spec_pkg::RegEncoderErrors: data_o <= 32'(encoder_errors_i);
        sp_spec_pkg::RegDecode: begin
          data_o <= 32'(code_threshold_o) << sp_spec_pkg::RegDecodeThresholdLsb |
                 32'(bits_o) << sp_spec_pkg::RegDecodeBitsLsb | 32'(decode_o) << sp_spec_pkg::RegDecodeCodesLsb |
                 32'(median_o) << sp_spec_pkg::RegDecodeMedianLsb;
          if (!Codes) error_o <= 1'b1;
        end
        sp_spec_pkg::RegLostCodes: begin
          data_o <= Codes ? lost_codes_i : 32'd0;
          if (!Codes) error_o <= 1'b1;
        end
        sp_spec_pkg::RegAbandoned: begin
          data_o <= Codes ? abandoned_i : 32'd0;
          if (!Codes) error_o <= 1'b1;
        end
        default: begin
          data_o  <= 32'd0;
          error_o <= 1'b1;
        end
      endcase
    end
  end

  // --- Decoder: in a build without one there is nothing to set ---
  if (Codes) begin : gen_codes
    localparam int SpecBits = 32'(sp_spec_pkg::RegDecodeReset[sp_spec_pkg::RegDecodeBitsLsb+:4]);
    localparam logic [3:0] ResetBits = 4'(SpecBits < MaxBits ? SpecBits : MaxBits);

    always_ff @(posedge clk_i) begin
      if (rst_i) begin
        decode_o         <= sp_spec_pkg::RegDecodeReset[sp_spec_pkg::RegDecodeCodesLsb];
        median_o         <= sp_spec_pkg::RegDecodeReset[sp_spec_pkg::RegDecodeMedianLsb];
        bits_o           <= ResetBits;
        code_threshold_o <= sp_spec_pkg::RegDecodeReset[sp_spec_pkg::RegDecodeThresholdLsb+:8];
      end else if (write && address_q == sp_spec_pkg::RegDecode) begin
        decode_o         <= data_i[sp_spec_pkg::RegDecodeCodesLsb];
        median_o         <= data_i[sp_spec_pkg::RegDecodeMedianLsb];
        bits_o           <= data_i[sp_spec_pkg::RegDecodeBitsLsb+:4];
        code_threshold_o <= data_i[sp_spec_pkg::RegDecodeThresholdLsb+:8];
      end
    end
  end else begin : gen_no_codes
    logic unused;

    assign decode_o         = 1'b0;
    assign median_o         = 1'b0;
    assign bits_o           = 4'd0;
    assign code_threshold_o = 8'd0;
    assign unused           = ^{lost_codes_i, abandoned_i};
  end

endmodule

`default_nettype wire
