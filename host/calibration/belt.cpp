#include "host/calibration/belt.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/files/numbers.h"
#include "selfproj/files/user_error.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/optics.h"

namespace selfproj::calibration {
namespace {

constexpr double kDegreesPerRadian = 180 / std::numbers::pi;

rig::Lens camera_lens_of(const rig::Rig& rig) {
  if (rig.light_plane) {
    const rig::RigLens& l = rig.calibration->camera;
    return {l.fx_px, l.fy_px, l.cx_px, l.cy_px, {l.k1, l.k2, l.p1, l.p2, l.k3, 0, 0, 0}};
  }
  return rig::calibration_of(rig).camera;
}

cv::Matx33d turn_of(const cv::Vec3d& rotation) {
  cv::Matx33d turn;
  cv::Rodrigues(rotation, turn);
  return turn;
}

cv::Vec3d vector_of(const cv::Matx33d& turn) {
  cv::Vec3d rotation;
  cv::Rodrigues(turn, rotation);
  return rotation;
}

// A view of the chessboard: its corners in an order that is that of the first view.
struct BoardView {
  std::vector<cv::Point3d> board;  // mm, z = 0
  std::vector<cv::Point2d> pixel;
};

// The poses at which a camera would see the view so; a flat board may have two.
std::vector<Pose> poses_of(const BoardView& view, const rig::Lens& lens) {
  std::vector<cv::Point2d> rays;
  for (const cv::Point2d& pixel : view.pixel) {
    const std::optional<cv::Vec2d> ray = lens.ray({pixel.x, pixel.y});
    if (!ray) {
      return {};
    }
    rays.emplace_back((*ray)[0], (*ray)[1]);
  }
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  cv::solvePnPGeneric(view.board, rays, cv::Matx33d::eye(), cv::noArray(), rotations, translations, false,
                      cv::SOLVEPNP_IPPE);
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    Pose pose{cv::Vec3d(rotations[i]), cv::Vec3d(translations[i])};
    if (pose.translation[2] > 0) {
      poses.push_back(pose);
    }
  }
  return poses;
}

// One chessboard on a belt: its pose at the first place, the angle of the belt's way on the board, and how far it has
// moved at each further place. As parameters: rotation, translation, angle, ways.
class MovedBoard {
 public:
  MovedBoard(const std::vector<BoardView>& views, const rig::Lens& lens) : views_(views), lens_(lens) {}

  [[nodiscard]] std::size_t count() const { return 6 + views_.size(); }

  [[nodiscard]] std::size_t residuals() const {
    std::size_t sum = 0;
    for (const BoardView& view : views_) {
      sum += 2 * view.pixel.size();
    }
    return sum;
  }

  static cv::Vec3d way_of(const Eigen::VectorXd& p) {
    return turn_of({p[0], p[1], p[2]}) * cv::Vec3d(std::cos(p[6]), std::sin(p[6]), 0);
  }
  static double along(const Eigen::VectorXd& p, std::size_t view) {
    return view == 0 ? 0 : p[static_cast<Eigen::Index>(6 + view)];
  }

  // Seen less computed, px.
  [[nodiscard]] Eigen::VectorXd off(const Eigen::VectorXd& p) const {
    const cv::Matx33d turn = turn_of({p[0], p[1], p[2]});
    const cv::Vec3d way = way_of(p);
    Eigen::VectorXd result(static_cast<Eigen::Index>(residuals()));
    Eigen::Index at = 0;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      const cv::Vec3d from = cv::Vec3d(p[3], p[4], p[5]) + along(p, v) * way;
      for (std::size_t i = 0; i < views_[v].pixel.size(); ++i) {
        const cv::Point3d& board = views_[v].board[i];
        const cv::Vec3d point = turn * cv::Vec3d(board.x, board.y, board.z) + from;
        const cv::Vec2d pixel = lens_.pixel({point[0] / point[2], point[1] / point[2]});
        result[at++] = views_[v].pixel[i].x - pixel[0];
        result[at++] = views_[v].pixel[i].y - pixel[1];
      }
    }
    return result;
  }

  struct Fit {
    Eigen::VectorXd parameters;
    Eigen::MatrixXd covariance;                            // of the parameters, by the residuals' own size
    double rms = std::numeric_limits<double>::infinity();  // of the residuals' lengths, px
  };

