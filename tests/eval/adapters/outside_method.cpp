#include "tests/eval/adapters/outside_method.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <map>

#include "common/text/printable.h"
#include "tests/eval/exchange/plain_mesh.h"

namespace haptics::eval {
namespace {

using adapter::Kind;
using namespace std::chrono_literals;
constexpr auto kHelloLimit = 20s;  // of an interpreter, on a busy machine
constexpr auto kLoadLimit = 60s;
constexpr auto kTickLimit = 5s;

template <class Type>
void append(std::string& message, const Type& value) {
  message.append(reinterpret_cast<const char*>(&value), sizeof value);
}

haptics_pose toC(const Pose& pose) {
  const Quat& q = pose.rotation;
  const Vec3& p = pose.position;
  return {{q.w, q.x, q.y, q.z}, {p.x, p.y, p.z}};
}

void appendPlace(std::string& message, Vec3 place) {
  for (const double coordinate : {place.x, place.y, place.z}) append(message, coordinate);
}

struct Declared {
  std::string command;
  std::string name;
  std::string version;
  std::uint32_t abilities = 0;

  [[nodiscard]] bool can(haptics_method_ability ability) const { return (abilities & ability) != 0; }
  void need(haptics_method_ability ability, const char* what) const {
    if (!can(ability)) throw NotApplicable(what);
  }
};

class OutsideMethod final : public OutsideRenderer {
 public:
  explicit OutsideMethod(const Declared& declared) : declared_(declared), process_(declared.command) {}

  void begin(std::span<const std::shared_ptr<const CollisionMesh>> bodies, std::span<const Pose> poses,
             Vec3 hip) override {
    load(bodies, poses, hip, surface_ ? surface_->spring_N_per_m : kSpring_N_per_m);
  }

  void setSurfaceProperties(const FeltSurface& surface) override {
    const SurfaceProperties& p = surface.properties;
    const bool rendersSurfaces = declared_.can(HAPTICS_FRICTION) || declared_.can(HAPTICS_SHADING);
    if (!rendersSurfaces) return;  // nothing but shapes
    if (p.texture || p.stiffnessOver || p.scalars != SurfaceScalars<double>{} || surface.tissue)
      throw NotApplicable("textures, maps, adhesion, taps and softness are not handed over");
    if (p.shading) declared_.need(HAPTICS_SHADING, "a surface is shaded");
    if (p.friction) declared_.need(HAPTICS_FRICTION, "a surface has friction");
    if (p.friction && (p.friction->variation != 0 || p.friction->dynamicVariation != 0))
      throw NotApplicable("friction that varies over the surface is not handed over");
    surface_ = surface;
  }

  void place(Vec3 hip) override {
    std::string message;
    appendPlace(message, hip);
    (void)ask(Kind::kPlace, message, kTickLimit, "when it is placed anew");
  }

  void edit(const EditedScene& scene, Vec3 hip) override {
    declared_.need(HAPTICS_EDITS, "the scene is edited under the hand");
    load(scene.bodies, scene.poses, hip, scene.spring_N_per_m);
  }

  Felt tick(std::span<const Pose> poses, Vec3 hip) override {
    if (!std::ranges::equal(poses, poses_)) {
      declared_.need(HAPTICS_MOVING_BODIES, "bodies move");
      poses_.assign(poses.begin(), poses.end());
    }
    ++tick_;
    message_.clear();
    appendPlace(message_, hip);
    for (const Pose& pose : poses) append(message_, toC(pose));
    const std::string_view said = ask(Kind::kTick, message_, kTickLimit, nullptr);
    adapter::Answer answer;
    if (said.size() != sizeof answer) wrong("answers " + std::to_string(said.size()) + " bytes where 88 are right");
    std::memcpy(&answer, said.data(), sizeof answer);
    return feltOf(answer);
  }

  [[nodiscard]] std::optional<double> ownTime_ns() const override { return duration_ns_; }
  [[nodiscard]] bool putOutside() const override { return putOutside_; }

 private:
  void load(std::span<const std::shared_ptr<const CollisionMesh>> bodies, std::span<const Pose> poses, Vec3 hip,
            double spring_N_per_m) {
    std::string heads, arrays;
    append(heads, adapter::LoadHead{static_cast<std::uint32_t>(bodies.size()), 0, {hip.x, hip.y, hip.z}});
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (!bodies[i]->closed()) declared_.need(HAPTICS_OPEN_MESHES, "a mesh is not closed");
      const PlainMesh mesh(*bodies[i]);
      adapter::BodyHead head{static_cast<std::uint32_t>(mesh.vertices.size()),
                             static_cast<std::uint32_t>(mesh.triangles.size()),
                             bodies[i]->closed() ? 1U : 0U,
                             0,
                             spring_N_per_m,
                             0,
                             0,
                             0,
                             toC(poses[i])};
      if (surface_ && surface_->properties.friction) {
        head.staticFriction = surface_->properties.friction->mu_static;
        head.dynamicFriction = surface_->properties.friction->mu_dynamic;
      }
      if (surface_ && surface_->properties.shading) head.crease_rad = surface_->properties.shading->crease_rad;
      append(heads, head);
      arrays.append(reinterpret_cast<const char*>(mesh.vertices.data()), mesh.vertices.size() * sizeof(Vec3f));
      arrays.append(reinterpret_cast<const char*>(mesh.triangles.data()),
                    mesh.triangles.size() * 3 * sizeof(std::uint32_t));
    }
    tick_ = 0;
    poses_.assign(poses.begin(), poses.end());
    (void)ask(Kind::kLoad, heads + arrays, kLoadLimit, "when a scene is loaded");
  }

