// The self-test of the arithmetic; under other compilers and options: tests/compilers.sh.
#include <gtest/gtest.h>

#include "nfopidn/firmware/self_test.hpp"

namespace nfopidn::test {
namespace {

TEST(SelfTest, FindsThisProgramsArithmeticRight) {
  EXPECT_EQ(self_test<float>(), SelfTest::ok);
  EXPECT_EQ(self_test<double>(), SelfTest::ok);
}

}  // namespace
}  // namespace nfopidn::test