  // Levenberg's and Marquardt's method with derivatives by differences.
  [[nodiscard]] Fit fit(Eigen::VectorXd p) const {
    constexpr int kSteps = 60;
    constexpr double kClose = 1e-12;
    Eigen::VectorXd now = off(p);
    double damping = 1e-6;
    Eigen::MatrixXd square;
    for (int step = 0; step < kSteps; ++step) {
      const Eigen::MatrixXd j = jacobian(p);
      square = j.transpose() * j;
      const Eigen::VectorXd down = j.transpose() * now;
      Eigen::MatrixXd damped = square;
      damped.diagonal() *= 1 + damping;
      const Eigen::VectorXd next = p - damped.ldlt().solve(down);
      const Eigen::VectorXd then = off(next);
      const double gain = now.squaredNorm() - then.squaredNorm();
      if (!(gain >= 0)) {
        damping *= 10;
        if (damping > 1e6) {
          break;
        }
        continue;
      }
      p = next;
      now = then;
      damping = std::max(damping / 10, 1e-12);
      if (gain <= kClose * now.squaredNorm()) {
        break;
      }
    }
    Fit result;
    result.parameters = p;
    const double free = static_cast<double>(residuals()) - static_cast<double>(count());
    result.covariance = square.inverse() * (now.squaredNorm() / std::max(1.0, free));
    result.rms = std::sqrt(now.squaredNorm() / (0.5 * static_cast<double>(residuals())));
    return result;
  }

  // RMS of the residuals' lengths of one view, px.
  [[nodiscard]] double rms_of(const Eigen::VectorXd& p, std::size_t view) const {
    const Eigen::VectorXd all = off(p);
    Eigen::Index begin = 0;
    for (std::size_t v = 0; v < view; ++v) {
      begin += static_cast<Eigen::Index>(2 * views_[v].pixel.size());
    }
    const auto size = static_cast<Eigen::Index>(2 * views_[view].pixel.size());
    return std::sqrt(all.segment(begin, size).squaredNorm() / (0.5 * static_cast<double>(size)));
  }

 private:
  [[nodiscard]] Eigen::MatrixXd jacobian(const Eigen::VectorXd& p) const {
    Eigen::MatrixXd j(static_cast<Eigen::Index>(residuals()), p.size());
    for (Eigen::Index k = 0; k < p.size(); ++k) {
      const double step = 1e-6 * std::max(1.0, std::abs(p[k]));
      Eigen::VectorXd above = p;
      Eigen::VectorXd below = p;
      above[k] += step;
      below[k] -= step;
      j.col(k) = (off(above) - off(below)) / (2 * step);
    }
    return j;
  }

  const std::vector<BoardView>& views_;
  const rig::Lens& lens_;
};

// The views, with corners counted from the end of the board where it was found the other way round than in the first.
// Throws UserError for an image without the whole chessboard.
std::vector<BoardView> views_of(const std::vector<BoardImage>& boards, const Chessboard& chessboard,
                                const rig::Lens& lens) {
  std::vector<BoardView> views;
  std::optional<Pose> first;
  for (const BoardImage& image : boards) {
    if (!image.reason.empty()) {
      throw UserError(image.name, image.reason);
    }
    BoardView view;
    for (int i = 0; i < chessboard.corners(); ++i) {
      view.board.push_back(chessboard.place(i));
    }
    view.pixel = image.corners;
    BoardView turned = view;
    std::reverse(turned.pixel.begin(), turned.pixel.end());
    if (first) {
      // The angle between the nearest of a view's poses and the first one's.
      const auto turn = [&](const BoardView& of) {
        double least = std::numeric_limits<double>::infinity();
        for (const Pose& pose : poses_of(of, lens)) {
          least = std::min(least, cv::norm(vector_of(turn_of(pose.rotation) * turn_of(first->rotation).t())));
        }
        return least;
      };
      if (turn(turned) < turn(view)) {
        view = std::move(turned);
      }
    } else if (const std::vector<Pose> poses = poses_of(view, lens); !poses.empty()) {
      first = poses.front();
    }
    if (poses_of(view, lens).empty()) {
      throw UserError(image.name, "the lens of the rig does not fit its chessboard");
    }
    views.push_back(std::move(view));
  }
  return views;
}

