#include "tests/sim/sim_server.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <stop_token>
#include <utility>
#include <variant>

#include "common/mesh/generators.h"
#include "haptic_server/net/admission.h"
#include "haptic_server/net/server_session.h"
#include "haptic_server/scene/asset_library.h"
#include "haptic_server/scene/dent_baking.h"
#include "haptic_server/scene/preparation.h"
#include "haptic_server/scene/scene_service.h"
#include "haptic_server/scene/session_lanes.h"

namespace haptics::sim {
namespace {

constexpr std::uint64_t kTimer_ns = 10 * kMillisecond_ns;  // the network thread's
constexpr double kPost_ms = 2;                             // from thread to thread, at most
constexpr std::uint64_t kTick_ns = kMillisecond_ns;
constexpr double kHandPause_ms = 400;  // between the dents that a hand leaves, at most

Transaction startScene() {
  Transaction scene;
  for (const std::string& name : SimServer::counters()) {
    scene.operations.push_back(AddObject{name, {BoxSource{Vec3(0.1), 1}}, {}, {}});
  }
  return scene;
}

/// Objects beside the counters, as detailed as the limits allow.
Transaction moreObjects(const Limits& limits, Random& random) {
  Transaction scene;
  const std::size_t details_bytes = limits.scene.details_bytes / (limits.startObjects + 1);
  for (std::size_t i = 0; i < limits.startObjects; ++i) {
    AddObject add{SimServer::startObject(i), {BoxSource{Vec3(0.1), 1}}, {}, {}};
    const auto side = static_cast<std::uint32_t>(2 + random.below(7));
    const std::size_t points = std::size_t{side} * side * side;
    constexpr std::size_t kPoint_bytes = 12, kRest_bytes = 600;
    if (random.chance(0.5) && kPoint_bytes * points < details_bytes &&
        kPoint_bytes * points + kRest_bytes < limits.scene.answer_bytes) {
      Lattice lattice{.low_m = Vec3(-0.2), .size_m = Vec3(0.4), .points = {side, side, side}, .control_m = {}};
      lattice.control_m.resize(points);
      for (Vec3f& point : lattice.control_m) point = Vec3f(static_cast<float>(random.uniform(-0.1, 0.1)));
      add.deformation.lattice = std::move(lattice);
    }
    scene.operations.push_back(std::move(add));
  }
  return scene;
}

SceneLimits limitsOf(const Stage& stage) {
  SceneLimits limits = stage.limits.scene;
  if (stage.mutant == Mutant::kAnswersOfAnySize) limits.answer_bytes = std::numeric_limits<std::size_t>::max();
  return limits;
}

}  // namespace

/// All that a crash takes away.
struct SimServer::Process : std::enable_shared_from_this<Process> {
  Process(Stage& stage, const ServerPace& pace, AssetStore& store, const std::optional<ServerCredentials>& credentials);

  struct Edit {
    std::uint64_t connection = 0;
    Submission submission;  // as a mutant has it
    SessionId session = kServerSession;
    std::uint64_t clientSeq = 0;
    std::stop_token unwanted = {};
    std::unique_ptr<Preparation> preparation = nullptr;
    std::optional<Sequencer::Scene> scene = std::nullopt;  // from which it was prepared last
  };
  using Lanes = SessionLanes<std::variant<Edit, std::function<void()>>>;
  using Job = Lanes::Job;
  static constexpr int kWorkers = 2;

  Stage& stage;
  const ServerPace& pace;
  AssetStore& store;
  Admission admission;
  const std::uint64_t started_ns = stage.time.now_ns();
  const ServerIdentity identity{"simulated server", "simulated", 1000, 3.3};

  // The network thread.
  std::shared_ptr<const SceneHistory> published;
  std::map<std::uint64_t, std::unique_ptr<Connection>> connections;
  std::uint64_t nextConnection = 1;
  std::uint64_t lastPost_ns = 0;
  std::uint64_t feltRevision = 0, feltSince = 0;  // as this thread knows
  std::size_t uploadBytes = 0;

