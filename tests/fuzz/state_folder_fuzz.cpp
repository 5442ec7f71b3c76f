// A state folder, as it may be found: the server starts, says why when it gives something up, takes the next edit, and
// starts again where it was. The first byte of a piece says what it is: a file, or a record; to a record is given what
// would break at every mutation, its place in the chain and the roots.

#include <exception>
#include <string>
#include <string_view>

#include "common/wire/convert.h"
#include "haptics/v1/state.pb.h"
#include "tests/fuzz/pieces.h"
#include "tests/haptic_server/state/kept_scene.h"
#include "tests/haptic_server/state/simulated_files.h"

namespace haptics {
namespace {

constexpr const char* kFolder = "/state";

/// A log, or the copy of its checkpoint.
class Records {
 public:
  void add(std::string_view bytes) {
    v1::LogRecord record;
    if (!record.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return;
    if (record.has_checkpoint()) complete(*record.mutable_checkpoint());
    if (record.has_edit()) complete(*record.mutable_edit()->mutable_commit());
    writer_.append(log_, record.SerializeAsString());
  }
  [[nodiscard]] const std::string& log() const noexcept { return log_; }

 private:
  std::string log_{kLogHead};
  RecordWriter writer_;
  SceneVersion version_;

  void complete(v1::Checkpoint& checkpoint) {
    std::vector<ObjectRecord> objects;
    for (const auto& state : checkpoint.object()) {
      if (auto object = fromWire(state)) objects.push_back(*std::move(object));
    }
    auto version = SceneVersion::fromSnapshot(checkpoint.revision(), std::move(objects));
    if (!version) return;
    version_ = *std::move(version);
    checkpoint.set_root(version_.root().asBytes());
  }
  void complete(v1::Commit& message) {
    message.set_revision(version_.revision() + 1);
    message.set_prev_root(version_.root().asBytes());
    message.set_root(version_.root().asBytes());
    const auto commit = fromWire(message);
    if (!commit) return;
    auto next = version_.apply(*commit);
    if (!next) return;
    version_ = *std::move(next);
    message.set_root(version_.root().asBytes());
  }
};

void run(std::span<const std::uint8_t> input) {
  const auto files = std::make_shared<test::SimulatedFiles>(1);
  static_cast<void>(files->makeFolder(kFolder));
  static_cast<void>(files->makeFolder(std::string(kFolder) + "/assets"));
  Records log, copy;
  enum Kind { kLog, kCopy, kLogRecord, kCopyRecord, kAsset, kUnfinished, kKinds };
  const auto path = [](const std::string& name) { return kFolder + ("/" + name); };
  fuzz::forEachPiece(input, [&](std::span<const std::uint8_t> piece) {
    if (piece.empty()) return;
    const std::string bytes(piece.begin() + 1, piece.end());
    switch (piece.front() % kKinds) {
      case kLog:
        return files->put(path("log"), bytes);
      case kCopy:
        return files->put(path("checkpoint"), bytes);
      case kLogRecord:
        log.add(bytes);
        return files->put(path("log"), log.log());
      case kCopyRecord:
        copy.add(bytes);
        return files->put(path("checkpoint"), copy.log());
      case kAsset:
        return files->put(path("assets/" + Hasher().add(std::as_bytes(std::span(bytes))).finish().hex()), bytes);
      default:
        return files->put(path("log.new"), bytes);
    }
  });

  const auto start = [&](std::uint64_t freshEpoch) { return test::KeptScene(kFolder, freshEpoch, 4000, 0, files); };
  ContentHash root;
  std::uint64_t epoch = 0;
  {
    auto scene = start(11);
    static_cast<void>(scene.sequencer.submit(7, 1, test::edit(test::add("new"))));
    static_cast<void>(scene.sequencer.submit(7, 2, test::edit(test::moveTo("new", {1, 0, 0}))));
    root = scene.version().root();
    epoch = scene.sequencer.history()->epoch;
  }
  const auto again = start(12);
  fuzz::require(again.version().root() == root, "the next process starts where this one was");
  fuzz::require(again.sequencer.history()->epoch == epoch, "nothing is lost by starting again");
}

}  // namespace
}  // namespace haptics

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  haptics::run({data, size});
  return 0;
}