MovedBoard::Fit fit_of(const std::vector<BoardView>& views, const rig::Lens& lens) {
  const MovedBoard board(views, lens);
  MovedBoard::Fit best;
  for (const Pose& start : poses_of(views.front(), lens)) {
    const cv::Matx33d turn = turn_of(start.rotation);
    // Where the middle of the board is, which the poses agree on better than on its lean.
    const auto middle = [&](const BoardView& view, const Pose& pose) {
      const cv::Point3d& last = view.board.back();
      return turn_of(pose.rotation) * (0.5 * cv::Vec3d(last.x, last.y, 0)) + pose.translation;
    };
    const cv::Vec3d from = middle(views.front(), start);
    const cv::Vec3d on_board = turn.t() * (middle(views.back(), poses_of(views.back(), lens).front()) - from);
    Eigen::VectorXd p(static_cast<Eigen::Index>(board.count()));
    p[6] = std::atan2(on_board[1], on_board[0]);
    const cv::Vec3d way = turn * cv::Vec3d(std::cos(p[6]), std::sin(p[6]), 0);
    for (int i = 0; i < 3; ++i) {
      p[i] = start.rotation[i];
      p[3 + i] = start.translation[i];
    }
    for (std::size_t v = 1; v < views.size(); ++v) {
      p[static_cast<Eigen::Index>(6 + v)] = way.dot(middle(views[v], poses_of(views[v], lens).front()) - from);
    }
    MovedBoard::Fit fit = board.fit(p);
    if (fit.rms < best.rms) {
      best = std::move(fit);
    }
  }
  return best;
}

// The straight line along = offset + slope given, and the greatest distance from it, and of which place.
struct EvenWay {
  double slope = 0, greatest = 0;
  std::size_t worst = 0;
};
EvenWay even_way(const std::vector<double>& given, const std::vector<BeltPlace>& places) {
  const auto n = static_cast<double>(given.size());
  double x = 0;
  double y = 0;
  for (std::size_t i = 0; i < given.size(); ++i) {
    x += given[i] / n;
    y += places[i].along_mm / n;
  }
  double xx = 0;
  double xy = 0;
  for (std::size_t i = 0; i < given.size(); ++i) {
    xx += (given[i] - x) * (given[i] - x);
    xy += (given[i] - x) * (places[i].along_mm - y);
  }
  EvenWay way{xy / xx};
  for (std::size_t i = 0; i < given.size(); ++i) {
    const double off = std::abs(places[i].along_mm - y - way.slope * (given[i] - x));
    if (off > way.greatest) {
      way.greatest = off;
      way.worst = i;
    }
  }
  return way;
}

// What moves, counts and seconds say of the conveyor.
void apply_ways(const BeltSettings& settings, BeltCalibration& result) {
  rig::RigSources& sources = *result.rig.sources;
  const auto way_of = [&](const std::vector<double>& given, const char* option) {
    constexpr double kRead = 0.5;  // mm: as a way is read, or stopped at
    const EvenWay way = even_way(given, result.places);
    const double length = std::abs(result.places.back().along_mm - result.places.front().along_mm);
    if (way.greatest > std::max(kRead, settings.scale_tolerance * length)) {
      throw UserError(option,
                      fmt::format("by the other places, {} is {:.2f} mm from where its value puts it; a value is "
                                  "wrong, or the images are in another order",
                                  result.places[way.worst].name, way.greatest));
    }
    result.spread_mm = std::max(result.spread_mm, way.greatest);
    return way.slope;
  };
  if (!settings.moves_mm.empty()) {
    result.way = way_of(settings.moves_mm, "--moves");
    if (!(std::abs(result.way - 1) <= settings.scale_tolerance)) {
      throw UserError("--moves", fmt::format("a millimetre of the belt moves the chessboard by {:.4f} mm; --moves or "
                                             "--square is wrong",
                                             result.way));
    }
  }
  if (!settings.counts.empty()) {
    const double slope = way_of(settings.counts, "--counts");
    if (!(slope > 0)) {
      throw UserError("--counts", "the encoder counts down along the belt's way; exchange its two channels");
    }
    result.rig.conveyor.encoder_mm_per_count = slope;
    sources.encoder = rig::ValueSource::measured;
  }
  if (!settings.seconds.empty()) {
    result.rig.conveyor.speed_mm_per_s = way_of(settings.seconds, "--seconds");
    sources.speed = rig::ValueSource::measured;
  }
}