  std::string_view ask(Kind kind, std::string_view message, std::chrono::milliseconds limit, const char* where) {
    return process_.ask(kind, message, limit, where != nullptr ? where : "in tick " + std::to_string(tick_));
  }

  [[noreturn]] void wrong(const std::string& what) const {
    throw MethodFault(what + " in tick " + std::to_string(tick_));
  }

  Felt feltOf(const adapter::Answer& answer) {
    const auto vec3 = [](const double(&v)[3]) { return Vec3(v[0], v[1], v[2]); };
    const Vec3 force_N = vec3(answer.force_N);
    const bool touching = (answer.flags & HAPTICS_TOUCHING) != 0;
    if (!isFinite(force_N)) wrong("answers a force that is not finite");
    if (!isFinite(vec3(answer.ihip_m))) wrong("answers an IHIP that is not finite");
    if (!isFinite(vec3(answer.torque_Nm))) wrong("answers a torque that is not finite");
    if (!touching && force_N != Vec3(0)) wrong("says that it does not touch, and gives a force");
    duration_ns_ = answer.duration_ns > 0 ? std::optional(answer.duration_ns) : std::nullopt;
    Felt felt{touching, vec3(answer.ihip_m), force_N, static_cast<int>(std::min(answer.triangles, 1U << 30))};
    felt.sliding = (answer.flags & HAPTICS_SLIDING) != 0;
    putOutside_ = (answer.flags & HAPTICS_PUT_OUTSIDE) != 0;
    return felt;
  }

  const Declared& declared_;
  AdapterProcess process_;
  std::optional<FeltSurface> surface_;
  std::vector<Pose> poses_;
  std::int64_t tick_ = 0;
  std::string message_;
  std::optional<double> duration_ns_;
  bool putOutside_ = false;
};

Declared declarationOf(const std::string& command) {
  AdapterProcess process(command);
  std::string question;
  append(question, adapter::Hello{HAPTICS_METHOD_ABI, 0});
  const std::string_view said = process.ask(Kind::kHello, question, kHelloLimit, "when it is asked what it is");
  adapter::Hello hello;
  if (said.size() < sizeof hello)
    throw MethodFault("does not say what it is: " + std::to_string(said.size()) + " bytes");
  std::memcpy(&hello, said.data(), sizeof hello);
  if (hello.abi != HAPTICS_METHOD_ABI)
    throw MethodFault("is of version " + std::to_string(hello.abi) + "; version " + std::to_string(HAPTICS_METHOD_ABI) +
                      " is right");
  const std::string text(said.substr(sizeof hello));
  const std::size_t end = text.find('\n');
  const std::string name = text.substr(0, end);
  if (!isMethodName(name))
    throw MethodFault("is called '" + printable(name) + "'; 1 to 40 letters, digits, '_', '-' and '.' are right");
  return {command, name, end == std::string::npos ? "" : printable(text.substr(end + 1)), hello.abilities};
}

bool isBuiltIn(std::string_view name) {
  for (const auto& among : {methods(), ablatedMethods(), singleConcernMethods()}) {
    if (std::ranges::find(among, name, &Method::name) != among.end()) return true;
  }
  return false;
}

struct Known {
  Declared declared;
  Method method;
};

}  // namespace

bool isOutside(std::string_view name) {
  return name.ends_with(".so") || name.find_first_of("/ ") != std::string_view::npos;
}

bool isMethodName(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  return !text.empty() && text.size() <= kLongest && std::ranges::all_of(text, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.';
  });
}

const Method& outsideMethod(const std::string& command) {
  static std::map<std::string, Known> known;
  if (const auto found = known.find(command); found != known.end()) return found->second.method;
  try {
    Declared declared = declarationOf(command);
    if (isBuiltIn(declared.name)) throw MethodFault("is called " + declared.name + ", as a built-in method is");
    Known& entry = known[command];
    entry.declared = std::move(declared);
    const Declared& of = entry.declared;
    const bool surfaces = of.can(HAPTICS_FRICTION) || of.can(HAPTICS_SHADING);
    entry.method = {.name = of.name,
                    .about = of.version,
                    .make = [&of] { return std::make_unique<OutsideMethod>(of); },
                    .edits = of.can(HAPTICS_EDITS),
                    .surfaces = surfaces,
                    .streams = of.can(HAPTICS_MOVING_BODIES),
                    .outside = true};
    return entry.method;
  } catch (const MethodFault& fault) {
    throw std::invalid_argument("--method " + command + ": " + fault.what());
  }
}

}  // namespace haptics::eval
