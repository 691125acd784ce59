// Tests `selfproj tolerance learn` and `selfproj inspect --parts` from the command line, and Modbus.
#include <gtest/gtest.h>
#include <modbus/modbus-tcp.h>
#include <modbus/modbus.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "host/production/modbus_server.h"
#include "selfproj/images/float_image.h"
#include "tests/cli/program.h"
#include "tests/host/production/made_packets.h"

namespace selfproj::test {
namespace {

using Words = std::vector<std::string>;

// A rig, a tolerance learned from eight good parts, and a run of six parts, the third and the fifth with a dent.
class PartsCommand : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new ScratchFolder;
    const rig::Rig rig = rig_of_made_packets();
    write_text(*folder_ / "rig.yaml", rig::to_yaml(rig));
    MadePackets good(rig, 3);
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> any(-1, 1);
    for (int i = 0; i < 8; ++i) {
      good.pass(made_part(false, any(random), any(random)), 5);
    }
    good.bare(1);
    write_text(*folder_ / "good.packets", good.text());
    MadePackets run(rig, 4);
    for (int i = 0; i < 6; ++i) {
      run.pass(made_part(i == 2 || i == 4, any(random), any(random)), 5);
    }
    run.bare(1);
    write_text(*folder_ / "run.packets", run.text());
    learned_ = new Outcome(
        host({"tolerance", "learn", "--rig", "rig.yaml", "--device", "file:good.packets", "--out", "tolerance.yaml"}));
  }
  static void TearDownTestSuite() {
    delete learned_;
    delete folder_;
  }

  static Outcome host(const Words& words) { return run_program(SELFPROJ_PROGRAM, words, folder_->path()); }
  static Outcome inspect(Words more) {
    more.insert(more.begin(), {"inspect", "--rig", "rig.yaml", "--device", "file:run.packets"});
    return host(more);
  }

  inline static ScratchFolder* folder_ = nullptr;  // NOLINT(readability-identifier-naming): a member
  inline static Outcome* learned_ = nullptr;       // NOLINT(readability-identifier-naming): a member
};

