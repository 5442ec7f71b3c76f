#include "common/credentials/credentials.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>
#include <regex>

#include "common/credentials/token_list.h"
#include "tests/common/temporary_folder.h"

namespace haptics::credentials_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class Credentials : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(makeCredentials(folder)); }

  static void write(const fs::path& file, const std::string& text) { std::ofstream(file, std::ios::trunc) << text; }
  static std::string read(const fs::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  static std::optional<Role> roleOf(const ServerCredentials& server, const std::string& token) {
    return TokenList(server).roleOf(hashOfToken(token));
  }

  const test::TemporaryFolder parent;
  const fs::path folder = parent / "made";
};

TEST_F(Credentials, GiveEachFileItsRoleAndNobodyElseOne) {
  const auto server = readServerCredentials(folder);
  ASSERT_TRUE(server) << server.error().text();
  const auto viewer = readClientCredentials(folder / kViewerFile);
  const auto editor = readClientCredentials(folder / kEditorFile);
  ASSERT_TRUE(viewer) << viewer.error().text();
  ASSERT_TRUE(editor) << editor.error().text();
  EXPECT_EQ(roleOf(*server, viewer->token), Role::kView);
  EXPECT_EQ(roleOf(*server, editor->token), Role::kEdit);
  EXPECT_EQ(viewer->serverCertificatePem, server->certificatePem);

  std::string guess = editor->token;
  guess.back() = static_cast<char>(guess.back() ^ 1);
  EXPECT_FALSE(roleOf(*server, guess));
  EXPECT_FALSE(roleOf(*server, ""));
  EXPECT_FALSE(roleOf(*server, editor->token.substr(0, kTokenBytes - 1)));
  EXPECT_FALSE(roleOf(*server, editor->token + '\0'));
  EXPECT_FALSE(roleOf(*server, hashOfToken(editor->token).asBytes())) << "the list itself is no token";
}

TEST_F(Credentials, AreReadableByTheirOwnerOnly) {
  for (const auto& entry : fs::directory_iterator(folder)) {
    EXPECT_EQ(entry.status().permissions(), fs::perms::owner_read | fs::perms::owner_write) << entry.path();
  }
}

TEST_F(Credentials, DifferEachTime) {
  ASSERT_TRUE(makeCredentials(parent / "other"));
  const auto other = readServerCredentials(parent / "other");
  ASSERT_TRUE(other);
  EXPECT_FALSE(roleOf(*other, readClientCredentials(folder / kEditorFile)->token));
  EXPECT_NE(other->certificatePem, readServerCredentials(folder)->certificatePem);
}

TEST_F(Credentials, AreNeverReplaced) {
  const std::string key = read(folder / kServerKeyFile);
  const auto again = makeCredentials(folder);
  ASSERT_FALSE(again);
  EXPECT_THAT(again.error().text(), HasSubstr(kServerKeyFile));
  EXPECT_EQ(read(folder / kServerKeyFile), key);
}

TEST_F(Credentials, ThatAreHalfMadeAreNamed) {
  fs::remove(folder / kServerKeyFile);
  fs::remove(folder / kTokensFile);
  const auto again = makeCredentials(folder);
  ASSERT_FALSE(again);
  EXPECT_THAT(again.error().text(), HasSubstr("viewer.credentials, editor.credentials, server.crt and no server.key"));
  for (const char* const name : {kViewerFile, kEditorFile, kServerCertificateFile}) fs::remove(folder / name);
  EXPECT_TRUE(makeCredentials(folder));
}

TEST_F(Credentials, LeaveNothingWhereTheyCannotAllBeWritten) {
  const fs::path other = parent / "other";
  fs::create_directory(other);
  fs::create_symlink("nowhere", other / kServerCertificateFile);
  EXPECT_FALSE(makeCredentials(other));
  EXPECT_EQ(std::distance(fs::directory_iterator(other), {}), 1);
}

TEST_F(Credentials, AreRefusedWhileOthersMayReadTheKey) {
  fs::permissions(folder / kServerKeyFile, fs::perms::group_read, fs::perm_options::add);
  const auto server = readServerCredentials(folder);
  ASSERT_FALSE(server);
  EXPECT_THAT(server.error().text(), HasSubstr("chmod 600"));

  // systemd's copies show the mask of their access control list there.
  setenv("CREDENTIALS_DIRECTORY", folder.c_str(), 1);
  EXPECT_TRUE(readServerCredentials(folder));
  fs::permissions(folder / kServerKeyFile, fs::perms::others_read, fs::perm_options::add);
  EXPECT_FALSE(readServerCredentials(folder));
  unsetenv("CREDENTIALS_DIRECTORY");
}

TEST_F(Credentials, NameTheFileThatIsMissing) {
  for (const char* name : {kServerCertificateFile, kServerKeyFile, kTokensFile}) {
    const fs::path away = parent / "away";
    fs::rename(folder / name, away);
    const auto server = readServerCredentials(folder);
    ASSERT_FALSE(server) << name;
    EXPECT_THAT(server.error().text(), HasSubstr(name));
    fs::rename(away, folder / name);
  }
  EXPECT_THAT(readClientCredentials(parent / "absent").error().text(), HasSubstr("hapticctl credentials"));
}

