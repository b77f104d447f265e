/// Whoever wants to be alone gets a domain that nobody is in.
#include <gtest/gtest.h>

#include "io/dds_domain.h"
#include "io/dds_publisher.h"
#include "tests/dds/dds_testing.h"

namespace stillpoint::test {
namespace {

TEST(Domain, IsInUseWhileAParticipantOfAnyTransportLives) {
  const int domain = io::own_domain();
  ASSERT_GE(domain, 1);
  EXPECT_FALSE(io::is_domain_in_use(domain));
  for (const char* transport : {"udp", "shm", "data_sharing"}) {
    const auto publisher = io::DdsPublisher::create(test_params(transport));
    ASSERT_TRUE(publisher) << publisher.error().message;
    EXPECT_TRUE(io::is_domain_in_use(domain)) << transport;
  }
  EXPECT_FALSE(io::is_domain_in_use(domain));
}

}  // namespace
}  // namespace stillpoint::test
