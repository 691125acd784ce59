// The verdict of the circuit, by its model, on the moments that a device delivers.
#ifndef SELFPROJ_HOST_PRODUCTION_VERDICT_RUN_H
#define SELFPROJ_HOST_PRODUCTION_VERDICT_RUN_H

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/production/belt_position.h"
#include "host/production/cutter.h"
#include "host/production/part_result.h"
#include "host/production/verdict_table.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/verdict.h"
#include "selfproj/rig/rig.h"

namespace selfproj::production {

// A frame of a part.
struct JudgedFrame {
  std::uint64_t sequence = 0;
  model::FrameVerdict verdict;
};

// How the verdicts of a board, in its packets, go with those of the model here.
struct BoardAgreement {
  std::uint64_t frames = 0;     // with a verdict of the board
  std::uint64_t defects = 0;    // of these with a defect
  std::uint64_t after_gap = 0;  // not compared: frames before them are missing here, so hits are not the same
  std::uint64_t disagree = 0;
  std::string first;  // about the first disagreement: frame, what both say, the column and its moments
};

// Judges frame after frame. Either at once, with the table's settings, and parts as the table says: what a board does.
// Or, with `tables`, when the host has placed a part: with limits for where the part lies across, from where its
// leading edge passed. A board does the same where that is known before the part comes.
class VerdictRun {
 public:
  // Keeps the first `keep` frames of parts for frames(). Throws UserError, naming `source`, if the table is not one for
  // this rig.
  VerdictRun(const rig::Rig& rig, VerdictTable table, std::string source, std::size_t keep,
             std::unique_ptr<const VerdictTables> tables = nullptr);

  // Takes the next frame: its moments, of as many columns as the header says. Throws UserError if it is not a frame of
  // the table. Frames that gave no profile do not come here; a column's hits are those of the frames that came.
  // `board` is what the board has found, if it says so.
  void add(const model::PacketHeader& header, const std::vector<std::uint32_t>& m0,
           const std::vector<std::uint32_t>& m1, const std::optional<model::FrameVerdict>& board = {});

  // What the model found in the frames of a part, which the host has cut and classified. Nothing if the part is to be
  // judged where it lies, and the host could not place it.
  std::optional<PartMoments> judge(const CutPart& part, const PartResult& result);

  [[nodiscard]] const std::vector<JudgedFrame>& frames() const { return kept_; }
  [[nodiscard]] std::uint64_t judged_frames() const { return judged_frames_; }
  [[nodiscard]] std::uint64_t defect_frames() const { return defect_frames_; }

  // By the rule of the table, or those that were placed.
  [[nodiscard]] std::uint64_t parts() const { return parts_; }
  [[nodiscard]] std::uint64_t parts_with_defect() const { return parts_with_defect_; }

  // The table asks for defects above its limits, or below, but not for both.
  [[nodiscard]] bool one_side_only() const { return table_.settings.above != table_.settings.below; }

  // Nothing is compared where parts are judged when they are placed.
  [[nodiscard]] const BoardAgreement& board() const { return board_; }

 private:
  struct Waiting {
    double belt_mm = 0;
    model::PacketHeader header;
    std::vector<std::uint32_t> m0, m1;
  };

  model::FrameVerdict judge(model::Verdict& model, const model::PartRule& rule, const model::VerdictSettings& settings,
                            const model::PacketHeader& header, const std::vector<std::uint32_t>& m0,
                            const std::vector<std::uint32_t>& m1);
  void compare(const model::PacketHeader& header, const std::vector<std::uint32_t>& m0,
               const std::vector<std::uint32_t>& m1, const model::FrameVerdict& here,
               const std::optional<model::FrameVerdict>& board);
  void judge_placed(const CutPart& part, const Placement& placement);

  rig::Rig rig_;
  VerdictTable table_;
  std::string source_;
  std::size_t keep_;
  std::unique_ptr<const VerdictTables> tables_;
  model::Verdict model_;
  BeltPosition belt_;
  std::size_t max_waiting_ = 0;
  std::deque<Waiting> waiting_;     // for their part to be placed
  std::deque<JudgedFrame> recent_;  // of the parts that were not yet asked for, at most
  std::vector<JudgedFrame> kept_;
  std::uint64_t judged_frames_ = 0, defect_frames_ = 0, parts_ = 0, parts_with_defect_ = 0;
  BoardAgreement board_;
  std::optional<std::uint64_t> last_sequence_;  // of the frames that came
  bool in_step_ = false;                        // the part that passes began here as on the board
  std::optional<std::uint32_t> part_;           // the newest one's number
  bool defect_ = false;                         // it has one
};

// The frames of parts as a table: sequence, part, section, defect, first_column, columns, unlit, lacks_light.
std::string judged_csv(const std::vector<JudgedFrame>& frames);

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_VERDICT_RUN_H
