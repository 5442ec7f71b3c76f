#include "haptic_server/state/saved_state.h"

#include <memory>
#include <utility>
#include <vector>

#include "common/wire/convert.h"
#include "haptic_server/scene/lost_parts.h"
#include "haptics/v1/state.pb.h"

namespace haptics {
namespace {

void write(const AcceptedEdit& edit, v1::KeptEdit& message) {
  message.set_session(edit.session);
  message.set_client_seq(edit.clientSeq);
  toWire(edit.commit, *message.mutable_commit());
  for (const std::string& report : edit.reports) message.add_report(report);
  message.set_next_object_id(edit.nextId);
}

Result<std::shared_ptr<const AcceptedEdit>> editFrom(const v1::KeptEdit& message) {
  auto commit = fromWire(message.commit());
  if (!commit) return tl::unexpected(std::move(commit).error().within("commit."));
  return std::make_shared<const AcceptedEdit>(
      AcceptedEdit{.session = message.session(),
                   .clientSeq = message.client_seq(),
                   .commit = *std::move(commit),
                   .reports = {message.report().begin(), message.report().end()},
                   .nextId = message.next_object_id()});
}

void write(const EditDeduplicator::SessionResults& session, v1::SessionResults& message) {
  message.set_session(session.session);
  message.set_forgotten_up_to(session.forgottenUpTo);
  for (const auto& result : session.results) {
    auto& kept = *message.add_result();
    kept.set_client_seq(result.clientSeq);
    kept.set_revision(result.revision);
    kept.set_root(result.root.asBytes());
  }
}

Result<EditDeduplicator::SessionResults> resultsFrom(const v1::SessionResults& message) {
  EditDeduplicator::SessionResults session{message.session(), message.forgotten_up_to(), {}};
  for (const auto& result : message.result()) {
    const auto root = hashFromWire(result.root(), "session.result.root");
    if (!root) return tl::unexpected(root.error());
    session.results.push_back({result.client_seq(), result.revision(), *root});
  }
  return session;
}

/// The newest edits that fit, oldest first.
void addResumable(const SceneHistory& history, v1::Checkpoint& checkpoint) {
  std::vector<v1::KeptEdit> newestFirst;
  std::size_t bytes = 0;
  for (std::size_t i = history.edits.size(); i-- > 0;) {
    v1::KeptEdit message;
    write(*history.edits[i], message);
    bytes += message.ByteSizeLong();
    if (bytes > kMaxResumeBytes) break;
    newestFirst.push_back(std::move(message));
  }
  for (auto edit = newestFirst.rbegin(); edit != newestFirst.rend(); ++edit) {
    *checkpoint.add_edit() = std::move(*edit);
  }
}

Result<SceneHistory> historyIn(const v1::Checkpoint& checkpoint) {
  std::vector<ObjectRecord> objects;
  for (const auto& object : checkpoint.object()) {
    auto record = fromWire(object);
    if (!record) return tl::unexpected(std::move(record).error().within("object."));
    objects.push_back(*std::move(record));
  }
  auto version = SceneVersion::fromSnapshot(checkpoint.revision(), std::move(objects));
  if (!version) return tl::unexpected(version.error());
  if (version->root().asBytes() != checkpoint.root()) return refused("root", "is not that of the objects");

  SceneHistory history{checkpoint.epoch(), *std::move(version), {}};
  for (const auto& message : checkpoint.edit()) {
    auto edit = editFrom(message);
    if (!edit) return tl::unexpected(std::move(edit).error().within("edit."));
    history.edits.push_back(*std::move(edit));
  }
  return history;
}

/// A state on its way from record to record.
struct Replay {
  SceneHistory history;
  SequencerState state;  // but for its history

  Result<void> begin(const v1::Checkpoint& checkpoint) {
    auto read = historyIn(checkpoint);
    if (!read) return tl::unexpected(std::move(read).error());
    history = *std::move(read);
    for (const auto& message : checkpoint.session()) {
      auto session = resultsFrom(message);
      if (!session) return tl::unexpected(std::move(session).error());
      state.memory.remember(*std::move(session));
    }
    for (const auto& object : checkpoint.lost()) {
      auto record = fromWire(object);
      if (!record) return tl::unexpected(std::move(record).error().within("lost."));
      state.lost.push_back(std::make_shared<const ObjectRecord>(*std::move(record)));
    }
    state.nextId = checkpoint.next_object_id();
    return {};
  }

