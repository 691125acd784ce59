#!/usr/bin/env python3
"""Proves the rules inside the RTL modules (`ifdef FORMAL) with Yosys and yosys-smtbmc and z3, or with Yosys's own ABC.

    prove.py [NAME...]           the proofs named, or all; prints their rows of the table in docs/proofs.md
    prove.py --faults [NAME...]  the planted faults: each must make its proof fail
    prove.py --list              what the tests run, a name a line: proofs, then faults

A proof of depth K by induction shows that no trace of K steps from the beginning breaks a rule, and that K steps which
keep the rules are never followed by one that breaks them. A proof by reachability shows that no trace at all breaks a
rule. A bounded proof shows that no trace of K steps from the beginning breaks a rule. Covers show that traces up to the
given depth reach every cover statement, so that the rules do not hold merely because no trace exists. Induction uses
z3; ABC does the rest, because it finds traces from the beginning sooner.

Standard library only.
"""

import argparse
import dataclasses
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import results  # noqa: E402
import rtl_tree  # noqa: E402


@dataclasses.dataclass(frozen=True)
class Proof:
    name: str
    module: str
    parameters: tuple  # of "NAME=VALUE"
    kind: str          # induction (yosys-smtbmc and z3), or of ABC: reachability or bounded
    depth: int         # with reachability only that of the search for a planted fault
    cover: int         # depth of the covers; 0: the module has none
    clocks: int = 1    # 2: free clocks, every step a moment
    lemmas: bool = True  # the rules of the parts count too, and what they assume is proved; else these are left out
    limit_s: int = 1800


@dataclasses.dataclass(frozen=True)
class Fault:
    name: str    # PROOF/what
    proof: str
    file: str    # below rtl/
    old: str     # occurs once
    new: str
    bounded: int = 0  # depth of a search from the beginning; 0: that of the proof


PROOFS = [
    Proof("skid_buffer", "sp_skid_buffer", ("Width=3",), "induction", 2, 8),
    Proof("fifo", "sp_fifo", ("Width=3", "LogDepth=2"), "induction", 2, 20),
    Proof("async_fifo", "sp_async_fifo", ("Width=1", "LogDepth=2"), "induction", 2, 24, clocks=2),
    Proof("packet_arbiter", "sp_packet_arbiter", ("Width=2",), "induction", 2, 16),
    Proof("frame_tracker", "sp_frame_tracker", ("MaxColumns=12", "MaxRows=3"), "induction", 8, 28),
    Proof("frame_timeout", "sp_frame_timeout", (), "induction", 2, 8),
    Proof("registers", "sp_registers", ("MaxColumns=16", "MaxRows=3", "Codes=1'b1", "Median=1'b1"),
          "induction", 8, 20),
    Proof("gray_lane", "sp_gray_lane", (), "induction", 5, 8),
    Proof("gray_sequence", "sp_gray_sequence", (), "induction", 3, 16),
    Proof("axil_bridge", "sp_axil_bridge", ("AddressBits=2", "TimeoutBits=2"), "induction", 3, 36, clocks=2),
    Proof("gray_axi_memory", "sp_gray_axi_memory", ("Width=1", "AddressBits=13", "LogDepth=4", "BurstWords=4"),
          "induction", 3, 24),
    Proof("packetizer", "sp_packetizer", ("ColumnBits=4", "RowBits=2", "PayloadBits=3", "LogDepth=4"), "induction", 2,
          40),
    Proof("packet_fifo", "sp_packet_fifo", ("Width=1", "LogDepth=1"), "bounded", 36, 20, clocks=2),
    Proof("packet_fifo_of_two", "sp_packet_fifo", ("Width=1", "LogDepth=2", "PacketWords=2"), "bounded", 36, 24,
          clocks=2),
    Proof("moment_drain", "sp_moment_drain", ("MaxRows=3", "GroupBits=1"), "reachability", 24, 24),
    Proof("moment_drain_of_four", "sp_moment_drain", ("MaxRows=3", "GroupBits=2"), "bounded", 30, 24),
    Proof("column_moments_binary", "sp_column_moments", ("MaxColumns=8", "MaxRows=3", "Grey=1'b0"), "bounded", 24, 16,
          lemmas=False),
    Proof("column_moments_values", "sp_column_moments", ("MaxColumns=8", "MaxRows=2", "Grey=1'b1"), "bounded", 22, 30,
          lemmas=False),
    Proof("column_moments_frames", "sp_column_moments", ("MaxColumns=8", "MaxRows=2", "Grey=1'b1", "ValueBits=8'h01"),
          "bounded", 28, 28, lemmas=False),
    Proof("column_runs_binary", "sp_column_runs", ("MaxColumns=8", "MaxRows=5", "Grey=1'b0"), "bounded", 20, 22,
          lemmas=False),
    Proof("column_runs_frames", "sp_column_runs", ("MaxColumns=8", "MaxRows=3", "Grey=1'b0"), "bounded", 24, 26,
          lemmas=False),
    Proof("column_runs_values", "sp_column_runs", ("MaxColumns=8", "MaxRows=3", "Grey=1'b1", "ValueBits=8'h03"),
          "bounded", 26, 36, lemmas=False),
    Proof("datagram_cutter", "sp_datagram_cutter", ("DatagramBytes=48", "LogDepth=2", "IdleClocks=2"), "induction", 1,
          30),
    Proof("replay_receiver", "sp_replay_receiver", ("MaxColumns=8", "MaxRows=2"), "induction", 2, 30),
    Proof("tap_gather_of_three", "sp_tap_gather", ("Taps=3",), "induction", 2, 8),
    Proof("tap_gather_of_two", "sp_tap_gather", ("Taps=2",), "induction", 2, 8),
    Proof("tap_gather_of_one", "sp_tap_gather", ("Taps=1",), "induction", 2, 12),
    Proof("beat_hold", "sp_beat_hold", ("Width=8",), "induction", 2, 12),
    Proof("beat_pairs", "sp_beat_pairs", ("XBits=2", "YBits=1", "LogWait=2"), "induction", 2, 16),
    Proof("channel_link_lock", "sp_channel_link_lock", ("LogGood=2",), "induction", 3, 44),
    Proof("channel_link_lock_twice", "sp_channel_link_lock", ("Samples=2", "LogGood=1"), "induction", 3, 48),
    Proof("moments_window", "sp_moments_path", ("MaxColumns=16", "MaxRows=15", "LogDepth=4"), "induction", 1, 2,
          lemmas=False),
]

