// Tests a newcomer's steps live: calibrate, then scan. Aravis' fake GigE camera looks at a scene that a virtual display
// lights. Nothing in the program knows that they are not real.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host/images/image_files.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/gray_sequence.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"
#include "sim/scene/targets.h"
#include "tests/cli/program.h"
#include "tests/host/camera/gige_camera.h"
#include "tests/host/capture/live_world.h"
#include "tests/support/virtual_screen.h"

namespace selfproj::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCamera = "camera:127.0.0.1?region=128x128";

// The program with a pipe for its standard input, so that a test can answer what it asks.
class Dialogue {
 public:
  Dialogue(const std::vector<std::string>& arguments, const fs::path& folder) : folder_(folder) {
    mkfifo((pipes_ / "answers").c_str(), 0600);
    std::string line = "exec \"$0\" \"$@\" < " + (pipes_ / "answers").string() + " > " + (pipes_ / "said").string();
    std::vector<std::string> words = {"-c", line, SELFPROJ_PROGRAM};
    words.insert(words.end(), arguments.begin(), arguments.end());
    program_ = std::thread([this, words] { outcome_ = run_program("/bin/sh", words, folder_); });
    answers_.open(pipes_ / "answers");
  }
  Dialogue(const Dialogue&) = delete;
  Dialogue& operator=(const Dialogue&) = delete;
  ~Dialogue() { end(); }

  // Waits until the program has asked `count` times. Returns false after a minute.
  bool waits(int count) {
    for (int i = 0; i < 600; ++i) {
      if (asked() >= count) {
        return true;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return false;
  }

  // Waits likewise, and answers.
  bool answer(int count, const std::string& text) {
    if (!waits(count)) {
      return false;
    }
    answers_ << text << std::endl;
    return true;
  }

  // How it ended, and all that it said.
  Outcome end() {
    answers_.close();
    if (program_.joinable()) {
      program_.join();
      outcome_.out = read_text(pipes_ / "said");
    }
    return outcome_;
  }

 private:
  int asked() {
    if (!fs::exists(pipes_ / "said")) {
      return 0;
    }
    const std::string said = read_text(pipes_ / "said");
    int count = 0;
    for (std::size_t at = said.find("Press Enter to capture"); at != std::string::npos;
         at = said.find("Press Enter to capture", at + 1)) {
      ++count;
    }
    return count;
  }

  ScratchFolder pipes_;
  fs::path folder_;
  std::thread program_;
  std::ofstream answers_;
  Outcome outcome_;
};

class LiveCalibration : public LiveTest {
 protected:
  LiveCalibration() : LiveTest(small_scanner(4, 4)) {}
  void prepare() override {
    const sim::PerturbedRig actual(rig_);
    const sim::ChessboardShape shape{6, 5, 30};
    for (const sim::ChessboardPlace& place : sim::chessboard_places(actual, shape, 6, 25)) {
      poses_.push_back(std::make_unique<sim::ChessboardScene>(rig_, shape, place));
    }
    plane_ = sim::make_scene("plane", rig_);
    look(*plane_, {.max_delay_ms = 20});
  }

  // Runs a command that has no end, until Ctrl-C after two seconds.
  Outcome until_ctrl_c(const std::vector<std::string>& words) {
    std::vector<std::string> timed = {"--foreground", "--preserve-status", "-s", "INT", "2", SELFPROJ_PROGRAM};
    timed.insert(timed.end(), words.begin(), words.end());
    return run_program("/usr/bin/timeout", timed, folder_.path());
  }

  // Takes all poses by dialogue; the first is taken back, and taken again.
  Outcome calibrate(const std::vector<std::string>& words) {
    Dialogue dialogue(words, folder_.path());
    int asked = 0;
    const auto answer = [&](const std::string& text) { EXPECT_TRUE(dialogue.answer(++asked, text)); };
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      EXPECT_TRUE(dialogue.waits(asked + 1));  // the capture of the pose before has ended
      world_->look_at(*poses_[i]);
      answer("");
      if (i == 0) {
        answer("u");
        answer("");
      }
    }
    answer("d");
    return dialogue.end();
  }

  // What the camera sees under each pattern of the sequence, without display, camera and network.
  void record(const std::string& name, int count) {
    fs::create_directory(folder_ / name);
    for (int i = 0; i < count; ++i) {
      const images::Image image = world_->image_under({gray_.rows(), gray_.columns(), gray_.image(i)});
      write_text(folder_ / name / ("image_" + std::to_string(i) + ".png"), images::encode_png(image));
    }
  }

  // The median distance in mm of depths from the truth.
  double error_of(const std::string& folder) {
    const std::vector<float> truth = world_->truth();
    const DepthErrors errors = depth_errors(folder_ / folder / "depth.tiff", truth);
    EXPECT_GT(errors.pixels, truth.size() / 2) << folder;
    return errors.median_mm;
  }

  structured_light::GraySequence gray_{rig_.projector.columns, rig_.projector.lines};
  std::vector<std::unique_ptr<sim::Scene>> poses_;
  std::unique_ptr<sim::Scene> plane_;
};

// The command lines of the blocks `sh` of a document, each in words, for this rig in place of the document's.
std::vector<std::vector<std::string>> commands_of(const fs::path& document) {
  std::string text = read_text(document);
  for (const auto& [from, to] : {std::pair<std::string, std::string>{" \\\n", " "},
                                 {"camera:192.168.1.20", kCamera},
                                 {"--display 1", "--display 0"},
                                 {"--chessboard 9x6 --square 25", "--chessboard 6x5 --square 30"},
                                 {"1280x800", "256x192"}}) {
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
      if (!text.substr(at).starts_with("camera:192.168.1.20?")) {
        text.replace(at, from.size(), to);
      }
    }
  }
  std::vector<std::vector<std::string>> commands;
  std::istringstream lines(text);
  bool inside = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("```")) {
      inside = line == "```sh";
    } else if (inside) {
      std::istringstream words(line);
      commands.emplace_back(std::istream_iterator<std::string>(words), std::istream_iterator<std::string>());
    }
  }
  return commands;
}

