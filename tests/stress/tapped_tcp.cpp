#include "tests/stress/tapped_tcp.h"

#include <utility>

#include "common/wire/framing.h"
#include "common/wire/tcp.h"

namespace haptics::stress {
namespace {

class Tap final : public Transport {
 public:
  Tap(std::unique_ptr<Transport> inner, std::function<void(const v1::Envelope&)> show)
      : inner_(std::move(inner)), show_(std::move(show)) {}

  void start(Events events) override {
    inner_->start({.received =
                       [this, received = std::move(events.received)](std::span<const char> bytes) {
                         decoder_.feed(bytes);
                         for (auto next = decoder_.next(); next && *next; next = decoder_.next()) show_(**next);
                         received(bytes);
                       },
                   .drained = std::move(events.drained),
                   .closed = std::move(events.closed)});
  }
  void send(std::string bytes) override { inner_->send(std::move(bytes)); }
  [[nodiscard]] std::size_t backlog() const noexcept override { return inner_->backlog(); }
  void close(const std::string& why) override { inner_->close(why); }
  [[nodiscard]] std::string peer() const override { return inner_->peer(); }
  void preferThroughput() override { inner_->preferThroughput(); }

 private:
  std::unique_ptr<Transport> inner_;
  std::function<void(const v1::Envelope&)> show_;
  FrameDecoder decoder_;
};

}  // namespace

ServerLink::Connect tappedTcp(Endpoint server, std::function<void(const v1::Envelope&)> received) {
  return [server = std::move(server), received = std::move(received)](EventLoop& loop,
                                                                      const ServerLink::Connected& done) {
    return std::make_shared<TcpConnector>(loop, server, [received, done](Result<std::unique_ptr<Transport>> transport) {
      if (!transport) return done(std::move(transport));
      done(std::make_unique<Tap>(*std::move(transport), received));
    });
  };
}

bool CommitOrder::follows(const v1::Envelope& envelope) {
  if (envelope.has_snapshot_end()) last_ = envelope.snapshot_end().revision();
  if (!envelope.has_commit()) return true;
  const std::uint64_t before = std::exchange(last_, envelope.commit().revision());
  return before == 0 || last_ == before + 1;
}

}  // namespace haptics::stress
