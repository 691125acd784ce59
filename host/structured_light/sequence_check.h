// Whether images of a Gray code are what they are taken for, as far as they can tell by themselves: an image that is
// late, missing, or in another place of the sequence; planes in another order; positives taken for negatives; a code
// that runs the other way than the geometry says, or that reaches beyond the projector.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_SEQUENCE_CHECK_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_SEQUENCE_CHECK_H

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "selfproj/model/column_moments.h"
#include "selfproj/structured_light/triangulation.h"

namespace selfproj::structured_light {

// Keeps the newest image of each pattern, of large ones a part in tiles, and looks at the pixels that the projector
// lights clearly: their contrast is far above the noise, which the images tell too.
class SequenceCheck {
 public:
  // `bits` pairs, positive and negative of each plane in turn, most significant first. `cyclic`: after the greatest
  // code the least may follow.
  SequenceCheck(int rows, int columns, int bits, bool cyclic = false);

  // Takes image `pattern`, 0..2 bits - 1.
  void add(int pattern, const model::ImageView& image);

  // The plane whose pair contradicts the others most, if any does. Both images of a pair together have the light of
  // white and black, the same for every pair. If one of them shows another pattern, many pixels are dark in both, or
  // bright in both. A bent curve of the camera and coarse pixels change this sum much less.
  struct Pair {
    int plane = 0;
    double share = 0;  // of the lit pixels
  };
  [[nodiscard]] std::optional<Pair> unpaired() const;

  // The plane at whose borders the code jumps, if there is one. From a pixel to its neighbour the code of a smooth
  // surface changes by one where one bit of the Gray code changes. It does not where the planes are in another order,
  // or positive and negative of some are exchanged.
  struct Jump {
    int plane = 0;
    std::size_t jumps = 0;    // borders where it does not change by one
    std::size_t borders = 0;  // of all borders of the plane
  };
  [[nodiscard]] std::optional<Jump> jumping() const;

  // A plane with narrower stripes than a later one, which should have the narrower ones: it is clear in fewer pixels,
  // or changes much more often.
  struct Coarse {
    int plane = 0;
    int later = 0;
  };
  [[nodiscard]] std::optional<Coarse> coarser() const;

  // Whether the second image is darker than the first wherever the projector lights the scene.
  [[nodiscard]] static bool is_white_and_black(const model::ImageView& white, const model::ImageView& black);

 private:
  struct Tile {
    int row, column, rows, columns;
    std::size_t first;  // pixel
  };
  struct Levels {
    int contrast = 0;       // the greatest difference of a pair
    int sum = 0;            // of that pair
    std::size_t plane = 0;  // its first image
  };
  struct Lit {
    std::vector<Levels> levels;  // of all pixels
    double noise = 0;            // standard deviation of a difference
    int contrast = 0;            // pixels with so much are lit
  };
  [[nodiscard]] Lit lit() const;
  struct Clear {
    std::size_t at = 0;  // along its line
    int gray = 0;
  };
  [[nodiscard]] std::vector<int> gray_of(const Lit& lit, int first, int planes) const;
  template <class Look>
  void for_each_line(const std::vector<int>& gray, const Look& look) const;
  double changes_of(const std::vector<int>& gray, std::size_t& distance) const;
  [[nodiscard]] std::vector<Jump> jumps_of(const std::vector<int>& gray, int planes) const;
  [[nodiscard]] bool complete() const { return taken_ >= 2 * bits_; }

  int bits_;
  bool cyclic_;
  int side_;  // of the image, the longer one
  int taken_ = 0;
  std::size_t pixels_ = 0;
  std::vector<Tile> tiles_;
  std::vector<std::vector<std::uint8_t>> images_;
};

// What an image sequence contradicts, as the end of a message; empty: nothing. `names` are those of the newest cycle's
// images, 2 bits of them.
std::string contradiction_of(const SequenceCheck& check, const std::vector<std::string>& names);

// The names of so many images of a device.
std::vector<std::string> names_of_patterns(const std::string& uri, int patterns);

// How much the code changes across the image, beside how much it would change on a surface of constant depth, in the
// direction of the image in which that is most: 1 there, less or more on surfaces that lean. Places along the projector
// follow each other as those in the camera's image do wherever both see a surface whole, so that it is above 0; a
// mirrored picture or code reverses it. `across`: how much it changes in the other direction, beside this one; the code
// of the projector's other axis does so more.
struct Pace {
  double along = 0;
  double across = 0;
};
// Nothing where there are too few borders between codes.
std::optional<Pace> pace_of(const Triangulation& triangulation, const std::uint16_t* codes);

// What the codes of a depth image, of its columns where both axes are coded, contradict: the way that they run, and the
// shares of pixels that have a code but no point. Empty: nothing.
std::string contradiction_of(const Triangulation& triangulation, const std::uint16_t* codes, const DepthShares& shares);

// What is less likely, but possible: surfaces that lean everywhere as no usual scene does.
std::string doubt_of(const Triangulation& triangulation, const std::uint16_t* codes);

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_SEQUENCE_CHECK_H
