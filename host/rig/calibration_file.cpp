#include "selfproj/rig/calibration_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/core/persistence.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "host/files/input_file.h"
#include "host/files/stderr_capture.h"
#include "host/files/text.h"
#include "host/rig/yaml.h"
#include "selfproj/files/user_error.h"
#include "selfproj/rig/calibration.h"

namespace selfproj::rig {
namespace {

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

bool is_space(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }

// Whether OpenCV reads the text as an octal or hexadecimal number.
bool is_not_decimal(std::string_view text) {
  if (text.starts_with('+') || text.starts_with('-')) {
    text.remove_prefix(1);
  }
  if (text.size() < 2 || text[0] != '0') {
    return false;
  }
  return text[1] == 'x' || text[1] == 'X' || std::all_of(text.begin(), text.end(), is_digit);
}

std::string not_decimal(std::string_view number) {
  return fmt::format("{} begins with 0; OpenCV would not read it as a decimal number", number);
}

// Walks through the tags of an XML text and the words between them.
class XmlValidator {
 public:
  XmlValidator(std::string_view text, const std::string& source) : text_(text), source_(source) {}

  void validate() {
    while (at_ < text_.size()) {
      if (text_[at_] == '<') {
        tag();
      } else {
        word();
      }
    }
  }

 private:
  // A comment is no tag, and neither are <? ... > and <! ... >.
  void tag() {
    const std::string_view rest = text_.substr(at_);
    const bool comment = rest.starts_with("<!--");
    const std::size_t end = text_.find(comment ? "-->" : ">", at_);
    const std::string_view inside = text_.substr(at_, end == std::string_view::npos ? end : end - at_);
    if (rest.starts_with("</")) {
      --depth_;
    } else if (!comment && !rest.starts_with("<?") && !rest.starts_with("<!") && !inside.ends_with('/') &&
               ++depth_ > kDeepestDocument) {
      fail("is nested too deeply");
    }
    at_ = end == std::string_view::npos ? text_.size() : end + 1;
  }

  // What stands between quotation marks is one word and no number.
  void word() {
    std::size_t end = at_;
    if (text_[at_] == '"') {
      end = std::min(text_.find_first_of("\"<", at_ + 1), text_.size());
      end += end < text_.size() && text_[end] == '"' ? 1 : 0;
    } else {
      while (end < text_.size() && text_[end] != '<' && !is_space(text_[end])) {
        ++end;
      }
      if (const std::string_view found = text_.substr(at_, end - at_); is_not_decimal(found)) {
        fail(not_decimal(found));
      }
    }
    at_ = std::max(end, at_ + 1);  // at least the space that stands here
  }

  [[noreturn]] void fail(const std::string& reason) const {
    const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n');
    throw UserError(source_, fmt::format("line {}: {}", line, reason));
  }