// The points of a laser's line in the axes of the rig's belt: along, across, and height.
std::vector<cv::Vec3d> points_on(const rig::Rig& rig, const LineAtHeight& line) {
  const rig::RigOptics optics(rig);
  std::vector<cv::Vec3d> points;
  for (const cv::Point2d& centre : line.centres) {
    const std::optional<cv::Vec2d> ray = optics.ray({centre.y, centre.x});
    const std::optional<double> z = ray ? optics.meet(*ray, {}) : std::nullopt;
    if (z) {
      points.emplace_back((*ray)[0] * *z, (*ray)[1] * *z, rig.plane_z_mm - *z);
    }
  }
  return points;
}

// Height = mean + slope (across - middle), without points that are far off.
struct HeightLine {
  double mean = 0, slope = 0, middle = 0, rms = 0;
  std::size_t points = 0;
};
HeightLine line_through(const std::vector<cv::Vec3d>& points, double height, double within) {
  constexpr int kRounds = 6;
  constexpr double kSpreads = 4.5 * 1.4826;
  constexpr double kMin = 0.005;  // mm
  HeightLine line;
  line.mean = height;
  double limit = within;
  for (int round = 0; round < kRounds; ++round) {
    const auto off = [&](const cv::Vec3d& p) { return p[2] - line.mean - line.slope * (p[1] - line.middle); };
    std::vector<cv::Vec3d> on;
    std::copy_if(points.begin(), points.end(), std::back_inserter(on),
                 [&](const cv::Vec3d& p) { return std::abs(off(p)) <= limit; });
    constexpr std::size_t kMinPoints = 8;
    if (on.size() < kMinPoints) {
      line.points = 0;
      return line;
    }
    const auto n = static_cast<double>(on.size());
    HeightLine next;
    for (const cv::Vec3d& p : on) {
      next.middle += p[1] / n;
      next.mean += p[2] / n;
    }
    double square = 0;
    double product = 0;
    for (const cv::Vec3d& p : on) {
      square += (p[1] - next.middle) * (p[1] - next.middle);
      product += (p[1] - next.middle) * (p[2] - next.mean);
    }
    next.slope = square > 0 ? product / square : 0;
    next.points = on.size();
    line = next;
    std::vector<double> distances;
    double sum = 0;
    for (const cv::Vec3d& p : on) {
      distances.push_back(std::abs(off(p)));
      sum += off(p) * off(p);
    }
    line.rms = std::sqrt(sum / n);
    limit = std::max(kMin, kSpreads * files::median_of(distances));
  }
  return line;
}

// Turns the belt about its way and moves it along its normal, so that the heights of the line become 0.
void take_as_zero(rig::Rig& rig, const HeightLine& line, BeltCalibration& result) {
  // A height that grows across by `slope`: the normal turns towards where the belt is higher, that is nearer.
  rig::RigBeltPose& pose = *rig.belt_pose;
  const cv::Vec3d way(pose.direction[0], pose.direction[1], pose.direction[2]);
  const cv::Vec3d normal(pose.normal[0], pose.normal[1], pose.normal[2]);
  // y of the rig's frame, in the calibration's axes: the frame of rows and columns is mirrored, so that the order of
  // the product is, too.
  const cv::Vec3d across = way.cross(normal);
  // The plane z = plane_z - mean - slope (y - middle).
  const cv::Vec3d next = cv::normalize(normal + line.slope * across);
  const double length = std::hypot(1.0, line.slope);
  rig.plane_z_mm = (rig.plane_z_mm - line.mean + line.slope * line.middle) / length;
  pose.normal = {next[0], next[1], next[2]};
  result.zero_turn_deg += std::atan(line.slope) * kDegreesPerRadian;
}

