// The numbers that cameras give their images, without the wrap.
#ifndef SELFPROJ_HOST_CAMERA_FRAME_NUMBERS_H
#define SELFPROJ_HOST_CAMERA_FRAME_NUMBERS_H

#include <algorithm>
#include <cstdint>
#include <optional>

namespace selfproj::camera {

// Makes a count from 0 of numbers that wrap. A number less than half a period ahead is a later image, any other an
// earlier one. But kConfirm images in a row that are earlier by more than kReordered, and follow each other, are the
// stream that goes on, after a long loss or one false number: the numbers up to them are then lost. Those of 64 bits
// have begun anew, and nothing is known to be lost.
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
      const std::uint64_t step = distance(newest_, number);
      const std::uint64_t half = period_ == 0 ? std::uint64_t{1} << 63U : (period_ + 1) / 2;
      if (step == 0 || step >= half) {
        if (!goes_on_at(number)) {
          return std::nullopt;
        }
        left_out = period_ == 0 ? 0 : step - 1 - std::min(guesses_, step - 1);
      } else {
        left_out = step > guesses_ + 1 ? step - 1 - guesses_ : 0;
      }
    }
    known_ = true;
    newest_ = number;
    guesses_ = 0;
    refused_ = 0;
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
  static constexpr std::uint64_t kReordered = 64;
  static constexpr int kConfirm = 3;

  // From one number to another, modulo the period.
  [[nodiscard]] std::uint64_t distance(std::uint64_t start, std::uint64_t end) const {
    if (period_ == 0) {
      return end - start;
    }
    const std::uint64_t to = (end - first_) % period_;
    const std::uint64_t from = (start - first_) % period_;
    return to >= from ? to - from : to + period_ - from;
  }

  // Whether this number, which is not a later one, confirms that the stream goes on here.
  bool goes_on_at(std::uint64_t number) {
    const std::uint64_t back = distance(number, newest_);
    if (back <= kReordered) {
      return false;
    }
    const std::uint64_t step = distance(last_refused_, number);
    refused_ = refused_ > 0 && step >= 1 && step <= kReordered ? refused_ + 1 : 1;
    last_refused_ = number;
    return refused_ >= kConfirm;
  }

  std::uint64_t first_;
  std::uint64_t period_;
  std::uint64_t newest_ = 0;
  std::uint64_t next_ = 0;     // the next count
  std::uint64_t guesses_ = 0;  // since the newest number
  std::uint64_t dropped_ = 0;
  std::uint64_t last_refused_ = 0;
  int refused_ = 0;  // in a row, each a little later than the one before
  bool known_ = false;
};

}  // namespace selfproj::camera

#endif  // SELFPROJ_HOST_CAMERA_FRAME_NUMBERS_H
