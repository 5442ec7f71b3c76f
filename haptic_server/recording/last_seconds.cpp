#include "haptic_server/recording/last_seconds.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <exception>
#include <span>
#include <system_error>
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
  std::vector<Keyframe> beginning;  // of each hand
  std::vector<RecordedTick> ticks;  // likewise, those of one tick together
};

/// Before anything else is done: a large scene takes longer to write than the ring keeps what is older than kSeconds.
/// Refused: there are no ticks yet, or the servo overtook the reading.
[[nodiscard]] Result<LastTicks> takeLastTicks(FlightRing& ring, double rate_Hz) {
  const std::uint64_t end = ring.end();
  const auto wanted = static_cast<std::uint64_t>(std::ceil(FlightRing::kSeconds * rate_Hz));
  LastTicks last;
  {
    const FlightRing::HeldKeyframes held(ring);
    const auto keyframes = held.atOrBefore(end > wanted ? end - wanted : 0);
    if (keyframes.empty()) return refused("", "the servo has not run yet");
    last.beginning.assign(keyframes.begin(), keyframes.end());
  }
  const std::uint64_t first = last.beginning[0].position;
  last.ticks.resize((end - first) * ring.hands());
  for (std::uint64_t position = first; position < end; ++position) {
    const auto tick = std::span(last.ticks).subspan((position - first) * ring.hands(), ring.hands());
    if (!ring.read(position, tick)) return refused("", "the servo overtook the recorder");
  }
  return last;
}

[[nodiscard]] Result<void> writeTo(const std::filesystem::path& file, const RecordingFacts& facts, FlightRing& ring,
                                   const AddScenes& addScenes) {
  const auto last = takeLastTicks(ring, facts.rate_Hz);
  if (!last) return tl::unexpected(last.error());
  auto writer = RecordingWriter::create(file, facts);
  if (!writer) return tl::unexpected(std::move(writer.error()));
  const auto oldest = std::ranges::min_element(last->beginning, {}, &Keyframe::scene);
  addScenes(*writer, std::max<std::uint64_t>(oldest->scene, 1));
  writer->add(last->beginning);
  for (std::size_t i = 0; i < last->ticks.size(); i += ring.hands())
    writer->add(std::span(last->ticks).subspan(i, ring.hands()));
  return writer->flush();
}

}  // namespace

Result<std::filesystem::path> recordLastSeconds(const RecordingPlace& place, std::string why, RecordingFacts facts,
                                                FlightRing& ring, const AddScenes& addScenes) {
  const auto& [folder, quota] = place;
  const auto file = folder / fileName(why);
  const auto withoutFile = [&file](Error error) {
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
    return tl::unexpected(std::move(error));
  };
  try {
    std::filesystem::create_directories(folder);
    if (auto room = makeRoomForRecording(folder, quota); !room) return tl::unexpected(room.error());
    facts.began_unix_ns = unixNow_ns() - static_cast<std::int64_t>(FlightRing::kSeconds * 1e9);
    facts.why = std::move(why);
    if (auto written = writeTo(file, facts, ring, addScenes); !written) return withoutFile(std::move(written.error()));
    rotateRecordings(folder, quota);
    return file;
  } catch (const std::filesystem::filesystem_error& error) {
    return refused(folder.string(), error.code().message());
  } catch (const std::exception& failure) {  // as without memory
    return withoutFile({file.string(), failure.what()});
  }
}

Result<std::filesystem::path> recordCrash(const RecordingPlace& place, FlightRing& ring, int journal) {
  const auto scenes = SceneJournalReader::open(journal);
  if (!scenes) return tl::unexpected(scenes.error());
  // All of them: each tells what differs from the one before.
  const auto addScenes = [&](RecordingWriter& writer, std::uint64_t) {
    scenes->forEach([&](std::string_view part) { writer.addPart(part); });
  };
  return recordLastSeconds(place, "crash", scenes->facts(), ring, addScenes);
}

}  // namespace haptics