// docs/first-scan.md, command by command, as its reader types them. The depth is as good as by the recorded route: the
// same scenes by the renderer, calibrated and measured from files.
TEST_F(LiveCalibration, TheFirstScanPage) {
  const std::unique_ptr<sim::Scene> part = sim::make_scene("block", rig_);
  const auto commands = commands_of(fs::path(SELFPROJ_SOURCE_DIR) / "docs" / "first-scan.md");
  ASSERT_EQ(commands.size(), 10U);
  for (const std::vector<std::string>& command : commands) {
    ASSERT_EQ(command.at(0), "selfproj");
    const std::vector<std::string> words(command.begin() + 1, command.end());
    world_->look_at(words.back() == "part" ? *part : *plane_);
    const Outcome outcome = words.at(0) == "calibrate"                           ? calibrate(words)
                            : words.at(0) == "capture" && words.back() == "8080" ? until_ctrl_c(words)
                                                                                 : run(words);
    ASSERT_EQ(outcome.status, 0) << words.at(0) << ": " << outcome.err << outcome.out;
  }
  for (const char* file : {"chessboard.svg", "gamma.csv", "calibration/pose_06/image_0034.png", "scan/report.html",
                           "scan/cloud.ply", "part/difference.png", "part/report.html"}) {
    EXPECT_TRUE(fs::exists(folder_ / file)) << file;
  }
  EXPECT_FALSE(fs::exists(folder_ / "calibration" / "pose_07"));

  std::vector<std::string> recorded = {"calibrate", "--projector", "256x192", "--chessboard", "6x5",
                                       "--square",  "30",          "--out",   "known"};
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    world_->look_at(*poses_[i]);
    recorded.push_back("pose_" + std::to_string(i));
    record(recorded.back(), gray_.count());
  }
  const Outcome known = run(recorded);
  ASSERT_EQ(known.status, 0) << known.err;
  world_->look_at(*plane_);
  record("plane", gray_.count());
  const Outcome depth = run({"depth", "--rig", "known/rig.yaml", "--bits", std::to_string(gray_.column_bits()),
                             "--row-bits", std::to_string(gray_.row_bits()), "--out", "known_depth", "plane"});
  ASSERT_EQ(depth.status, 0) << depth.err;
  const double files = error_of("known_depth");
  EXPECT_LT(error_of("scan"), 1.5 * files + 0.5) << "mm; files " << files;
}

