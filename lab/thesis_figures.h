// The figures of chapters 3 and 4 of the thesis, made again in simulation: pictures, curves, and the numbers behind
// them.
#ifndef SELFPROJ_LAB_THESIS_FIGURES_H
#define SELFPROJ_LAB_THESIS_FIGURES_H

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/report/page.h"
#include "host/report/report.h"
#include "selfproj/images/float_image.h"

namespace selfproj::lab {

// What is made of one figure.
struct ThesisFigure {
  std::string number;   // "3.9"
  std::string caption;  // what it shows, in a few words
  std::string source;   // the experiment whose whole course has the figures for the tables; "": none
  std::vector<report::ReportPicture> pictures;
  std::vector<report::ReportPlot> plots;
  std::vector<std::pair<std::string, images::FloatImage>> maps;  // mm; name of the file without its ending
  std::string csv;                                               // the numbers behind plots and pictures
  std::vector<std::pair<std::string, double>> values;            // key, value: what the figure says in numbers
};

// Makes the figures. Figures of one scene share what was rendered and measured for them, while this object lives.
class ThesisFigures {
 public:
  // `done` is called after each rendered image or measured frame.
  explicit ThesisFigures(std::function<void()> done);
  ThesisFigures(const ThesisFigures&) = delete;
  ThesisFigures& operator=(const ThesisFigures&) = delete;
  ~ThesisFigures();

  // The numbers of all figures that can be made, in the order of the thesis.
  static std::vector<std::string> numbers();

  // Throws std::invalid_argument for another number.
  ThesisFigure make(const std::string& number);

 private:
  struct Stages;
  std::unique_ptr<Stages> stages_;
};

}  // namespace selfproj::lab

#endif  // SELFPROJ_LAB_THESIS_FIGURES_H
