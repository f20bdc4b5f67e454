#include "abbe/report/json_writer.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

namespace abbe {
namespace {

using nlohmann::json;
using Layout = JsonWriter::Layout;

TEST(JsonWriter, WhatIsWrittenReadsBack) {
  JsonWriter writer;
  writer.begin_object();
  writer.member("name", "a \"quoted\" \\ name\n\t\x01").member("count", std::uint64_t{18446744073709551615U});
  writer.member("negative", -3).member("yes", true).member("no", false);
  writer.key("nothing").null();
  writer.member("position_mm", Vec3(1, -2.5, 1e-300));
  writer.key("points").begin_array();
  for (int i = 0; i < 3; ++i) writer.begin_object(Layout::one_line).member("i", i).end();
  writer.end();
  writer.key("empty").begin_object().end();
  writer.member("texts", std::vector<std::string>{"X", "Y"});
  writer.end();
  const json read = json::parse(writer.take());
  EXPECT_EQ(read["name"], "a \"quoted\" \\ name\n\t\x01");
  EXPECT_EQ(read["count"], 18446744073709551615U);
  EXPECT_EQ(read["negative"], -3);
  EXPECT_TRUE(read["yes"]);
  EXPECT_FALSE(read["no"]);
  EXPECT_TRUE(read["nothing"].is_null());
  EXPECT_EQ(read["position_mm"], json::array({1, -2.5, 1e-300}));
  EXPECT_EQ(read["points"].size(), 3U);
  EXPECT_EQ(read["points"][2]["i"], 2);
  EXPECT_TRUE(read["empty"].empty());
  EXPECT_EQ(read["texts"], json::array({"X", "Y"}));
}

TEST(JsonWriter, NumbersReadBackBitEqual) {
  std::mt19937_64 random{11};
  JsonWriter writer;
  std::vector<double> numbers = {0.0, -0.0, 0.1, 1e22, 5e-324, std::numeric_limits<double>::max()};
  while (numbers.size() < 2000) {
    const double number = std::bit_cast<double>(random());
    if (std::isfinite(number)) numbers.push_back(number);
  }
  writer.value(numbers);
  const json read = json::parse(writer.take());
  ASSERT_EQ(read.size(), numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    EXPECT_EQ(read[i].get<double>(), numbers[i]) << i;
  }
}

TEST(JsonWriter, NumbersThatAreNotFiniteAreNull) {
  JsonWriter writer;
  writer.value(std::vector<double>{std::numeric_limits<double>::quiet_NaN(), HUGE_VAL, -HUGE_VAL});
  EXPECT_EQ(json::parse(writer.take()), json::array({nullptr, nullptr, nullptr}));
}

TEST(JsonWriter, AnyBytesGiveValidText) {
  std::mt19937_64 random{5};
  for (int k = 0; k < 2000; ++k) {
    std::string bytes(random() % 12, '\0');
    for (char& c : bytes) c = static_cast<char>(random() % 3 == 0 ? random() : 0xC0 + random() % 0x40);
    JsonWriter writer;
    writer.value(std::string_view(bytes));
    EXPECT_TRUE(json::accept(writer.take())) << "draw " << k;
  }
}

TEST(JsonWriter, WhatWasTakenAndWhatFollowsMakeOneText) {
  JsonWriter writer;
  writer.begin_array();
  std::string text;
  for (int i = 0; i < 10; ++i) {
    writer.value(i);
    text += writer.take();
    EXPECT_EQ(writer.pending(), 0U);
  }
  writer.end();
  text += writer.take();
  EXPECT_EQ(json::parse(text).size(), 10U);
}

}  // namespace
}  // namespace abbe