FAULTS = [
    Fault("skid_buffer/drops_a_word", "skid_buffer", "common/sp_skid_buffer.sv",
          "spare_valid_q <= 1'b1;", "spare_valid_q <= !s_data_i[0];", 12),
    Fault("skid_buffer/always_ready", "skid_buffer", "common/sp_skid_buffer.sv",
          "assign s_ready_o = !spare_valid_q;", "assign s_ready_o = 1'b1;", 12),
    Fault("fifo/one_too_many", "fifo", "common/sp_fifo.sv",
          "assign s_ready_o = wr_ptr_q != {!rd_ptr_q[LogDepth], rd_ptr_q[LogDepth-1:0]};",
          "assign s_ready_o = 1'b1;", 12),
    Fault("fifo/narrow_word", "fifo", "common/sp_fifo.sv",
          ".wr_data_i(s_data_i),", ".wr_data_i(Width'(s_data_i[Width-2:0])),", 12),
    Fault("async_fifo/no_synchronizer", "async_fifo", "common/sp_async_fifo.sv",
          "rd_gray_q != wr_gray_seen &&", "rd_gray_q != wr_gray_q &&"),
    Fault("async_fifo/binary_pointer", "async_fifo", "common/sp_async_fifo.sv",
          "wr_gray_q <= gray_of(wr_next_q);", "wr_gray_q <= wr_next_q;"),
    Fault("packet_fifo/counts_words", "packet_fifo", "common/sp_packet_fifo.sv",
          "end else if (wr_valid_i && wr_last_i) begin", "end else if (wr_valid_i) begin"),
    Fault("packet_fifo_of_two/too_few_bits", "packet_fifo_of_two", "common/sp_packet_fifo.sv",
          "$clog2((1 << LogDepth) / PacketWords + 2)", "$clog2((1 << LogDepth) / PacketWords + 1) - 1"),
    Fault("packet_arbiter/changes_inside", "packet_arbiter", "board/sp_packet_arbiter.sv",
          "assign second         = busy_q ? of_second_q : !first_valid_i;",
          "assign second         = !first_valid_i;", 12),
    Fault("frame_tracker/takes_any_time", "frame_tracker", "board/sp_frame_tracker.sv",
          "may_take_q  <= run_i && !hold_i && !s1_take_q && took_q == '0;",
          "may_take_q  <= run_i && !hold_i && !s1_take_q;", 16),
    Fault("frame_tracker/row_too_many", "frame_tracker", "board/sp_frame_size.sv",
          "new_rows_less_2_q   <= rows_i - RowBits'(2);", "new_rows_less_2_q   <= rows_i - RowBits'(1);", 16),
    Fault("frame_timeout/carry_one_late", "frame_timeout", "board/sp_frame_timeout.sv",
          "pause_q.low == 12'hFFE;", "pause_q.low == 12'hFFF;"),
    Fault("registers/last_pattern_at_any_time", "registers", "board/sp_registers.sv",
          "!((trigger_run_o || trigger_on_frame_o) && trigger_wanted);", "!(trigger_run_o && trigger_wanted);", 16),
    Fault("registers/width_at_any_time", "registers", "board/sp_registers.sv",
          "hit_q[sp_spec_pkg::RegTriggerWidth/4] && !trigger_run_o;", "hit_q[sp_spec_pkg::RegTriggerWidth/4];", 16),
    Fault("registers/held_too_late", "registers", "board/sp_registers.sv",
          "asked_q[2:0] != '0 && write_i || hold_q;", "asked_q[2:1] != '0 && write_i || hold_q;", 16),
    Fault("axil_bridge/forgets_an_answer", "axil_bridge", "board/sp_axil_bridge.sv",
          "if (!late_q && reading_q) s_axil_rvalid_o <= 1'b1;",
          "if (!late_q && reading_q) s_axil_rvalid_o <= !timed_out_q;"),
    Fault("axil_bridge/answer_after_its_toggle", "axil_bridge", "board/sp_axil_bridge.sv",
          "if (answer_i) begin back_error_q", "if ($past(answer_i)) begin back_error_q"),
    Fault("axil_bridge/error_of_a_read_lost", "axil_bridge", "board/sp_axil_bridge.sv",
          "s_axil_rresp_o <= back_error_q ? SlaveError : Okay;", "s_axil_rresp_o <= Okay;"),
    Fault("packet_fifo/count_crosses_in_binary", "packet_fifo", "common/sp_packet_fifo.sv",
          "sp_sync #( .Width(CountBits) ) u_written_to_rd ( .clk_i(rd_clk_i), .rst_i(rd_rst_i), .d_i (written_gray_q), "
          ".q_o (written_gray_seen) );",
          "logic [CountBits-1:0] seen; assign written_gray_seen = gray_of(seen); sp_sync #( .Width(CountBits) ) "
          "u_count ( .clk_i(rd_clk_i), .rst_i(rd_rst_i), .d_i (written_next_q - 1'b1), .q_o (seen) );"),
    Fault("packetizer/no_fill", "packetizer", "board/sp_packetizer.sv",
          "(q.state[Fill] || q.state[Payload] && payload_break_i) && !all_put,", "q.state[Fill] && !all_put,", 24),
    Fault("packetizer/loses_uncounted", "packetizer", "board/sp_packetizer.sv",
          "|| q.asked[BreakFirst2] && !take_empty;", ";", 16),
    Fault("packetizer/room_for_one_less", "packetizer", "board/sp_packetizer.sv",
          "{1'b0, ~need1_q} + (CountBits + 1)'(1);", "{1'b0, ~need1_q} + (CountBits + 1)'(2);"),
    Fault("packetizer/check_word_cleared_late", "packetizer", "board/sp_packetizer.sv",
          "clear_q <= q.state[Settle];", "clear_q <= q.state[Settle+2];"),
    Fault("packetizer/check_word_without_trailer", "packetizer", "board/sp_packetizer.sv",
          "fold_q <= q.state[Header+:4] != '0 || put_payload || q.state[Trailer];",
          "fold_q <= q.state[Header+:4] != '0 || put_payload;"),
    Fault("gray_lane/greater_or_equal", "gray_lane", "gray/sp_gray_lane.sv",
          "= {2'b00, threshold_i} - 10'(difference_q);", "= {2'b00, threshold_i} - 10'(difference_q) - 10'd1;", 6),
    Fault("gray_sequence/one_pair_early", "gray_sequence", "gray/sp_gray_sequence.sv",
          "assign enough   = pairs_up == bits_i;", "assign enough   = pairs_up + 4'd1 >= bits_i;", 12),
    Fault("gray_sequence/cast_of_yosys", "gray_sequence", "gray/sp_gray_sequence.sv",
          "~({MaxBits{1'b1}} << bits_i)", "~(~MaxBits'(0) << bits_i)", 6),
    Fault("gray_axi_memory/address_changes", "gray_axi_memory", "gray/sp_gray_axi_memory.sv",
          "if (ar) m_axi_araddr_o <=", "if (m_axi_arvalid_o) m_axi_araddr_o <=", 8),
    Fault("gray_axi_memory/short_burst_unmarked", "gray_axi_memory", "gray/sp_gray_axi_memory.sv",
          "assign m_axi_wlast_o  = left_q == '0 ||", "assign m_axi_wlast_o  = left_q == '0 || 1'b0 &&"),
    Fault("gray_axi_memory/reads_before_answers", "gray_axi_memory", "gray/sp_gray_axi_memory.sv",
          "level_q == '0 && bursts_q == '0 &&", "level_q == '0 &&"),
    Fault("gray_axi_memory/more_bursts_than_counted", "gray_axi_memory", "gray/sp_gray_axi_memory.sv",
          "|| part) && !(&bursts_q);", "|| part);"),
    Fault("moment_drain/breaks_early", "moment_drain", "moments/sp_moment_drain.sv",
          "assign break_o = break_q[Latency-1];", "assign break_o = break_q[Latency-2];"),
    Fault("moment_drain/words_early", "moment_drain", "moments/sp_moment_drain.sv",
          "assign valid_o = valid_q[Latency-1];", "assign valid_o = valid_q[Latency-2];"),
    Fault("moment_drain/ends_one_early", "moment_drain_of_four", "moments/sp_drain_order.sv",
          "group_q == last_group_q;", "group_q + 1'b1 == last_group_q;"),
    Fault("column_moments_binary/row_off_by_one", "column_moments_binary", "moments/sp_moment_sums.sv",
          "s1_row_q         <= row_i;", "s1_row_q         <= row_i - RowBits'(1);", 12),
    Fault("column_moments_binary/no_forward", "column_moments_binary", "moments/sp_moment_sums.sv",
          "s1_onto_last_q   <= s2_add_q && (s1_add_q ? two_groups_i : one_group_i);",
          "s1_onto_last_q   <= s2_add_q && !s1_add_q && one_group_i;", 14),
    Fault("column_moments_values/threshold_kept", "column_moments_values", "moments/sp_pixel_weights.sv",
          "+ s1_room_q + 8'd1;", ";", 20),
    Fault("column_moments_frames/unwanted_drains", "column_moments_frames", "moments/sp_column_moments.sv",
          "valid_q[4] && s4_drain_row && accept_i", "valid_q[4] && s4_drain_row", 24),
    Fault("column_runs_binary/ties_to_the_later", "column_runs_binary", "moments/sp_run_best.sv",
          "s5_beats_best_q <= s4_run_i && s4_m0_i > s4_best;", "s5_beats_best_q <= s4_run_i && s4_m0_i >= s4_best;"),
    Fault("column_runs_binary/gap_one_less", "column_runs_binary", "moments/sp_run_lane.sv",
          "&& s2_strongest_i && s2_dark_q == s2_gap_i;", "&& s2_strongest_i && s2_dark_q + 2'd1 == s2_gap_i;"),
    Fault("column_runs_binary/second_not_kept", "column_runs_binary", "moments/sp_run_best.sv",
          "s5_beats_best_q ? s5_best_q :", "s5_beats_best_q ? s5_second_q :"),
    Fault("column_runs_binary/best_not_forwarded", "column_runs_binary", "moments/sp_run_best.sv",
          "s3_after_new_i && s5_keep_i ? new_word :", "1'b0 ? new_word :"),
    Fault("column_runs_frames/first_row_beside_a_drain_lost", "column_runs_frames", "moments/sp_run_sums.sv",
          "write_q <= {write_q[3:1], add_i};", "write_q <= {write_q[3:1], add_i && !drain_i};"),
    Fault("column_runs_values/count_not_cleared", "column_runs_values", "moments/sp_run_lane.sv",
          "s3_m_q <= !s2_open_q ? '0 :", "s3_m_q <= !s2_open_q ? {raw_m_i[MBits-1:M0Bits], M0Bits'(0)} :"),
    Fault("column_runs_values/second_of_one_run", "column_runs_values", "moments/sp_run_finish.sv",
          "second_o = runs_o[1] ?", "second_o = runs_o[0] ?"),
    Fault("datagram_cutter/leaves_before_it_is_whole", "datagram_cutter", "link/sp_datagram_cutter.sv",
          "assign fetch = get_q != head_q &&", "assign fetch = get_q != put_q &&", 8),
    Fault("datagram_cutter/length_one_word_late", "datagram_cutter", "link/sp_datagram_cutter.sv",
          "if (first_q && word_q == 2'd0)", "if (first_q && word_q == 2'd1)", 12),
    Fault("datagram_cutter/counts_packets_only", "datagram_cutter", "link/sp_datagram_cutter.sv",
          "sequence_q <= sequence_q + 1'b1;", "sequence_q <= sequence_q + 32'(ended_q);", 12),
    Fault("datagram_cutter/overwrites_when_full", "datagram_cutter", "link/sp_datagram_cutter.sv",
          "assign room = !held[LogDepth];", "assign room = 1'b1;", 12),
    Fault("datagram_cutter/session_ends_in_a_packet", "datagram_cutter", "link/sp_datagram_cutter.sv",
          "&& !take && (!inside_q || header_q && ended_q)) open_q", "&& !take) open_q", 12),
    Fault("datagram_cutter/ends_with_a_full_piece", "datagram_cutter", "link/sp_datagram_cutter.sv",
          "ended_q <= s_last_i;", "ended_q <= s_last_i || beats_q == CountBits'(PieceBeats - 1);", 12),
    Fault("replay_receiver/damaged_counts", "replay_receiver", "camera/sp_replay_receiver.sv",
          "taken = ends && good_q && !error_q2 && left_q <= PieceBits'(1) && !forget;",
          "taken = ends && good_q && !error_q2 && !forget;"),
    Fault("replay_receiver/keeps_the_frame_before", "replay_receiver", "camera/sp_replay_receiver.sv",
          "else if (valid_q && at_q == FirstWord && judged && begins) next_q <= '0;", ""),
    Fault("replay_receiver/gap_counts", "replay_receiver", "camera/sp_replay_receiver.sv",
          "assign goes_on = start_q[2+:CountBits] == next_q &&", "assign goes_on = start_q[2+:CountBits] >= next_q &&"),
    Fault("replay_receiver/writes_while_it_leaves", "replay_receiver", "camera/sp_replay_receiver.sv",
          "&& !busy_q && from_q == host_i", "&& from_q == host_i"),
    Fault("replay_receiver/any_sender", "replay_receiver", "camera/sp_replay_receiver.sv",
          "&& !busy_q && from_q == host_i", "&& !busy_q"),
    Fault("replay_receiver/drops_uncounted", "replay_receiver", "camera/sp_replay_receiver.sv",
          "dropped_o <= dropped_o + ahead_q;", "dropped_o <= dropped_o + 32'(ahead_q != '0);"),
    Fault("tap_gather_of_three/beat_of_the_wrong_place", "tap_gather_of_three", "camera/sp_tap_gather.sv",
          "2'd1: beat_o = all[16+:32];", "2'd1: beat_o = all[8+:32];", 8),
    Fault("tap_gather_of_three/pixels_stay_after_a_line", "tap_gather_of_three", "camera/sp_tap_gather.sv",
          "if (rst_i || clear_i) fill_q <= 2'd0;", "if (rst_i) fill_q <= 2'd0;", 8),
    Fault("tap_gather_of_two/one_too_early", "tap_gather_of_two", "camera/sp_tap_gather.sv",
          "assign full_o = take_i && fill_q == 2'(4 - Taps);", "assign full_o = take_i;", 8),
    Fault("tap_gather_of_one/keeps_too_little", "tap_gather_of_one", "camera/sp_tap_gather.sv",
          "if (take_i) kept_q <= all[8*Taps+:8*Kept];", "if (full_o) kept_q <= all[8*Taps+:8*Kept];", 12),
    Fault("beat_hold/goes_on_after_a_loss", "beat_hold", "camera/sp_beat_hold.sv",
          "open_q <= open && !lost_o && !cut_i;", "open_q <= open && !cut_i;", 12),
    Fault("beat_hold/ends_a_line_that_is_cut", "beat_hold", "camera/sp_beat_hold.sv",
          "if (lost_o || cut_i) whole_q <= 1'b0;", "if (lost_o) whole_q <= 1'b0;", 12),
    Fault("beat_hold/start_with_the_second_beat", "beat_hold", "camera/sp_beat_hold.sv",
          "assign first = first_q || begins_i;", "assign first = first_q;", 12),
    Fault("beat_pairs/joins_a_start_with_another_beat", "beat_pairs", "camera/sp_beat_pairs.sv",
          "assign same = x_start_i == y_start_i && x_end_i == y_end_i;", "assign same = x_end_i == y_end_i;", 12),
    Fault("beat_pairs/goes_on_in_the_middle", "beat_pairs", "camera/sp_beat_pairs.sv",
          "both && same && (!skip_q || x_start_i);", "both && same;", 12),
    Fault("beat_pairs/drops_a_beat_that_waits", "beat_pairs", "camera/sp_beat_pairs.sv",
          "assign x_ready_o = pair ||", "assign x_ready_o = x_valid_i && wait_q != '0 || pair ||", 12),
    Fault("beat_pairs/waits_for_ever", "beat_pairs", "camera/sp_beat_pairs.sv",
          "assign late = wait_q == '1 && !both;", "assign late = 1'b0;"),
    Fault("channel_link_lock/gives_a_wrong_word", "channel_link_lock", "camera/sp_channel_link_lock.sv",
          "valid_o <= judge && right && locked_o;", "valid_o <= judge && locked_o;", 32),
    Fault("channel_link_lock/moves_in_a_lock", "channel_link_lock", "camera/sp_channel_link_lock.sv",
          "assign move = judge && !pattern_q && !locked_o;", "assign move = judge && !pattern_q;", 32),
    Fault("channel_link_lock/moves_too_soon", "channel_link_lock", "camera/sp_channel_link_lock.sv",
          "assign judge = complete_q && settle_q == '0;", "assign judge = complete_q && settle_q[3:1] == '0;", 40),
    Fault("channel_link_lock/counts_wrong_words", "channel_link_lock", "camera/sp_channel_link_lock.sv",
          "if (judge) good_q <= !right ? '0 :", "if (judge) good_q <= !right ? good_q :", 32),
    Fault("channel_link_lock_twice/samples_may_differ", "channel_link_lock_twice", "camera/sp_channel_link_lock.sv",
          "assign right = pattern_q && agree_q;", "assign right = pattern_q;", 32),
    Fault("moments_window/last_row_left_out", "moments_window", "board/sp_moments_path.sv",
          "beat_row_i <= last_row ||", "beat_row_i < last_row ||"),
]


