// The numbers that cameras give their images, without the wrap.
#ifndef SELFPROJ_HOST_CAMERA_FRAME_NUMBERS_H
#define SELFPROJ_HOST_CAMERA_FRAME_NUMBERS_H

#include <cstdint>
#include <optional>

namespace selfproj {

// Makes a count from 0 of numbers that wrap. A number less than half a period ahead is a later image, any other an
// earlier one. A loss of half a period or more in one piece is therefore not seen as such.
class FrameNumbers {
 public:
  // Numbers first, first + 1, …, first + period - 1, first, …; period 0: 64-bit numbers that do not wrap. GigE Vision
  // has first 1 and period 65,535, because it leaves out 0.
  FrameNumbers(std::uint64_t first, std::uint64_t period) : first_(first), period_(period) {}

  // Returns the count of the image with this number: 0 for the first one. Returns nothing if it is not later than the
  // one before. Adds the numbers left out to dropped().
  std::optional<std::uint64_t> accept(std::uint64_t number) {
    std::uint64_t left_out = 0;
    if (known_) {
      const std::uint64_t step = distance(number);
      const std::uint64_t half = period_ == 0 ? std::uint64_t{1} << 63U : (period_ + 1) / 2;
      if (step == 0 || step >= half) {
        return std::nullopt;
      }
      left_out = step > guesses_ + 1 ? step - 1 - guesses_ : 0;
    }
    known_ = true;
    newest_ = number;
    guesses_ = 0;
    dropped_ += left_out;
    const std::uint64_t count = next_ + left_out;
    next_ = count + 1;
    return count;
  }

  // Returns a count for an image whose number did not come: the next one. The next number that does come tells how many
  // were left out before and after it.
  std::uint64_t guess() {
    ++guesses_;
    return next_++;
  }

  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

 private:
  // From the newest number to this one, modulo the period.
  [[nodiscard]] std::uint64_t distance(std::uint64_t number) const {
    if (period_ == 0) {
      return number - newest_;
    }
    const std::uint64_t to = (number - first_) % period_;
    const std::uint64_t from = (newest_ - first_) % period_;
    return to >= from ? to - from : to + period_ - from;
  }

  std::uint64_t first_;
  std::uint64_t period_;
  std::uint64_t newest_ = 0;
  std::uint64_t next_ = 0;     // the next count
  std::uint64_t guesses_ = 0;  // since the newest number
  std::uint64_t dropped_ = 0;
  bool known_ = false;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CAMERA_FRAME_NUMBERS_H
