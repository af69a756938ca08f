#include "vision/labelling/evidence_terms.h"

#include "tests/testing/status.h"

namespace egosieve::vision {
namespace {

TEST(EvidenceTerms, WhatIsDescribedIsParsed) {
  for (const char* text : {"all", "epipolar", "road", "epipolar,negative_depth",
                           "epipolar,accumulation", "negative_depth,road"}) {
    const auto terms = Value(ParseEvidenceTerms(text));
    EXPECT_EQ(Describe(terms), text);
  }
  EXPECT_EQ(Describe(*ParseEvidenceTerms("epipolar")), "epipolar");
  EXPECT_EQ(Describe(*ParseEvidenceTerms("road,epipolar")), "epipolar,road");
  EXPECT_EQ(Describe(EvidenceTerms::EpipolarAlone()), "epipolar");
}

TEST(EvidenceTerms, NonsenseIsRefusedWithTheNames) {
  for (const char* text : {"", "epipolar,", "everything", "all,epipolar", "epipolar;road"}) {
    const auto terms = ParseEvidenceTerms(text);
    EXPECT_THAT(terms, IsInvalid()) << text;
    EXPECT_THAT(std::string(terms.status().message()), ::testing::HasSubstr("negative_depth"));
  }
  EXPECT_FALSE(ParseEvidenceTerms("accumulation").ok()) << "nothing says what moves";
}

}  // namespace
}  // namespace egosieve::vision
