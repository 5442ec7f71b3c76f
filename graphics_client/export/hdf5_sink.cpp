#include "graphics_client/export/hdf5_sink.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <list>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "graphics_client/editing/scene_text.h"
#include "graphics_client/export/hdf5_file.h"
#include "graphics_client/export/tick_columns.h"

namespace haptics {
namespace {

constexpr std::size_t kTicksOfChunk = 4'096;
constexpr std::size_t kRowsOfChunk = 1'024;

/// "2026-11-25T01:02:03Z".
[[nodiscard]] std::string utcTime(std::int64_t unix_ns) {
  const std::time_t seconds = unix_ns / 1'000'000'000;
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  std::array<char, 32> text;
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc)};
}

/// "force.written" is the data set "force/written".
[[nodiscard]] std::string pathOf(std::string name) {
  std::ranges::replace(name, '.', '/');
  return name;
}

void describe(hid_t set, const char* units, const char* frame, const char* description) {
  setAttribute(set, "units", std::string(units));
  if (*frame != '\0') setAttribute(set, "frame", std::string(frame));
  setAttribute(set, "description", std::string(description));
}

/// Data sets of a group that grow together.
class RowSets {
 public:
  RowSets(hid_t file, const std::string& name, std::size_t rowsOfChunk)
      : group_(makeGroup(file, name)), rowsOfChunk_(rowsOfChunk) {}

  [[nodiscard]] hid_t group() const noexcept { return group_; }
  Hdf5Rows<std::uint64_t>& number(const std::string& name, const char* description, const char* units = "1") {
    Hdf5Rows<std::uint64_t>& set = numbers_.emplace_back(group_, name, 1, rowsOfChunk_);
    describe(set.set(), units, "", description);
    return set;
  }
  Hdf5Rows<double>& reals(const std::string& name, std::size_t width, const char* units, const char* frame,
                          const char* description) {
    Hdf5Rows<double>& set = reals_.emplace_back(group_, name, width, rowsOfChunk_);
    describe(set.set(), units, frame, description);
    return set;
  }
  void flush() {
    for (auto& set : reals_) set.flush();
    for (auto& set : numbers_) set.flush();
  }

 private:
  Hdf5Group group_;
  std::size_t rowsOfChunk_;
  std::list<Hdf5Rows<double>> reals_;
  std::list<Hdf5Rows<std::uint64_t>> numbers_;
};

/// The columns of tickColumns(), of one hand.
class TickSets {
 public:
  TickSets(hid_t file, const std::string& name) : sets_(file, name, kTicksOfChunk) {
    for (const char* inner : {"force", "tool", "primitive", "device"})
      static_cast<void>(makeGroup(sets_.group(), inner));
    for (const TickColumn& column : tickColumns()) {
      const std::string path = pathOf(column.name);
      if (column.number != nullptr) {
        numbers_.push_back(&sets_.number(path, column.description, column.unit));
      } else {
        reals_.push_back(&sets_.reals(path, column.width, column.unit, column.frame, column.description));
      }
    }
  }

  void add(const TickValues& values) {
    auto real = reals_.begin();
    auto number = numbers_.begin();
    for (const TickColumn& column : tickColumns()) {
      if (column.number != nullptr) {
        *(*number++)->next() = column.number(values);
      } else {
        column.reals(values, (*real++)->next());
      }
    }
  }
  void flush() { sets_.flush(); }

 private:
  RowSets sets_;
  std::vector<Hdf5Rows<double>*> reals_;  // in the order of their columns, as the next
  std::vector<Hdf5Rows<std::uint64_t>*> numbers_;
};

template <class Vector>
void put(Hdf5Rows<double>& rows, const Vector& v) {
  double* at = rows.next();
  for (int i = 0; i < 3; ++i) at[i] = v[i];
}