class ProofError(Exception):
    """A tool failed, or a fault could not be planted."""


def run(command, limit_s, folder):
    try:
        return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=limit_s, check=False)
    except FileNotFoundError as error:
        raise ProofError(f"{error.filename}: not installed; scripts/setup.sh installs it") from error
    except subprocess.TimeoutExpired as error:
        raise ProofError(f"{command[0]}: no answer within {limit_s} s") from error


def write_models(proof, rtl, folder, *kinds):
    """Returns the paths of models of the module with its rules: flat, memories as registers, free clocks as data.

    The kinds are smt2 (SMT-LIB), rules (AIGER), and covers (AIGER with the covers in place of the rules). What a part
    of the module assumes, the module has to guarantee: it becomes an assertion.
    """
    two_clocks = "clk2fflogic; " if proof.clocks == 2 else ""
    helpers = sorted((ROOT / "tests/formal").glob("sp_formal_*.sv"))
    files = rtl_tree.sources_of(proof.module, rtl, helpers)
    read = rtl_tree.read_command(proof.module, proof.parameters, files=files, formal=True)
    script = (read + f"hierarchy -check -top {proof.module}; proc; chformal -cover -remove A:top %n; "
              f"chformal {'-assume2assert' if proof.lemmas else '-remove'} A:top *sp_formal_* %u %n; "
              f"prep -nordff -flatten; memory_map; {two_clocks}opt -full; dffunmap; design -save model")
    # a cover is reached if the assertion of its opposite fails
    contrary = folder / "contrary.v"
    contrary.write_text("(* techmap_celltype = \"$cover\" *) module contrary(input A, EN); "
                        "\\$assert _TECHMAP_REPLACE_ (.A(!A), .EN(EN)); endmodule\n")
    statements = {"rules": "chformal -cover -remove",
                  "covers": f"chformal -assert -remove; techmap -map {contrary}"}
    paths = []
    for kind in kinds:
        path = folder / (f"{proof.name}.smt2" if kind == "smt2" else f"{proof.name}.{kind}.aig")
        paths.append(path)
        script += "; design -load model; "
        if kind == "smt2":
            script += f"write_smt2 -wires {path}"
        else:
            script += (f"{statements[kind]}; opt -full; setundef -undriven -anyseq; formalff -clk2ff -ff2anyinit; "
                       f"techmap; simplemap; dffunmap; delete -output; opt_clean; abc -g AND -fast; opt_clean; "
                       f"write_aiger -B -zinit {path}")
    result = run(["yosys", "-q", "-p", script], proof.limit_s, folder)
    if result.returncode != 0 or not all(path.exists() for path in paths):
        said = [line for line in (result.stdout + result.stderr).splitlines() if not line.startswith(">")]
        raise ProofError(f"Yosys failed on {proof.module}: " + "\n".join(said[-3:]))
    return paths


