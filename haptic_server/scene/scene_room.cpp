#include "haptic_server/scene/scene_room.h"

#include <chrono>
#include <exception>
#include <random>
#include <utility>

#include "common/clock/monotonic.h"

namespace haptics {
namespace {

/// How often the builder frees scenes that the servo has left behind while nothing is edited.
constexpr std::chrono::milliseconds kReclaimEvery{100};

std::uint64_t randomEpoch() {
  std::random_device entropy;
  const std::uint64_t epoch = std::uint64_t{entropy()} << 32 | entropy();
  return epoch == 0 ? 1 : epoch;  // 0 is a client that holds nothing
}

}  // namespace

SceneRoom::SceneRoom(Options options, SceneCrossing& crossing)
    : options_(std::move(options)),
      crossing_(crossing),
      library_(options_.assetFolders, store_),
      sequencer_(randomEpoch(), library_),
      servoScenes_(options_.makePlan),
      published_(sequencer_.history()) {}

SceneRoom::~SceneRoom() { stop(); }

Result<std::vector<std::string>> SceneRoom::loadStartScene(const Transaction& scene) {
  const EditOutcome outcome = apply(kServerSession, history()->version.revision() + 1, scene);
  if (const auto* error = std::get_if<Error>(&outcome)) return tl::unexpected(*error);
  if (const auto* conflict = std::get_if<EditConflict>(&outcome)) return refused("preconditions", conflict->reason);
  return std::get<std::shared_ptr<const AcceptedEdit>>(outcome)->reports;
}

void SceneRoom::start() {
  builder_ = std::thread([this] { run(); });
}

void SceneRoom::stop() {
  {
    const std::lock_guard lock(queueMutex_);
    stopping_ = true;
  }
  queueChanged_.notify_all();
  if (builder_.joinable()) builder_.join();
}

void SceneRoom::submitEdit(SessionId session, std::uint64_t clientSeq, Transaction transaction,
                           const EditReply& reply) {
  const std::size_t work = 1 + transaction.operations.size() + transaction.preconditions.size();
  auto job = [this, session, clientSeq, transaction = std::move(transaction), reply] {
    reply(apply(session, clientSeq, transaction));
  };
  if (!enqueue({work, std::move(job)}))
    reply(Error{"busy", "the server has too many edits waiting; send it again later"});
}

void SceneRoom::submitMesh(const ContentHash& hash, std::string bytes, const UploadReply& reply) {
  auto job = [this, hash, bytes = std::move(bytes), reply]() mutable {
    try {
      reply(store_.internEncoded(hash, std::move(bytes)));
    } catch (const std::exception& failure) {
      reply(refused("data", std::string("the server could not build the mesh: ") + failure.what()));
    }
  };
  if (!enqueue({1, std::move(job)}))
    reply(refused("busy", "the server has too many edits waiting; send it again later"));
}

std::shared_ptr<const SceneHistory> SceneRoom::history() const {
  const std::lock_guard lock(historyMutex_);
  return published_;
}

void SceneRoom::setListener(HistoryListener listener) {
  const std::lock_guard lock(historyMutex_);
  listener_ = std::move(listener);
  if (listener_) listener_(published_);
}

bool SceneRoom::enqueue(Job job) {
  {
    const std::lock_guard lock(queueMutex_);
    if (stopping_ || queuedWork_ + job.work > kMaxQueuedWork) return false;
    queuedWork_ += job.work;
    queue_.push_back(std::move(job));
  }
  queueChanged_.notify_one();
  return true;
}

void SceneRoom::run() {
  std::unique_lock lock(queueMutex_);
  while (!stopping_) {
    if (queue_.empty()) queueChanged_.wait_for(lock, kReclaimEvery);
    std::function<void()> task;
    if (!stopping_ && !queue_.empty()) {
      task = std::move(queue_.front().run);
      queuedWork_ -= queue_.front().work;
      queue_.pop_front();
    }
    lock.unlock();
    if (task) task();
    const auto departure = servoScenes_.nextDeparture_ns();
    if (departure && *departure <= monotonicNow_ns()) publishToServo();
    crossing_.reclaim();
    task = nullptr;  // what it holds is freed without the lock
    lock.lock();
  }
}

EditOutcome SceneRoom::apply(SessionId session, std::uint64_t clientSeq, const Transaction& transaction) {
  const auto before = sequencer_.history();
  EditOutcome outcome;
  try {
    outcome = sequencer_.submit(session, clientSeq, transaction);
  } catch (const std::exception& failure) {
    return Error{"", std::string("the server could not carry out the edit: ") + failure.what()};
  }
  if (sequencer_.history() == before) return outcome;

  publishToServo();
  if (options_.log) {
    for (const std::string& report : std::get<std::shared_ptr<const AcceptedEdit>>(outcome)->reports)
      options_.log(report);
  }
  const std::lock_guard lock(historyMutex_);
  published_ = sequencer_.history();
  if (listener_) listener_(published_);
  return outcome;
}

void SceneRoom::publishToServo() { crossing_.publish(servoScenes_.make(sequencer_, monotonicNow_ns())); }

}  // namespace haptics
