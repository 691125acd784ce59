// make_parts FOLDER: a rig, a tolerance, good parts, and a run of parts of which every third has a dent, as packets;
// and the registers of a board, `bar`.
#include <cstdio>
#include <random>

#include "tests/cli/program.h"
#include "tests/host/production/made_packets.h"
#include "tests/support/board_registers.h"

int main(int argc, char** argv) {
  using namespace selfproj;        // NOLINT(google-build-using-namespace)
  using namespace selfproj::test;  // NOLINT(google-build-using-namespace)
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_parts FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  const rig::Rig rig = rig_of_made_packets();
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> any(-1, 1);
  MadePackets good(rig, 1);
  MadePackets run(rig, 2);
  for (int i = 0; i < 9; ++i) {
    good.pass(made_part(false, any(random), any(random)), 5);
    run.pass(made_part(i % 3 == 2, any(random), any(random)), 5);
  }
  good.bare(1);
  run.bare(1);
  write_text(folder / "rig.yaml", rig::to_yaml(rig));
  write_text(folder / "good.packets", good.text());
  write_text(folder / "run.packets", run.text());
  write_text(folder / "bar", register_bytes());
  return 0;
}