TEST_F(Credentials, OfATokenWithdrawnOpenNothing) {
  const auto editor = readClientCredentials(folder / kEditorFile);
  write(folder / kTokensFile, std::regex_replace(read(folder / kTokensFile), std::regex("edit .*\n"), ""));
  const auto server = readServerCredentials(folder);
  ASSERT_TRUE(server) << server.error().text();
  EXPECT_FALSE(roleOf(*server, editor->token));
}

TEST_F(Credentials, AreWithdrawnAndGivenWhileTheListIsInUse) {
  const auto server = readServerCredentials(folder);
  ASSERT_TRUE(server);
  TokenList tokens(*server);
  const ContentHash viewer = hashOfToken(readClientCredentials(folder / kViewerFile)->token);
  const std::string whole = read(folder / kTokensFile);
  EXPECT_EQ(tokens.refresh(), false) << "nothing has changed";

  write(folder / kTokensFile, std::regex_replace(whole, std::regex("view .*\n"), ""));
  EXPECT_EQ(tokens.refresh(), true);
  EXPECT_FALSE(tokens.roleOf(viewer));

  write(folder / kTokensFile, "view 12\n");
  EXPECT_FALSE(tokens.refresh()) << "a bad list is named, and the one before stays";
  EXPECT_EQ(tokens.refresh(), false) << "once";
  EXPECT_FALSE(tokens.refresh(true)) << "or when asked";

  write(folder / kTokensFile, whole);
  EXPECT_EQ(tokens.refresh(), true);
  EXPECT_EQ(tokens.roleOf(viewer), Role::kView);

  write(folder / kTokensFile, "# nobody\n");
  EXPECT_EQ(tokens.refresh(), true);
  EXPECT_FALSE(tokens.roleOf(viewer));
}

TEST_F(Credentials, OfATornListAreRefused) {
  for (const char* list : {"", "# nobody\n", "edit 12\n",
                           "admin "
                           "0000000000000000000000000000000000000000000000000000000000000000\n"}) {
    write(folder / kTokensFile, list);
    const auto server = readServerCredentials(folder);
    ASSERT_FALSE(server) << list;
    EXPECT_THAT(server.error().text(), HasSubstr(kTokensFile));
    EXPECT_THAT(server.error().text(), Not(HasSubstr("00000000"))) << "it may be a token";
  }
}

TEST_F(Credentials, OfATornClientFileAreRefused) {
  const std::string whole = read(folder / kEditorFile);
  const fs::path torn = parent / "torn";
  for (const std::string& text :
       {std::string(), whole.substr(0, 120), std::regex_replace(whole, std::regex("token"), "key"),
        std::regex_replace(whole, std::regex("token: .."), "token: xy"),
        std::regex_replace(whole, std::regex("MII"), "MMM"), std::string(1U << 17, 'a')}) {
    write(torn, text);
    const auto client = readClientCredentials(torn);
    ASSERT_FALSE(client) << text;
    EXPECT_THAT(client.error().field, testing::StartsWith(torn.string()));
  }
}

TEST_F(Credentials, MayBeSavedByAnyEditor) {
  const std::string editor = read(folder / kEditorFile), tokens = read(folder / kTokensFile);
  const std::string token = readClientCredentials(folder / kEditorFile)->token;
  const auto saved = [](const std::string& text, const std::string& end) {
    return "\xef\xbb\xbf" + std::regex_replace("# f\u00fcr\n\n \n" + text, std::regex("\n"), end);
  };
  for (const std::string end : {"\n", "\r\n", " \r\n", "\r"}) {
    write(folder / kEditorFile, saved(editor, end));
    write(folder / kTokensFile, saved(tokens, end));
    const auto client = readClientCredentials(folder / kEditorFile);
    ASSERT_TRUE(client) << client.error().text();
    EXPECT_EQ(client->token, token);
    const auto server = readServerCredentials(folder);
    ASSERT_TRUE(server) << server.error().text();
    EXPECT_EQ(roleOf(*server, token), Role::kEdit);
  }
  write(folder / kEditorFile, std::regex_replace(editor, std::regex("token: "), "token:\u00a0"));
  EXPECT_EQ(readClientCredentials(folder / kEditorFile).error().field, (folder / kEditorFile).string() + ":2");
  write(folder / kTokensFile, std::regex_replace(tokens, std::regex("edit "), "edit\u00a0"));
  EXPECT_EQ(readServerCredentials(folder).error().field, (folder / kTokensFile).string() + ":3");
  write(folder / kTokensFile, "\xff\xfe#");
  EXPECT_THAT(readServerCredentials(folder).error().reason, HasSubstr("UTF-16"));
}

}  // namespace
}  // namespace haptics::credentials_test
