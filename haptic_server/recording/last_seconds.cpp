#include "haptic_server/recording/last_seconds.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <utility>
#include <vector>

#include "common/clock/unix_time.h"
#include "haptic_server/recording/scene_journal.h"

namespace haptics {
namespace {

/// "flight-20261120T143005.123Z-device_lost.haptics"
[[nodiscard]] std::string fileName(const std::string& why) {
  const std::int64_t now_ns = unixNow_ns();
  const auto seconds = static_cast<std::time_t>(now_ns / 1'000'000'000);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char stamp[32];
  std::strftime(stamp, sizeof stamp, "%Y%m%dT%H%M%S", &utc);
  const std::string thousandths = std::to_string(1000 + now_ns / 1'000'000 % 1000).substr(1);
  std::string name = std::string("flight-") + stamp + '.' + thousandths + "Z-" + why + ".haptics";
  std::ranges::replace(name, ' ', '_');
  return name;
}

struct LastTicks {
  std::unique_ptr<Keyframe> beginning;
  std::vector<RecordedTick> ticks;
};

/// Before anything else is done: a large scene takes longer to write than the ring keeps what is older than kSeconds.
/// Refused: there are no ticks yet, or the servo overtook the reading.
[[nodiscard]] Result<LastTicks> takeLastTicks(FlightRing& ring, double rate_Hz) {
  const std::uint64_t end = ring.end();
  const auto wanted = static_cast<std::uint64_t>(std::ceil(FlightRing::kSeconds * rate_Hz));
  LastTicks last;
  {
    const FlightRing::HeldKeyframes held(ring);
    const Keyframe* keyframe = held.atOrBefore(end > wanted ? end - wanted : 0);
    if (keyframe == nullptr) return refused("", "the servo has not run yet");
    last.beginning = std::make_unique<Keyframe>(*keyframe);
  }
  last.ticks.resize(end - last.beginning->position);
  for (std::size_t i = 0; i < last.ticks.size(); ++i) {
    if (!ring.read(last.beginning->position + i, last.ticks[i])) return refused("", "the servo overtook the recorder");
  }
  return last;
}

[[nodiscard]] Result<void> writeTo(const std::filesystem::path& file, const RecordingFacts& facts, FlightRing& ring,
                                   const AddScenes& addScenes) {
  const auto last = takeLastTicks(ring, facts.rate_Hz);
  if (!last) return tl::unexpected(last.error());
  auto writer = RecordingWriter::create(file, facts);
  if (!writer) return tl::unexpected(std::move(writer.error()));
  addScenes(*writer, std::max<std::uint64_t>(last->beginning->scene, 1));
  writer->add(*last->beginning);
  for (const RecordedTick& tick : last->ticks) writer->add(tick);
  return writer->flush();
}

}  // namespace

Result<std::filesystem::path> recordLastSeconds(const RecordingPlace& place, std::string why, RecordingFacts facts,
                                                FlightRing& ring, const AddScenes& addScenes) {
  const auto& [folder, quota] = place;
  try {
    std::filesystem::create_directories(folder);
    if (auto room = makeRoomForRecording(folder, quota); !room) return tl::unexpected(room.error());
    const auto file = folder / fileName(why);
    facts.began_unix_ns = unixNow_ns() - static_cast<std::int64_t>(FlightRing::kSeconds * 1e9);
    facts.why = std::move(why);
    if (auto written = writeTo(file, facts, ring, addScenes); !written) {
      std::filesystem::remove(file);
      return tl::unexpected(std::move(written.error()));
    }
    rotateRecordings(folder, quota);
    return file;
  } catch (const std::filesystem::filesystem_error& error) {
    return refused(folder.string(), error.code().message());
  }
}

Result<std::filesystem::path> recordCrash(const std::filesystem::path& folder, FlightRing& ring, int journal) {
  const auto scenes = SceneJournalReader::open(journal);
  if (!scenes) return tl::unexpected(scenes.error());
  // All of them: each tells what differs from the one before.
  const auto addScenes = [&](RecordingWriter& writer, std::uint64_t) {
    scenes->forEach([&](std::string_view part) { writer.addPart(part); });
  };
  return recordLastSeconds({folder}, "crash", scenes->facts(), ring, addScenes);
}

}  // namespace haptics
