// Tests what is refused of the text of a calibration, before OpenCV reads it.

#include <gtest/gtest.h>

#include <string>

#include "selfproj/rig/calibration_file.h"
#include "tests/support/error_of.h"

namespace selfproj::test {
namespace {

std::string error_of_text(const std::string& text) {
  return test::error_of([&] { rig::check_calibration_text(text, "c.yaml"); });
}

std::string repeated(const std::string& part, int times) {
  std::string text;
  for (int i = 0; i < times; ++i) {
    text += part;
  }
  return text;
}

const std::string kYaml = "%YAML:1.0\n---\n";
const std::string kXml = "<?xml version=\"1.0\"?>\n";

TEST(CalibrationText, WhatOpenCvWritesIsTaken) {
  const std::string matrix = "   rows: 3\n   cols: 1\n   dt: d\n   data: [ 0., -1.5e-03, 100 ]\n";
  EXPECT_EQ(error_of_text(kYaml + "# made 010\nT: !!opencv-matrix\n" + matrix + "when: \"010\"\n"), "none");
  EXPECT_EQ(error_of_text("{ \"T\": { \"type_id\": \"opencv-matrix\", \"rows\": 3, \"data\": [ 0.0, -0.5, 0 ] } }"),
            "none");
  EXPECT_EQ(error_of_text(kXml + "<opencv_storage>\n<!-- <a> 010 -->\n<T type_id=\"opencv-matrix\">\n<rows>3</rows>\n"
                                 "<data>0. -0.5 0 1e-3</data></T>\n<when>\"010 <\"</when>\n</opencv_storage>\n"),
            "none");
  EXPECT_EQ(error_of_text(""), "none") << "OpenCV refuses it";
}

// OpenCV reads what is nested with one call within another, up to the end of the stack.
TEST(CalibrationText, DepthIsLimited) {
  for (const std::string& text :
       {kYaml + "a: " + repeated("[", 500'000), kYaml + repeated("- ", 500'000), kYaml + repeated("a: {", 100'000),
        repeated("{\"a\":", 100'000), kXml + "<opencv_storage>" + repeated("<a>", 300'000),
        kXml + repeated("\"<a>", 100'000)}) {
    EXPECT_NE(error_of_text(text).find("nested too deeply"), std::string::npos) << text.substr(0, 40);
  }
  EXPECT_EQ(error_of_text(kXml + repeated("<a>", 16) + repeated("</a>", 16)), "none");
  EXPECT_EQ(error_of_text(kXml + "<a>" + repeated("<b/><c></c>", 100) + "</a>"), "none");
}

// OpenCV would read 010 as 8.
TEST(CalibrationText, NumbersAreDecimal) {
  for (const char* number : {"010", "-010", "+00", "0x10", "-0X1F", "08"}) {
    const std::string reason = std::string(number) + " begins with 0; OpenCV would not read it as a decimal number";
    EXPECT_EQ(error_of_text(kYaml + "a: 1\nb: [ 1, " + number + ", 3 ]\n"), "c.yaml: line 4: " + reason);
    EXPECT_EQ(error_of_text(std::string("{ \"a\":\n") + number + " }"), "c.yaml: line 2: " + reason);
    EXPECT_EQ(error_of_text(kXml + "<a>1\n" + number + "</a>"), "c.yaml: line 3: " + reason);
  }
  for (const char* number : {"0", "-0", "0.10", "00.5", "1010", "0e1", "0."}) {
    EXPECT_EQ(error_of_text(kYaml + "a: " + number + "\n"), "none") << number;
    EXPECT_EQ(error_of_text(kXml + "<a>" + number + "</a>"), "none") << number;
  }
}

TEST(CalibrationText, OneDocumentWithoutAliases) {
  EXPECT_EQ(error_of_text(kYaml + "a: 1\n---\na: 2\n"), "c.yaml: line 4: a second document begins; one is expected");
  EXPECT_EQ(error_of_text(kYaml + "a: &x 1\nb: *x\n"), "c.yaml: line 4: aliases are not understood");
}

}  // namespace
}  // namespace selfproj::test
