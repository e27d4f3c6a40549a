// The word that was probably meant.
#include <gtest/gtest.h>

#include "nfopidn/io/nearest.hpp"

namespace nfopidn {
namespace {

TEST(EditDistance, CountsEachKindOfEditOnce) {
  EXPECT_EQ(edit_distance("mass", "mass"), 0U);
  EXPECT_EQ(edit_distance("masss", "mass"), 1U);
  EXPECT_EQ(edit_distance("mas", "mass"), 1U);
  EXPECT_EQ(edit_distance("mask", "mass"), 1U);
  EXPECT_EQ(edit_distance("amss", "mass"), 1U);
  EXPECT_EQ(edit_distance("", "mass"), 4U);
  EXPECT_EQ(edit_distance("mass", ""), 4U);
  EXPECT_EQ(edit_distance("", ""), 0U);
}

// Textbook values; the last is 3 as no letter is touched twice (2 with the unrestricted distance).
TEST(EditDistance, IsThatOfOptimalStringAlignment) {
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
  EXPECT_EQ(edit_distance("sunday", "saturday"), 3U);
  EXPECT_EQ(edit_distance("a cat", "an abct"), 4U);
  EXPECT_EQ(edit_distance("ca", "abc"), 3U);
}

const std::vector<std::string> words = {"mass", "inertia", "initial-pose", "initial-velocity"};

TEST(NearestWord, HasTheFewestEdits) {
  EXPECT_EQ(nearest_word("masss", words), "mass");
  EXPECT_EQ(nearest_word("inital-pose", words), "initial-pose");
  EXPECT_EQ(nearest_word("initial-veolcity", words), "initial-velocity");
  EXPECT_EQ(nearest_word("ab", {"ac", "abcd", "abc"}), "abc");
  EXPECT_EQ(nearest_word("abcx", {"abcy", "abcz"}), "abcy");  // the first of equals
}

TEST(NearestWord, MayHaveAnEditForEveryThreeLetters) {
  EXPECT_EQ(nearest_word("pi", {"pid"}), "pid");
  EXPECT_EQ(nearest_word("p", {"pi"}), "");
  EXPECT_EQ(nearest_word("maxx", {"mass"}), "");
  EXPECT_EQ(nearest_word("inerxxa", words), "inertia");
  EXPECT_EQ(nearest_word("inexxxa", words), "");
  EXPECT_EQ(nearest_word("colour", words), "");
  EXPECT_EQ(nearest_word("", words), "");
  EXPECT_EQ(nearest_word("mass", {}), "");
}

TEST(NearestWord, TakesCaseAndDashesAsNoDifference) {
  EXPECT_EQ(nearest_word("Initial_Pose", words), "initial-pose");
  EXPECT_EQ(nearest_word("initial-pose", {"initial_pose"}), "initial_pose");
  EXPECT_EQ(nearest_word("MASS", words), "mass");
}

TEST(NearestWord, LooksAtNoWordOfMoreThan64Letters) {
  const std::string word(64, 'a');
  EXPECT_EQ(nearest_word(word, {word + "b"}), word + "b");
  EXPECT_EQ(nearest_word(word + "c", {word}), "");
}

TEST(Suggestion, IsAQuestionOrNothing) {
  EXPECT_EQ(suggestion("masss", words), " (did you mean mass?)");
  EXPECT_EQ(suggestion("colour", words), "");
}

}  // namespace
}  // namespace nfopidn
