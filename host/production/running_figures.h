// Mean, spread and trend of a figure over parts, without keeping the numbers.
#ifndef SELFPROJ_HOST_PRODUCTION_RUNNING_FIGURES_H
#define SELFPROJ_HOST_PRODUCTION_RUNNING_FIGURES_H

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace selfproj {

// Sums about the running means, which lose no digits over millions of parts. The numbers come in order: the n-th has
// the abscissa n.
class RunningFigures {
 public:
  void add(double value) {
    ++count_;
    const auto n = static_cast<double>(count_);
    const double x = n;
    const double dx = x - mean_x_;
    mean_x_ += dx / n;
    const double dy = value - mean_;
    mean_ += dy / n;
    xx_ += dx * (x - mean_x_);
    xy_ += dx * (value - mean_);
    yy_ += dy * (value - mean_);
    least_ = count_ == 1 ? value : std::min(least_, value);
    greatest_ = count_ == 1 ? value : std::max(greatest_, value);
  }

  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double mean() const { return mean_; }
  [[nodiscard]] double least() const { return least_; }
  [[nodiscard]] double greatest() const { return greatest_; }

  // Standard deviation; 0 of fewer than two.
  [[nodiscard]] double spread() const {
    return count_ > 1 ? std::sqrt(std::max(0.0, yy_) / static_cast<double>(count_ - 1)) : 0;
  }

  // How much the straight line through all of them rises from one to the next; 0 of fewer than two.
  [[nodiscard]] double trend() const { return count_ > 1 ? xy_ / xx_ : 0; }

 private:
  std::uint64_t count_ = 0;
  double mean_ = 0, mean_x_ = 0;
  double xx_ = 0, xy_ = 0, yy_ = 0;
  double least_ = 0, greatest_ = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_PRODUCTION_RUNNING_FIGURES_H