class Hdf5Sink final : public SessionSink {
 public:
  Hdf5Sink(const std::filesystem::path& file, const SessionFacts& facts)
      : name_(file.string()),
        file_(create(file), name_),
        ticks_(file_, "ticks"),
        bodies_(file_, "bodies", kRowsOfChunk),
        dents_(file_, "dents", kRowsOfChunk),
        edits_(file_, "edits", kRowsOfChunk),
        faults_(file_, "faults", kRowsOfChunk),
        gaps_(file_, "gaps", kRowsOfChunk),
        scenes_(makeGroup(file_, "scenes")),
        meshes_(makeGroup(file_, "meshes")) {
    if (!facts.secondDevice.empty()) second_.emplace(file_, "second_hand");
    setAttribute(file_, "format", std::string("haptics session 1: SI units, right-handed world frame"));
    setAttribute(file_, "source", facts.source);
    setAttribute(file_, "server", facts.server);
    setAttribute(file_, "device", facts.device);
    if (second_) setAttribute(file_, "second_device", facts.secondDevice);
    setAttribute(file_, "rate_Hz", facts.rate_Hz);
    setAttribute(file_, "max_force_N", facts.maxForce_N);
    setAttribute(file_, "began", utcTime(facts.began_unix_ns));
    setAttribute(file_, "began_unix_ns", static_cast<std::uint64_t>(std::max<std::int64_t>(0, facts.began_unix_ns)));
  }

  [[nodiscard]] Result<void> scene(std::uint64_t tick, const MirrorView& view) override {
    return tried([&] {
      *editTick_.next() = tick;
      *editRevision_.next() = view.scene->revision();
      char number[24];
      std::snprintf(number, sizeof number, "%08llu", static_cast<unsigned long long>(view.scene->revision()));
      if (!revisions_.insert(view.scene->revision()).second) return;
      const Hdf5Group group = makeGroup(scenes_, number);
      setAttribute(group, "root", view.scene->root().hex());
      setAttribute(group, "first_tick", tick);
      setAttribute(group, "text", sceneText(*view.scene, ""));
      for (const auto& object : view.scene->objects()) add(group, *object, view);
    });
  }

  [[nodiscard]] Result<void> add(const SessionTick& tick) override {
    return tried([&] {
      ticks_.add({tick.sample, tick.tool});
      if (second_) second_->add({tick.second == nullptr ? TelemetrySample{} : *tick.second, ToolState{}});
      for (const BodyState& body : tick.moved) add(tick.sample.tick, body);
      if (tick.dents != nullptr) addDents(tick.sample.tick, *tick.dents);
      if (tick.sample.fault != fault_ && tick.sample.fault != Fault::kNone) {
        *faultTick_.next() = tick.sample.tick;
        *faultCode_.next() = static_cast<std::uint64_t>(tick.sample.fault);
      }
      fault_ = tick.sample.fault;
    });
  }

  [[nodiscard]] Result<void> gap(const TickGap& gap) override {
    return tried([&] {
      *gapAfter_.next() = gap.after;
      *gapMissed_.next() = gap.missed;
      *gapLost_.next() = gap.lost;
    });
  }

  [[nodiscard]] Result<void> finish(const SessionEnd& end) override {
    return tried([&] {
      ticks_.flush();
      if (second_) second_->flush();
      for (RowSets* sets : {&bodies_, &dents_, &edits_, &faults_, &gaps_}) sets->flush();
      setAttribute(file_, "ticks", end.ticks);
      setAttribute(file_, "ticks_missed_by_servo", end.missed);
      setAttribute(file_, "ticks_lost", end.lost);
      setAttribute(file_, "note", end.note);
      if (H5Fflush(file_, H5F_SCOPE_GLOBAL) < 0) throw Hdf5Failure(name_);
    });
  }

 private:
  using Hdf5File = Hdf5Handle<H5Fclose>;
  std::string name_;
  Hdf5File file_;
  TickSets ticks_;
  std::optional<TickSets> second_;
  RowSets bodies_, dents_, edits_, faults_, gaps_;
  Hdf5Group scenes_, meshes_;
  std::set<std::uint64_t> revisions_;
  std::set<std::string> written_;  // meshes
  Fault fault_ = Fault::kNone;