TEST_F(LiveCalibration, AnswersThatAreNoneAndNoPoses) {
  const std::vector<std::string> before = folder_.names();
  Dialogue dialogue({"calibrate", "--camera", kCamera, "--chessboard", "6x5", "--square", "30", "--out", "live"},
                    folder_.path());
  ASSERT_TRUE(dialogue.answer(1, "what?"));
  ASSERT_TRUE(dialogue.answer(2, "u"));
  ASSERT_TRUE(dialogue.answer(3, "d"));
  const Outcome ended = dialogue.end();
  EXPECT_EQ(ended.status, 1);
  EXPECT_EQ(ended.err, "selfproj: live: no pose was taken; at least two are needed, and nothing is written\n");
  EXPECT_NE(ended.out.find("'what?' is not one of the answers.\n"), std::string::npos) << ended.out;
  EXPECT_NE(ended.out.find("There is no pose to discard.\n"), std::string::npos) << ended.out;
  EXPECT_EQ(folder_.names(), before);
}

// Poses that were taken are not lost: not when a capture fails, and not when they do not determine the rig, as one pose
// taken twice does not. They can be calibrated from then.
TEST_F(LiveCalibration, PosesAreKeptWhenTheRestFails) {
  Dialogue dialogue(
      {"calibrate", "--camera", kCamera, "--chessboard", "6x5", "--square", "30", "--settle-ms", "30", "--out", "live"},
      folder_.path());
  ASSERT_TRUE(dialogue.answer(1, ""));  // there is no chessboard
  ASSERT_TRUE(dialogue.waits(2));
  world_->look_at(*poses_[0]);
  ASSERT_TRUE(dialogue.answer(2, ""));
  ASSERT_TRUE(dialogue.answer(3, ""));
  ASSERT_TRUE(dialogue.waits(4));
  world_->put_cap_on();
  ASSERT_TRUE(dialogue.answer(4, ""));
  ASSERT_TRUE(dialogue.answer(5, "d"));
  const Outcome ended = dialogue.end();
  EXPECT_EQ(ended.status, 1);
  EXPECT_NE(ended.out.find("This pose is not used: no chessboard of 6 x 5 inner corners is completely visible\n"),
            std::string::npos)
      << ended.out;
  EXPECT_NE(ended.out.find("This pose was not captured: camera:127.0.0.1: sees no light"), std::string::npos)
      << ended.out;
  const std::string kept =
      "; the poses are kept: live/pose_* with --projector 256x192 instead of --camera calibrates from them, and from "
      "further ones\n";
  ASSERT_TRUE(ended.err.ends_with(kept)) << ended.err;
  const Outcome again = run({"calibrate", "--projector", "256x192", "--chessboard", "6x5", "--square", "30", "--out",
                             "again", "live/pose_01", "live/pose_02"});
  EXPECT_EQ(again.status, 1);
  EXPECT_EQ(again.err, ended.err.substr(0, ended.err.size() - kept.size()) + "\n");
  EXPECT_FALSE(fs::exists(folder_ / "again"));
  EXPECT_FALSE(fs::exists(folder_ / "live" / "report.json"));
}

// A folder that cannot take the poses is refused before the first one.
TEST_F(LiveCalibration, AFolderThatIsThereIsRefusedAtOnce) {
  fs::create_directory(folder_ / "live");
  const Outcome refused =
      run({"calibrate", "--camera", kCamera, "--chessboard", "6x5", "--square", "30", "--out", "live"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_EQ(refused.err, "selfproj: live: exists already; a new folder is needed for results in folders\n");
  EXPECT_EQ(refused.out, "");
}

}  // namespace
}  // namespace selfproj::test
