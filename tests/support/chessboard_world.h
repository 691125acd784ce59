// A camera, a projector and a chessboard between them, by vectors and directly from OpenCV's lens model. Calibration is
// tested against it. Shares no code with host/.
#ifndef SELFPROJ_TESTS_SUPPORT_CHESSBOARD_WORLD_H
#define SELFPROJ_TESTS_SUPPORT_CHESSBOARD_WORLD_H

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <random>
#include <vector>

namespace selfproj::test {

struct WorldLens {
  double fx, fy, cx, cy;
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;

  // Column and row of the ray (x, y, 1).
  [[nodiscard]] cv::Vec2d pixel(double x, double y) const {
    const double r2 = x * x + y * y;
    const double q = 1 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2;
    return {fx * (x * q + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx,
            fy * (y * q + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cy};
  }

  [[nodiscard]] cv::Vec2d pixel(const cv::Vec3d& p) const { return pixel(p[0] / p[2], p[1] / p[2]); }
};

// Rotates about x, then y, then z, in degrees.
inline cv::Matx33d turn(double x, double y, double z) {
  constexpr double kRad = 3.14159265358979323846 / 180;
  const auto c = [](double a) { return std::cos(a * kRad); };
  const auto s = [](double a) { return std::sin(a * kRad); };
  const cv::Matx33d rx(1, 0, 0, 0, c(x), -s(x), 0, s(x), c(x));
  const cv::Matx33d ry(c(y), 0, s(y), 0, 1, 0, -s(y), 0, c(y));
  const cv::Matx33d rz(c(z), -s(z), 0, s(z), c(z), 0, 0, 0, 1);
  return rz * ry * rx;
}

// x_camera = turn x_chessboard + at.
struct ChessboardPose {
  cv::Matx33d turn;
  cv::Vec3d at;
};

struct World {
  WorldLens camera{260, 261, 118, 102};
  WorldLens projector{150, 151, 49, 41};
  cv::Matx33d rotation = test::turn(-15, -3, 1);  // x_projector = rotation x_camera + translation
  cv::Vec3d translation{6, -150, 40};
  int camera_columns = 240, camera_rows = 200;
  int projector_columns = 96, projector_rows = 80;
  bool mirrored = false;                            // the projector counts its rows from below
  int chessboard_columns = 7, chessboard_rows = 5;  // inner corners
  double square = 40;

  [[nodiscard]] cv::Vec3d on_chessboard(int corner) const {
    const int row = corner / chessboard_columns;
    return {square * (corner % chessboard_columns), square * row, 0};
  }
  [[nodiscard]] cv::Vec2d in_camera(const cv::Vec3d& p) const { return camera.pixel(p); }
  [[nodiscard]] cv::Vec2d in_projector(const cv::Vec3d& p) const {
    cv::Vec2d pixel = projector.pixel(rotation * p + translation);
    pixel[1] = mirrored ? projector_rows - 1 - pixel[1] : pixel[1];
    return pixel;
  }

  // A pose with the board's middle at (x, y, z), turned about its middle.
  [[nodiscard]] ChessboardPose pose(double x, double y, double z, const cv::Matx33d& turned) const {
    const cv::Vec3d middle(0.5 * square * (chessboard_columns - 1), 0.5 * square * (chessboard_rows - 1), 0);
    return {turned, cv::Vec3d(x, y, z) - turned * middle};
  }

  // Poses in which camera and projector see the chessboard, as different from each other as a user would turn it.
  [[nodiscard]] std::vector<ChessboardPose> poses() const {
    return {pose(0, 10, 560, turn(0, 0, 0)),     pose(-20, 0, 560, turn(28, 4, 3)),
            pose(20, 5, 570, turn(-26, 0, -4)),  pose(10, 10, 550, turn(3, 27, 2)),
            pose(-10, 0, 560, turn(-4, -28, 5)), pose(0, 12, 590, turn(20, 20, 8)),
            pose(8, -6, 580, turn(-20, 20, -6)), pose(0, 4, 540, turn(18, -20, 0))};
  }
};

// An image of the world's Gray-code sequence: the camera sees the chessboard, white with black squares and a white
// margin of one square, under a pattern. Beyond the chessboard there is nothing. Each pixel averages 6 x 6 points over
// 1.8 x 1.8 pixels, like a lens blur. Lenses have no distortion.
class ChessboardImages {
 public:
  ChessboardImages(const World& world, const ChessboardPose& pose) : world_(world) {
    constexpr double kBlack = 0.15;
    samples_.resize(static_cast<std::size_t>(world.camera_rows * world.camera_columns * kSide * kSide));
    const cv::Vec3d normal(pose.turn(0, 2), pose.turn(1, 2), pose.turn(2, 2));
    std::size_t i = 0;
    for (int r = 0; r < world.camera_rows; ++r) {
      for (int c = 0; c < world.camera_columns; ++c) {
        for (int k = 0; k < kSide * kSide; ++k, ++i) {
          const double column = c + kSpread * ((k % kSide + 0.5) / kSide - 0.5);
          const double row = r + kSpread * ((k / kSide + 0.5) / kSide - 0.5);  // NOLINT: whole
          const cv::Vec3d ray((column - world.camera.cx) / world.camera.fx, (row - world.camera.cy) / world.camera.fy,
                              1);
          const cv::Vec3d p = ray * (normal.dot(pose.at) / normal.dot(ray));
          const cv::Vec3d b = pose.turn.t() * (p - pose.at) * (1 / world.square);
          const bool outside =
              b[0] < -2 || b[1] < -2 || b[0] > world.chessboard_columns + 1 || b[1] > world.chessboard_rows + 1;
          const bool margin = b[0] < -1 || b[1] < -1 || b[0] > world.chessboard_columns || b[1] > world.chessboard_rows;
          const bool black =
              !margin && (static_cast<int>(std::floor(b[0])) + static_cast<int>(std::floor(b[1]))) % 2 == 0;
          const cv::Vec2d seen = world.in_projector(p);
          samples_[i] = {static_cast<int>(std::floor(seen[0] + 0.5)), static_cast<int>(std::floor(seen[1] + 0.5)),
                         outside ? 0
                         : black ? kBlack
                                 : 1};
        }
      }
    }
  }

  // The image under a pattern of projector_rows x projector_columns values of 0 or 255. Grey values have noise of this
  // standard deviation.
  [[nodiscard]] std::vector<std::uint8_t> image(const std::vector<std::uint8_t>& pattern, double noise,
                                                std::mt19937_64& random) const {
    constexpr double kDark = 6;
    constexpr double kLight = 190;
    std::normal_distribution<double> normal(0, noise > 0 ? noise : 1);
    std::vector<std::uint8_t> pixels;
    for (std::size_t i = 0; i < samples_.size(); i += kSide * kSide) {
      double sum = 0;
      for (std::size_t k = i; k < i + kSide * kSide; ++k) {
        const Sample& s = samples_[k];
        const bool on =
            s.column >= 0 && s.row >= 0 && s.column < world_.projector_columns && s.row < world_.projector_rows;
        const double light =
            on ? pattern[static_cast<std::size_t>(s.row * world_.projector_columns + s.column)] / 255.0 : 0;
        sum += s.albedo * (0.1 + light);
      }
      const double grey = kDark + kLight * sum / (kSide * kSide) + (noise > 0 ? normal(random) : 0);
      pixels.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(grey), 0L, 255L)));
    }
    return pixels;
  }

 private:
  static constexpr int kSide = 6;
  static constexpr double kSpread = 1.8;
  struct Sample {
    int column, row;
    double albedo;
  };
  World world_;
  std::vector<Sample> samples_;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SUPPORT_CHESSBOARD_WORLD_H