  static constexpr const char* kTick = "of the servo";
  Hdf5Rows<std::uint64_t>& bodyTick_ = bodies_.number("tick", kTick);
  Hdf5Rows<std::uint64_t>& bodyObject_ = bodies_.number("object", "id");
  Hdf5Rows<double>& bodyPosition_ = bodies_.reals("position", 3, "m", "world", "of the object's origin");
  Hdf5Rows<double>& bodyRotation_ = bodies_.reals("rotation", 4, "1", "world", "unit quaternion w, x, y, z");
  Hdf5Rows<std::uint64_t>& bodyCondition_ =
      bodies_.number("condition", "0 awake, 1 asleep, 2 out of bounds, 3 not finite");
  Hdf5Rows<std::uint64_t>& dentTick_ = dents_.number("tick", kTick);
  Hdf5Rows<std::uint64_t>& dentObject_ = dents_.number("object", "id; 0: no dent is left");
  Hdf5Rows<double>& dentCentre_ = dents_.reals("centre", 3, "m", "object", "where it is deepest, at rest");
  Hdf5Rows<double>& dentDisplacement_ = dents_.reals("displacement", 3, "m", "object", "of its centre");
  Hdf5Rows<std::uint64_t>& editTick_ = edits_.number("tick", "the first one that was felt with the revision");
  Hdf5Rows<std::uint64_t>& editRevision_ = edits_.number("revision", "of the scene");
  Hdf5Rows<std::uint64_t>& faultTick_ = faults_.number("tick", "the first one with it");
  Hdf5Rows<std::uint64_t>& faultCode_ = faults_.number("fault", "as Fault of telemetry.proto");
  Hdf5Rows<std::uint64_t>& gapAfter_ = gaps_.number("after_tick", "the tick before the gap");
  Hdf5Rows<std::uint64_t>& gapMissed_ = gaps_.number("missed", "ticks that the servo slept through");
  Hdf5Rows<std::uint64_t>& gapLost_ = gaps_.number("lost", "ticks that were computed, and lost on the way");

  static hid_t create(const std::filesystem::path& file) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // whoever asks reports failures
    return H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  }

  template <class Work>
  [[nodiscard]] Result<void> tried(const Work& work) {
    try {
      work();
      return {};
    } catch (const Hdf5Failure& failure) {
      return refused(name_, std::string("cannot be written (") + failure.what() + "); is the disk full?");
    }
  }

  void add(std::uint64_t tick, const BodyState& body) {
    *bodyTick_.next() = tick;
    *bodyObject_.next() = body.object;
    put(bodyPosition_, body.pose.position);
    const Quat& q = body.pose.rotation;
    std::ranges::copy(std::array{q.w, q.x, q.y, q.z}, bodyRotation_.next());
    *bodyCondition_.next() = static_cast<std::uint64_t>(body.condition);
  }

  void addDents(std::uint64_t tick, const MotionState& motion) {
    static constexpr ObjectDent kNone{};
    const std::span<const ObjectDent> dents = motion.dentCount == 0 ? std::span(&kNone, 1) : motion.dents();
    for (const ObjectDent& dent : dents) {
      *dentTick_.next() = tick;
      *dentObject_.next() = dent.object;
      put(dentCentre_, dent.dent.centre);
      put(dentDisplacement_, dent.dent.displacement);
    }
  }

  void add(hid_t scene, const ObjectRecord& object, const MirrorView& view) {
    const Hdf5Group group = makeGroup(scene, std::to_string(object.id));
    const std::string mesh = object.mesh.hex();
    setAttribute(group, "name", object.name);
    setAttribute(group, "mesh", "/meshes/" + mesh);
    forEachMaterialScalar(
        [&group](std::string_view name, double value) { setAttribute(group, std::string(name).c_str(), value); },
        object.material);
    const Vec3 at = object.pose.position;
    const Quat& q = object.pose.rotation;
    describe(writeRows<double>(group, "position", std::array{at.x, at.y, at.z}, 1), "m", "world",
             "as the scene has it");
    describe(writeRows<double>(group, "rotation", std::array{q.w, q.x, q.y, q.z}, 1), "1", "world",
             "unit quaternion w, x, y, z");
    const auto found = view.meshes.find(object.mesh);
    if (found == view.meshes.end() || !written_.insert(mesh).second) return;
    const TriMesh& surface = *found->second;
    const Hdf5Group of = makeGroup(meshes_, mesh);
    const std::span vertices(reinterpret_cast<const float*>(surface.vertices.data()), 3 * surface.vertices.size());
    const std::span triangles(reinterpret_cast<const std::uint32_t*>(surface.triangles.data()),
                              3 * surface.triangles.size());
    describe(writeRows<float>(of, "vertices", vertices, 3), "m", "object", "x, y, z");
    describe(writeRows<std::uint32_t>(of, "triangles", triangles, 3), "1", "",
             "their corners, counterclockwise seen from outside");
  }
};

}  // namespace

Result<std::unique_ptr<SessionSink>> makeHdf5Sink(const std::filesystem::path& file, const SessionFacts& facts) {
  try {
    return std::make_unique<Hdf5Sink>(file, facts);
  } catch (const Hdf5Failure& failure) {
    return refused(file.string(), std::string("cannot be written (") + failure.what() + "); does its folder exist?");
  }
}

}  // namespace haptics
