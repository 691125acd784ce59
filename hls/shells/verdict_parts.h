// Where parts begin and end, and which settings are in force: rtl/verdict/sp_verdict_parts.sv, register by register, as
// a part of VerdictShell.
#ifndef SELFPROJ_HLS_SHELLS_VERDICT_PARTS_H
#define SELFPROJ_HLS_SHELLS_VERDICT_PARTS_H

#include "hls/types.h"
#include "selfproj/model/generated/selfproj_spec.h"

namespace selfproj {
namespace hls {

using VerdictCount = Uint<24>;  // of the encoder
using VerdictWord = Uint<32>;
// Places of words: those of the registers, and from the middle on {1, bank, section}, the beginnings of sections
using VerdictPlace = Uint<5>;
constexpr int kDefectPlace = (spec::kRegVerdictDefect - spec::kRegVerdictControl) / 4;
constexpr int kShiftPlace = (spec::kRegVerdictShift - spec::kRegVerdictControl) / 4;
constexpr int kLightPlace = (spec::kRegVerdictLight - spec::kRegVerdictControl) / 4;
constexpr int kStartPlace = (spec::kRegVerdictStart - spec::kRegVerdictControl) / 4;
constexpr int kLengthPlace = (spec::kRegVerdictLength - spec::kRegVerdictControl) / 4;
constexpr int kPitchPlace = (spec::kRegVerdictPitch - spec::kRegVerdictControl) / 4;
constexpr int kDelayPlace = (spec::kRegEjectorDelay - spec::kRegVerdictControl) / 4;
constexpr int kSectionPlace = 16;

struct VerdictParts {
  Uint<4> at;  // the step of a frame, 1 to 13, or 0
  bool start;
  VerdictWord word;  // read two clocks ago
  bool by_encoder, hold;
  bool chosen;
  bool waits;
  VerdictCount count, point, way;
  bool over, reached, begins_next;
  bool due, dark;
  Uint<8> dark_frames;
  bool taken;
  bool later;
  bool in_part, first, fresh;
  Uint<16> part;
  bool section;  // of two
  VerdictWord defect, shift;

  void reset() {
    at = 0;
    start = false;
    word = 0;
    by_encoder = false;
    hold = false;
    chosen = false;
    waits = false;
    count = 0;
    point = 0;
    way = 0;
    over = false;
    reached = false;
    begins_next = false;
    due = false;
    dark = false;
    dark_frames = 0;
    taken = false;
    later = false;
    in_part = false;
    first = false;
    fresh = true;
    part = 0;
    section = false;
    defect = (1 << spec::kRegVerdictDefectWidthLsb) | (1 << spec::kRegVerdictDefectHitsLsb);
    shift = 0;
  }

  Uint<1> bank() const { return defect >> spec::kRegVerdictDefectBankLsb; }

  // The word that is read in this clock. Beside a write nothing is read, and the step waits.
  VerdictPlace address() const {
    VerdictPlace place = kDelayPlace;
    if (at >= 1 && at <= 3) {
      place = kLightPlace;
    } else if (at == 4) {
      place = kLengthPlace;
    } else if (at == 5) {
      place = kSectionPlace + 1;
      if (bank() != 0) {
        place = place + 2;
      }
      if (section) {
        place = place - 1;  // there is none behind it
      }
    } else if (at == 6) {
      place = kStartPlace;
    } else if (at >= 7 && at <= 9) {
      place = kPitchPlace;
    } else if (at == 10) {
      place = kDefectPlace;
    } else if (at == 11) {
      place = kShiftPlace;
    }
    return place;
  }

  // A clock. `found` ends a frame, `whole` says that it did not break.
  void step(bool write, bool hold_in, bool by_encoder_in, bool frame, bool restart, const VerdictCount& encoder,
            bool found, bool whole, const Uint<12>& lit, const VerdictWord& read) {
    Uint<4> now = at;  // not const: behind `at = 0` ICSC 1.6.8 would take it for 0, and leave out what depends on it
    const bool chooses = by_encoder && !chosen;
    VerdictCount least = word;
    if (waits) {
      least = 0;
    }
    const Uint<25> beyond = way - least;
    const bool begins = (!hold || taken) && (by_encoder ? (!in_part || over) && reached : begins_next);
    const bool stays = in_part && !(by_encoder && over);
    const VerdictCount old_way = way;
    way = count - point;

    if (!write) {
      if (now == 7) {
        later = (beyond >> 24) == 0;
      }
      if (now == 11) {
        section = !begins && (section || (stays && later));
      }
      if (now == 3) {
        const Uint<12> wanted = word >> spec::kRegVerdictLightLitLsb;
        dark = lit < wanted;
      }
      if (now == 4 && due) {
        dark_frames = dark ? dark_frames + 1 : 0;
      }
      if (now == 6) {
        over = (beyond >> 24) == 0;
      }
      if (now == 10) {
        reached = ((beyond >> 23) & 1) == 0;
      }
      if (first && !hold && now == 12) {
        defect = word;
      }
      if (first && !hold && now == 13) {
        shift = word;
      }
    }
    if (now == 7 && chooses) {
      point = 0;
    } else if (!write && ((now == 8 && chooses) || (now == 11 && begins && !(by_encoder && waits)))) {
      if (by_encoder) {
        point = point + word;
      } else {
        point = point + old_way;
      }
    }
    if (now == 11 && begins) {
      dark_frames = 0;
    }

    if (now == 8 && chooses) {
      waits = true;
    }
    if (now == 11 && !write && (begins || !by_encoder)) {
      waits = false;
    }
    if (now == 11 && !write && begins) {
      fresh = true;
      part = part + 1;
    } else if (found && whole && in_part) {
      fresh = false;
    }
    if (now == 13 && first && !hold) {
      taken = true;
    }

    if (frame && restart) {
      in_part = false;
      first = false;
      begins_next = false;
      chosen = false;
      due = false;
    } else {
      if (!write && now == 5) {
        if (by_encoder != chosen) {
          in_part = false;
        } else if (due && !by_encoder) {
          const Uint<8> most = word >> spec::kRegVerdictLightDarkFramesLsb;
          begins_next = !in_part && !dark;
          in_part = in_part && !(dark && dark_frames >= most);
        }
        due = false;
      }
      if (!write && now == 11) {
        begins_next = false;
        chosen = by_encoder;
        first = begins;
        in_part = stays || begins;
      }
      if (found && whole) {
        due = true;
      }
    }

    start = now == 13 && !write;
    if (!write) {
      at = 0;
      if (now != 0 && now != 13) {
        at = now + 1;
      }
      word = read;
    }
    if (frame) {
      at = 1;
      count = encoder;
      by_encoder = by_encoder_in;
      hold = hold_in;
    }
  }
};

}  // namespace hls
}  // namespace selfproj

#endif  // SELFPROJ_HLS_SHELLS_VERDICT_PARTS_H
