#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "common/error/error.h"
#include "common/nats/nats_credentials.h"
#include "common/nats/nats_handles.h"
#include "common/nats/nats_socket.h"

namespace haptics {

/// How the reason begins where trying again does not help: credentials, a certificate or a permission.
inline constexpr std::string_view kNatsRefusal = "refused: ";

struct NatsOptions {
  std::string url;  ///< "nats://HOST:PORT", "tls://HOST:PORT", or several of a cluster with commas between them.
  std::optional<NatsCredentials> credentials{};
  std::string clientName;  ///< For the server's log.
};

struct NatsMessage {
  std::string subject, bytes;
};

/// A message that JetStream keeps.
struct StoredMessage {
  std::uint64_t sequence = 0;
  std::string subject, bytes;
};

/// What to read of a stream: the message with this sequence, or the last one of a subject.
struct StoredQuery {
  std::string stream;
  std::uint64_t sequence = 0;  ///< 0: by the subject.
  std::string subject = {};
};

/// Messages of one subject wait in it until they are taken. It is the connection's, and of no use after it.
class NatsSubscription {
 public:
  explicit NatsSubscription(natsSubscription* subscription) : subscription_(subscription) {}
  /// Nothing within the time, or the connection is gone.
  [[nodiscard]] std::optional<NatsMessage> next(std::chrono::milliseconds timeout);
  [[nodiscard]] std::size_t waiting() const;

 private:
  natsSubscription* subscription_;
};

/// A connection to a NATS server, of any thread. It does not connect again: what was under way is unknown then, and its
/// owner has to begin anew.
class NatsConnection {
 public:
  /// Requests that are under way at once while many messages are read: hides the round trip, and is no burst.
  static constexpr std::size_t kReadAhead = 32;
  /// What waits in a subscription, at most; what comes then is lost, and its reader finds the gap.
  static constexpr int kMaxWaiting = 4096, kMaxWaiting_bytes = 16 << 20;
  /// A server that announces a longer message is left. Those of a session are below 1 MiB; JetStream's own tell of all chunks.
  static constexpr std::uint64_t kMaxMessage_bytes = 8U << 20;

  /// Refused: no server answers within some seconds or before a stop, it refuses the credentials, or its certificate is not
  /// trusted.
  [[nodiscard]] static Result<std::unique_ptr<NatsConnection>> open(const NatsOptions& options,
                                                                    const std::stop_token& stop = {});
  ~NatsConnection();
  NatsConnection(const NatsConnection&) = delete;
  NatsConnection& operator=(const NatsConnection&) = delete;

  /// Why it is of no more use, also where the server does not permit something; nothing while all is well.
  [[nodiscard]] std::optional<Error> failure() const;

  /// What is published after it returned arrives.
  [[nodiscard]] Result<NatsSubscription> subscribe(const std::string& subject);
  /// To the other subject where the server does not permit this one.
  [[nodiscard]] Result<NatsSubscription> subscribe(const std::string& subject, const std::string& other);
  /// Of one message, in bytes, as the server takes it.
  [[nodiscard]] std::int64_t maxPayload() const { return natsConnection_GetMaxPayload(connection_); }
  [[nodiscard]] Result<void> publish(const std::string& subject, std::string_view bytes);
  /// Bytes that the system has not taken yet.
  [[nodiscard]] std::size_t unsent_bytes() const;
  /// The first answer; nothing when nobody is there to answer in time.
  [[nodiscard]] Result<std::optional<std::string>> request(const std::string& subject, std::string_view bytes,
                                                           std::chrono::milliseconds timeout);
  /// Reads messages of a stream that allows direct get. `take` gets what was found for one query after the other, nothing
  /// for one that is not stored, and returns whether to go on; `next` gives the queries until there are no more.
  [[nodiscard]] Result<void> readStored(const std::function<std::optional<StoredQuery>()>& next,
                                        const std::function<bool(std::optional<StoredMessage>)>& take,
                                        const std::stop_token& stop = {});

  [[nodiscard]] natsConnection* handle() noexcept { return connection_; }

 private:
  NatsConnection() = default;
  natsConnection* connection_ = nullptr;
  std::mutex subscribing_;  // guards subscriptions_
  /// Also those that are not needed any more: libnats 3.4 crashes where one is destroyed while a message for it is read.
  std::vector<nats::Subscription> subscriptions_;
  mutable std::mutex mutex_;  // guards what follows, which the library's threads set
  std::optional<Error> failure_;
  std::string optionalSubject_;  // may be refused
  bool closed_ = false;          // the last that the library calls back with
  std::condition_variable becameClosed_;

  std::jthread guarding_;

  [[nodiscard]] natsStatus addSubscription(const std::string& subject, natsSubscription*& made);
  [[nodiscard]] bool isRefused(const std::string& subject) const;
  void guard(const NatsSocket& socket, const std::stop_token& stop);
  // The library, which calls these back, is C.
  void fail(std::string_view kind, const char* why) noexcept;
  void closed() noexcept;
};

}  // namespace haptics
