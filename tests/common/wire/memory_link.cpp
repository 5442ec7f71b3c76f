#include "tests/common/wire/memory_link.h"

#include <algorithm>
#include <utility>

namespace haptics {

/// What both ends and the link share: for each end, its callbacks and the bytes that it has sent.
struct MemoryLink::Shared {
  struct End {
    std::string name;
    std::shared_ptr<Transport::Events> events;  // null before start, after closed and after destruction
    std::string outgoing;
    bool closing = false;  // sends nothing new, receives nothing
    bool gone = false;     // destroyed or cut
    std::string why;
  };
  End ends[2];

  bool deliver(int from, std::size_t limit);
  bool finish(int at);
};

bool MemoryLink::Shared::deliver(int from, std::size_t limit) {
  End& sender = ends[from];
  End& receiver = ends[1 - from];
  // An end that has not started yet keeps its bytes waiting.
  const bool listening = receiver.events != nullptr && !receiver.closing;
  if (sender.outgoing.empty() || (!listening && !receiver.gone && !receiver.closing)) return false;
  const std::string bytes = sender.outgoing.substr(0, limit);
  sender.outgoing.erase(0, bytes.size());
  if (bytes.empty()) return false;
  if (const auto events = receiver.events; listening && events->received) events->received(bytes);
  if (const auto events = sender.events; events && sender.outgoing.empty() && !sender.closing && events->drained) {
    events->drained();
  }
  return true;
}

/// Reports the end of the connection to one end: its own close, once everything is out, or the peer's.
bool MemoryLink::Shared::finish(int at) {
  End& end = ends[at];
  const End& peer = ends[1 - at];
  const bool peerLeft = (peer.closing || peer.gone) && peer.outgoing.empty();
  const bool left = end.gone || (end.closing && end.outgoing.empty());
  if (!end.events || !(left || peerLeft)) return false;
  if (end.why.empty()) end.why = "closed by the peer";
  const auto events = std::exchange(end.events, nullptr);
  end.closing = end.gone = true;
  end.outgoing.clear();
  if (events->closed) events->closed(end.why);
  return true;
}

namespace {

class MemoryTransport final : public Transport {
 public:
  MemoryTransport(std::shared_ptr<MemoryLink::Shared> shared, int end) : shared_(std::move(shared)), end_(end) {}
  ~MemoryTransport() override {
    self().events = nullptr;
    self().closing = self().gone = true;
  }

  void start(Events events) override {
    if (!self().gone) self().events = std::make_shared<Events>(std::move(events));
  }
  void send(std::string bytes) override {
    if (!self().closing) self().outgoing += bytes;
  }
  [[nodiscard]] std::size_t backlog() const noexcept override { return self().outgoing.size(); }
  void close(const std::string& why) override {
    if (self().closing) return;
    self().closing = true;
    self().why = why;
  }
  [[nodiscard]] std::string peer() const override { return shared_->ends[1 - end_].name; }

 private:
  [[nodiscard]] MemoryLink::Shared::End& self() const { return shared_->ends[end_]; }

  std::shared_ptr<MemoryLink::Shared> shared_;
  int end_;
};

}  // namespace

MemoryLink::MemoryLink() : shared_(std::make_shared<Shared>()) {
  shared_->ends[0].name = "client in this process";
  shared_->ends[1].name = "server in this process";
  client_ = std::make_unique<MemoryTransport>(shared_, 0);
  server_ = std::make_unique<MemoryTransport>(shared_, 1);
}
MemoryLink::~MemoryLink() = default;

std::unique_ptr<Transport> MemoryLink::takeClient() { return std::move(client_); }
std::unique_ptr<Transport> MemoryLink::takeServer() { return std::move(server_); }

bool MemoryLink::pump(std::size_t limit_bytes) {
  const auto shared = shared_;
  const std::size_t sent[2] = {shared->ends[0].outgoing.size(), shared->ends[1].outgoing.size()};
  bool moved = false;
  for (const int from : {0, 1}) moved |= shared->deliver(from, std::min(limit_bytes, sent[from]));
  for (const int at : {0, 1}) moved |= shared->finish(at);
  return moved;
}

void MemoryLink::settle() {
  while (pump()) {
  }
}

void MemoryLink::cut(const std::string& why) {
  const auto shared = shared_;
  for (Shared::End& end : shared->ends) {
    end.outgoing.clear();
    end.closing = end.gone = true;
    if (end.why.empty()) end.why = why;
  }
  for (const int at : {0, 1}) shared->finish(at);
}

}  // namespace haptics
