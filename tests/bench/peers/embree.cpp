#include <embree3/rtcore.h>

#include <cmath>
#include <limits>
#include <new>

#include "tests/bench/peers/peers.h"

namespace haptics::bench {
namespace {

struct Release {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
using Device = std::unique_ptr<RTCDeviceTy, Release>;
using Scene = std::unique_ptr<RTCSceneTy, Release>;

Scene sceneOf(RTCDevice device, const TriMesh& mesh, RTCSceneFlags flags) {
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<Vec3f*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                               sizeof(Vec3f), mesh.vertices.size()));
  std::uninitialized_copy(mesh.vertices.begin(), mesh.vertices.end(), vertices);
  auto* triangles = static_cast<TriangleIndices*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(TriangleIndices), mesh.triangles.size()));
  std::uninitialized_copy(mesh.triangles.begin(), mesh.triangles.end(), triangles);
  rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
  rtcCommitGeometry(geometry);
  Scene scene(rtcNewScene(device));
  rtcSetSceneFlags(scene.get(), flags);
  rtcSetSceneBuildQuality(scene.get(), RTC_BUILD_QUALITY_HIGH);
  rtcAttachGeometry(scene.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene.get());
  return scene;
}

/// Ericson, Real-Time Collision Detection, 5.1.5, in float, as Embree's own tutorial has it.
Vec3f closestOnTriangle(Vec3f p, Vec3f a, Vec3f b, Vec3f c) {
  const Vec3f ab = b - a, ac = c - a, ap = p - a;
  const float d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vec3f bp = p - b;
  const float d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const Vec3f cp = p - c;
  const float d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + ab * (d1 / (d1 - d3));
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + ac * (d2 / (d2 - d6));
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
  const float scale = 1 / (va + vb + vc);
  return a + ab * (vb * scale) + ac * (vc * scale);
}

struct Nearest {
  const TriMesh* mesh;
  Vec3f point{0};
  float distance_m = std::numeric_limits<float>::infinity();
};

bool lookAt(RTCPointQueryFunctionArguments* args) {
  auto& nearest = *static_cast<Nearest*>(args->userPtr);
  const auto [a, b, c] = nearest.mesh->triangles[args->primID];
  const auto& v = nearest.mesh->vertices;
  const Vec3f h(args->query->x, args->query->y, args->query->z);
  const Vec3f point = closestOnTriangle(h, v[a], v[b], v[c]);
  const float distance_m = glm::distance(h, point);
  if (!(distance_m < nearest.distance_m)) return false;
  nearest.point = point;
  nearest.distance_m = distance_m;
  if (distance_m >= args->query->radius) return false;
  args->query->radius = distance_m;
  return true;
}

RTCRay rayOf(const Way& way) {
  const Vec3f from(way.from);
  const Vec3f along = Vec3f(way.to) - from;
  RTCRay ray{};
  ray.org_x = from.x, ray.org_y = from.y, ray.org_z = from.z;
  ray.dir_x = along.x, ray.dir_y = along.y, ray.dir_z = along.z;
  ray.tfar = 1;
  ray.mask = ~0U;
  return ray;
}

template <class Answer>
double mean(std::span<const Way> ways, Answer answer) {
  double sum = 0;
  for (const Way& way : ways) sum += answer(rayOf(way));
  return sum / static_cast<double>(ways.size());
}

double occludedMean(RTCScene scene, std::span<const Way> ways) {
  return mean(ways, [scene](RTCRay ray) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, &ray);
    return ray.tfar < 0 ? 1.0 : 0.0;
  });
}

double firstMean(RTCScene scene, std::span<const Way> ways) {
  return mean(ways, [scene](const RTCRay& ray) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit hit{ray, {}};
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &context, &hit);
    return static_cast<double>(hit.ray.tfar);
  });
}

}  // namespace

struct Embree::Scenes {
  explicit Scenes(const TriMesh& m)
      : mesh(m),
        device(rtcNewDevice("threads=2")),
        fast(sceneOf(device.get(), mesh, RTC_SCENE_FLAG_NONE)),
        watertight(sceneOf(device.get(), mesh, RTC_SCENE_FLAG_ROBUST)) {}

  TriMesh mesh;
  Device device;
  Scene fast;
  Scene watertight;
};

Embree::Embree(const TriMesh& mesh) : scenes_(std::make_shared<const Scenes>(mesh)) {}
std::string Embree::version() { return RTC_VERSION_STRING; }

Contestants Embree::closest(std::span<const Vec3> places) const {
  const auto lap = [scenes = scenes_, places] {
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    double sum = 0;
    Vec3f before(std::numeric_limits<float>::max());
    for (const Vec3 place : places) {
      constexpr float kRounding = 1 + 0x1p-20F;
      const Vec3f h(place);
      RTCPointQuery query{h.x, h.y, h.z, 0, glm::distance(h, before) * kRounding};
      Nearest nearest{&scenes->mesh};
      rtcPointQuery(scenes->fast.get(), &query, &context, lookAt, &nearest);
      before = nearest.point;
      sum += nearest.distance_m;
    }
    return sum / static_cast<double>(places.size());
  };
  return {{"embree_point_query", lap}};
}

Contestants Embree::occluded(std::span<const Way> ways) const {
  return {{"embree_occluded", [s = scenes_, ways] { return occludedMean(s->fast.get(), ways); }},
          {"embree_watertight_occluded", [s = scenes_, ways] { return occludedMean(s->watertight.get(), ways); }}};
}

Contestants Embree::first(std::span<const Way> ways) const {
  return {{"embree_intersect", [s = scenes_, ways] { return firstMean(s->fast.get(), ways); }},
          {"embree_watertight_intersect", [s = scenes_, ways] { return firstMean(s->watertight.get(), ways); }}};
}

}  // namespace haptics::bench
