#include "host/files/text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "host/files/json_text.h"
#include "tests/cli/program.h"
#include "tests/support/error_of.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// nlohmann's library is the other opinion: its dump() throws for what is not UTF-8.
bool is_utf8(const std::string& text) {
  try {
    return !nlohmann::json(text).dump().empty();
  } catch (const nlohmann::json::type_error&) {
    return false;
  }
}

// Bytes of random characters, cut, joined and changed.
std::string random_bytes(Random& random) {
  const std::string parts[] = {"a",    "\n",           "\xC3\xA4",          "\xE2\x82\xAC",     "\xF0\x9F\x98\x80",
                               "\xE4", "\xC0\x80",     "\xED\xA0\x80",      "\xF4\x90\x80\x80", "\xFF",
                               "\x80", "\xEF\xBF\xBD", std::string(1, '\0')};
  std::string text;
  for (int i = random.between(0, 12); i > 0; --i) {
    text += parts[random.between(0, 12)];
  }
  if (!text.empty() && random.between(0, 2) == 0) {
    text[static_cast<std::size_t>(random.between(0, static_cast<int>(text.size()) - 1))] =
        static_cast<char>(random.between(0, 255));
  }
  return text;
}

TEST(Text, IsRefusedOrShownUnlessItIsUtf8) {
  for_cases(2000, [](Random& random) {
    const std::string text = random_bytes(random);
    const bool good = is_utf8(text);
    EXPECT_TRUE(is_utf8(files::shown(text)));
    EXPECT_EQ(files::shown(text) == text, good);
    EXPECT_FALSE(files::json_text(nlohmann::json(text)).empty());
    const std::string error = error_of([&] { files::utf8_text(text, "a.yaml"); });
    EXPECT_EQ(error == "none", good) << error;
  });
}

TEST(Text, FilesSayTheLine) {
  const ScratchFolder folder;
  const std::string file = folder / "a.yaml";
  const auto error_for = [&](const std::string& text) {
    write_text(file, text);
    return error_of([&] { files::read_text(file, 1000); });
  };
  EXPECT_NE(error_for("a: 1\nname: Fl\xE4"
                      "che\n")
                .find("a.yaml: line 2: is not text in UTF-8"),
            std::string::npos);
  EXPECT_NE(error_for(std::string("\xFF\xFE"
                                  "a\0",
                                  4))
                .find("UTF-16"),
            std::string::npos);
  write_text(file,
             "\xEF\xBB\xBF"
             "y_mm,z_mm\n");
  EXPECT_EQ(files::read_text(file, 1000), "y_mm,z_mm\n");
}

}  // namespace
}  // namespace selfproj::test
