// A recording, as somebody sends it who wants it looked into: refused, or replayed, and shown by the viewer. A piece is a part; it is given what
// would break at every mutation: the framing that a recorder gives it, this program's layout of the state, the roots of
// its scenes.

#include <sys/mman.h>
#include <unistd.h>

#include <map>
#include <string>
#include <string_view>

#include "common/wire/convert.h"
#include "graphics_client/session/recorded_session.h"
#include "haptic_server/recording/replay.h"
#include "haptic_server/recording/state_image.h"
#include "haptic_server/state/record_chain.h"
#include "tests/fuzz/pieces.h"

namespace haptics {
namespace {

/// Follows the scenes of a recording as far as that makes sense.
class Roots {
 public:
  void complete(v1::RecordedScene& scene) {
    for (const std::uint64_t id : scene.gone()) objects_.erase(id);
    for (const v1::RecordedObject& object : scene.put()) objects_[object.state().id()] = object.state();
    std::vector<ObjectRecord> records;
    for (const auto& [id, state] : objects_) {
      const auto record = fromWire(state);
      const bool pendingRemoval = std::ranges::find(scene.leaving(), id) != scene.leaving().end();
      if (record && !pendingRemoval) records.push_back(*record);
    }
    const auto version = SceneVersion::fromSnapshot(scene.revision(), std::move(records));
    if (version) scene.set_root(version->root().asBytes());
  }

 private:
  std::map<std::uint64_t, v1::ObjectState> objects_;
};

/// Opens it, and shows every moment of it.
void show(std::string_view recording) {
  const int file = memfd_create("recording", 0);
  fuzz::require(write(file, recording.data(), recording.size()) == static_cast<ssize_t>(recording.size()), "written");
  const auto session = RecordedSession::read("/proc/self/fd/" + std::to_string(file), {});
  close(file);
  if (!session) return;
  for (std::size_t i = 0; i < session->moments().list().size(); ++i) static_cast<void>(session->view(i, 1));
  static_cast<void>(session->status(session->duration_s()));
}

}  // namespace
}  // namespace haptics

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptics;
  const std::string_view sent{reinterpret_cast<const char*>(data), size};
  static_cast<void>(replay(sent));
  show(sent);

  std::string recording(kRecordingHead);
  RecordWriter chain(kRecordingHead);
  Roots roots;
  fuzz::forEachPiece({data, size}, [&](std::span<const std::uint8_t> piece) {
    v1::RecordingPart part;
    if (!part.ParseFromArray(piece.data(), static_cast<int>(piece.size()))) return;
    if (part.has_head()) part.mutable_head()->set_state_layout(stateLayout());
    if (part.has_scene()) roots.complete(*part.mutable_scene());
    chain.append(recording, part.SerializeAsString());
  });
  const auto outcome = replay(recording);
  fuzz::require(!outcome || !outcome->cutOff, "a recording that is whole is not cut off");
  show(recording);
  return 0;
}
