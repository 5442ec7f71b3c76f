#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "common/clock/monotonic.h"
#include "common/interruption/progress.h"
#include "haptic_server/scene/asset_library.h"
#include "haptic_server/scene/asset_store.h"
#include "haptic_server/scene/dent_baking.h"
#include "haptic_server/scene/preparation.h"
#include "haptic_server/scene/sequencer.h"
#include "haptic_server/scene/servo_scene_builder.h"
#include "haptic_server/scene/session_lanes.h"
#include "haptic_server/scene/work_notes.h"
#include "haptic_server/scene/work_watch.h"
#include "haptic_server/servo/scene_mailbox.h"

namespace haptics {

struct Price;

/// The server's own copy of the scene and the builder thread that changes it: edits and uploads in, servo scenes and
/// histories out. The long work of an edit, that is assets that are read, computed, checked, hashed and built, and parts
/// derived from large meshes, is prepared by workers first; the builder then decides the edit by the scene as it is by
/// then. Each session's edits and uploads take effect in their order; nobody waits for another session's.
class SceneService {
 public:
  struct Options {
    std::vector<std::filesystem::path> assetFolders;
    ServoSceneBuilder::MakePlan makePlan;  ///< Empty unless a simulated hand explores.
    /// Where the objects that move are, and which dents stay; null when nothing has changed since the last call; may be
    /// empty. Called on the builder thread after start().
    std::function<const MotionState*()> takeMotion = nullptr;
    DeviceLimits device = {};                     ///< For clamps and warnings of them.
    WorkLimits mostOfEdit = {};                   ///< What takes more is ended, and refused.
    std::string readOnlyReason = {};              ///< Why every edit is refused; empty: none is for that.
    std::function<void(const std::string&)> log;  ///< One line for each asset made; called on the builder thread.
    /// Each scene that the servo is about to get, and what it is made of; may be empty. On the thread that publishes it.
    ServoSceneBuilder::OnMade onServoScene = {};
    std::function<std::uint64_t()> now_ns = monotonicNow_ns;
  };
  using EditReply = std::function<void(const EditOutcome&)>;
  /// How far the preparation of an edit is, on a worker's thread, at most every kProgressEvery.
  using EditProgress = std::function<void(WorkStage stage, double share)>;
  static constexpr std::chrono::milliseconds kProgressEvery{200};
  using UploadReply = std::function<void(Result<std::shared_ptr<const Asset>>)>;
  using AssetReader = std::function<Result<std::string>(const ContentHash&)>;  ///< Canonical bytes, unverified.
  using HistoryListener = std::function<void(std::shared_ptr<const SceneHistory>)>;

  /// Memory of the edits that wait for the builder, as decoded; the bytes of uploads, which their clients have
  /// reserved, come on top.
  static constexpr std::size_t kMaxQueued_bytes = 64U << 20;
  /// Limit for one session's edits: the others find room.
  static constexpr std::size_t kMaxQueuedOfOne_bytes = kMaxQueued_bytes / 2;
  /// Edits that are decided together when so many wait: the journal then waits for the disk once. More of them delay
  /// the first one's reply.
  static constexpr std::size_t kMaxBatch = 64;
  /// Threads that prepare. Each may hold what building the largest mesh takes, some GB.
  static constexpr unsigned kMinWorkers = 2, kMaxWorkers = 4;
  /// One more prepares while all of them are busy. Once it has been at an edit for so long, and others wait, that edit is
  /// postponed until one of them is free: short work passes long work, whoever asked for how much of it. Larger: a longer
  /// wait behind what is tried; smaller: fewer edits pass.
  static constexpr std::chrono::milliseconds kShortWork{300};
  /// What builds in that time.
  static constexpr std::size_t kShortUpload_bytes = 1U << 20;

  SceneService(Options options, SceneMailbox& mailbox);
  ~SceneService();

