#include "graphics_client/mirror/server_link.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <future>
#include <thread>

#include "common/clock/monotonic.h"
#include "common/mesh/mesh_asset.h"
#include "common/wire/tcp.h"
#include "tests/common/temporary_folder.h"
#include "tests/graphics_client/mirror/fake_server.h"

// Real sockets and threads; nothing here depends on how fast they are.
namespace haptics::server_link_test {
namespace {

using std::chrono::seconds;
using testing::HasSubstr;

constexpr seconds kPatience(30);

/// A fake server on a thread of its own that welcomes each client with a snapshot and serves its asset requests.
class TcpFakeServer {
 public:
  explicit TcpFakeServer(std::uint16_t port = 0) {
    server.addObject("a");
    auto listener = TcpListener::open(loop_, {"127.0.0.1", port}, [this](auto transport) {
      server.accept(std::move(transport));
      served_ = 0;
      if (speaksFirst) server.heartbeat();
    });
    EXPECT_TRUE(listener) << listener.error().text();
    listener_ = std::move(*listener);
    thread_ = std::thread([this] {
      serve_ = loop_.every(std::chrono::milliseconds(1), [this] { serve(); });
      loop_.run();
      serve_ = {};
    });
  }
  ~TcpFakeServer() {
    loop_.stop();
    thread_.join();
    listener_.reset();
    server.drop();
  }

  [[nodiscard]] Endpoint where() const { return listener_->local(); }
  /// Runs on the server's thread; returns when it has.
  void run(const std::function<void()>& task) {
    std::promise<void> done;
    loop_.post([&] {
      task();
      done.set_value();
    });
    done.get_future().wait();
  }

  FakeServer server;  // on the loop's thread
  bool refuses = false;
  bool speaksFirst = false;  ///< As a server that answers what it cannot read.

 private:
  void serve() {
    for (; server.connected() && served_ < server.heard().size(); ++served_) answer(server.heard()[served_]);
  }

  void answer(const v1::Envelope& envelope) {
    if (envelope.has_hello() && refuses) {
      v1::Envelope refusal;
      refusal.mutable_refusal()->set_reason("closed today");
      server.send(refusal);
    } else if (envelope.has_hello()) {
      server.welcome(false);
      server.snapshot();
    } else if (envelope.has_asset_request()) {
      server.asset(*ContentHash::fromBytes(envelope.asset_request().hash()), envelope.asset_request().offset());
    } else if (envelope.has_edit_request()) {
      server.accepted(envelope.edit_request().client_seq(), 2);
      server.live(envelope.edit_request().client_seq(), 2, 900);
    } else if (envelope.has_status_request()) {
      v1::Envelope status;
      status.mutable_status()->set_ticks(42);
      server.send(status);
    } else if (envelope.has_asset_upload()) {
      const v1::AssetChunk& chunk = envelope.asset_upload().chunk();
      if (chunk.offset() + chunk.data().size() < chunk.total_size()) return;
      v1::Envelope reply;
      reply.mutable_asset_upload_reply()->set_hash(chunk.hash());
      reply.mutable_asset_upload_reply()->set_accepted(true);
      server.send(reply);
    }
  }