// Turns the laser's plane about its line on the belt.
void turn_light(rig::Rig& rig, double angle) {
  rig::RigLightPlane& light = *rig.light_plane;
  const cv::Vec3d normal(light.normal[0], light.normal[1], light.normal[2]);
  const cv::Vec3d belt(rig.belt_pose->normal[0], rig.belt_pose->normal[1], rig.belt_pose->normal[2]);
  const cv::Vec3d line = cv::normalize(normal.cross(belt));
  // The point of that line nearest to the camera: a normal + b belt.
  const double c = normal.dot(belt);
  const double b = (rig.plane_z_mm - c * light.distance_mm) / (1 - c * c);
  const double a = light.distance_mm - c * b;
  const cv::Vec3d on = a * normal + b * belt;
  const cv::Vec3d next = turn_of(angle * line) * normal;
  light.normal = {next[0], next[1], next[2]};
  light.distance_mm = next.dot(on);
}

constexpr double kOfOneHeight = 0.2;  // of the distance to the next height: what belongs to a height

// How far points may be from a height to belong to it.
double reach_of(const std::vector<LineAtHeight>& lines, std::size_t line, double most) {
  double least = most;
  for (const LineAtHeight& other : lines) {
    const double apart = std::abs(other.height_mm - lines[line].height_mm);
    least = apart > 0 ? std::min(least, kOfOneHeight * apart) : least;
  }
  return least;
}

// Height 0, and the scale of heights, from the laser.
void apply_lines(const std::vector<LineAtHeight>& lines, const BeltSettings& settings, BeltCalibration& result) {
  rig::Rig& rig = result.rig;
  const auto measured = [&](std::size_t i, double wide) {
    const std::vector<cv::Vec3d> points = points_on(rig, lines[i]);
    const HeightLine line = line_through(points, lines[i].height_mm, wide);
    if (points.empty()) {
      throw UserError(lines[i].name, "nothing in it is brighter than --laser-threshold");
    }
    if (line.points == 0) {
      std::vector<double> heights;
      for (const cv::Vec3d& p : points) {
        if (i == 0 || std::abs(p[2]) > settings.height_tolerance) {
          heights.push_back(p[2]);
        }
      }
      if (heights.empty()) {
        throw UserError(lines[i].name, fmt::format("nothing in it is higher than the belt; the height is said to be "
                                                   "{:g} mm",
                                                   lines[i].height_mm));
      }
      throw UserError(
          lines[i].name,
          fmt::format("what is bright in it{} is {:.3g} mm high (median), not within {:.3g} mm of the height "
                      "{:g} mm; is the image that of the line, and are the height, --thickness and --square "
                      "right?",
                      i == 0 ? "" : ", beside the belt,", files::median_of(heights), wide, lines[i].height_mm));
    }
    return line;
  };
  const auto zero = [&] {
    const HeightLine line = measured(0, settings.height_tolerance);
    take_as_zero(rig, line, result);
    return line;
  };
  result.zero_mm = zero().mean;
  zero();
  if (lines.size() > 1) {
    // The slope of measured over true heights, at the places of the lines' middles.
    const auto scale = [&] {
      double product = 0;
      double square = 0;
      for (std::size_t i = 1; i < lines.size(); ++i) {
        const double wide = std::max(reach_of(lines, i, std::abs(lines[i].height_mm)),
                                     std::abs(lines[i].height_mm) * 2 * settings.scale_tolerance);
        product += lines[i].height_mm * measured(i, wide).mean;
        square += lines[i].height_mm * lines[i].height_mm;
      }
      return product / square;
    };
    const double before = scale();
    result.light_scale = before;
    if (!(std::abs(before - 1) <= settings.scale_tolerance)) {
      throw UserError("--heights", fmt::format("the laser sees {:.4f} mm for each mm of them; they, --square or the "
                                               "laser's plane are wrong",
                                               before));
    }
    constexpr int kSteps = 6;
    constexpr double kStep = 1e-4;
    for (int i = 0; i < kSteps; ++i) {
      const double now = scale();
      const rig::Rig kept = rig;
      turn_light(rig, kStep);
      const double by_turn = (scale() - now) / kStep;
      rig = kept;
      const double turn = (1 - now) / by_turn;
      turn_light(rig, turn);
      result.light_turn_deg += turn * kDegreesPerRadian;
      zero();
    }
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const HeightLine line = measured(i, reach_of(lines, i, settings.height_tolerance));
    result.heights.push_back({lines[i].name, lines[i].height_mm, line.mean, line.rms, line.points});
  }
}

}  // namespace