  /// Applies the transaction at once and publishes it, the same way as any edit, also while the journal cannot keep it.
  /// Before start() only.
  /// @return The reports of the assets, or the bad field.
  [[nodiscard]] Result<std::vector<std::string>> loadStartScene(const Transaction& scene);
  /// Goes on from this state, whose assets are read by hash, and publishes it; every edit from now on is kept by the
  /// journal, which outlives the service, before it is published or answered. Objects whose assets cannot be had stay as
  /// what is left of them (lost_parts.h), and get them back when a client uploads them. Before loadStartScene() and
  /// start() only. The reader is called on the builder thread too.
  /// @return What is lost of which object, or here again; one line each.
  [[nodiscard]] std::vector<std::string> resume(SequencerState state, AssetReader readAsset, EditJournal& journal);
  /// What is worked at is noted there, and edits and uploads at which a server died before are refused. May be null.
  /// Before start() only.
  void noteWorkIn(std::unique_ptr<WorkNotes> notes) noexcept { notes_ = std::move(notes); }
  /// What is worked at from now on is not what the server dies at. Any thread.
  void endsInOrder() noexcept {
    if (notes_) notes_->endsInOrder();
  }
  /// Any thread. The journal keeps all of the present state anew, on the builder thread, after this was called there.
  /// False as below.
  [[nodiscard]] bool checkpoint(std::function<void()> before);
  /// Any thread. "box: mesh, motion": objects that are without a part since the start, in words.
  [[nodiscard]] std::vector<std::string> lostParts() const;
  /// The scene is this version from now on, which was made elsewhere of these assets, in assetStore(); the servo keeps
  /// what it has. Any thread. False: there is no room for more work now.
  [[nodiscard]] bool show(SceneVersion version, Sequencer::Assets assets);
  [[nodiscard]] AssetStore& assetStore() noexcept { return store_; }
  void start();
  /// Before start(), or in its place for virtual time: the builder's work and the workers' that waits, on this thread.
  void executeAll();
  void stop();  ///< Interrupts what is in hand and drops the rest; their replies never come. Also done on destruction.
  /// The same, but without waiting any longer. False: a thread is at something that is not interrupted, which stop()
  /// waits for; all else may be asked of the service meanwhile.
  [[nodiscard]] bool stopWithin(std::chrono::milliseconds patience);

  /// Any thread. The reply comes on the builder thread, after the new history was published. False, and no reply:
  /// there is no room for more work now.
  /// \param unwanted  Asks for a stop when nobody waits for the edit any more: it is dropped, or interrupted unless it has
  ///                  been accepted, and the reply never comes or never matters.
  /// \param progress  May be empty; not called any more once the reply has come.
  [[nodiscard]] bool submitEdit(SessionId session, std::uint64_t clientSeq, Transaction transaction,
                                const EditReply& reply, std::stop_token unwanted = {}, EditProgress progress = {});
  /// What the edit would take at most, or why it cannot be. On the builder thread, or in its place.
  [[nodiscard]] Result<Price> priceOf(const Transaction& transaction);
  struct Place {
    std::uint64_t clientSeq;
    std::size_t place;  ///< 1: the next; places of edits that were postponed count from 1 too.
  };
  /// Any thread. The session's edit that waits to be prepared, if one does; its later ones wait behind it.
  [[nodiscard]] std::optional<Place> waiting(SessionId session) const;
  /// Any thread. Checks the bytes against the hash and builds the asset, in order with the session's edits; who asked
  /// holds it until an edit names it. False as above. The reply always comes while the service runs.
  [[nodiscard]] bool submitAsset(SessionId session, const AssetName& name, std::string bytes, const UploadReply& reply,
                                 std::stop_token unwanted = {});
  /// Any thread. Null when it is neither in the scene nor held by someone.
  [[nodiscard]] std::shared_ptr<const Asset> findAsset(const ContentHash& hash) const { return store_.find(hash); }
  /// Any thread. deformedHash() of a version of the scene whose assets are here.
  [[nodiscard]] std::optional<ContentHash> deformedHash(const SceneVersion& scene,
                                                        std::span<const ObjectDent> dents) const;
  [[nodiscard]] std::shared_ptr<const SceneHistory> history() const;  ///< Any thread. The newest.
  /// Any thread. What is driven apart from the scene; the newest.
  using DrivenShapes = Sequencer::DrivenShapes;
  [[nodiscard]] std::shared_ptr<const DrivenShapes> drivenShapes() const;
  /// Called on the builder thread after each revision, and once here with the present one. An empty function ends it:
  /// when this returns, the old listener is not running and will not run again. A listener sets no other.
  void setListener(HistoryListener listener);

 private:
  struct Edit {
    Submission submission;
    EditReply reply;
    std::stop_token unwanted;
    EditProgress progress;
    std::unique_ptr<Preparation> preparation = nullptr;
    std::optional<Sequencer::Scene> scene = std::nullopt;  // from which it is or was prepared last
    int timesPrepared = 0;
    std::optional<Error> failure = std::nullopt;  // of the preparation
  };
  struct Upload {
    AssetName name;
    std::string bytes;
    UploadReply reply;
    std::stop_token unwanted;
    std::optional<Result<std::shared_ptr<const Asset>>> built = std::nullopt;
  };
  using Lanes = SessionLanes<std::variant<Edit, Upload, std::function<void()>>>;
  using Job = Lanes::Job;