  // The builder and the servo.
  AssetLibrary library{{}, store};
  std::unique_ptr<StateFolder> folder;
  Sequencer sequencer{1, library, limitsOf(stage)};
  Lanes lanes{std::numeric_limits<std::size_t>::max(), std::numeric_limits<std::size_t>::max()};  // in jobs
  bool building = false;
  int preparing = 0;
  SessionId lastLane = 0;  // where sessions are reordered
  bool adopting = false;
  std::map<SessionId, std::uint64_t> freshSeq;  // without dedupe
  struct Decision {
    std::uint64_t connection, clientSeq;
    EditOutcome outcome;
  };
  std::optional<Decision> held;  // to be swapped with the next
  std::function<void()> died;    // of a write, where it is to

  [[nodiscard]] std::uint64_t tick() const { return (stage.time.now_ns() - started_ns) / kTick_ns; }
  void after(std::uint64_t delay_ns, std::function<void()> task) {
    stage.time.after(delay_ns, weak_from_this(), [this, task = std::move(task)] {
      try {
        task();
      } catch (const test::PowerFailure&) {
        stage.time.after(0, weak_from_this(), died);
      }
    });
  }
  void begin(Disk& disk, bool keepsState);
  void makeStartScene();
  void onTimer();
  bool enqueue(SessionId session, Lanes::Task task);
  bool submit(std::uint64_t connection, Submission submission, std::stop_token unwanted);
  void buildNext();
  void execute();
  [[nodiscard]] std::vector<Job> takeJobs();
  [[nodiscard]] bool execute(Job& job);
  void prepareNext();
  void prepare(const std::shared_ptr<Job>& job, std::uint64_t left_ns);
  void prepared(Job job);
  void post(std::function<void()> task);
  void postTo(std::uint64_t connection, std::function<void(ServerSession&)> task);
  bool decide(std::span<Edit* const> batch, AssetResolver& resolver);
  EditOutcomes apply(std::span<Edit* const> batch, AssetResolver& resolver);
  void answer(std::uint64_t connection, std::uint64_t clientSeq, const EditOutcome& outcome);
  void adoptLater();
  void dentLater();
  void dent();
  void adopted(std::uint64_t revision, std::uint64_t tick);
};

/// The network thread's end of one connection; as Server's own.
struct SimServer::Connection final : SessionHost {
  Connection(Process& process_, std::uint64_t number_, std::unique_ptr<Transport> transport_)
      : process(process_),
        number(number_),
        transport(std::move(transport_)),
        session(*transport, *this, process.identity, process.stage.limits.session) {}