BeltCalibration calibrate_belt(const rig::Rig& rig, const std::vector<BoardImage>& boards,
                               const std::vector<LineAtHeight>& lines, const BeltSettings& settings) {
  if (boards.size() < 2) {
    throw UserError("calibrate belt", "images of the chessboard at two or more places of the belt are needed");
  }
  const rig::Lens lens = camera_lens_of(rig);
  const std::vector<BoardView> views = views_of(boards, settings.chessboard, lens);
  const MovedBoard::Fit fit = fit_of(views, lens);
  const MovedBoard board(views, lens);
  const Eigen::VectorXd& p = fit.parameters;
  BeltCalibration result;
  result.rig = rig;
  result.rms_px = fit.rms;
  const double sign = MovedBoard::along(p, views.size() - 1) < 0 ? -1 : 1;  // the belt's way is that of the images
  double apart = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    result.places.push_back({boards[v].name, sign * MovedBoard::along(p, v), board.rms_of(p, v)});
    apart = std::max(apart, std::abs(result.places[v].along_mm));
  }
  // A board that was turned or did not move straight fits worse than noise does.
  constexpr double kMaxRms = 1;  // px
  if (!(fit.rms <= kMaxRms)) {
    const auto worst = std::max_element(result.places.begin(), result.places.end(),
                                        [](const BeltPlace& a, const BeltPlace& b) { return a.rms_px < b.rms_px; });
    throw UserError(worst->name, fmt::format("its chessboard is {:.2f} px RMS off a board that one belt moves straight "
                                             "on; it was touched, it is not flat, or the rig is another camera's",
                                             worst->rms_px));
  }
  if (!(apart >= settings.chessboard.square_mm)) {
    throw UserError("calibrate belt",
                    fmt::format("the chessboard moved by {:.2f} mm; move the belt by a square or more", apart));
  }
  const cv::Matx33d turn = turn_of({p[0], p[1], p[2]});
  cv::Vec3d normal(turn(0, 2), turn(1, 2), turn(2, 2));
  const cv::Vec3d at(p[3], p[4], p[5]);
  normal *= normal.dot(at) < 0 ? -1 : 1;
  const cv::Vec3d way = sign * MovedBoard::way_of(p);
  result.rig.belt_pose = rig::RigBeltPose{{way[0], way[1], way[2]}, {normal[0], normal[1], normal[2]}};
  result.rig.plane_z_mm = normal.dot(at) + settings.thickness_mm;
  const cv::Vec3d side = way.cross(normal);
  // How normal, distance and way change with the parameters.
  const auto figures = [&](const Eigen::VectorXd& q) {
    const cv::Matx33d m = turn_of({q[0], q[1], q[2]});
    cv::Vec3d n(m(0, 2), m(1, 2), m(2, 2));
    n *= n.dot(normal) < 0 ? -1 : 1;
    // The middle of the board, whose distance is known best.
    const cv::Point3d& last = views.front().board.back();
    const cv::Vec3d middle = m * (0.5 * cv::Vec3d(last.x, last.y, 0)) + cv::Vec3d(q[3], q[4], q[5]);
    return Eigen::Vector4d(n.dot(way), n.dot(side), n.dot(middle), sign * MovedBoard::way_of(q).dot(side));
  };
  Eigen::MatrixXd by(4, p.size());
  for (Eigen::Index k = 0; k < p.size(); ++k) {
    constexpr double kStep = 1e-6;
    Eigen::VectorXd above = p;
    Eigen::VectorXd below = p;
    above[k] += kStep;
    below[k] -= kStep;
    by.col(k) = (figures(above) - figures(below)) / (2 * kStep);
  }
  const Eigen::Vector4d variance = (by * fit.covariance * by.transpose()).diagonal();
  result.normal_sd_deg = std::sqrt(variance[0] + variance[1]) * kDegreesPerRadian;
  result.distance_sd_mm = std::sqrt(variance[2]);
  result.direction_sd_deg = std::sqrt(variance[3]) * kDegreesPerRadian;

  if (!result.rig.sources) {
    const auto source = rig.calibration ? rig::ValueSource::measured : rig::ValueSource::drawing;
    result.rig.sources = rig::RigSources{.camera = source, .light = source};
  }
  result.rig.sources->belt = rig::ValueSource::measured;
  apply_ways(settings, result);
  if (!lines.empty()) {
    apply_lines(lines, settings, result);
  }
  return result;
}

}  // namespace selfproj::calibration