  Result<void> follow(const v1::KeptEdit& message) {
    auto edit = editFrom(message);
    if (!edit) return tl::unexpected(std::move(edit).error());
    const Commit& commit = (*edit)->commit;
    if (commit.prevRoot != history.version.root()) return refused("commit.prev_root", "is not the root before it");
    auto next = history.version.apply(commit);
    if (!next) return tl::unexpected(std::move(next).error().within("commit."));
    if (next->root() != commit.root) return refused("commit.root", "is not what the commit leads to");

    state.memory.remember((*edit)->session, {(*edit)->clientSeq, commit.revision, commit.root});
    state.nextId = (*edit)->nextId;
    history.append(*std::move(edit), *std::move(next));
    return {};
  }
};

bool parse(std::string_view record, v1::LogRecord& message) {
  return message.ParseFromArray(record.data(), static_cast<int>(record.size()));
}

}  // namespace

std::string checkpointRecord(const SequencerState& state) {
  v1::LogRecord record;
  v1::Checkpoint& checkpoint = *record.mutable_checkpoint();
  const SceneVersion& version = state.history->version;
  checkpoint.set_epoch(state.history->epoch);
  checkpoint.set_revision(version.revision());
  checkpoint.set_root(version.root().asBytes());
  for (const auto& object : version.objects()) toWire(*object, *checkpoint.add_object());
  checkpoint.set_next_object_id(state.nextId);
  for (const auto& session : state.memory.sessions()) write(session, *checkpoint.add_session());
  addResumable(*state.history, checkpoint);
  for (const auto& object : stillLost(state)) toWire(*object, *checkpoint.add_lost());
  return record.SerializeAsString();
}

std::string editRecord(const AcceptedEdit& edit) {
  v1::LogRecord record;
  write(edit, *record.mutable_edit());
  return record.SerializeAsString();
}

Result<SavedState> readLog(std::string_view log) {
  if (!log.starts_with(kLogHead)) {
    return refused("", "does not begin with \"" + std::string(kLogHead.substr(0, kLogHead.size() - 1)) +
                           "\": it is damaged, or no log of this version");
  }
  RecordReader reader(log);
  v1::LogRecord record;
  Replay replay;
  const auto first = reader.next();
  if (!first || !parse(*first, record) || !record.has_checkpoint()) {
    return refused("", "is damaged at its first record, the checkpoint that all others build on");
  }
  if (auto begun = replay.begin(record.checkpoint()); !begun) {
    return tl::unexpected(std::move(begun).error().within("checkpoint."));
  }

  std::size_t good = reader.offset();
  RecordWriter writer(reader.chain());
  std::string misfit;
  while (const auto payload = reader.next()) {
    if (!parse(*payload, record) || !record.has_edit()) {
      misfit = "holds no edit";
    } else if (const auto followed = replay.follow(record.edit()); !followed) {
      misfit = followed.error().text();
    }
    if (!misfit.empty()) break;
    good = reader.offset();
    writer = RecordWriter(reader.chain());
  }
  replay.state.history = std::make_shared<const SceneHistory>(std::move(replay.history));
  SavedState saved{std::move(replay.state), writer, {}};
  if (good < log.size()) {
    const bool torn = misfit.empty() && reader.end() == LogEnd::kTorn;
    if (misfit.empty()) misfit = torn ? "the record is incomplete" : "what follows is not what was written";
    saved.damage = LogDamage{torn, good, log.size() - good, misfit};
  }
  return saved;
}

Result<SavedState> readLogBehind(std::string_view beginning, std::string_view log) {
  std::string whole(beginning);
  if (log.size() > beginning.size()) whole += log.substr(beginning.size());
  auto saved = readLog(whole);
  if (saved && log.size() < beginning.size()) {
    saved->damage = LogDamage{false, log.size(), 0, "the log is shorter than its checkpoint"};
  }
  return saved;
}

}  // namespace haptics
