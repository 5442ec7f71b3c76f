#include "common/nats/nats_credentials.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "tests/common/temporary_folder.h"

namespace haptics::nats_credentials_test {
namespace {

class NatsCredentialsFile : public testing::Test {
 protected:
  Result<NatsCredentials> read(const std::string& text) {
    std::ofstream(folder_.path() / "a.nats") << text;
    return readNatsCredentials(folder_.path() / "a.nats");
  }
  test::TemporaryFolder folder_;
};

const std::string kCertificate = "-----BEGIN CERTIFICATE-----\nMAAA\n-----END CERTIFICATE-----\n";

TEST_F(NatsCredentialsFile, HasUserPasswordAndPerhapsACertificate) {
  const auto plain = read("user: relay\npassword: a b: c\n");
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->user, "relay");
  EXPECT_EQ(plain->password, "a b: c");
  EXPECT_EQ(plain->trustedPem, "");
  const auto secured = read(kCertificate + "user: relay\npassword: secret\n" + kCertificate);
  ASSERT_TRUE(secured);
  EXPECT_EQ(secured->trustedPem, kCertificate + kCertificate);
  EXPECT_TRUE(read(kCertificate)) << "who may watch without a name";
}

TEST_F(NatsCredentialsFile, SaysWhatIsMissing) {
  for (const char* text : {"", "user: relay\n", "password: secret\n", "-----BEGIN CERTIFICATE-----\nMAAA\n",
                           "-----BEGIN PRIVATE KEY-----\nMAAA\n-----END PRIVATE KEY-----\nuser: a\npassword: b\n"}) {
    const auto bad = read(text);
    ASSERT_FALSE(bad) << text;
    EXPECT_NE(bad.error().field.find("a.nats"), std::string::npos);
  }
  EXPECT_FALSE(readNatsCredentials(folder_.path() / "none"));
  EXPECT_FALSE(readNatsCredentials(folder_.path())) << "a folder";
  EXPECT_FALSE(readNatsCredentials("/dev/zero")) << "without end";
  ASSERT_EQ(mkfifo((folder_.path() / "fifo").c_str(), 0600), 0);
  EXPECT_FALSE(readNatsCredentials(folder_.path() / "fifo")) << "it does not wait for a writer";
}

}  // namespace
}  // namespace haptics::nats_credentials_test
