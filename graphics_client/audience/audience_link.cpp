#include "graphics_client/audience/audience_link.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/wire/framing.h"
#include "graphics_client/audience/published_messages.h"
#include "graphics_client/audience/relayed_session.h"
#include "graphics_client/audience/stored_session.h"

namespace haptics {
namespace {

/// Between looks at whether to stop.
constexpr std::chrono::milliseconds kSlice{50};
/// What has come and waits to be looked at; while it is more, NATS is not read.
constexpr std::size_t kMaxUnseen_bytes = 8U << 20;
/// Before a NATS server that did not answer is tried again: twice the one before, up to this.
constexpr std::chrono::milliseconds kFirstPause{250}, kLongestPause{8000};

/// Bytes that one thread hands to another; who hands over waits while they are too many.
class Backlog {
 public:
  void add(std::size_t bytes, const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    bytes_ += bytes;
    becameFew_.wait(lock, stop, [this] { return bytes_ <= kMaxUnseen_bytes; });
  }
  void remove(std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    bytes_ -= bytes;
    becameFew_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable_any becameFew_;
  std::size_t bytes_ = 0;
};

/// Tasks for a loop from other threads, which its owner, on the loop's thread, outlives or not.
class Poster {
 public:
  explicit Poster(EventLoop& loop) : loop_(loop) {}
  template <class Task>
  void post(Task task) {
    loop_.post([alive = std::weak_ptr<int>(alive_), task = std::move(task)]() mutable {
      if (!alive.expired()) task();
    });
  }

 private:
  EventLoop& loop_;
  std::shared_ptr<int> alive_ = std::make_shared<int>();
};

/// What an attempt has read, with the messages that came meanwhile waiting in `live`.
struct Joined {
  std::unique_ptr<NatsConnection> connection;
  NatsSubscription live;
  StoredSession stored;
};

class RelayedTransport final : public Transport {
 public:
  RelayedTransport(EventLoop& loop, Joined joined, SessionSubjects subjects, std::string peer)
      : poster_(loop),
        connection_(std::move(joined.connection)),
        live_(std::move(joined.live)),
        subjects_(std::move(subjects)),
        peer_(std::move(peer)),
        session_(
            std::move(joined.stored), [this](v1::Envelope& envelope) { deliver(envelope); },
            [this](const ContentHash& asset, std::uint64_t offset) { ask(asset, offset); }) {}

  ~RelayedTransport() override {
    following_.request_stop();
    fetching_.request_stop();
  }

  void start(Events events) override { events_ = std::move(events); }

  void send(std::string bytes) override {
    if (isClosed_) return;
    decoder_.feed(bytes);
    for (auto next = decoder_.next(); next && *next; next = decoder_.next()) {
      if (auto taken = session_.fromClient(**next); !taken) return close(taken.error().text());
    }
    if (session_.greeted() && !following_.joinable()) {
      following_ = std::jthread([this](const std::stop_token& stop) { follow(stop); });
      fetching_ = std::jthread([this](const std::stop_token& stop) { fetchAll(stop); });
    }
  }

  [[nodiscard]] std::size_t backlog() const noexcept override { return 0; }

  void close(const std::string& why) override {
    if (std::exchange(isClosed_, true)) return;
    poster_.post([this, why] {
      if (const auto closed = std::exchange(events_.closed, nullptr)) closed(why);
    });
  }

  [[nodiscard]] std::string peer() const override { return peer_; }

 private:
  struct Wanted {
    ContentHash asset;
    std::uint64_t offset;
  };

  /// Later, for the client may be within send().
  void deliver(v1::Envelope& envelope) {
    envelope.set_protocol_version(kProtocolVersion);
    envelope.set_message_id(++messageId_);
    std::string frame;
    if (auto framed = appendFrame(frame, envelope); !framed) return close(framed.error().text());
    poster_.post([this, frame = std::move(frame)] {
      if (!isClosed_ && events_.received) events_.received(frame);
    });
  }

  void ask(const ContentHash& asset, std::uint64_t offset) {
    const std::lock_guard lock(mutex_);
    wanted_.push_back({asset, offset});
    becameWanted_.notify_one();
  }

  void follow(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      if (auto message = live_.next(kSlice)) {
        if (message->subject.ends_with(subjects_.sample) && live_.waiting() > kMaxBehindSample) continue;
        const std::size_t bytes = message->bytes.size();
        poster_.post([this, message = *std::move(message)] {
          take(message);
          unseen_.remove(message.bytes.size());
        });
        unseen_.add(bytes, stop);
      } else if (auto why = connection_->failure()) {
        return poster_.post([this, why = why->text()] { close(why); });
      }
    }
  }

  void take(const NatsMessage& message) {
    const bool isCommit = message.subject.ends_with(subjects_.commit);
    if (auto taken = isCommit ? session_.commit(message.bytes) : session_.sample(message.bytes); !taken) {
      close(taken.error().text());
    }
  }

  void fetchAll(const std::stop_token& stop) {
    for (;;) {
      std::unique_lock lock(mutex_);
      if (!becameWanted_.wait(lock, stop, [this] { return !wanted_.empty(); })) return;
      const Wanted wanted = wanted_.front();
      wanted_.pop_front();
      lock.unlock();
      fetch(wanted, stop);
    }
  }

