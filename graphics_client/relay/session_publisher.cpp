#include "graphics_client/relay/session_publisher.h"

#include <algorithm>
#include <array>
#include <new>
#include <set>
#include <utility>

#include "common/assets/asset_content.h"
#include "common/clock/monotonic.h"
#include "common/wire/framing.h"
#include "common/wire/snapshot.h"
#include "graphics_client/audience/published_messages.h"

namespace haptics {
namespace {

constexpr std::chrono::milliseconds kClaimWithin{500};
constexpr std::int64_t kAnswerWithin_ms = 5000;
/// What is still under way at the end is waited for so long.
constexpr std::int64_t kEndWithin_ms = 500;
/// A message of a session, with what NATS and its subject add.
constexpr std::int64_t kMinPayload_bytes = kMaxFrameBytes;
/// After a chunk was published: it may be under way.
constexpr std::uint64_t kUnderWay_ns = 5'000'000'000;
/// Chunks that are not acknowledged yet: 4 MiB in memory.
constexpr std::int64_t kPendingChunks = 32;
constexpr std::int64_t kPendingScene = 8192;

bool isFull(jsErrCode code) {
  constexpr std::array kFull{JSInsufficientResourcesErr, JSStorageResourcesExceededErr, JSMemoryResourcesExceededErr,
                             JSAccountResourcesExceededErr, JSStreamStoreFailedErr};
  return std::ranges::count(kFull, code) > 0;
}

RelayFailure failureOf(const std::string& where, natsStatus status, jsErrCode code, const std::string& text) {
  if (isFull(code)) {
    return {
        {where, "is full, or JetStream has no room for it: " + text + "; give it more, or remove what is not needed"},
        true};
  }
  if (status == NATS_MAX_PAYLOAD) {
    return {{where, "a message is larger than NATS takes; raise its max_payload"}, true};
  }
  if (code == JSStreamWrongLastSequenceErr) return {{where, "has another writer: " + text}};
  return {{where, text.empty() ? natsErrorText(status) : text}};
}

RelayFailure failureOf(Error why) {
  const bool isFinal = why.reason.starts_with(kNatsRefusal);
  return {std::move(why), isFinal};
}

}  // namespace

tl::expected<std::unique_ptr<SessionPublisher>, RelayFailure> SessionPublisher::open(const NatsOptions& options,
                                                                                     const SessionSubjects& subjects,
                                                                                     int replicas) {
  auto connection = NatsConnection::open(options);
  if (!connection) return tl::unexpected(failureOf(std::move(connection).error()));
  std::unique_ptr<SessionPublisher> publisher(new SessionPublisher(*std::move(connection), subjects, replicas));
  for (const auto step : {&SessionPublisher::checkPayload, &SessionPublisher::claim, &SessionPublisher::makeContexts,
                          &SessionPublisher::prepareStreams, &SessionPublisher::readStored}) {
    if (auto failure = (publisher.get()->*step)()) return tl::unexpected(*std::move(failure));
  }
  return publisher;
}

SessionPublisher::~SessionPublisher() {
  if (scene_) {
    jsPubOptions options;
    jsPubOptions_Init(&options);
    options.MaxWait = connection_->failure() ? 1 : kEndWithin_ms;
    (void)js_PublishAsyncComplete(scene_.get(), &options);
  }
  connection_.reset();  // before its subscriptions: NatsConnection says why
}

std::optional<RelayFailure> SessionPublisher::checkPayload() {
  const std::int64_t most_bytes = connection_->maxPayload();
  if (most_bytes >= kMinPayload_bytes) return std::nullopt;
  return RelayFailure{
      {"NATS", "takes messages of " + std::to_string(most_bytes) + " bytes, and a session has some of " +
                   std::to_string(kMinPayload_bytes) + "; raise its max_payload"},
      true};
}

/// Asks whether a relay answers for this session, then answers for it.
std::optional<RelayFailure> SessionPublisher::claim() {
  auto answer = connection_->request(subjects_.relay, {}, kClaimWithin);
  if (!answer) return failureOf(std::move(answer).error());
  if (*answer) return RelayFailure{{"--session", "another relay publishes under this name"}, true};
  natsSubscription* made = nullptr;
  const natsStatus status = natsConnection_Subscribe(
      &made, connection_->handle(), subjects_.relay.c_str(),
      [](natsConnection* connection, natsSubscription*, natsMsg* message, void*) noexcept {
        if (const char* replyTo = natsMsg_GetReply(message))
          (void)natsConnection_PublishString(connection, replyTo, "here");
        natsMsg_Destroy(message);
      },
      nullptr);
  claim_.reset(made);
  if (status != NATS_OK) return RelayFailure{{"NATS subject " + subjects_.relay, natsErrorText(status)}};
  (void)natsConnection_FlushTimeout(connection_->handle(), kAnswerWithin_ms);
  if (auto why = connection_->failure()) return failureOf(*std::move(why));
  return std::nullopt;
}

std::optional<RelayFailure> SessionPublisher::makeContexts() {
  for (auto [context, pending] : {std::pair{&scene_, kPendingScene}, {&assets_, kPendingChunks}}) {
    jsOptions options;
    jsOptions_Init(&options);
    options.Wait = kAnswerWithin_ms;
    options.PublishAsync.MaxPending = pending;
    options.PublishAsync.StallWait = kAnswerWithin_ms;
    options.PublishAsync.AckHandler = &SessionPublisher::acknowledged;
    options.PublishAsync.AckHandlerClosure = this;
    jsCtx* made = nullptr;
    if (const natsStatus status = natsConnection_JetStream(&made, connection_->handle(), &options); status != NATS_OK) {
      return RelayFailure{{"JetStream", natsErrorText(status)}};
    }
    context->reset(made);
  }
  return std::nullopt;
}

std::optional<RelayFailure> SessionPublisher::prepareStreams() {
  struct Wanted {
    const std::string& stream;
    std::array<const char*, 3> subjects;
    int subjectCount;
    std::int64_t max_bytes, maxPerSubject;
  };
  const std::array wanted{Wanted{subjects_.sceneStream,
                                 {subjects_.snapshot.c_str(), subjects_.latest.c_str(), subjects_.commit.c_str()},
                                 3,
                                 kMaxScene_bytes,
                                 -1},
                          Wanted{subjects_.assetStream, {subjects_.assets.c_str()}, 1, kMaxAssets_bytes, 1}};
  for (const Wanted& one : wanted) {
    jsStreamInfo* info = nullptr;
    jsErrCode code{};
    jsOptions withSubjects;
    jsOptions_Init(&withSubjects);
    withSubjects.Stream.Info.SubjectsFilter = subjects_.assets.c_str();
    natsStatus status = js_GetStreamInfo(&info, scene_.get(), one.stream.c_str(), &withSubjects, &code);
    if (status == NATS_NOT_FOUND) {
      jsStreamConfig config;
      jsStreamConfig_Init(&config);
      auto names = one.subjects;
      config.Name = one.stream.c_str();
      config.Subjects = names.data();
      config.SubjectsLen = one.subjectCount;
      config.MaxBytes = one.max_bytes;
      config.MaxMsgsPerSubject = one.maxPerSubject;
      config.Discard = js_DiscardNew;
      config.AllowDirect = true;
      config.Replicas = replicas_;
      status = js_AddStream(&info, scene_.get(), &config, nullptr, &code);
    }
    if (status == NATS_NO_RESPONDERS || code == JSNotEnabledErr || code == JSNotEnabledForAccountErr) {
      return RelayFailure{
          {"JetStream", "is not on at this NATS server; start it with -js, or with jetstream in its file"}, true};
    }
    if (status != NATS_OK) return failureOf("JetStream stream " + one.stream, status, code, natsErrorText(status));
    if (&one.stream == &subjects_.sceneStream) lastSequence_ = info->State.LastSeq;
    noteStored(*info);
    jsStreamInfo_Destroy(info);
  }
  return std::nullopt;
}

std::optional<RelayFailure> SessionPublisher::readStored() {
  auto read = readStoredSession(*connection_, subjects_);
  if (auto why = connection_->failure()) return failureOf(*std::move(why));
  // What cannot be read is replaced by the next snapshot.
  if (!read || !*read || (**read).lastSequence != lastSequence_) return std::nullopt;
  stored_ = **std::move(read);
  snapshotSequence_ = stored_->snapshotSequence;
  commitsSince_ = lastSequence_ - snapshotSequence_;
  return std::nullopt;
}

std::optional<HeldScene> SessionPublisher::held() const {
  if (!stored_) return std::nullopt;
  return HeldScene{stored_->welcome.epoch(), stored_->scene};
}

SessionFollower SessionPublisher::follower() {
  return {.welcomed = [this](const v1::Welcome& welcome) { welcome_ = welcome; },
          .snapshot = [this](const SceneVersion& scene) { snapshot(scene); },
          .commit = [this](const v1::Commit& message, const SceneVersion& after) { commit(message, after); },
          .telemetry = [this](const v1::Telemetry& message) { telemetry(message); }};
}

/// Parts, then what says where they are; each stored only if all before it were. The one before is kept for those who are
/// reading it.
void SessionPublisher::snapshot(const SceneVersion& scene) {
  const std::uint64_t first = lastSequence_ + 1;
  sendSnapshot(scene, kPublishedChunk_bytes, [&](const v1::Envelope& envelope) {
    v1::SnapshotPart part;
    part.set_protocol_version(kProtocolVersion);
    part.set_epoch(welcome_.epoch());
    if (envelope.has_snapshot_begin()) *part.mutable_begin() = envelope.snapshot_begin();
    if (envelope.has_snapshot_objects()) *part.mutable_objects() = envelope.snapshot_objects();
    if (envelope.has_snapshot_end()) *part.mutable_end() = envelope.snapshot_end();
    store(subjects_.snapshot, part);
  });
  v1::LatestSnapshot latest;
  latest.set_protocol_version(kProtocolVersion);
  latest.set_sequence(first);
  v1::Welcome& welcome = *latest.mutable_welcome();
  welcome = welcome_;
  welcome.set_revision(scene.revision());
  welcome.set_root(scene.root().asBytes());
  welcome.clear_resumed();
  welcome.clear_may_edit();
  welcome.clear_datagram_port();
  welcome.clear_datagram_cookie();
  store(subjects_.latest, latest);
  if (snapshotSequence_ > 1) purge(subjects_.sceneStream, {}, snapshotSequence_);
  snapshotSequence_ = first;
  commitsSince_ = bytesSince_ = 0;
}

void SessionPublisher::commit(const v1::Commit& message, const SceneVersion& after) {
  v1::PublishedCommit published;
  published.set_protocol_version(kProtocolVersion);
  published.set_epoch(welcome_.epoch());
  *published.mutable_commit() = message;
  store(subjects_.commit, published, std::to_string(welcome_.epoch()) + "-" + std::to_string(message.revision()));
  ++commitsSince_;
  bytesSince_ += published.ByteSizeLong();
  if (commitsSince_ >= kCommitsPerSnapshot || bytesSince_ >= kBytesPerSnapshot) snapshot(after);
}

void SessionPublisher::telemetry(const v1::Telemetry& message) {
  if (connection_->unsent_bytes() > kMaxUnsentForSample_bytes) return;
  v1::LiveMessage live;
  live.set_protocol_version(kProtocolVersion);
  live.set_epoch(welcome_.epoch());
  *live.mutable_telemetry() = message;
  if (auto done = connection_->publish(subjects_.sample, live.SerializeAsString()); !done) {
    fail({std::move(done).error()});
  }
}

void SessionPublisher::publishHeartbeat(const MirrorView& view) {
  v1::LiveMessage live;
  live.set_protocol_version(kProtocolVersion);
  live.set_epoch(view.epoch);
  live.mutable_heartbeat()->set_epoch(view.epoch);
  live.mutable_heartbeat()->set_revision(view.scene->revision());
  live.mutable_heartbeat()->set_root(view.scene->root().asBytes());
  if (auto done = connection_->publish(subjects_.sample, live.SerializeAsString()); !done) {
    fail({std::move(done).error()});
  }
}

void SessionPublisher::store(const std::string& subject, const google::protobuf::Message& message,
                             const std::string& id) {
  const std::string bytes = message.SerializeAsString();
  jsPubOptions options;
  jsPubOptions_Init(&options);
  options.MaxWait = kAnswerWithin_ms;
  options.ExpectLastSeq = lastSequence_;
  if (!id.empty()) options.MsgId = id.c_str();
  const natsStatus status =
      js_PublishAsync(scene_.get(), subject.c_str(), bytes.data(), static_cast<int>(bytes.size()), &options);
  if (status != NATS_OK) return fail(failureOf("JetStream stream " + subjects_.sceneStream, status, {}, {}));
  ++lastSequence_;
}

void SessionPublisher::publishAssets(const MirrorView& view, const std::set<ContentHash>& surfaces) {
  std::set<std::string> named;
  for (const ContentHash& key : surfaces) named.insert(key.hex());
  for (const SceneVersion::Object& object : view.scene->objects()) {
    for (const AssetName& asset : object->assets()) {
      if (!named.insert(asset.hash.hex()).second) continue;
      const auto content = view.contentOf(asset);
      if (content) storeAsset(asset.hash, static_cast<v1::AssetKind>(asset.kind), canonicalBytes(*content));
    }
  }
  std::erase_if(assetsStored_, [&](const auto& entry) {
    if (named.contains(entry.first)) return false;
    purge(subjects_.assetStream, subjects_.chunksOf(entry.first), 0);
    return true;
  });
}

void SessionPublisher::publishSurface(const ContentHash& key, const std::string& bytes) {
  storeAsset(key, v1::ASSET_KIND_UNSPECIFIED, CanonicalBytes(bytes, {}));
}

/// What an earlier relay stored is read, and replaced where it is not as it has to be.
void SessionPublisher::storeAsset(const ContentHash& name, v1::AssetKind kind, const CanonicalBytes& bytes) {
  const auto [entry, isNew] = assetsStored_.try_emplace(name.hex());
  Stored& stored = entry->second;
  if (!stored.chunks.empty()) return;
  stored.name = name;
  const std::uint64_t chunks = (bytes.size() + kPublishedChunk_bytes - 1) / kPublishedChunk_bytes;
  const auto message = [&](std::uint64_t index) {
    v1::AssetChunk chunk;
    chunk.set_hash(name.asBytes());
    chunk.set_kind(kind);
    chunk.set_total_size(bytes.size());
    chunk.set_offset(index * kPublishedChunk_bytes);
    chunk.set_data(bytes.copy(chunk.offset(), kPublishedChunk_bytes));
    return chunk.SerializeAsString();
  };
  std::vector<bool> isStored(chunks, false);
  if (!isNew) {
    std::uint64_t asked = 0, taken = 0;
    const auto read = connection_->readStored(
        [&]() -> std::optional<StoredQuery> {
          if (asked == chunks) return std::nullopt;
          return StoredQuery{.stream = subjects_.assetStream, .subject = subjects_.chunk(name, asked++)};
        },
        [&](const std::optional<StoredMessage>& found) {
          isStored[taken] = found && found->bytes == message(taken);
          ++taken;
          return true;
        });
    if (!read) return fail(failureOf(read.error()));
  }
  for (std::uint64_t index = 0; index < chunks && !failure(); ++index) {
    const std::string chunk = message(index);
    stored.chunks.push_back(Hasher().add(chunk).finish());
    if (isStored[index]) continue;
    const natsStatus status = js_PublishAsync(assets_.get(), subjects_.chunk(name, index).c_str(), chunk.data(),
                                              static_cast<int>(chunk.size()), nullptr);
    if (status != NATS_OK) return fail(failureOf("JetStream stream " + subjects_.assetStream, status, {}, {}));
    lastStored_ns_ = monotonicNow_ns();
  }
}

std::optional<ContentHash> SessionPublisher::checkStored() {
  if (monotonicNow_ns() < lastStored_ns_ + kUnderWay_ns) return std::nullopt;
  std::vector<std::pair<Stored*, std::uint64_t>> asked;
  for (auto at = assetsStored_.lower_bound(nextCheck_.first); at != assetsStored_.end(); ++at) {
    std::uint64_t index = at->first == nextCheck_.first ? nextCheck_.second : 0;
    for (; index < at->second.chunks.size() && asked.size() < NatsConnection::kReadAhead; ++index) {
      asked.emplace_back(&at->second, index);
    }
    nextCheck_ = {at->first, index};
    if (asked.size() == NatsConnection::kReadAhead) break;
  }
  if (asked.size() < NatsConnection::kReadAhead) nextCheck_ = {};  // from the first on
  Stored* damaged = nullptr;
  std::size_t next = 0, taken = 0;
  const auto read = connection_->readStored(
      [&]() -> std::optional<StoredQuery> {
        if (next == asked.size()) return std::nullopt;
        const auto& [of, index] = asked[next++];
        return StoredQuery{.stream = subjects_.assetStream, .subject = subjects_.chunk(of->name, index)};
      },
      [&](const std::optional<StoredMessage>& found) {
        const auto& [of, index] = asked[taken++];
        const bool isRight = found && Hasher().add(found->bytes).finish() == of->chunks[index];
        if (!isRight) damaged = of;
        return isRight;
      });
  if (!read) fail(failureOf(read.error()));
  if (damaged == nullptr) return std::nullopt;
  damaged->chunks.clear();
  return damaged->name;
}

/// Subjects end in HASH.N.
void SessionPublisher::noteStored(const jsStreamInfo& info) {
  if (info.State.Subjects == nullptr) return;
  constexpr std::size_t kDigits = 64;
  for (int i = 0; i < info.State.Subjects->Count; ++i) {
    const std::string_view subject = info.State.Subjects->List[i].Subject;
    const std::size_t dot = subject.rfind('.');
    if (dot == std::string_view::npos || dot < kDigits) continue;
    assetsStored_.try_emplace(std::string(subject.substr(dot - kDigits, kDigits)));
  }
}

std::optional<RelayFailure> SessionPublisher::failure() const {
  if (auto lost = connection_->failure()) return failureOf(*std::move(lost));
  const std::lock_guard lock(mutex_);
  return failure_;
}

void SessionPublisher::fail(RelayFailure failure) {
  const std::lock_guard lock(mutex_);
  if (!failure_) failure_ = std::move(failure);
}

/// Up to a sequence above 1: NATS takes 1, as it takes none, for all.
void SessionPublisher::purge(const std::string& stream, const std::string& subject, std::uint64_t upTo) {
  jsOptions options;
  jsOptions_Init(&options);
  if (!subject.empty()) options.Stream.Purge.Subject = subject.c_str();
  if (upTo != 0) options.Stream.Purge.Sequence = upTo;
  jsErrCode code{};
  const natsStatus status = js_PurgeStream(assets_.get(), stream.c_str(), &options, &code);
  if (status != NATS_OK) fail(failureOf("JetStream stream " + stream, status, code, natsErrorText(status)));
}

/// Of a thread of the library, which is C.
void SessionPublisher::acknowledged(jsCtx*, natsMsg* message, jsPubAck*, jsPubAckErr* error, void* self) noexcept {
  if (error != nullptr) {
    auto& publisher = *static_cast<SessionPublisher*>(self);
    try {
      const std::string text = error->ErrText != nullptr ? error->ErrText : "";
      publisher.fail(
          failureOf("JetStream subject " + std::string(natsMsg_GetSubject(message)), error->Err, error->ErrCode, text));
    } catch (const std::bad_alloc&) {
      publisher.fail({{"JetStream", "no memory"}});  // so short that it takes none
    }
  }
  natsMsg_Destroy(message);
}

}  // namespace haptics