def solve(proof, smt2, options, folder):
    """(passed, output) of yosys-smtbmc."""
    result = run(["yosys-smtbmc", "-s", "z3", "--unroll", "--noprogress", *options, str(smt2)], proof.limit_s, folder)
    output = result.stdout + result.stderr
    if "Status: PASSED" in output:
        return True, output
    if "Status: FAILED" in output:
        return False, output
    raise ProofError(f"yosys-smtbmc gave no verdict on {proof.name}:\n{output[-2000:]}")


def counts_of(aiger):
    """Returns how many rules or covers an AIGER file has, and how many assumptions."""
    # "aig", the largest index, inputs, latches, outputs, gates; then rules and assumptions, if there are any
    header = [int(word) for word in aiger.read_bytes().split(b"\n", 1)[0].split()[1:]] + [0, 0]
    return header[5], header[6]


def said_by_abc(proof, aiger, search, folder):
    """Returns what ABC prints about a search for steps in which a rule is broken and no assumption ever was."""
    # without assumptions, `fold` would take the last rule for one
    fold = "fold; " if counts_of(aiger)[1] else ""
    result = run(["yosys-abc", "-c", f"read {aiger.name}; {fold}strash; {search}"], proof.limit_s, folder)
    return result.stdout + result.stderr


def solve_aiger(proof, aiger, depth, folder, every=False):
    """Returns the steps in which ABC breaks a rule: the first one, or one for every rule that can be broken."""
    # with two clocks, many registers are equal
    search = "scorr; dc2; bmc3 -g" if proof.clocks == 2 else "bmc3"
    output = said_by_abc(proof, aiger, f"{search} -F {depth}{' -a' * every}", folder)
    broken = re.findall(r"Output +\d+ .*was asserted in frame +(\d+)", output)
    if not broken and f"No output asserted in {depth} frames" not in output:
        raise ProofError(f"ABC gave no verdict on {proof.name}:\n{output[-2000:]}")
    return [int(step) for step in broken]


