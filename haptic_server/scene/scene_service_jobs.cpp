#include <sys/resource.h>

#include <algorithm>
#include <exception>
#include <set>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/interruption/interruption.h"
#include "haptic_server/scene/scene_limits.h"
#include "haptic_server/scene/scene_service.h"

// The schedule of jobs on the builder's and the workers' threads.
namespace haptics {
namespace {

/// How often the builder frees scenes that the servo has left behind while nothing is edited.
constexpr std::chrono::milliseconds kReclaimEvery{100};

/// Largest upload that the builder itself builds, in some milliseconds.
constexpr std::size_t kBuiltAtOnce_bytes = 256U << 10;

/// Niceness of the threads that prepare: the builder and the network come first.
constexpr int kWorkersNice = 5;

/// After so many preparations in vain, since others changed meanwhile what the edit is about, the builder makes what is
/// left while all wait: so that every edit is decided at last.
constexpr int kMaxPreparations = 4;

/// Such an edit is tried on its own: it may have to be prepared.
bool makesAsset(const Transaction& transaction) {
  return std::ranges::any_of(transaction.operations, [](const Operation& operation) {
    const auto* material = std::get_if<SetMaterial>(&operation);
    return std::holds_alternative<AddObject>(operation) || std::holds_alternative<RemeshObject>(operation) ||
           (material && !material->material.surface.empty());
  });
}

std::stop_token unwantedOf(const auto& job) {
  return std::visit(
      [](const auto& task) -> std::stop_token {
        if constexpr (requires { task.unwanted; }) return task.unwanted;
        return {};
      },
      job.task);
}

/// Passes a new stage on at once, and its share at most every kProgressEvery.
ProgressWatch::Listener throttled(SceneService::EditProgress progress) {
  if (!progress) return {};
  constexpr std::uint64_t kEvery_ns = std::chrono::nanoseconds(SceneService::kProgressEvery).count();
  return [progress = std::move(progress), last = WorkStage{}, after_ns = std::uint64_t{0}](WorkStage stage,
                                                                                           double share) mutable {
    const std::uint64_t now_ns = monotonicNow_ns();
    if (stage == last && now_ns < after_ns) return;
    last = stage;
    after_ns = now_ns + kEvery_ns;
    progress(stage, share);
  };
}

}  // namespace

bool SceneService::submitEdit(SessionId session, std::uint64_t clientSeq, Transaction transaction,
                              const EditReply& reply, std::stop_token unwanted, EditProgress progress) {
  const std::size_t size_bytes = sizeof(Job) + memoryOf_bytes(transaction);
  return enqueue(session, size_bytes,
                 Edit{{session, clientSeq, std::move(transaction)}, reply, std::move(unwanted), std::move(progress)});
}

bool SceneService::submitAsset(SessionId session, const AssetName& name, std::string bytes, const UploadReply& reply,
                               std::stop_token unwanted) {
  return enqueue(session, sizeof(Job), Upload{name, std::move(bytes), reply, std::move(unwanted)});
}

bool SceneService::enqueue(SessionId session, std::size_t size_bytes, Lanes::Task task) {
  {
    const std::lock_guard lock(queueMutex_);
    if (stopping_ || !lanes_.add(session, size_bytes, std::move(task))) return false;
  }
  queueChanged_.notify_one();
  return true;
}

void SceneService::start() {
  const unsigned workers = std::clamp(std::thread::hardware_concurrency(), kMinWorkers, kMaxWorkers);
  running_ = 1 + workers;
  builder_ = std::thread([this] { run(); });
  for (unsigned i = 0; i < workers; ++i) workers_.emplace_back([this] { work(); });
}

void SceneService::askToStop() {
  {
    const std::lock_guard lock(queueMutex_);
    stopping_ = true;
  }
  stop_.request_stop();
  queueChanged_.notify_all();
  workAdded_.notify_all();
}

void SceneService::stop() {
  askToStop();
  if (builder_.joinable()) builder_.join();
  for (std::thread& worker : workers_) {
    if (worker.joinable()) worker.join();
  }
}

bool SceneService::stopWithin(std::chrono::milliseconds patience) {
  askToStop();
  std::unique_lock lock(queueMutex_);
  return queueChanged_.wait_for(lock, patience, [this] { return running_ == 0; });
}

/// With queueMutex_ locked.
void SceneService::ended() {
  --running_;
  queueChanged_.notify_all();
}

void SceneService::run() {
  const Interruptible interruptible(stop_.get_token());
  std::unique_lock lock(queueMutex_);
  while (!stopping_) {
    if (lanes_.next() == nullptr && !servoScenes_.planIsOld()) queueChanged_.wait_for(lock, kReclaimEvery);
    std::vector<Job> jobs = takeJobs();
    lock.unlock();
    runRound(std::move(jobs));
    lock.lock();
  }
  ended();
}

/// One round of the builder.
void SceneService::runRound(std::vector<Job> jobs) {
  const bool idle = jobs.empty();
  try {
    followServo();
    execute(jobs);
    bakeDents();
    const auto departure = servoScenes_.nextDeparture_ns();
    const bool due = (departure && *departure <= options_.now_ns()) || isBehind_;
    if ((idle && servoScenes_.planIsOld()) || due) {
      publishToServo(idle ? ServoSceneBuilder::Plan::kReplan : ServoSceneBuilder::Plan::kKeep);
    }
  } catch (const std::exception& failure) {
    log(std::string("the scene's builder goes on without what it was at: ") + failure.what());
  }
  finish(jobs);
  mailbox_.reclaim();
}

void SceneService::executeAll() {
  for (bool more = true; more;) {
    std::unique_lock lock(queueMutex_);
    std::vector<Job> jobs = takeJobs();
    lock.unlock();
    runRound(std::move(jobs));
    for (lock.lock(); lanes_.anyAside();) {
      Job job = *lanes_.takeAside();
      lock.unlock();
      static_cast<void>(prepare(job));
      lock.lock();
      lanes_.prepared(std::move(job));
    }
    more = lanes_.next() != nullptr;
  }
}

/// The next job, or several edits that make no assets, and with them those that nobody waits for. With the lock.
std::vector<SceneService::Job> SceneService::takeJobs() {
  const auto mayShare = [](const Job& job) {
    if (unwantedOf(job).stop_requested()) return true;
    const auto* edit = std::get_if<Edit>(&job.task);
    return edit && !edit->preparation && !makesAsset(edit->submission.transaction);
  };
  std::vector<Job> jobs;
  while (!stopping_ && lanes_.next() != nullptr && jobs.size() < kMaxBatch) {
    if (!jobs.empty() && !(mayShare(jobs.back()) && mayShare(*lanes_.next()))) break;
    jobs.push_back(lanes_.take());
  }
  return jobs;
}

/// Leaves the finished jobs in the list.
void SceneService::execute(std::vector<Job>& jobs) {
  std::vector<Job> wanted, done, early;
  for (Job& job : jobs) {
    const bool unwanted = unwantedOf(job).stop_requested();
    if (unwanted) drop(job);
    (unwanted ? done : wanted).push_back(std::move(job));
  }
  jobs = std::move(done);
  if (wanted.size() > 1 && executeTogether(wanted)) {
    std::ranges::move(wanted, std::back_inserter(jobs));
    return;
  }
  std::set<SessionId> waiting;  // for one of theirs that takes long
  for (Job& job : wanted) {
    if (waiting.contains(job.session)) {
      early.push_back(std::move(job));
    } else if (execute(job)) {
      jobs.push_back(std::move(job));
    } else {
      waiting.insert(job.session);
      const std::lock_guard lock(queueMutex_);
      lanes_.setAside(std::move(job));
      workAdded_.notify_one();
    }
  }
  const std::lock_guard lock(queueMutex_);
  for (; !early.empty(); early.pop_back()) lanes_.putBack(std::move(early.back()));
}

/// Edits. False: one of them takes long, and nothing was done.
bool SceneService::executeTogether(std::span<Job> jobs) {
  std::vector<Submission> submissions;
  for (Job& job : jobs) submissions.push_back(std::move(std::get<Edit>(job.task).submission));
  Preparation nothing(library_);
  const auto outcomes = apply(submissions, nothing);
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    auto& edit = std::get<Edit>(jobs[i].task);
    if (outcomes) {
      edit.reply((*outcomes)[i]);
    } else {
      edit.submission = std::move(submissions[i]);
    }
  }
  return outcomes.has_value();
}

