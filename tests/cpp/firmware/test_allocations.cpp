// The step and the reset take nothing from the heap: operator new is replaced and counted.
#include <cstdlib>
#include <memory>
#include <new>

#include "nfopidn/firmware.hpp"
#include "support.hpp"

namespace {
// Only what this thread asks for between begin and end counts.
thread_local long allocations = 0;

void* counted(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
}  // namespace

void* operator new(std::size_t size) { return counted(size); }
void* operator new[](std::size_t size) { return counted(size); }
// std::stable_sort asks so; all forms must agree on where memory comes from.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size == 0 ? 1 : size);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size == 0 ? 1 : size);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

namespace nfopidn::test {
namespace {

template <class Law>
class Allocations : public ::testing::Test {};
using Laws =
    ::testing::Types<Controller<float, Fir<float, 7>>,
                     Controller<float, Fir<float, 7>, FixedVariant<float>>,
                     Controller<double, Fir<double, 7>>, Controller<double, Fir<double, 1026, 64>>>;
TYPED_TEST_SUITE(Allocations, Laws);

TYPED_TEST(Allocations, NoneInStepAndReset) {
  using Base = typename TypeParam::Base;
  Draws draw(1);
  const auto law = std::make_unique<TypeParam>();
  ASSERT_EQ(law->configure({}), Status::ok);
  const long before = allocations;
  Base sum = 0;
  for (int k = 0; k < 1000; ++k) {
    sum += law->step(random_measurement<Base>(draw), random_reference<Base>(draw)).left;
    if (k % 100 == 0) law->reset();
  }
  EXPECT_EQ(allocations, before);
  EXPECT_NE(sum, Base(0));
}

TEST(AllocationCount, SeesOne) {
  const long before = allocations;
  const auto number = std::make_unique<int>(1);
  EXPECT_EQ(allocations, before + *number);
}

}  // namespace
}  // namespace nfopidn::test