def proved_by_reachability(proof, aiger, folder):
    """Returns whether ABC finds an invariant from which every rule follows, or a trace that breaks one."""
    output = said_by_abc(proof, aiger, "scorr; dc2; pdr", folder)
    if "Property proved" not in output and "was asserted in frame" not in output:
        raise ProofError(f"ABC gave no verdict on {proof.name}:\n{output[-2000:]}")
    return "Property proved" in output


def wrong(output):
    """Returns the lines that say what failed, without the clock."""
    lines = [re.sub(r"^##\s+\S+\s+", "", line) for line in output.splitlines()]
    return [line for line in lines if "failed" in line.lower()]


def check(proof, model, folder):
    """Raises ProofError if a rule does not hold."""
    if proof.kind == "bounded":
        if broken := solve_aiger(proof, model, proof.depth, folder):
            raise ProofError(f"{proof.name}: a rule is broken in step {broken[0]}")
        return
    if proof.kind == "reachability":
        if not proved_by_reachability(proof, model, folder):
            raise ProofError(f"{proof.name}: a rule is broken")
        return
    for options in (["-t", str(proof.depth)], ["-i", "-t", str(proof.depth)]):
        passed, output = solve(proof, model, options, folder)
        if not passed:
            raise ProofError(f"{proof.name} ({' '.join(options)}):\n" + "\n".join(wrong(output)))


