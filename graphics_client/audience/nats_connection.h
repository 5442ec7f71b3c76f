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
#include <vector>

#include "common/error/error.h"
#include "common/nats/nats_credentials.h"
#include "common/nats/nats_handles.h"

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

  /// Refused: no server answers, it refuses the credentials, or its certificate is not trusted.
  [[nodiscard]] static Result<std::unique_ptr<NatsConnection>> open(const NatsOptions& options);
  ~NatsConnection();
  NatsConnection(const NatsConnection&) = delete;
  NatsConnection& operator=(const NatsConnection&) = delete;

  /// Why it is of no more use, also where the server does not permit something; nothing while all is well.
  [[nodiscard]] std::optional<Error> failure() const;

  /// What is published after it returned arrives.
  [[nodiscard]] Result<NatsSubscription> subscribe(const std::string& subject);
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
  bool closed_ = false;  // the last that the library calls back with
  std::condition_variable becameClosed_;

  [[nodiscard]] natsStatus subscribe(const std::string& subject, natsSubscription*& made);
  // The library, which calls these back, is C.
  void fail(std::string_view kind, const char* why) noexcept;
  void closed() noexcept;
};

}  // namespace haptics