  EventLoop loop_;
  std::unique_ptr<TcpListener> listener_;
  Timer serve_;
  std::size_t served_ = 0;
  std::thread thread_;
};

ServerLink::Options to(const Endpoint& where) {
  return {.server = where, .clientName = "test", .credentials = {}, .telemetryRate_Hz = 60, .fetchAssets = true};
}

bool inStep(const MirrorView& view) { return view.link == LinkState::kLive && view.hashesEqual; }

TEST(ServerLink, ComesIntoStepWithTheServer) {
  TcpFakeServer fake;
  const ServerLink link(to(fake.where()));
  const auto view = link.waitUntil(inStep, kPatience);
  ASSERT_TRUE(view);
  EXPECT_EQ(view->serverRoot, fake.server.scene.root());
  EXPECT_EQ(*recomputedRoot(*view), fake.server.scene.root());
  EXPECT_THAT(view->linkText, HasSubstr("connected to 127.0.0.1:"));
}

TEST(ServerLink, ShowsTelemetryAsItComes) {
  TcpFakeServer fake;
  const ServerLink link(to(fake.where()));
  ASSERT_TRUE(link.waitUntil(inStep, kPatience));
  fake.run([&] { fake.server.telemetry(7, monotonicNow_ns()); });
  const auto view = link.waitUntil([](const MirrorView& v) { return v.sample.has_value(); }, kPatience);
  ASSERT_TRUE(view);
  EXPECT_EQ(view->sample->tick, 7U);
  EXPECT_EQ(link.latest()->samplesReceived, 1U);
}

TEST(ServerLink, CarriesEditsStatusAndUploads) {
  TcpFakeServer fake;
  ServerLink link(to(fake.where()));
  std::promise<std::uint64_t> replied;
  std::promise<std::uint64_t> live;
  std::promise<std::uint64_t> ticks;
  std::promise<bool> uploaded;
  link.submit(removal(1), {.replied = [&](const v1::EditReply& r) { replied.set_value(r.accepted().revision()); },
                           .live = [&](const v1::EditLive& l) { live.set_value(l.tick()); }});
  link.requestStatus([&](const v1::Status& s) { ticks.set_value(s.ticks()); });
  link.upload(AssetKind::kMesh, encodeMesh(grid(100)),
              {.progress = {}, .finished = [&](const v1::AssetUploadReply& r) { uploaded.set_value(r.accepted()); }});
  auto revision = replied.get_future();
  ASSERT_EQ(revision.wait_for(kPatience), std::future_status::ready);
  EXPECT_EQ(revision.get(), 2U);
  auto tick = live.get_future();
  ASSERT_EQ(tick.wait_for(kPatience), std::future_status::ready);
  EXPECT_EQ(tick.get(), 900U);
  auto status = ticks.get_future();
  ASSERT_EQ(status.wait_for(kPatience), std::future_status::ready);
  EXPECT_EQ(status.get(), 42U);
  auto upload = uploaded.get_future();
  ASSERT_EQ(upload.wait_for(kPatience), std::future_status::ready);
  EXPECT_TRUE(upload.get());
}

TEST(ServerLink, FindsARestartedServerAgain) {
  auto fake = std::make_unique<TcpFakeServer>();
  const Endpoint where = fake->where();
  const ServerLink link(to(where));
  ASSERT_TRUE(link.waitUntil(inStep, kPatience));
  fake.reset();
  ASSERT_TRUE(link.waitUntil([](const MirrorView& v) { return v.link == LinkState::kConnecting; }, kPatience));
  EXPECT_EQ(link.latest()->scene->objects().size(), 1U);  // still shown
  fake = std::make_unique<TcpFakeServer>(where.port);
  fake->run([&] { ++fake->server.epoch; });
  const auto view = link.waitUntil([](const MirrorView& v) { return inStep(v) && v.connections > 1; }, kPatience);
  ASSERT_TRUE(view);
}

TEST(ServerLink, WaitsForAServerThatIsNotThereYet) {
  Endpoint where;
  { where = TcpFakeServer().where(); }
  const ServerLink link(to(where));
  const auto view = link.waitUntil(
      [](const MirrorView& v) { return v.linkText.find("cannot connect") != std::string::npos; }, kPatience);
  ASSERT_TRUE(view);
  EXPECT_EQ(view->link, LinkState::kConnecting);
  EXPECT_THAT(view->linkText, HasSubstr(where.text()));
  const TcpFakeServer fake(where.port);
  EXPECT_TRUE(link.waitUntil(inStep, kPatience));
}

TEST(ServerLink, ShowsThatItWasRefused) {
  TcpFakeServer fake;
  fake.run([&] { fake.refuses = true; });
  const ServerLink link(to(fake.where()));
  const auto view = link.waitUntil([](const MirrorView& v) { return v.link == LinkState::kRefused; }, kPatience);
  ASSERT_TRUE(view);
  EXPECT_EQ(view->linkText, "refused by the server: closed today");
}

TEST(ServerLink, WithCredentialsSaysAtOnceThatTheServerSpeaksPlainly) {
  const test::TemporaryFolder folder;
  ASSERT_TRUE(makeCredentials(folder.path()));
  TcpFakeServer fake;
  ServerLink::Options options = to(fake.where());
  options.credentials = readClientCredentials(folder / kEditorFile).value();
  fake.run([&] { fake.speaksFirst = true; });
  const ServerLink link(options);
  const auto view = link.waitUntil([](const MirrorView& v) { return v.link == LinkState::kRefused; }, kPatience);
  ASSERT_TRUE(view);
  EXPECT_THAT(view->linkText, HasSubstr("does not speak TLS"));
}

TEST(ServerLink, LeavesAServerForAnotherOneAndForNone) {
  const TcpFakeServer one, other;
  ServerLink link(to(one.where()));
  ASSERT_TRUE(link.waitUntil(inStep, kPatience));
  link.connectTo(other.where(), std::nullopt);
  EXPECT_EQ(link.latest()->epoch, 0U) << "nothing of the one before";
  const auto view = link.waitUntil(inStep, kPatience);
  ASSERT_TRUE(view);
  EXPECT_THAT(view->linkText, HasSubstr(other.where().text()));
  link.disconnect();
  EXPECT_EQ(link.latest()->link, LinkState::kClosed);
  EXPECT_FALSE(
      link.waitUntil([](const MirrorView& v) { return v.link != LinkState::kClosed; }, std::chrono::milliseconds(700)))
      << "it is not tried again";
}

TEST(ServerLink, HasAViewFromTheFirstMoment) {
  const ServerLink link(to({"127.0.0.1", 1}));
  ASSERT_TRUE(link.latest());
  EXPECT_TRUE(link.latest()->scene);
  EXPECT_EQ(link.latest()->link, LinkState::kConnecting);
}

TEST(ServerLink, GivesNothingWhenTheConditionDoesNotComeTrueInTime) {
  const ServerLink link(to({"127.0.0.1", 1}));
  EXPECT_FALSE(link.waitUntil([](const MirrorView&) { return false; }, std::chrono::milliseconds(20)));
}

TEST(ServerLink, CanBeLeftAtAnyMoment) {
  TcpFakeServer fake;
  for (int i = 0; i < 20; ++i) {
    const ServerLink link(to(fake.where()));
    std::this_thread::sleep_for(std::chrono::milliseconds(i % 5));
  }
}

}  // namespace
}  // namespace haptics::server_link_test
