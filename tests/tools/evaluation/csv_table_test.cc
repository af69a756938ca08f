// Tables of text: what is written is read again, and damage is named by its line.
#include "tools/evaluation/csv_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace egosieve::tools {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(CsvTable, FieldsOfTheHeaderInAnyOrder) {
  const auto rows = ParseCsv("c, b ,a\r\n3,2,1\r\n\n  \n6,,4,more\n", {"a", "b"}, {"none", "c"});
  ASSERT_TRUE(rows.ok()) << rows.status();
  ASSERT_EQ(rows->size(), 2u);
  EXPECT_THAT((*rows)[0].texts, ElementsAre("1", "2", "", "3"));
  EXPECT_EQ((*rows)[0].line, 2);
  EXPECT_THAT((*rows)[1].texts, ElementsAre("4", "", "", "6"));
  EXPECT_EQ((*rows)[1].line, 5);
}

TEST(CsvTable, WhatIsWrittenIsRead) {
  for (const std::string text :
       {"", "plain", "two words", "a,b", "\"", "say \"a\", b", "a\nb\r\nc", "\n", " a ", "ä"}) {
    const std::string csv = "first,text,last\n1," + CsvField(text) + ",2\n3,x,4";
    const auto rows = ParseCsv(csv, {"first", "text", "last"});
    ASSERT_TRUE(rows.ok()) << rows.status();
    ASSERT_EQ(rows->size(), 2u) << csv;
    EXPECT_THAT((*rows)[0].texts, ElementsAre("1", text, "2"));
    EXPECT_THAT((*rows)[1].texts, ElementsAre("3", "x", "4"));
    EXPECT_EQ((*rows)[1].line, 3 + std::count(text.begin(), text.end(), '\n'));
  }
}

TEST(CsvTable, OrdinaryTextHasNoQuotes) {
  EXPECT_EQ(CsvField("kitti/drive 0001-a_b.c;d"), "kitti/drive 0001-a_b.c;d");
  EXPECT_EQ(CsvField("a,b"), "\"a,b\"");
  EXPECT_EQ(CsvField("a\"b"), "\"a\"\"b\"");
  EXPECT_EQ(CsvField("a\nb"), "\"a\nb\"");
}

TEST(CsvTable, QuotesMayHaveSpaceAroundThem) {
  const auto rows = ParseCsv("\"a\",b\n \"1,\" , 2\"\n", {"a", "b"});
  ASSERT_TRUE(rows.ok()) << rows.status();
  EXPECT_THAT((*rows)[0].texts, ElementsAre("1,", "2\""));
}

TEST(CsvTable, DamageIsNamedByItsLine) {
  const auto message = [](const std::string& csv) {
    const absl::Status status = ParseCsv(csv, {"a", "b"}).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << csv;
    return std::string(status.message());
  };
  EXPECT_THAT(message(""), HasSubstr("line 1 has no field \"a\""));
  EXPECT_THAT(message("a,b\n1,2\n3\n"), HasSubstr("line 3: no b"));
  EXPECT_THAT(message("a,b\n\"1\n\",2\n3,\"4\n"), HasSubstr("line 4: a quote is not closed"));
  EXPECT_THAT(message("a,b\n\"1\"2,3\n"), HasSubstr("line 2: text follows a closed quote"));
}

}  // namespace
}  // namespace egosieve::tools