def cover(proof, aiger, folder):
    """Returns the number of covers; raises ProofError if one is not reached."""
    covers = counts_of(aiger)[0]
    reached = len(solve_aiger(proof, aiger, proof.cover, folder, every=True))
    if reached < covers or covers == 0:
        raise ProofError(f"{proof.name}: {covers - reached} of {covers} covers not reached within {proof.cover} steps")
    return covers


def prove(proof, folder):
    """Returns one line of the table; raises ProofError if a rule does not hold or a cover is not reached."""
    begin = time.monotonic()
    rules = "smt2" if proof.kind == "induction" else "rules"
    model, aiger = write_models(proof, ROOT / "rtl", folder, rules, "covers")
    check(proof, model, folder)
    covers = cover(proof, aiger, folder)
    parameters = ", ".join(proof.parameters)
    return (f"| `{proof.module}` ({parameters}) | {proof.kind} | {proof.depth} | {proof.clocks} | {covers} | "
            f"{time.monotonic() - begin:.0f} s |")


def expect_failure(fault, folder):
    """Returns one line about the fault; raises ProofError if its proof does not find it."""
    proof = next(proof for proof in PROOFS if proof.name == fault.proof)
    rtl = rtl_tree.plant(folder, fault.file, fault.old, fault.new)
    if proof.kind == "induction" and not fault.bounded:
        model, = write_models(proof, rtl, folder, "smt2")
        found = not solve(proof, model, ["-i", "-t", str(proof.depth)], folder)[0]
    else:
        model, = write_models(proof, rtl, folder, "rules")
        found = solve_aiger(proof, model, fault.bounded or proof.depth, folder)
    if not found:
        raise ProofError(f"{fault.name}: not found by {proof.name}")
    return f"{fault.name}: found"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faults", action="store_true", help="the planted faults instead")
    parser.add_argument("--list", action="store_true", help="the names")
    parser.add_argument("names", nargs="*", metavar="NAME")
    arguments = parser.parse_args()
    if arguments.list:
        print("\n".join([proof.name for proof in PROOFS] + [fault.name for fault in FAULTS]))
        return 0
    known = FAULTS if arguments.faults else PROOFS
    unknown = set(arguments.names) - {entry.name for entry in known}
    if unknown:
        print(f"prove.py: {sorted(unknown)[0]}: no such {'fault' if arguments.faults else 'proof'}", file=sys.stderr)
        return 2
    failed = False
    for entry in known:
        if arguments.names and entry.name not in arguments.names:
            continue
        with tempfile.TemporaryDirectory(prefix="prove.") as folder:
            try:
                action = expect_failure if arguments.faults else prove
                print(action(entry, pathlib.Path(folder)), flush=True)
            except (ProofError, rtl_tree.PlantError) as error:
                print(f"prove.py: {error}", file=sys.stderr)
                failed = True
    if not failed and not arguments.names:
        keep(arguments.faults)
    return 1 if failed else 0


def keep(faults):
    """All proofs, or all planted faults, as results, with the time of one core."""
    times = os.times()
    cpu = {"cpu_s": round(times.user + times.system + times.children_user + times.children_system)}
    if faults:
        results.write("formal_faults", "Planted faults that the proofs of the RTL's blocks have to find",
                      "tests/formal/prove.py --faults", {"planted": len(FAULTS), "missed": 0, **cpu})
    else:
        kinds = [proof.kind for proof in PROOFS]
        results.write("formal", "Proofs of the rules inside the RTL's blocks", "tests/formal/prove.py",
                      {**{kind: kinds.count(kind) for kind in sorted(set(kinds))}, **cpu})


if __name__ == "__main__":
    sys.exit(main())