  Options options_;
  SceneMailbox& mailbox_;
  AssetStore store_;
  AssetLibrary library_;
  Sequencer sequencer_;                                           // builder thread, or loadStartScene before it runs
  ServoSceneBuilder servoScenes_;                                 // likewise
  AssetReader readAsset_;                                         // likewise
  std::vector<std::shared_ptr<const ObjectRecord>> lostAtStart_;  // of the state that was resumed; does not change

  std::map<ObjectId, std::vector<PermanentDent>> permanentDents_;  // not baked yet; builder thread
  std::uint64_t permanentDentsAt_ = 0;                             // scene revision that the servo had then; likewise
  DentWatermarks handled_;                                         // likewise
  std::uint64_t bakeAfter_ns_ = 0;                                 // likewise
  bool isBehind_ = false;                                          // the servo has an older scene; likewise
  bool isUnheard_ = false;                                         // so has the listener; likewise
  std::uint64_t catchUpAfter_ns_ = 0;                              // likewise

  EditJournal* journal_ = nullptr;  // does not change once it runs, nor does the next
  std::unique_ptr<WorkNotes> notes_;

  mutable std::mutex queueMutex_;  // guards the six below
  std::condition_variable queueChanged_, workAdded_;
  Lanes lanes_{kMaxQueued_bytes, kMaxQueuedOfOne_bytes};
  bool stopping_ = false;
  std::stop_source planning_;  // of the plan that is made while there is nothing else to do
  std::size_t running_ = 0;    // builder and workers
  std::size_t idle_ = 0;       // workers, but for the one of short work
  std::stop_source stop_;      // of whatever they do
  std::thread builder_;
  std::vector<std::thread> workers_;

  mutable std::mutex historyMutex_;  // guards the one below
  std::shared_ptr<const SceneHistory> published_;
  std::shared_ptr<const DrivenShapes> drivenShapes_ = std::make_shared<const DrivenShapes>();
  std::mutex listenerMutex_;  // held while the listener runs, and then historyMutex_; guards the one below
  HistoryListener listener_;

  bool enqueue(SessionId session, std::size_t size_bytes, Lanes::Task task);
  void askToStop();
  void run();
  void runRound();
  void replan();
  enum class Prepared : std::uint8_t { kDone, kUnwanted, kTakesLong };
  void work(bool shortWork);
  [[nodiscard]] Job takeToPrepare(std::unique_lock<std::mutex>& lock, bool shortWork);
  void ended();
  void takeJobs(std::vector<Job>& jobs);
  void execute(std::vector<Job>& jobs);
  [[nodiscard]] bool executeTogether(std::span<Job* const> jobs);
  [[nodiscard]] bool execute(Job& job);
  [[nodiscard]] bool execute(Edit& edit);
  [[nodiscard]] bool execute(Upload& upload);
  [[nodiscard]] Prepared prepare(Job& job, std::optional<std::chrono::milliseconds> patience = std::nullopt);
  void prepare(Edit& edit);
  void build(Upload& upload);
  void drop(Job& job);
  void answer(auto& task, auto outcome) const noexcept;
  void giveUp(std::span<Job> jobs, const char* why) const noexcept;
  [[nodiscard]] bool refuseDeadly(Job& job) const;
  void finish(std::span<const Job> jobs);
  void followServo();
  EditOutcomes apply(std::span<const Submission> submissions, AssetResolver& resolver,
                     const std::stop_token& unwanted = {});
  EditOutcomes decide(std::span<const Submission> submissions, AssetResolver& resolver,
                      const std::stop_token& unwanted);
  void publish(const std::shared_ptr<const SceneHistory>& before);
  [[nodiscard]] Result<std::shared_ptr<const Asset>> findOrRead(const AssetName& name);
  void restoreLostParts(const ContentHash& asset);
  void publishHistory();
  void publishDrivenShapes();
  void publishToServo(ServoSceneBuilder::Plan plan);
  void log(const std::string& line) const;
  void bakeDents();
  [[nodiscard]] bool bakeDents(ObjectId object, std::span<const PermanentDent> dents);
};

}  // namespace haptics