TEST_F(PartsCommand, LearnsAndJudges) {
  ASSERT_EQ(learned_->status, 0) << learned_->err;
  EXPECT_EQ(learned_->out.rfind("8 good parts; ", 0), 0U) << learned_->out;
  const Outcome old = host({"tolerance", "learn", "--rig", "rig.yaml", "--device", "file:good.packets", "--out",
                            "old.yaml", "--shift-mm", "2", "--turn-deg=3", "--smallest-mm2", "0.5"});
  EXPECT_EQ(old.err,
            "note: --shift-mm is now --max-shift-mm\nnote: --turn-deg is now --max-turn-deg\n"
            "note: --smallest-mm2 is now --min-defect-mm2\n");
  EXPECT_EQ(read_text(*folder_ / "old.yaml"), read_text(*folder_ / "tolerance.yaml"));
  const Outcome run = inspect({"--tolerance", "tolerance.yaml", "--parts", "run", "--json", "counts.json"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("6 parts: 4 good, 2 bad, 0 inconclusive; result after the last frame p50 "), std::string::npos)
      << run.out;
  const auto counts = nlohmann::json::parse(read_text(*folder_ / "counts.json"));
  EXPECT_EQ(counts.at("parts"), 6);
  EXPECT_EQ(counts.at("parts_bad"), 2);
  EXPECT_EQ(counts.at("part_folders"), 2);
  EXPECT_GT(counts.at("result_delay_p99_ms"), 0);

  std::istringstream lines(read_text(*folder_ / "run/parts.jsonl"));
  std::istringstream table(read_text(*folder_ / "run/parts.csv"));
  std::string line;
  std::string row;
  std::getline(table, row);
  EXPECT_EQ(row.rfind("part,verdict,begin_mm,", 0), 0U);
  int number = 0;
  while (std::getline(lines, line)) {
    ++number;
    const auto part = nlohmann::json::parse(line);
    const bool dent = number == 3 || number == 5;
    EXPECT_EQ(part.at("part"), number);
    EXPECT_EQ(part.at("verdict"), dent ? "bad" : "good") << line;
    EXPECT_NEAR(part.at("placement").at("length_mm").get<double>(), 20, 0.4);
    ASSERT_TRUE(std::getline(table, row));
    EXPECT_EQ(row.rfind(std::to_string(number) + (dent ? ",bad," : ",good,"), 0), 0U) << row;
    const std::string folder = "run/part_00000" + std::to_string(number);
    EXPECT_EQ(std::filesystem::exists(*folder_ / folder), dent);
    if (dent) {
      ASSERT_EQ(part.at("defects").size(), 1U) << line;
      const auto& defect = part.at("defects")[0];
      EXPECT_NEAR(defect.at("along_mm").get<double>(), 12, 0.4);
      EXPECT_NEAR(defect.at("across_mm").get<double>(), 5, 0.4);
      EXPECT_NEAR(defect.at("depth_mm").get<double>(), -0.5, 0.08);
      EXPECT_EQ(nlohmann::json::parse(read_text(*folder_ / (folder + "/result.json"))), part);
      const images::FloatImage difference =
          images::read_float_tiff(*folder_ / (folder + "/difference.tiff"));  // from the plane
      EXPECT_NEAR(difference.row((12 + 2) * 4)[(5 + 20 + 2) * 4], 7.5, 0.1);
      EXPECT_GT(std::filesystem::file_size(*folder_ / (folder + "/difference.png")), 1000U);
    }
  }
  EXPECT_EQ(number, 6);
  const auto statistics = nlohmann::json::parse(read_text(*folder_ / "run/statistics.json"));
  EXPECT_EQ(statistics.at("length_mm").at("parts"), 6);
  EXPECT_NEAR(statistics.at("length_mm").at("mean").get<double>(), 20, 0.4);
}

TEST_F(PartsCommand, KeepsNoMoreFoldersThanTold) {
  const Outcome run =
      inspect({"--tolerance", "tolerance.yaml", "--parts", "few", "--keep-parts", "1", "--json", "few.json"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_TRUE(std::filesystem::exists(*folder_ / "few/part_000003"));
  EXPECT_FALSE(std::filesystem::exists(*folder_ / "few/part_000005"));
  EXPECT_EQ(nlohmann::json::parse(read_text(*folder_ / "few.json")).at("part_folders_left_out"), 1);
}

TEST_F(PartsCommand, SaysThatAllWasTooShort) {
  std::string rig = read_text(*folder_ / "rig.yaml");
  const std::size_t at = rig.find("min_length_mm: ");
  ASSERT_NE(at, std::string::npos);
  rig.replace(at, rig.find('\n', at) - at, "min_length_mm: 22");
  write_text(*folder_ / "long.yaml", rig);
  const Outcome run = host({"inspect", "--rig", "long.yaml", "--device", "file:run.packets", "--tolerance",
                            "tolerance.yaml", "--parts", "none", "--json", "none.json"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("0 parts: 0 good, 0 bad, 0 inconclusive → none\n"), std::string::npos) << run.out;
  EXPECT_NE(run.err.find("no part was cut: 6 times something came that is shorter than min_length_mm (22 mm)"),
            std::string::npos)
      << run.err;
  EXPECT_EQ(nlohmann::json::parse(read_text(*folder_ / "none.json")).at("specks"), 6);
}

// The run's parts, which come every 30 mm, judged by moments: as by heights. The line meets the first one 4.8 mm behind
// its leading edge's place at 55 mm.
TEST_F(PartsCommand, JudgesMomentsByATable) {
  const Outcome made = host({"verdict", "table", "--rig", "rig.yaml", "--tolerance", "tolerance.yaml", "--start",
                             "5980", "--pitch", "3000", "--max-shift", "1", "--out", "verdict.yaml"});
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_NE(made.out.find(" of 512 columns are judged, in 1 section; a column is 0.23"), std::string::npos) << made.out;
  EXPECT_NE(made.out.find("a defect: 2 neighbouring columns (w) out in 6 (m) of 6 frames (h), too high or too low; too "
                          "high is below the band\n"),
            std::string::npos)
      << made.out;
  // From the first limits to the last
  EXPECT_NE(made.out.find("parts are judged from count 6"), std::string::npos) << made.out;
  EXPECT_NE(made.out.find(" on, every 3000 counts, for 1"), std::string::npos) << made.out;
  const Outcome shown = host({"verdict", "show", "verdict.yaml", "--across", "0.7", "--higher", "-0.4"});
  ASSERT_EQ(shown.status, 0) << shown.err;
  EXPECT_NE(shown.out.find("shift of the settings: 3 columns (up to 5 are allowed), -1.0"), std::string::npos)
      << shown.out;

  for (const bool placed : {false, true}) {
    const std::string name = placed ? "placed" : "as-told";
    Words words = {"--tolerance", "tolerance.yaml", "--verdict", "verdict.yaml", "--parts",
                   name + "/p",   "--out",          name + "/o", "--json",       name + ".json"};
    if (placed) {
      words.emplace_back("--verdict-placed");
    }
    std::filesystem::create_directory(*folder_ / name);
    const Outcome run = inspect(words);
    ASSERT_EQ(run.status, 0) << run.err;
    EXPECT_NE(run.out.find("by moments 2 of 6 parts have a defect, in "), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("; as by heights 6, more 0, less 0\n"), std::string::npos) << run.out;
    const auto counts = nlohmann::json::parse(read_text(*folder_ / (name + ".json")));
    EXPECT_EQ(counts.at("verdict_parts"), 6);
    EXPECT_EQ(counts.at("verdict_parts_with_defect"), 2);
    EXPECT_EQ(counts.at("verdict_agrees"), 6);
    const auto summary = nlohmann::json::parse(read_text(*folder_ / (name + "/o/summary.json")));
    EXPECT_EQ(summary.at("counters").at("verdict_defect_frames"), counts.at("verdict_defect_frames"));

    // Each line of the table is a frame of a part; those with a defect are those of the parts.
    std::istringstream table(read_text(*folder_ / (name + "/o/verdict.csv")));
    std::string row;
    std::getline(table, row);
    EXPECT_EQ(row, "sequence,part,section,defect,first_column,columns,unlit,lacks_light");
    std::uint64_t frames = 0;
    std::uint64_t defects = 0;
    while (std::getline(table, row)) {
      ++frames;
      const std::size_t section = row.find(',', row.find(',') + 1);
      defects += row.at(row.find(',', section + 1) + 1) == '1' ? 1 : 0;
    }
    EXPECT_EQ(frames, counts.at("verdict_frames").get<std::uint64_t>());
    std::istringstream lines(read_text(*folder_ / (name + "/p/parts.jsonl")));
    std::string line;
    std::uint64_t of_parts = 0;
    while (std::getline(lines, line)) {
      const auto part = nlohmann::json::parse(line);
      const auto& moments = part.at("moments");
      EXPECT_EQ(moments.at("defect"), part.at("verdict") == "bad") << line;
      EXPECT_GT(moments.at("frames"), 100) << line;
      of_parts += moments.at("defect_frames").get<std::uint64_t>();
      if (moments.at("defect")) {  // 3 mm at 5 mm across
        EXPECT_GE(moments.at("columns"), 10);
        EXPECT_NEAR(moments.at("first_column").get<int>(), 256 + (5 - 1.5) / 0.2318, 6) << line;
      }
    }
    EXPECT_EQ(of_parts, defects);
    EXPECT_GT(defects, 30U);
  }

  // A table that finds none of the bad parts, and one by which every second part never begins
  const std::string text = read_text(*folder_ / "verdict.yaml");
  for (const auto& [name, from, to, why] :
       {std::array<std::string, 4>{"blind", "width: 2", "width: 60", "by moments 2 of the 2 bad parts have no defect"},
        {"rare", "pitch_counts: 3000", "pitch_counts: 6000", "by moments 3 parts came"}}) {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), to);
    write_text(*folder_ / (name + ".yaml"), changed);
    const Outcome run =
        inspect({"--tolerance", "tolerance.yaml", "--verdict", name + ".yaml", "--parts", name, "--check"});
    EXPECT_EQ(run.status, 1);
    EXPECT_NE(run.err.find(why), std::string::npos) << run.err;
  }
}

TEST_F(PartsCommand, VerdictRefusesInOneLine) {
  const auto error = [](const Outcome& outcome) {
    EXPECT_EQ(outcome.status, 2);
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    return outcome.err;
  };
  const auto table = [&](Words more) {
    more.insert(more.begin(),
                {"verdict", "table", "--rig", "rig.yaml", "--tolerance", "tolerance.yaml", "--out", "refused.yaml"});
    return error(host(more));
  };
  EXPECT_NE(table({}).find("--start: is needed: "), std::string::npos);
  const Words evenly = {"--start", "0", "--pitch", "3000"};
  const auto with = [&](Words more) {
    more.insert(more.end(), evenly.begin(), evenly.end());
    return table(more);
  };
  EXPECT_NE(with({"--defect", "2"}).find("--defect 2: is not WIDTHxLENGTH"), std::string::npos);
  EXPECT_NE(with({"--defect", "2x-1"}).find("--defect 2x-1: is not WIDTHxLENGTH"), std::string::npos);
  EXPECT_NE(with({"--shift", "1.5", "--max-shift", "1"}).find("--shift: and --max-shift together are 2.5 mm"),
            std::string::npos);
  EXPECT_NE(with({"--play-across", "50"}).find("no column of made can be judged"), std::string::npos);
  EXPECT_NE(table({"--start", "0"}).find("--start"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(*folder_ / "refused.yaml"));
  EXPECT_NE(error(inspect({"--verdict", "tolerance.yaml"})).find("tolerance.yaml: "), std::string::npos);
  EXPECT_NE(error(inspect({"--verdict-placed"})).find("--verdict"), std::string::npos);
  EXPECT_NE(error(host({"verdict", "show", "none.yaml"})).find("none.yaml: "), std::string::npos);
}

TEST_F(PartsCommand, BadInputIsOneLine) {
  const auto error = [](const Outcome& outcome) {
    EXPECT_EQ(outcome.status, 2);
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    return outcome.err;
  };
  EXPECT_NE(error(inspect({"--parts", "x"})).find("--parts: needs --tolerance"), std::string::npos);
  EXPECT_NE(error(inspect({"--tolerance", "none.yaml"})).find("none.yaml: "), std::string::npos);
  EXPECT_NE(error(host({"inspect", "--rig", "rig.yaml", "--device", "file:rig.yaml", "--tolerance", "tolerance.yaml"}))
                .find("file:rig.yaml: holds no packet of a board, but "),
            std::string::npos);
  write_text(*folder_ / "empty.packets", "");
  EXPECT_NE(error(host({"inspect", "--rig", "rig.yaml", "--device", "file:empty.packets", "--out", "nothing"}))
                .find("file:empty.packets: holds no packet of a board\n"),
            std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(*folder_ / "nothing"));
  EXPECT_NE(error(inspect({"--tolerance", "tolerance.yaml", "--modbus", "0"})).find("--modbus 0: is neither a port"),
            std::string::npos);
  std::filesystem::create_directory(*folder_ / "full");
  write_text(*folder_ / "full/file", "");
  EXPECT_NE(error(inspect({"--tolerance", "tolerance.yaml", "--parts", "full"})).find("full: is not empty"),
            std::string::npos);
  EXPECT_NE(error(host({"inspect", "--device", "file:run.packets", "--tolerance", "tolerance.yaml"}))
                .find("--rig: light-section has no section `parts`"),
            std::string::npos);
  EXPECT_NE(error(host({"tolerance", "learn", "--rig", "rig.yaml", "--device", "file:good.packets", "--out", "t.yaml",
                        "--count", "900"}))
                .find("good parts came; at least 5 are needed"),
            std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(*folder_ / "t.yaml"));

  // Regions that cannot be judged or told apart.
  const std::string learned = read_text(*folder_ / "tolerance.yaml");
  const auto judged_by = [&](const std::string& text) {
    write_text(*folder_ / "changed.yaml", text);
    return error(inspect({"--tolerance", "changed.yaml"}));
  };
  std::string coarse = learned;
  const std::size_t defect = coarse.find("min_defect_mm2: ");
  coarse.replace(defect, coarse.find('\n', defect) - defect, "min_defect_mm2: 900");
  EXPECT_NE(judged_by(coarse).find("has no room for a square of min_defect_mm2, 900 mm²"), std::string::npos);
  EXPECT_NE(judged_by(learned + learned.substr(learned.find("  - name: "))).find("is there twice"), std::string::npos);
  EXPECT_NE(error(host({"tolerance", "learn", "--rig", "rig.yaml", "--device", "file:good.packets", "--min-defect-mm2",
                        "900", "--out", "t.yaml"}))
                .find("has room for a square of the smallest defect's area, 900 mm²"),
            std::string::npos);

  // Of another part.
  std::string other = read_text(*folder_ / "tolerance.yaml");
  const std::size_t at = other.find("heights_mm: [") + 13;
  other.insert(at, "7");
  write_text(*folder_ / "other.yaml", other);
  EXPECT_NE(error(inspect({"--tolerance", "other.yaml"})).find("other.yaml: is for another part: at "),
            std::string::npos);

  // A port that is taken.
  const production::ModbusServer taken({.port = 15020},
                                       [] { return std::array<std::uint16_t, production::kModbusRegisters>{}; });
  EXPECT_NE(error(inspect({"--tolerance", "tolerance.yaml", "--modbus", "15020"}))
                .find("--modbus 127.0.0.1:15020: Address already in use"),
            std::string::npos);
}

using Client = std::unique_ptr<modbus_t, void (*)(modbus_t*)>;
Client client_of(int port) {
  Client client(modbus_new_tcp("127.0.0.1", port), [](modbus_t* context) {
    modbus_close(context);
    modbus_free(context);
  });
  EXPECT_EQ(modbus_connect(client.get()), 0) << modbus_strerror(errno);
  return client;
}

TEST(Modbus, TellsWhatIsThereAndTakesNothing) {
  production::PartCounts state;
  state.verdicts = {70'000, 3, 2};
  state.specks = 5;
  state.last_part = 70'005;
  state.last_verdict = production::Verdict::bad;
  state.last_defects = 2;
  state.last_depth_mm = -0.3;
  state.last_delay_ns = 4'500'000;
  state.last_ns = 1'000'000'000;
  state.last_moments = production::PartMoments{.frames = 40, .defect_frames = 3};
  state.by_moments = 6;
  state.board_disagrees = 65'537;
  const production::ModbusServer server({.port = 15021},
                                        [&] { return production::modbus_registers(state, 9, 17, 1'250'000'000); });
  const std::array<std::uint16_t, production::kModbusRegisters> expected = {
      1, 17, 2, 1, 4469, 1, 4464, 0, 3, 0, 2, 0, 250, 2, 65236, 0, 4500, 0, 9, 0, 5, 2, 0, 6, 1, 1};
  const Client client = client_of(15021);
  std::array<std::uint16_t, production::kModbusRegisters> values{};
  ASSERT_EQ(modbus_read_input_registers(client.get(), 0, production::kModbusRegisters, values.data()),
            int{production::kModbusRegisters});
  EXPECT_EQ(values, expected);
  ASSERT_EQ(modbus_read_registers(client.get(), 2, 3, values.data()), 3);
  EXPECT_EQ(values[0], 2);
  EXPECT_EQ(modbus_write_register(client.get(), 2, 1), -1);
  EXPECT_EQ(errno, EMBXILFUN);
  EXPECT_EQ(modbus_read_registers(client.get(), production::kModbusRegisters - 1, 2, values.data()), -1);
  EXPECT_EQ(errno, EMBXILADD);

  // Requests that are none, beside a client that goes on being served.
  std::mt19937_64 random(1);
  for (int i = 0; i < 300; ++i) {
    const Client rude = client_of(15021);
    std::vector<std::uint8_t> bytes(1 + random() % 300);
    std::generate(bytes.begin(), bytes.end(), [&] { return static_cast<std::uint8_t>(random()); });
    if (i % 2 == 0 && bytes.size() > 8) {  // a head that promises a request
      bytes[2] = bytes[3] = bytes[4] = 0;
      bytes[5] = static_cast<std::uint8_t>(bytes.size() - 6);
    }
    ASSERT_GT(send(modbus_get_socket(rude.get()), bytes.data(), bytes.size(), MSG_NOSIGNAL), 0);
    if (i % 50 == 0) {
      ASSERT_EQ(modbus_read_input_registers(client.get(), 0, production::kModbusRegisters, values.data()),
                int{production::kModbusRegisters})
          << modbus_strerror(errno);
      EXPECT_EQ(values, expected);
    }
  }
  ASSERT_EQ(modbus_read_input_registers(client.get(), 0, production::kModbusRegisters, values.data()),
            int{production::kModbusRegisters});
  EXPECT_EQ(values, expected);
}

}  // namespace
}  // namespace selfproj::test
