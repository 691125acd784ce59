#include "host/images/natural_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

namespace selfproj::test {
namespace {

using Names = std::vector<std::string>;

TEST(NaturalOrder, NumbersCountByTheirValue) {
  const Names order = {"",
                       "7",
                       "10",
                       "A1",
                       "a",
                       "a01",
                       "a1",
                       "a2",
                       "a02b",
                       "a10",
                       "a10.png",
                       "a10b",
                       "a11",
                       "b",
                       "img1.png",
                       "img2.png",
                       "img09.png",
                       "img10.png",
                       "img99.png",
                       "img100.png",
                       "run2/1.png",
                       "run10/1.png",
                       "z99999999999999999999999999",
                       "z100000000000000000000000000"};
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (std::size_t k = 0; k < order.size(); ++k) {
      EXPECT_EQ(images::natural_less(order[i], order[k]), i < k) << order[i] << " and " << order[k];
    }
  }
}

TEST(NaturalOrder, IsAStrictOrder) {
  std::mt19937 random(1);
  const std::string characters = "0012a.";
  Names names;
  for (int i = 0; i < 200; ++i) {
    std::string name;
    for (std::size_t k = random() % 6; k > 0; --k) {
      name += characters[random() % characters.size()];
    }
    names.push_back(name);
  }
  for (const std::string& a : names) {
    for (const std::string& b : names) {
      EXPECT_EQ(images::natural_less(a, b) || images::natural_less(b, a), a != b) << a << " and " << b;
      for (std::size_t k = 0; k < 20; ++k) {
        EXPECT_FALSE(images::natural_less(a, b) && images::natural_less(b, names[k]) &&
                     !images::natural_less(a, names[k]))
            << a << ", " << b << ", " << names[k];
      }
    }
  }
}

TEST(NaturalOrder, FilesOfAFolder) {
  EXPECT_EQ(images::in_natural_order({"img10.png", "img1.png", "img2.png"}),
            (Names{"img1.png", "img2.png", "img10.png"}));
}

TEST(NaturalOrder, WhatAShellExpandedIsTakenByNumber) {
  EXPECT_EQ(images::in_listed_order({"img1.png", "img10.png", "img11.png", "img2.png"}),
            (Names{"img1.png", "img2.png", "img10.png", "img11.png"}));
  EXPECT_EQ(images::in_listed_order({"p10_a.png", "p1_a.png", "p2_a.png"}),
            (Names{"p1_a.png", "p2_a.png", "p10_a.png"}))
      << "by bytes, where a mark comes after the digits";
  EXPECT_EQ(images::in_listed_order({"p1_a.png", "p10_a.png", "p2_a.png"}),
            (Names{"p1_a.png", "p2_a.png", "p10_a.png"}))
      << "by the rules of a language, where a mark comes before the digits";
  EXPECT_EQ(images::in_listed_order({"pose_1", "pose_10", "pose_2"}), (Names{"pose_1", "pose_2", "pose_10"}));
}

TEST(NaturalOrder, EachPatternOfAListIsTakenByNumber) {
  EXPECT_EQ(images::in_listed_order({"pos1", "pos10", "pos2", "neg1", "neg10", "neg2"}),
            (Names{"pos1", "pos2", "pos10", "neg1", "neg2", "neg10"}));
}

TEST(NaturalOrder, AnyOtherOrderIsTheUsers) {
  for (const Names& names :
       {Names{"pos0", "neg0", "pos1", "neg1", "pos10", "neg10"}, Names{"img10", "img9", "img8", "img1"},
        Names{"img3", "img1", "img2"}, Names{"b", "a"}, Names{"one.png"}, Names{}}) {
    EXPECT_EQ(images::in_listed_order(names), names);
  }
}

TEST(NaturalOrder, NumbersOfOneWidthStayAsTheyWere) {
  Names names;
  for (int i = 1; i <= 120; ++i) {
    names.push_back("frame_" + std::string(5 - std::to_string(i).size(), '0') + std::to_string(i) + ".png");
  }
  EXPECT_EQ(images::in_listed_order(names), names);
  EXPECT_EQ(images::in_natural_order(names), names);
}

}  // namespace
}  // namespace selfproj::test