  [[nodiscard]] std::uint64_t now_ns() const override { return process.stage.time.now_ns() + kSecond_ns; }
  [[nodiscard]] std::shared_ptr<const SceneHistory> history() const override { return process.published; }
  [[nodiscard]] std::shared_ptr<const Asset> findAsset(const ContentHash& hash) const override {
    return process.store.find(hash);
  }
  [[nodiscard]] Result<Role> admit(SessionId id, const std::string& itsToken) override {
    token = hashOfToken(itsToken);
    std::vector<Admission::Client> others;
    for (const auto& [n, other] : process.connections) {
      if (other->session.welcomed()) others.push_back(other->client());
    }
    auto role = process.admission.admit(id, itsToken, others);
    if (role) process.stage.oracle.admitted(id, process.admission.editSession({id, *role, token}));
    return role;
  }
  ~Connection() override { left.request_stop(); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  [[nodiscard]] bool submitEdit(SessionId, std::uint64_t clientSeq, Transaction transaction, bool) override {
    return process.submit(number, {process.admission.editSession(client()), clientSeq, std::move(transaction)},
                          left.get_token());
  }
  [[nodiscard]] bool submitAsset(const AssetName& name, std::string bytes) override {
    const auto job = [&p = process, n = number, name, bytes = std::move(bytes)] {
      const auto asset = p.store.internEncoded(name, bytes);
      p.postTo(n, [name, asset](ServerSession& s) { s.assetDecided(name.hash, asset); });
    };
    return process.enqueue(process.admission.editSession(client()), std::function<void()>(job));
  }
  [[nodiscard]] bool reserveUpload(std::size_t bytes) override {
    if (bytes > process.stage.limits.uploadBudget_bytes - process.uploadBytes) return false;
    process.uploadBytes += bytes;
    return true;
  }
  void releaseUpload(std::size_t bytes) override { process.uploadBytes -= bytes; }
  void sessionClaimed(SessionId id) override {
    for (auto& [n, other] : process.connections) {
      if (other.get() != this && other->session.welcomed() && other->session.id() == id) {
        other->session.close("its session goes on in a newer connection");
      }
    }
  }
  void fillStatus(v1::Status& status) override { status.set_ticks(process.tick()); }
  void refused(const std::string& why) override {
    process.stage.log.add([&] { return "server: refuses client " + std::to_string(session.id() % 1000) + ": " + why; });
  }
  void ended(const std::string&) override {
    process.post([&p = process, n = number] { p.connections.erase(n); });
  }

  [[nodiscard]] Admission::Client client() const { return {session.id(), session.role(), token}; }

  Process& process;
  std::uint64_t number;
  std::unique_ptr<Transport> transport;
  ContentHash token{};  // its hash
  std::stop_source left;
  ServerSession session;
};

SimServer::Process::Process(Stage& stage_, const ServerPace& pace_, AssetStore& store_,
                            const std::optional<ServerCredentials>& credentials)
    : stage(stage_), pace(pace_), store(store_), admission(credentials) {}

void SimServer::Process::begin(Disk& disk, bool keepsState) {
  auto found = disk.open(store);
  auto kept = keepsState ? Oracle::Kept::kState : Oracle::Kept::kNothing;
  if (!found) {
    stage.oracle.fail("the server does not start: " + found.error().text());
    kept = Oracle::Kept::kNothing;
    found = Disk(disk.epoch(), stage.random, stage.mutant).open(store);
  }
  if (keepsState && found->powerWasLost) kept = Oracle::Kept::kStateAfterPowerLoss;
  folder = std::move(found->folder);
  auto& [state, assets, warnings, changed] = found->restored;
  const RecentEdits& edits = state.history->edits;
  for (std::size_t i = 0; i < edits.size(); ++i) freshSeq[edits[i]->session] = edits[i]->clientSeq;
  sequencer.resume(std::move(state), std::move(assets), *folder);
  stage.oracle.serverStarted(*sequencer.history(), kept);
  if (kept == Oracle::Kept::kNothing) makeStartScene();
  published = sequencer.history();
  adoptLater();
  dentLater();
  onTimer();
}

void SimServer::Process::makeStartScene() {
  Edit counters{.submission = {kServerSession, 1, startScene()}};
  (void)apply(std::vector{&counters}, library);
  if (stage.limits.startObjects == 0) return;
  Edit others{.submission = {kServerSession, 2, moreObjects(stage.limits, stage.random)}};
  const auto made = apply(std::vector{&others}, library);
  if (const auto* error = std::get_if<Error>(&made->front())) stage.oracle.fail("no start scene: " + error->text());
}

/// A hand leaves dents in what is plastic, which the builder bakes by edits of the server's own.
void SimServer::Process::dentLater() {
  after(stage.random.milliseconds(0, kHandPause_ms), [this] {
    if (pace.handDents) dent();
    dentLater();
  });
}

void SimServer::Process::dent() {
  const SceneVersion& version = sequencer.history()->version;
  for (const auto& object : version.objects()) {
    const auto& softness = object->deformation.softness;
    if (!softness || softness->plastic == 0 || stage.random.chance(0.7)) continue;
    const std::vector<Vec3f> shape = sequencer.assetsOf(object->id).shapeAtRest(object->deformation);
    const Vec3f centre = shape[stage.random.below(shape.size())];
    const Dent left{centre, Vec3f(static_cast<float>(stage.random.uniform(-1e-3, 1e-3)))};
    const PermanentDent staying{1, left};
    const BakeResult taken = bake(object->deformation, sequencer.assetsOf(object->id), {&staying, 1});
    if (taken.residue.vertex.empty()) continue;
    const auto asset = store.intern(taken.residue);
    SetDeformation set{ObjectRef{object->id}, {}};
    set.deformation.residue = AssetSource{asset->name.hash};
    Edit own{.submission = {kServerSession, version.revision() + 1, {{}, {std::move(set)}}}};
    decide(std::vector{&own}, library);
    return;
  }
}

void SimServer::Process::onTimer() {
  TelemetrySample sample;
  sample.tick = tick();
  sample.time_ns = stage.time.now_ns() + kSecond_ns;
  sample.sceneRevision = feltRevision;
  sample.adoptionTick = feltSince;
  for (auto& [n, connection] : connections) {
    connection->session.offerTelemetry(sample);
    connection->session.poll();
    stage.oracle.serverHolds(connection->transport->backlog());
  }
  after(kTimer_ns, [this] { onTimer(); });
}

bool SimServer::Process::enqueue(SessionId session, Lanes::Task task) {
  if (lanes.bytes() >= pace.builderQueue) return false;
  const SessionId lane = stage.mutant == Mutant::kSessionReordered ? ++lastLane : session;
  (void)lanes.add(lane, 1, std::move(task));
  buildNext();
  return true;
}

bool SimServer::Process::submit(std::uint64_t connection, Submission submission, std::stop_token unwanted) {
  Edit edit{connection, std::move(submission), 0, 0, std::move(unwanted)};
  edit.session = edit.submission.session;
  edit.clientSeq = edit.submission.clientSeq;
  Transaction& transaction = edit.submission.transaction;
  if (stage.mutant == Mutant::kNoCompareAndSet) transaction.preconditions.clear();
  if (stage.mutant == Mutant::kHalfTransactions && transaction.operations.size() == 2) {
    transaction.operations.pop_back();
  }
  return enqueue(edit.session, std::move(edit));
}

void SimServer::Process::buildNext() {
  if (building || lanes.next() == nullptr) return;
  building = true;
  after(stage.random.milliseconds(0, pace.build_ms), [this] {
    execute();
    building = false;
    buildNext();
  });
}

/// An upload, an edit that was prepared, or the edits that wait before the next of these; as SceneService.
std::vector<SimServer::Process::Job> SimServer::Process::takeJobs() {
  const auto isAlone = [](const Job& job) {
    const auto* edit = std::get_if<Edit>(&job.task);
    return edit == nullptr || edit->preparation;
  };
  std::vector<Job> jobs;
  const std::size_t most = 1 + stage.random.below(SceneService::kMaxBatch);
  while (lanes.next() != nullptr && jobs.size() < most) {
    if (!jobs.empty() && (isAlone(jobs.back()) || isAlone(*lanes.next()))) break;
    jobs.push_back(lanes.take());
  }
  return jobs;
}

void SimServer::Process::execute() {
  std::vector<Job> jobs = takeJobs();
  std::vector<Edit*> wanted;
  for (Job& job : jobs) {
    auto* edit = std::get_if<Edit>(&job.task);
    if (edit != nullptr && !edit->unwanted.stop_requested()) wanted.push_back(edit);
  }
  if (wanted.size() > 1) {
    Preparation nothing(library, stage.limits.maxTriangles);
    if (decide(wanted, nothing)) {
      for (const Job& job : jobs) lanes.finished(job);
      return;
    }
  }
  std::set<SessionId> waiting;
  std::vector<Job> early;
  for (Job& job : jobs) {
    if (waiting.contains(job.session)) {
      early.push_back(std::move(job));
    } else if (execute(job)) {
      lanes.finished(job);
    } else {
      waiting.insert(job.session);
      lanes.setAside(std::move(job));
    }
  }
  for (; !early.empty(); early.pop_back()) lanes.putBack(std::move(early.back()));
  prepareNext();
}

/// False: it is to be prepared.
bool SimServer::Process::execute(Job& job) {
  auto* edit = std::get_if<Edit>(&job.task);
  if (edit == nullptr) {
    std::get<std::function<void()>>(job.task)();
    return true;
  }
  if (edit->unwanted.stop_requested()) return true;
  if (!edit->preparation) edit->preparation = std::make_unique<Preparation>(library, stage.limits.maxTriangles);
  if (edit->scene && edit->scene->history == sequencer.history()) edit->preparation->allowLongWork();
  if (decide(std::vector{edit}, *edit->preparation)) return true;
  edit->scene = sequencer.scene();
  // Until here they held.
  if (stage.mutant == Mutant::kPreconditionsJudgedEarly) edit->submission.transaction.preconditions.clear();
  return false;
}

void SimServer::Process::prepareNext() {
  while (preparing < kWorkers && lanes.anyAside()) {
    ++preparing;
    prepare(std::make_shared<Job>(*lanes.takeAside()), stage.random.milliseconds(0, pace.prepare_ms));
  }
}

/// It looks now and then whether it is still wanted.
void SimServer::Process::prepare(const std::shared_ptr<Job>& job, std::uint64_t left_ns) {
  constexpr std::uint64_t kLookEvery_ns = 100 * kMillisecond_ns;
  const std::uint64_t step_ns = std::min(left_ns, kLookEvery_ns);
  after(step_ns, [this, job, left_ns, step_ns] {
    const bool unwanted = std::get<Edit>(job->task).unwanted.stop_requested();
    if (left_ns > step_ns && !unwanted) return prepare(job, left_ns - step_ns);
    --preparing;
    prepared(std::move(*job));
    prepareNext();
    buildNext();
  });
}

void SimServer::Process::prepared(Job job) {
  Edit& edit = std::get<Edit>(job.task);
  if (edit.unwanted.stop_requested()) {
    stage.log.add([] { return "server: gives up an edit that nobody waits for"; });
    if (stage.mutant != Mutant::kSuccessorLost) lanes.finished(job);
    return;
  }
  edit.preparation->prepare(*edit.scene, edit.submission.transaction);
  lanes.prepared(std::move(job));
}

void SimServer::Process::post(std::function<void()> task) {
  lastPost_ns = std::max(lastPost_ns, stage.time.now_ns() + stage.random.milliseconds(0, kPost_ms));
  after(lastPost_ns - stage.time.now_ns(), std::move(task));
}

void SimServer::Process::postTo(std::uint64_t connection, std::function<void(ServerSession&)> task) {
  post([this, connection, task = std::move(task)] {
    if (const auto at = connections.find(connection); at != connections.end()) task(at->second->session);
  });
}

/// False: the resolver needs preparation.
bool SimServer::Process::decide(std::span<Edit* const> batch, AssetResolver& resolver) {
  const auto before = sequencer.history();
  const auto outcomes = apply(batch, resolver);
  if (!outcomes) return false;
  if (sequencer.history() != before) {
    post([this, history = sequencer.history()] {
      published = history;
      for (auto& [n, other] : connections) other->session.sceneChanged();
    });
  }
  for (std::size_t i = 0; i < batch.size(); ++i) answer(batch[i]->connection, batch[i]->clientSeq, (*outcomes)[i]);
  return true;
}

EditOutcomes SimServer::Process::apply(std::span<Edit* const> batch, AssetResolver& resolver) {
  const std::uint64_t before = sequencer.history()->version.revision();
  std::vector<Submission> submissions;
  for (Edit* edit : batch) {
    if (stage.mutant == Mutant::kNoDedupe) edit->submission.clientSeq = ++freshSeq[edit->submission.session];
    submissions.push_back(std::move(edit->submission));
  }
  auto outcomes = sequencer.submit(submissions, resolver);
  for (std::size_t i = 0; i < batch.size(); ++i) batch[i]->submission = std::move(submissions[i]);
  if (!outcomes) return outcomes;
  std::uint64_t revision = before;
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const Edit& edit = *batch[i];
    const auto* accepted = std::get_if<std::shared_ptr<const AcceptedEdit>>(&(*outcomes)[i]);
    if (accepted == nullptr) {
      const auto* error = std::get_if<Error>(&(*outcomes)[i]);
      const bool superseded = error != nullptr && error->reason.starts_with("was refused before");
      stage.oracle.turnedDown(edit.session, edit.clientSeq, superseded);
    } else if ((*accepted)->commit.revision == revision + 1) {
      ++revision;
      stage.oracle.committed(edit.session, edit.clientSeq, **accepted);
    }
  }
  if (revision != before) adoptLater();
  return outcomes;
}

void SimServer::Process::answer(std::uint64_t connection, std::uint64_t clientSeq, const EditOutcome& outcome) {
  const auto reply = [&](std::uint64_t seq, const EditOutcome& what) {
    postTo(connection, [seq, what](ServerSession& s) { s.editDecided(seq, what); });
  };
  if (stage.mutant == Mutant::kSwappedReplies && !held && stage.random.chance(0.05)) {
    held = Decision{connection, clientSeq, outcome};
    return;
  }
  if (!held || held->connection != connection) return reply(clientSeq, outcome);
  reply(clientSeq, held->outcome);
  reply(held->clientSeq, outcome);
  held.reset();
}

/// The servo goes over to the newest scene, some time after it was published.
void SimServer::Process::adoptLater() {
  if (stage.mutant == Mutant::kLiveBeforeAdoption) {
    post([this, revision = sequencer.history()->version.revision()] { adopted(revision, tick()); });
  }
  if (adopting) return;
  adopting = true;
  after(stage.random.milliseconds(0, pace.adopt_ms), [this] {
    adopting = false;
    const std::uint64_t revision = sequencer.history()->version.revision();
    stage.oracle.adopted(revision, tick());
    post([this, revision, since = tick()] { adopted(revision, since); });
  });
}

void SimServer::Process::adopted(std::uint64_t revision, std::uint64_t since) {
  feltRevision = revision;
  feltSince = since;
  for (auto& [n, connection] : connections) connection->session.adopted(revision, since);
}

SimServer::SimServer(Stage& stage, const ServerPace& pace) : stage_(stage), pace_(pace) {}
SimServer::~SimServer() = default;

void SimServer::start(bool keepState) {
  if (!keepState) {
    const bool sameEpoch = disk_ && stage_.mutant == Mutant::kEpochKeptWithoutState;
    disk_ = std::make_unique<Disk>(sameEpoch ? disk_->epoch() : stage_.random.bits(), stage_.random, stage_.mutant);
  }
  process_ = std::make_shared<Process>(stage_, pace_, store_, credentials_);
  process_->begin(*disk_, keepState);
  stage_.log.add([&] { return std::string("server: starts ") + (keepState ? "with its state" : "anew"); });
}

void SimServer::crash() {
  stage_.log.add([] { return "server: crashes"; });
  process_.reset();
  disk_->processDied();
}

void SimServer::dieInNextWrite(const std::function<void()>& died) {
  if (!up()) return;
  process_->died = died;
  disk_->dieInNextWrite();
}

void SimServer::knowTokens(const std::vector<std::string>& tokens) {
  credentials_.emplace();
  for (const std::string& token : tokens) credentials_->tokens.push_back({Role::kEdit, hashOfToken(token)});
  if (!up()) return;
  process_->admission = Admission(credentials_);
  if (stage_.mutant == Mutant::kTokenOnlyAtHello) return;
  for (auto& [n, connection] : process_->connections) {
    if (!connection->session.welcomed()) continue;
    const auto allowed = process_->admission.check(connection->client());
    if (!allowed) connection->session.refuse(allowed.error().field, allowed.error().reason);
  }
}

void SimServer::accept(std::unique_ptr<Transport> transport) {
  const std::uint64_t number = process_->nextConnection++;
  auto& connection =
      *process_->connections.emplace(number, std::make_unique<Connection>(*process_, number, std::move(transport)))
           .first->second;
  connection.session.start();
  if (stage_.mutant != Mutant::kAdoptionUntold && process_->feltRevision != 0) {
    connection.session.adopted(process_->feltRevision, process_->feltSince);
  }
}

std::shared_ptr<const SceneHistory> SimServer::history() const { return process_->sequencer.history(); }

std::string SimServer::startObject(std::size_t i) { return "s" + std::to_string(i); }

const std::vector<std::string>& SimServer::counters() {
  static const std::vector<std::string> names{"c0", "c1", "c2", "c3"};
  return names;
}

}  // namespace haptics::sim