  /// All chunks of an asset. One that is not stored, not yet or not any more, is said to be unavailable: it is asked for again.
  void fetch(const Wanted& wanted, const std::stop_token& stop) {
    const std::uint64_t first = wanted.offset / kPublishedChunk_bytes;
    std::uint64_t asked = first, arrived = first, total_bytes = 0;
    bool isWhole = false;
    const auto read = connection_->readStored(
        [&]() -> std::optional<StoredQuery> {
          if (total_bytes != 0 && asked * kPublishedChunk_bytes >= total_bytes) return std::nullopt;
          return StoredQuery{.stream = subjects_.assetStream, .subject = subjects_.chunk(wanted.asset, asked++)};
        },
        [&](const std::optional<StoredMessage>& message) {
          auto chunk = message ? readAssetChunk(message->bytes, wanted.asset, arrived) : refused("", "is not stored");
          if (!chunk || (total_bytes != 0 && chunk->total_size() != total_bytes)) return false;
          ++arrived;
          total_bytes = chunk->total_size();
          const std::size_t bytes = chunk->data().size();
          poster_.post([this, bytes, chunk = behind(*std::move(chunk), wanted.offset)] {
            v1::Envelope envelope;
            *envelope.mutable_asset_chunk() = chunk;
            deliver(envelope);
            unseen_.remove(bytes);
          });
          unseen_.add(bytes, stop);
          isWhole = arrived * kPublishedChunk_bytes >= total_bytes;
          return !isWhole;
        },
        stop);
    if (read && isWhole) return;
    poster_.post([this, asset = wanted.asset] {
      v1::Envelope envelope;
      envelope.mutable_asset_unavailable()->set_hash(asset.asBytes());
      deliver(envelope);
    });
  }

  /// The chunk without what is before this offset.
  static v1::AssetChunk behind(v1::AssetChunk chunk, std::uint64_t offset) {
    if (chunk.offset() >= offset) return chunk;
    chunk.mutable_data()->erase(0, offset - chunk.offset());
    chunk.set_offset(offset);
    return chunk;
  }

  Poster poster_;
  std::unique_ptr<NatsConnection> connection_;
  NatsSubscription live_;
  SessionSubjects subjects_;
  std::string peer_;
  RelayedSession session_;
  Events events_;
  FrameDecoder decoder_;
  Backlog unseen_;
  std::uint64_t messageId_ = 0;
  bool isClosed_ = false;

  std::mutex mutex_;  // guards wanted_
  std::condition_variable_any becameWanted_;
  std::deque<Wanted> wanted_;
  std::jthread following_, fetching_;  // joined before anything that they use is gone
};

/// One attempt to join a session, on a thread of its own.
class Attempt {
 public:
  /// @param silent  Attempts before this one that no server answered.
  Attempt(EventLoop& loop, const NatsOptions& options, const SessionSubjects& subjects, const std::string& name,
          const std::shared_ptr<std::atomic<int>>& silent, ServerLink::Connected done)
      : loop_(loop), poster_(loop), done_(std::move(done)), joining_([=, this](const std::stop_token& stop) {
          pause(*silent, stop);
          auto joined = join(options, subjects, name, *silent, stop);
          // Shared, for a task of the loop is copied.
          const auto outcome = std::make_shared<Result<Joined>>(std::move(joined));
          poster_.post([this, outcome, subjects, peer = "session " + name + " at " + options.url] {
            if (!*outcome) return done_(tl::unexpected(std::move(*outcome).error()));
            done_(std::make_unique<RelayedTransport>(loop_, std::move(**outcome), subjects, peer));
          });
        }) {}

 private:
  static void pause(int silent, const std::stop_token& stop) {
    if (silent == 0) return;
    constexpr int kMaxDoubled = 10;
    const auto length = std::min(kLongestPause, kFirstPause * (1 << std::min(silent, kMaxDoubled)));
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any never;
    never.wait_for(lock, stop, length, [] { return false; });
  }

  static Result<Joined> join(const NatsOptions& options, const SessionSubjects& subjects, const std::string& name,
                             std::atomic<int>& silent, const std::stop_token& stop) {
    auto connection = NatsConnection::open(options, stop);
    silent = connection ? 0 : silent + 1;
    if (!connection) return tl::unexpected(std::move(connection).error());
    auto live = (*connection)->subscribe(subjects.live, subjects.audienceLive);
    if (!live) return tl::unexpected(std::move(live).error());
    const std::uint64_t deadline_ns = monotonicNow_ns() + kSignWithin_ns;
    for (bool isPublished = false; !isPublished;) {
      if (const auto message = live->next(kSlice)) {
        isPublished = message->subject.ends_with(subjects.sample) && readLiveMessage(message->bytes).has_value();
      }
      if (auto why = (*connection)->failure()) return tl::unexpected(*std::move(why));
      if (stop.stop_requested()) return refused("", "stopped");
      if (monotonicNow_ns() > deadline_ns) {
        return refused("session " + name, "is not published at " + options.url + " now");
      }
    }
    auto stored = readStoredSession(**connection, subjects, stop);
    if (!stored) return tl::unexpected(std::move(stored).error());
    if (!*stored) return refused("session " + name, "has no snapshot at " + options.url + " yet");
    return Joined{*std::move(connection), *std::move(live), **std::move(stored)};
  }

  EventLoop& loop_;
  Poster poster_;
  ServerLink::Connected done_;
  std::jthread joining_;
};

}  // namespace

ServerLink::Connect connectThroughNats(NatsOptions options, SessionSubjects subjects, std::string sessionName) {
  return [options = std::move(options), subjects = std::move(subjects), name = std::move(sessionName),
          silent = std::make_shared<std::atomic<int>>(0)](EventLoop& loop,
                                                          ServerLink::Connected done) -> std::shared_ptr<void> {
    return std::make_shared<Attempt>(loop, options, subjects, name, silent, std::move(done));
  };
}

}  // namespace haptics