  std::string_view text_;
  const std::string& source_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

void check_calibration_text(const std::string& text, const std::string& source) {
  const std::size_t begin = std::min(text.find_first_not_of(" \t\r\n"), text.size());
  if (std::string_view(text).substr(begin).starts_with('<')) {
    XmlValidator(text, source).validate();
    return;
  }
  validate_yaml(text, source,
                [](const std::string& scalar) { return is_not_decimal(scalar) ? not_decimal(scalar) : ""; });
}

namespace {

class Reader {
 public:
  explicit Reader(const std::string& file) : file_(file) {
    const std::string text = files::read_text(file, files::kMostTextBytes);
    check_calibration_text(text, file);
    const files::StderrCapture capture;
    try {
      // By its text, so that no name means something else to OpenCV (it unpacks NAME.gz).
      storage_.open(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    } catch (const cv::Exception&) {
      storage_.release();
    }
    if (!storage_.isOpened()) {
      throw UserError(file, "is not a calibration file of OpenCV");
    }
  }

  // The numbers of a matrix; there must be `count` of them unless it is 0.
  std::vector<double> numbers(const std::string& key, std::size_t count) const {
    const cv::FileNode node = storage_[key];
    if (node.empty()) {
      throw UserError(file_, key + " is missing");
    }
    cv::Mat matrix;
    {
      const files::StderrCapture capture;
      try {
        constexpr double kMaxNumbers = 100;
        if (!node.isMap() || static_cast<double>(node["rows"]) * static_cast<double>(node["cols"]) <= kMaxNumbers) {
          node >> matrix;
        }
        matrix.convertTo(matrix, CV_64F);
      } catch (const cv::Exception&) {
        matrix.release();
      }
    }
    if (matrix.empty() || matrix.channels() != 1) {
      throw UserError(file_, key + " is not a matrix");
    }
    if (count != 0 && matrix.total() != count) {
      throw UserError(file_, key + " has " + std::to_string(matrix.total()) + " numbers; " + std::to_string(count) +
                                 " are expected");
    }
    std::vector<double> values(matrix.begin<double>(), matrix.end<double>());
    constexpr double kFar = 1e9;  // larger than any matrix of a camera has
    if (!std::all_of(values.begin(), values.end(), [](double value) { return std::abs(value) <= kFar; })) {
      throw UserError(file_, key + " has a number that is not finite, or greater than 1e9");
    }
    return values;
  }

  // Whether fy may be negative, because the image's rows grow upwards if its columns grow to the right.
  enum class Mirrored : std::uint8_t { no, possible };

  Lens lens(const std::string& name, Mirrored mirrored) const {
    const std::vector<double> m = numbers(name + "_K", 9);
    constexpr double kMin = 1e-9;
    if (!(m[0] > kMin && (m[4] > kMin || (mirrored == Mirrored::possible && m[4] < -kMin))) || m[1] != 0 || m[3] != 0 ||
        m[6] != 0 || m[7] != 0 || m[8] != 1) {
      throw UserError(file_, name + "_K is not a camera matrix (fx, 0, cx; 0, fy, cy; 0, 0, 1)");
    }
    const std::vector<double> k = numbers(name + "_kc", 0);
    if (k.size() != 4 && k.size() != 5 && k.size() != 8) {
      throw UserError(file_, name + "_kc has " + std::to_string(k.size()) + " coefficients; 4, 5 or 8 are expected");
    }
    Lens lens{m[0], m[4], m[2], m[5], {}};
    std::copy(k.begin(), k.end(), lens.k.begin());
    return lens;
  }

  // Leaves both unchanged if the key is absent.
  void size(const std::string& key, int& columns, int& rows) const {
    if (storage_[key].empty()) {
      return;
    }
    const std::vector<double> values = numbers(key, 2);
    constexpr double kMax = 1 << 15;
    if (!std::all_of(values.begin(), values.end(), [](double value) { return value >= 1 && value <= kMax; })) {
      throw UserError(file_, key + " is not a size in pixels");
    }
    columns = static_cast<int>(values[0]);
    rows = static_cast<int>(values[1]);
  }

 private:
  std::string file_;
  cv::FileStorage storage_;
};

}  // namespace

Calibration read_calibration(const std::string& file) {
  const Reader reader(file);
  Calibration result;
  result.camera = reader.lens("cam", Reader::Mirrored::no);
  result.projector = reader.lens("pro", Reader::Mirrored::possible);
  const std::vector<double> r = reader.numbers("R", 9);
  std::copy(r.begin(), r.end(), result.rotation.val);
  constexpr double kNear = 1e-3;
  if (cv::norm(result.rotation * result.rotation.t() - cv::Matx33d::eye()) > kNear ||
      cv::determinant(result.rotation) < 0) {
    throw UserError(file, "R is not a rotation");
  }
  const std::vector<double> t = reader.numbers("T", 3);
  result.translation = {t[0], t[1], t[2]};
  constexpr double kMin = 1e-9;
  if (cv::norm(result.translation) < kMin) {
    throw UserError(file, "T is 0: camera and projector are at the same place");
  }
  reader.size("cam_size", result.camera_columns, result.camera_rows);
  reader.size("pro_size", result.projector_columns, result.projector_rows);
  return result;
}

std::string calibration_yaml(const Calibration& calibration, const CalibrationRms& rms) {
  cv::FileStorage storage("calibration.yaml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  const auto lens = [&](const std::string& name, int columns, int rows, const Lens& l) {
    storage << name + "_size" << cv::Mat(cv::Vec2i(columns, rows));
    storage << name + "_K" << cv::Mat(cv::Matx33d(l.fx, 0, l.cx, 0, l.fy, l.cy, 0, 0, 1));
    const bool rational = l.k[5] != 0 || l.k[6] != 0 || l.k[7] != 0;
    const std::size_t count = rational ? l.k.size() : 5;
    storage << name + "_kc"
            << cv::Mat(std::vector<double>(l.k.begin(), l.k.begin() + static_cast<std::ptrdiff_t>(count)));
  };
  lens("cam", calibration.camera_columns, calibration.camera_rows, calibration.camera);
  lens("pro", calibration.projector_columns, calibration.projector_rows, calibration.projector);
  storage << "R" << cv::Mat(calibration.rotation) << "T" << cv::Mat(calibration.translation);
  const DepthMatrices columns = depth_matrices(calibration, CodedAxis::columns);
  storage << "T_C" << cv::Mat(columns.camera) << "T_P" << cv::Mat(columns.projector);
  storage << "T_P_rows" << cv::Mat(depth_matrices(calibration, CodedAxis::rows).projector);
  storage << "cam_rms" << rms.camera << "pro_rms" << rms.projector << "stereo_rms" << rms.stereo;
  return storage.releaseAndGetString();
}

}  // namespace selfproj::rig
