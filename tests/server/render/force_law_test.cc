#include "server/render/force_law.h"

#include <gtest/gtest.h>

namespace mwidth::render {
namespace {

TEST(ForceLawTest, ResistsAccelerationWithAPositiveMassAndHelpsItWithANegativeOne) {
  EXPECT_EQ(VirtualForce(0.5, 3), 1.5);
  EXPECT_EQ(VirtualForce(-0.5, 3), -1.5);
  EXPECT_EQ(VirtualForce(-0.5, -3), 1.5);
  EXPECT_EQ(VirtualForce(0, 1e6), 0);
}

}  // namespace
}  // namespace mwidth::render
