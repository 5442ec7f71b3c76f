#include "graphics_client/audience/nats_connection.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <new>
#include <utility>
#include <vector>

#include "common/clock/monotonic.h"

namespace haptics {
namespace {

constexpr std::int64_t kConnectWithin_ms = 1000;
/// A server that is cut off is noticed after some pings without an answer.
constexpr std::int64_t kPing_ms = 1000;
constexpr int kUnansweredPings = 3;
constexpr std::int64_t kFlushWithin_ms = 2000;
/// Longest wait for one stored message: a server under load takes tens of milliseconds.
constexpr std::uint64_t kReadWithin_ns = 3'000'000'000;
constexpr std::int64_t kSlice_ms = 50;  // between looks at whether to stop
/// A server that does not read is left.
constexpr std::int64_t kWriteWithin_ms = 2000;
/// How the subjects end at which stored messages are awaited (deploy/nats.conf).
constexpr std::string_view kAnswer = ".r";

std::string textOf(natsMsg* message) {
  return {natsMsg_GetData(message), static_cast<std::size_t>(natsMsg_GetDataLength(message))};
}

std::string headerOf(natsMsg* message, const char* name) {
  const char* value = nullptr;
  return natsMsgHeader_Get(message, name, &value) == NATS_OK && value != nullptr ? value : "";
}

std::uint64_t numberIn(std::string_view text) {
  std::uint64_t number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

/// The answer to a direct get; nothing where there is no such message.
Result<std::optional<StoredMessage>> storedIn(natsMsg* answer) {
  const std::string status = headerOf(answer, "Status");
  if (status == "404" || status == "503") return std::optional<StoredMessage>();
  if (!status.empty()) return refused("JetStream", "answers " + status + " " + headerOf(answer, "Description"));
  return StoredMessage{numberIn(headerOf(answer, "Nats-Sequence")), headerOf(answer, "Nats-Subject"), textOf(answer)};
}

natsStatus ask(natsConnection* connection, const StoredQuery& query, const std::string& replyTo) {
  std::string subject = "$JS.API.DIRECT.GET." + query.stream, payload;
  if (query.sequence == 0) {
    subject += "." + query.subject;
  } else {
    payload = "{\"seq\":" + std::to_string(query.sequence) + "}";
  }
  return natsConnection_PublishRequest(connection, subject.c_str(), replyTo.c_str(), payload.data(),
                                       static_cast<int>(payload.size()));
}

natsStatus apply(natsOptions* options, const NatsOptions& wanted) {
  for (const natsStatus step :
       {setNatsServers(*options, wanted.url, wanted.credentials),
        natsOptions_SetName(options, wanted.clientName.c_str()), natsOptions_SetTimeout(options, kConnectWithin_ms),
        natsOptions_SetAllowReconnect(options, false), natsOptions_SetPingInterval(options, kPing_ms),
        natsOptions_SetMaxPingsOut(options, kUnansweredPings),
        natsOptions_SetWriteDeadline(options, kWriteWithin_ms)}) {
    if (step != NATS_OK) return step;
  }
  return NATS_OK;
}

}  // namespace

std::optional<NatsMessage> NatsSubscription::next(std::chrono::milliseconds timeout) {
  natsMsg* message = nullptr;
  if (natsSubscription_NextMsg(&message, subscription_, timeout.count()) != NATS_OK) return std::nullopt;
  const nats::Message owner(message);
  return NatsMessage{natsMsg_GetSubject(message), textOf(message)};
}

std::size_t NatsSubscription::waiting() const {
  int messages = 0;
  return natsSubscription_GetPending(subscription_, &messages, nullptr) == NATS_OK ? static_cast<std::size_t>(messages)
                                                                                   : 0;
}

Result<std::unique_ptr<NatsConnection>> NatsConnection::open(const NatsOptions& options, const std::stop_token& stop) {
  natsOptions* made = nullptr;
  natsStatus status = natsOptions_Create(&made);
  const nats::Options owner(made);
  std::unique_ptr<NatsConnection> connection(new NatsConnection);
  if (status == NATS_OK) status = apply(made, options);
  if (status == NATS_OK) {
    status = natsOptions_SetErrorHandler(
        made,
        [](natsConnection* which, natsSubscription*, natsStatus error, void* self) noexcept {
          if (error == NATS_SLOW_CONSUMER) return;  // a reader finds the gap
          const char* detail = nullptr;
          (void)natsConnection_GetLastError(which, &detail);
          static_cast<NatsConnection*>(self)->fail(
              error == NATS_NOT_PERMITTED ? kNatsRefusal : "",
              detail != nullptr && *detail != '\0' ? detail : natsStatus_GetText(error));
        },
        connection.get());
  }
  if (status == NATS_OK) {
    status = natsOptions_SetDisconnectedCB(
        made,
        [](natsConnection*, void* self) noexcept {
          static_cast<NatsConnection*>(self)->fail("", "the connection to the NATS server is lost");
        },
        connection.get());
  }
  if (status == NATS_OK) {
    status = natsOptions_SetClosedCB(
        made, [](natsConnection*, void* self) noexcept { static_cast<NatsConnection*>(self)->closed(); },
        connection.get());
  }
  NatsSocket socket;
  if (status == NATS_OK) status = connectToNats(connection->connection_, *made, options.url, stop, socket);
  if (status == NATS_OK) {
    connection->guarding_ =
        std::jthread([self = connection.get(), socket](const std::stop_token& ends) { self->guard(socket, ends); });
    return connection;
  }
  if (status == NATS_NO_SERVER || status == NATS_CONNECTION_CLOSED)
    return refused(options.url, "no NATS server answers there");
  if (status == NATS_CONNECTION_AUTH_FAILED || status == NATS_SSL_ERROR) {
    return refused(options.url, std::string(kNatsRefusal) + natsErrorText(status));
  }
  return refused(options.url, natsErrorText(status));
}

NatsConnection::~NatsConnection() {
  if (connection_ == nullptr) return;
  guarding_.request_stop();
  guarding_.join();
  (void)natsConnection_FlushTimeout(connection_, kSlice_ms);
  natsConnection_Close(connection_);
  {
    std::unique_lock lock(mutex_);
    becameClosed_.wait(lock, [this] { return closed_; });
  }
  natsConnection_Destroy(connection_);
}

void NatsConnection::closed() noexcept {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  becameClosed_.notify_all();
}

void NatsConnection::fail(std::string_view kind, const char* why) noexcept {
  const std::lock_guard lock(mutex_);
  if (failure_) return;
  try {
    if (!optionalSubject_.empty() && std::string_view(why).find('"' + optionalSubject_ + '"') != std::string_view::npos)
      return;
    failure_ = Error{"NATS", std::string(kind) + why};
  } catch (const std::bad_alloc&) {
    failure_ = Error{"NATS", "no memory"};  // so short that it takes none
  }
}

std::optional<Error> NatsConnection::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

Result<NatsSubscription> NatsConnection::subscribe(const std::string& subject) {
  natsSubscription* made = nullptr;
  natsStatus status = addSubscription(subject, made);
  if (status == NATS_OK) status = natsConnection_FlushTimeout(connection_, kFlushWithin_ms);
  if (status != NATS_OK) return refused("NATS subject " + subject, natsErrorText(status));
  if (auto why = failure()) return tl::unexpected(*std::move(why));
  return NatsSubscription(made);
}

Result<NatsSubscription> NatsConnection::subscribe(const std::string& subject, const std::string& other) {
  {
    const std::lock_guard lock(mutex_);
    optionalSubject_ = subject;
  }
  auto first = subscribe(subject);
  return first && isRefused(subject) ? subscribe(other) : std::move(first);
}

/// Known once the server has seen all that was sent; the library calls back only later.
bool NatsConnection::isRefused(const std::string& subject) const {
  const char* detail = nullptr;
  return natsConnection_GetLastError(connection_, &detail) == NATS_NOT_PERMITTED && detail != nullptr &&
         std::string_view(detail).find('"' + subject + '"') != std::string_view::npos;
}

natsStatus NatsConnection::addSubscription(const std::string& subject, natsSubscription*& made) {
  natsStatus status = natsConnection_SubscribeSync(&made, connection_, subject.c_str());
  if (status == NATS_OK) status = natsSubscription_SetPendingLimits(made, kMaxWaiting, kMaxWaiting_bytes);
  const std::lock_guard lock(subscribing_);
  subscriptions_.emplace_back(made);
  return status;
}

/// Leaves a server whose message does not end.
void NatsConnection::guard(const NatsSocket& socket, const std::stop_token& stop) {
  natsStatistics* made = nullptr;
  if (natsStatistics_Create(&made) != NATS_OK) return;
  const nats::Statistics statistics(made);
  std::uint64_t messages = 0, begin_bytes = 0;
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  while (!never.wait_for(lock, stop, std::chrono::milliseconds(kSlice_ms), [] { return false; }) &&
         !stop.stop_requested()) {
    std::uint64_t received = 0;
    if (natsConnection_GetStats(connection_, made) != NATS_OK ||
        natsStatistics_GetCounts(made, &received, nullptr, nullptr, nullptr, nullptr) != NATS_OK) {
      return;
    }
    const std::uint64_t bytes = socket.received_bytes();
    if (received != std::exchange(messages, received)) begin_bytes = bytes;
    if (bytes < begin_bytes + kMaxMessage_bytes) continue;
    fail("", "the server sends a message of more than 8 MiB");
    return socket.shutDown();
  }
}

Result<void> NatsConnection::publish(const std::string& subject, std::string_view bytes) {
  const natsStatus status =
      natsConnection_Publish(connection_, subject.c_str(), bytes.data(), static_cast<int>(bytes.size()));
  if (status != NATS_OK) return refused("NATS subject " + subject, natsErrorText(status));
  return {};
}

std::size_t NatsConnection::unsent_bytes() const {
  const int bytes = natsConnection_Buffered(connection_);
  return bytes > 0 ? static_cast<std::size_t>(bytes) : 0;
}

Result<std::optional<std::string>> NatsConnection::request(const std::string& subject, std::string_view bytes,
                                                           std::chrono::milliseconds timeout) {
  natsMsg* answer = nullptr;
  const natsStatus status = natsConnection_Request(&answer, connection_, subject.c_str(), bytes.data(),
                                                   static_cast<int>(bytes.size()), timeout.count());
  const nats::Message owner(answer);
  if (status == NATS_NO_RESPONDERS || status == NATS_TIMEOUT) return std::optional<std::string>();
  if (status != NATS_OK) return refused("NATS subject " + subject, natsErrorText(status));
  return std::optional(textOf(answer));
}

Result<void> NatsConnection::readStored(const std::function<std::optional<StoredQuery>()>& next,
                                        const std::function<bool(std::optional<StoredMessage>)>& take,
                                        const std::stop_token& stop) {
  natsInbox* made = nullptr;
  if (natsInbox_Create(&made) != NATS_OK) return refused("NATS", "has no inbox");
  const std::string inbox = made;
  natsInbox_Destroy(made);
  natsSubscription* subscribed = nullptr;
  if (const auto status = addSubscription(inbox + ".>", subscribed); status != NATS_OK)
    return refused("NATS", natsErrorText(status));
  const std::unique_ptr<natsSubscription, decltype(&natsSubscription_Unsubscribe)> answers(
      subscribed, &natsSubscription_Unsubscribe);

  std::map<std::uint64_t, std::optional<StoredMessage>> arrived;
  std::uint64_t asked = 0, taken = 0;
  bool isLast = false;
  std::uint64_t deadline_ns = monotonicNow_ns() + kReadWithin_ns;
  for (;;) {
    while (!isLast && asked < taken + kReadAhead) {
      const auto query = next();
      if (!query) {
        isLast = true;
        break;
      }
      const natsStatus status = ask(connection_, *query, inbox + "." + std::to_string(asked) + std::string(kAnswer));
      if (status != NATS_OK) return refused("NATS", natsErrorText(status));
      ++asked;
    }
    for (auto at = arrived.find(taken); at != arrived.end(); at = arrived.find(taken)) {
      ++taken;
      deadline_ns = monotonicNow_ns() + kReadWithin_ns;
      const bool goesOn = take(std::move(at->second));
      arrived.erase(at);
      if (!goesOn) return {};
    }
    if (isLast && taken == asked) return {};
    if (stop.stop_requested()) return refused("", "stopped");
    if (auto why = failure()) return tl::unexpected(*std::move(why));
    if (monotonicNow_ns() > deadline_ns) return refused("JetStream", "does not answer");
    if (asked < taken + kReadAhead && !isLast) continue;
    natsMsg* answer = nullptr;
    const natsStatus status = natsSubscription_NextMsg(&answer, subscribed, kSlice_ms);
    const nats::Message owner(answer);
    if (status == NATS_TIMEOUT) continue;
    if (status == NATS_NO_RESPONDERS) {
      arrived[taken] = std::nullopt;  // of all that are asked: there is no such stream
      continue;
    }
    if (status != NATS_OK) return refused("NATS", natsErrorText(status));
    auto stored = storedIn(answer);
    if (!stored) return tl::unexpected(std::move(stored).error());
    const std::string_view subject = natsMsg_GetSubject(answer);
    const std::uint64_t index = numberIn(subject.substr(std::min(subject.size(), inbox.size() + 1)));
    if (index >= taken && index < asked) arrived[index] = *std::move(stored);
  }
}

}  // namespace haptics
