#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <exception>
#include <set>
#include <utility>

#include "common/clock/monotonic.h"
#include "common/interruption/interruption.h"
#include "haptic_server/scene/edit_price.h"
#include "haptic_server/scene/scene_draft.h"
#include "haptic_server/scene/scene_limits.h"
#include "haptic_server/scene/scene_service.h"

// The schedule of jobs on the builder's and the workers' threads.
namespace haptics {
namespace {

using namespace std::chrono_literals;

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

/// Key of a client's work; a task of the server's own has none. Of a session each: another one may try the same anew.
WorkNotes::Key keyOf(const auto& job) {
  return std::visit(
      [&job](const auto& one) -> WorkNotes::Key {
        if constexpr (requires { one.submission; }) return {job.session, one.submission.clientSeq};
        if constexpr (requires { one.name; }) {
          WorkNotes::Key key{job.session};
          std::memcpy(&key.second, one.name.hash.bytes.data(), sizeof key.second);
          return key;
        }
        return {};
      },
      job.task);
}

/// "the object "poison"", of its first operation.
std::string whatItIsAbout(const Transaction& transaction) {
  if (transaction.operations.empty()) return "nothing";
  return std::visit(
      [](const auto& op) {
        if constexpr (requires { op.name; }) return "the object \"" + op.name + "\"";
        if constexpr (requires { op.object; }) return op.object.text();
      },
      transaction.operations.front());
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

Result<Price> SceneService::priceOf(const Transaction& transaction) {
  const Sequencer::Scene scene = sequencer_.scene();
  SceneDraft draft(scene.history->version, scene.assets, scene.nextId, scene.limits);
  for (const Operation& operation : transaction.operations) {
    if (auto applies = draft.apply(operation, ""); !applies) return tl::unexpected(std::move(applies).error());
  }
  return draft.priceOf(library_);
}

std::optional<SceneService::Place> SceneService::waiting(SessionId session) const {
  const std::lock_guard lock(queueMutex_);
  const auto queued = lanes_.queued(session);
  const auto* edit = queued ? std::get_if<Edit>(&queued->job->task) : nullptr;
  if (edit == nullptr) return std::nullopt;
  return Place{edit->submission.clientSeq, queued->place};
}

bool SceneService::submitAsset(SessionId session, const AssetName& name, std::string bytes, const UploadReply& reply,
                               std::stop_token unwanted) {
  return enqueue(session, sizeof(Job), Upload{name, std::move(bytes), reply, std::move(unwanted)});
}

bool SceneService::enqueue(SessionId session, std::size_t size_bytes, Lanes::Task task) {
  {
    const std::lock_guard lock(queueMutex_);
    if (stopping_ || !lanes_.add(session, size_bytes, std::move(task))) return false;
    planning_.request_stop();
  }
  queueChanged_.notify_one();
  return true;
}

void SceneService::start() {
  const unsigned workers = std::clamp(std::thread::hardware_concurrency(), kMinWorkers, kMaxWorkers);
  running_ = 2 + workers;
  builder_ = std::thread([this] { run(); });
  for (unsigned i = 0; i <= workers; ++i) workers_.emplace_back([this, i] { work(i == 0); });
}

void SceneService::askToStop() {
  endsInOrder();
  {
    const std::lock_guard lock(queueMutex_);
    stopping_ = true;
    planning_.request_stop();
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
    if (lanes_.next() == nullptr && (isBehind_ || !servoScenes_.planIsOld()))
      queueChanged_.wait_for(lock, kReclaimEvery);
    lock.unlock();
    runRound();
    lock.lock();
  }
  ended();
}

/// One round of the builder.
void SceneService::runRound() {
  std::vector<Job> jobs;
  try {
    takeJobs(jobs);
    const bool idle = jobs.empty();
    followServo();
    execute(jobs);
    bakeDents();
    if (isUnheard_) publishHistory();
    const auto departure = servoScenes_.nextDeparture_ns();
    if ((departure && *departure <= options_.now_ns()) || isBehind_) {
      publishToServo(ServoSceneBuilder::Plan::kKeep);
    } else if (idle && servoScenes_.planIsOld()) {
      replan();
    }
  } catch (const std::exception& failure) {
    giveUp(jobs, failure.what());
  }
  finish(jobs);
  mailbox_.reclaim();
}

/// Until there is a job; then later, anew.
void SceneService::replan() {
  std::stop_token untilWork;
  {
    const std::lock_guard lock(queueMutex_);
    if (stopping_ || lanes_.next() != nullptr) return;
    planning_ = std::stop_source();
    untilWork = planning_.get_token();
  }
  const Interruptible planning(untilWork);
  publishToServo(ServoSceneBuilder::Plan::kReplan);
}

void SceneService::executeAll() {
  for (bool more = true; more;) {
    runRound();
    std::unique_lock lock(queueMutex_);
    while (lanes_.anyAside()) {
      Job job = *lanes_.takeAside();
      lock.unlock();
      static_cast<void>(prepare(job));
      lock.lock();
      lanes_.prepared(std::move(job));
    }
    more = lanes_.next() != nullptr;
  }
}

/// The next job, or several edits that make no assets, and with them those that nobody waits for.
void SceneService::takeJobs(std::vector<Job>& jobs) {
  const auto mayShare = [](const Job& job) {
    if (unwantedOf(job).stop_requested()) return true;
    const auto* edit = std::get_if<Edit>(&job.task);
    return edit && !edit->preparation && !makesAsset(edit->submission.transaction);
  };
  const std::lock_guard lock(queueMutex_);
  while (!stopping_ && lanes_.next() != nullptr && jobs.size() < kMaxBatch) {
    if (!jobs.empty() && !(mayShare(jobs.back()) && mayShare(*lanes_.next()))) break;
    jobs.emplace_back();  // first: it may throw
    jobs.back() = lanes_.take();
  }
}

/// Those that go back into the queue leave an empty job in the list.
void SceneService::execute(std::vector<Job>& jobs) {
  std::vector<Job*> wanted, early;
  for (Job& job : jobs) {
    const bool unwanted = unwantedOf(job).stop_requested();
    if (unwanted) drop(job);
    if (!unwanted && !refuseDeadly(job)) wanted.push_back(&job);
  }
  if (wanted.size() > 1 && executeTogether(wanted)) return;
  std::set<SessionId> waiting;  // for one of theirs that takes long
  for (Job* job : wanted) {
    if (waiting.contains(job->session)) {
      early.push_back(job);
    } else if (!execute(*job)) {
      waiting.insert(job->session);
      const std::lock_guard lock(queueMutex_);
      lanes_.setAside(std::move(*job));
      *job = {};
      workAdded_.notify_all();
    }
  }
  const std::lock_guard lock(queueMutex_);
  for (; !early.empty(); early.pop_back()) {
    lanes_.putBack(std::move(*early.back()));
    *early.back() = {};
  }
}

/// A server died at it before: true, and it is answered, unless it was accepted then.
bool SceneService::refuseDeadly(Job& job) const {
  if (notes_ == nullptr || !notes_->isDeadly(keyOf(job))) return false;
  if (auto* upload = std::get_if<Upload>(&job.task)) {
    answer(*upload,
           refused("data",
                   "is what the server was building when it died; this session does not try it again. Start the "
                   "client anew to try it once more"));
    return true;
  }
  auto* edit = std::get_if<Edit>(&job.task);
  if (edit == nullptr || sequencer_.isKnown(edit->submission)) return false;
  answer(*edit, Error{"client_seq", "is of the edit at which the server died, about " +
                                        whatItIsAbout(edit->submission.transaction) +
                                        "; it is not tried again. Give it another number to try it once more"});
  return true;
}

/// Edits. False: one of them takes long, and nothing was done.
bool SceneService::executeTogether(std::span<Job* const> jobs) {
  std::vector<Submission> submissions;
  std::vector<WorkNotes::UnderWay> notes;
  notes.reserve(jobs.size());
  for (const Job* job : jobs) notes.emplace_back(notes_.get(), keyOf(*job));
  for (Job* job : jobs) submissions.push_back(std::move(std::get<Edit>(job->task).submission));
  Preparation nothing(library_);
  auto outcomes = apply(submissions, nothing);
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    auto& edit = std::get<Edit>(jobs[i]->task);
    if (outcomes) {
      answer(edit, std::move((*outcomes)[i]));
    } else {
      edit.submission = std::move(submissions[i]);
    }
  }
  return outcomes.has_value();
}

/// False: it takes long, and is to be prepared.
bool SceneService::execute(Job& job) {
  const WorkNotes::UnderWay note(notes_.get(), keyOf(job));
  try {
    if (auto* edit = std::get_if<Edit>(&job.task)) return execute(*edit);
    if (auto* upload = std::get_if<Upload>(&job.task)) return execute(*upload);
    std::get<std::function<void()>>(job.task)();
  } catch (const std::exception& failure) {
    giveUp({&job, 1}, failure.what());
  }
  return true;
}

bool SceneService::execute(Edit& edit) {
  if (edit.failure) {
    answer(edit, *edit.failure);
    return true;
  }
  if (!edit.preparation) edit.preparation = std::make_unique<Preparation>(library_);
  const bool unchanged = edit.scene && edit.scene->history == sequencer_.history();
  const bool inVain = edit.timesPrepared >= kMaxPreparations;
  if (unchanged || inVain) edit.preparation->allowLongWork();
  std::stop_source enough;
  const auto stop = [&enough] { enough.request_stop(); };
  const std::stop_callback onUnwanted(edit.unwanted, stop);
  std::optional<WorkWatch> watch;
  if (inVain) watch.emplace(options_.mostOfEdit, stop);
  if (auto outcomes = apply({&edit.submission, 1}, *edit.preparation, enough.get_token())) {
    EditOutcome& outcome = outcomes->front();
    if (auto tooMuch = watch ? watch->tooMuch() : std::nullopt; tooMuch && std::holds_alternative<Error>(outcome))
      outcome = *std::move(tooMuch);
    answer(edit, outcome);
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
  answer(upload, *std::move(upload.built));
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

void SceneService::work(bool shortWork) {
  setpriority(PRIO_PROCESS, 0, kWorkersNice);  // this thread's
  std::unique_lock lock(queueMutex_);
  for (;;) {
    Job job = takeToPrepare(lock, shortWork);
    if (stopping_) return ended();
    lock.unlock();
    try {
      const Prepared prepared = prepare(job, shortWork ? std::optional(kShortWork) : std::nullopt);
      if (prepared == Prepared::kUnwanted) drop(job);
      lock.lock();
      if (prepared == Prepared::kDone) {
        lanes_.prepared(std::move(job));
      } else if (prepared == Prepared::kTakesLong) {
        lanes_.postpone(std::move(job));
        workAdded_.notify_all();
      } else {
        lanes_.finished(job);
      }
    } catch (const std::exception& failure) {
      if (lock) lock.unlock();
      giveUp({&job, 1}, failure.what());
      lock.lock();
      lanes_.finished(job);
    }
    queueChanged_.notify_one();
    lock.unlock();
    job = {};  // what it holds is freed without the lock
    lock.lock();
  }
}

/// Waits for one. Nothing while stopping_.
SceneService::Job SceneService::takeToPrepare(std::unique_lock<std::mutex>& lock, bool shortWork) {
  if (shortWork) {
    workAdded_.wait(lock, [this] { return stopping_ || (lanes_.anyAside() && idle_ == 0); });
    return stopping_ ? Job{} : *lanes_.takeAside();
  }
  ++idle_;
  workAdded_.wait(lock, [this] { return stopping_ || lanes_.anyAside() || lanes_.anyPostponed(); });
  --idle_;
  if (stopping_) return {};
  Job job = *lanes_.takeAsideOrPostponed();
  if (lanes_.anyAside()) workAdded_.notify_all();
  return job;
}

SceneService::Prepared SceneService::prepare(Job& job, std::optional<std::chrono::milliseconds> patience) {
  const WorkNotes::UnderWay note(notes_.get(), keyOf(job));
  const std::stop_token unwanted = unwantedOf(job);
  std::stop_source either;
  const auto stop = [&either] { either.request_stop(); };
  const std::stop_callback onStop(stop_.get_token(), stop);
  const std::stop_callback onUnwanted(unwanted, stop);
  const Interruptible interruptible(either.get_token());
  auto* edit = std::get_if<Edit>(&job.task);
  auto* upload = std::get_if<Upload>(&job.task);
  if (upload && patience && upload->bytes.size() > kShortUpload_bytes) return Prepared::kTakesLong;
  std::atomic<bool> takesLong = false;
  const auto othersWait = [&, patient = std::chrono::steady_clock::now() + patience.value_or(0ms)] {
    if (!patience || std::chrono::steady_clock::now() < patient) return false;
    const std::lock_guard lock(queueMutex_);
    return takesLong = lanes_.anyAside() && idle_ == 0;
  };
  std::optional<WorkWatch> watch;
  const auto refuseTooMuch = [&] {
    if (auto tooMuch = watch ? watch->tooMuch() : std::nullopt) edit->failure = std::move(tooMuch);
    return edit && edit->failure;
  };
  try {
    if (edit) watch.emplace(options_.mostOfEdit, stop, othersWait);
    interruptionPoint();
    if (edit) prepare(*edit);
    if (upload) {
      build(*upload);
      if (journal_ && *upload->built) journal_->prepare(**upload->built);
    }
  } catch (const Interrupted&) {
    if (unwanted.stop_requested() || stop_.stop_requested()) return Prepared::kUnwanted;
    if (refuseTooMuch()) return Prepared::kDone;
    return takesLong ? Prepared::kTakesLong : Prepared::kUnwanted;
  } catch (const std::exception& failure) {  // the machine has no other thread, or no memory
    const std::string reason = std::string("the server could not carry it out: ") + failure.what();
    if (edit) edit->failure = Error{"", reason};
    if (upload) upload->built = refused("data", reason);
  }
  static_cast<void>(refuseTooMuch());
  return unwanted.stop_requested() ? Prepared::kUnwanted : Prepared::kDone;
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
  if (upload && !stop_.stop_requested()) answer(*upload, refused("", "nobody waits for it any more"));
}

/// Once; a later answer says nothing.
void SceneService::answer(auto& task, auto outcome) const noexcept {
  try {
    if (const auto reply = std::exchange(task.reply, {})) reply(std::move(outcome));
  } catch (const std::exception& failure) {
    giveUp({}, failure.what());
  }
}

/// The jobs that have no answer yet are refused; not by a stop, after which they are sent again.
void SceneService::giveUp(std::span<Job> jobs, const char* why) const noexcept {
  if (stop_.stop_requested()) return;
  try {
    log(std::string("the scene's builder goes on without what it was at: ") + why);
    const Error error{"", std::string("the server could not carry it out: ") + why};
    for (Job& job : jobs) {
      if (auto* edit = std::get_if<Edit>(&job.task)) answer(*edit, error);
      if (auto* upload = std::get_if<Upload>(&job.task)) answer(*upload, tl::unexpected(error));
    }
  } catch (const std::exception&) {  // no memory for the words
  }
}

void SceneService::finish(std::span<const Job> jobs) {
  const std::lock_guard lock(queueMutex_);
  for (const Job& job : jobs) {
    if (job.number != 0) lanes_.finished(job);
  }
}

}  // namespace haptics