/// False: it takes long, and is to be prepared.
bool SceneService::execute(Job& job) {
  try {
    if (auto* edit = std::get_if<Edit>(&job.task)) return execute(*edit);
    if (auto* upload = std::get_if<Upload>(&job.task)) return execute(*upload);
    std::get<std::function<void()>>(job.task)();
  } catch (const std::exception& failure) {
    log(std::string("the scene's builder goes on without what it was at: ") + failure.what());
  }
  return true;
}

bool SceneService::execute(Edit& edit) {
  if (edit.failure) {
    edit.reply(*edit.failure);
    return true;
  }
  if (!edit.preparation) edit.preparation = std::make_unique<Preparation>(library_);
  const bool unchanged = edit.scene && edit.scene->history == sequencer_.history();
  if (unchanged || edit.timesPrepared >= kMaxPreparations) edit.preparation->allowLongWork();
  if (const auto outcomes = apply({&edit.submission, 1}, *edit.preparation, edit.unwanted)) {
    edit.reply(outcomes->front());
    return true;
  }
  edit.scene = sequencer_.scene();
  ++edit.timesPrepared;
  return false;
}

bool SceneService::execute(Upload& upload) {
  if (!upload.built) {
    if (upload.bytes.size() > kBuiltAtOnce_bytes) return false;
    build(upload);
  }
  if (*upload.built && !lostAtStart_.empty()) {
    try {
      restoreLostParts(upload.name.hash);
    } catch (const std::exception& failure) {
      log(std::string("what was lost of the scene stays lost: ") + failure.what());
    }
  }
  upload.reply(*std::move(upload.built));
  return true;
}

void SceneService::build(Upload& upload) {
  try {
    upload.built = store_.internEncoded(upload.name, std::move(upload.bytes));
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception& failure) {
    upload.built = refused("data", std::string("the server could not build the asset: ") + failure.what());
  }
}

void SceneService::work() {
  setpriority(PRIO_PROCESS, 0, kWorkersNice);  // this thread's
  std::unique_lock lock(queueMutex_);
  for (;;) {
    workAdded_.wait(lock, [this] { return stopping_ || lanes_.anyAside(); });
    if (stopping_) return ended();
    Job job = *lanes_.takeAside();
    lock.unlock();
    const bool wanted = prepare(job);
    if (!wanted) drop(job);
    lock.lock();
    if (wanted) {
      lanes_.prepared(std::move(job));
    } else {
      lanes_.finished(job);
    }
    queueChanged_.notify_one();
    lock.unlock();
    job = {};  // what it holds is freed without the lock
    lock.lock();
  }
}

/// False: nobody waits for it any more.
bool SceneService::prepare(Job& job) {
  const std::stop_token unwanted = unwantedOf(job);
  std::stop_source either;
  const auto stop = [&either] { either.request_stop(); };
  const std::stop_callback onStop(stop_.get_token(), stop);
  const std::stop_callback onUnwanted(unwanted, stop);
  const Interruptible interruptible(either.get_token());
  try {
    interruptionPoint();
    if (auto* edit = std::get_if<Edit>(&job.task)) prepare(*edit);
    if (auto* upload = std::get_if<Upload>(&job.task)) {
      build(*upload);
      if (journal_ && *upload->built) journal_->prepare(**upload->built);
    }
  } catch (const Interrupted&) {
    return false;
  }
  return !unwanted.stop_requested();
}

void SceneService::prepare(Edit& edit) {
  const ProgressWatch watch(throttled(edit.progress));
  try {
    edit.preparation->prepare(*edit.scene, edit.submission.transaction);
    if (!journal_) return;
    for (const auto& asset : edit.preparation->made()) journal_->prepare(asset);
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception& failure) {
    edit.failure = Error{"", std::string("the server could not carry out the edit: ") + failure.what()};
  }
}

/// Nobody waits for it, but memory may be reserved for what was uploaded.
void SceneService::drop(Job& job) {
  auto* upload = std::get_if<Upload>(&job.task);
  if (upload && !stop_.stop_requested()) upload->reply(refused("", "nobody waits for it any more"));
}

void SceneService::finish(std::span<const Job> jobs) {
  const std::lock_guard lock(queueMutex_);
  for (const Job& job : jobs) lanes_.finished(job);
}

}  // namespace haptics
