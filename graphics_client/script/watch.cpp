#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <string>

#include "common/json/message_json.h"
#include "common/telemetry/fault_words.h"
#include "common/telemetry/tick_gaps.h"
#include "common/text/printable.h"
#include "common/wire/convert.h"
#include "common/wire/driven_shapes.h"
#include "graphics_client/mirror/tick_queue.h"
#include "graphics_client/script/verbs.h"

namespace haptics {
namespace {

constexpr double kMilli = 1000;  // of a metre, of a joule

const char* nameOf(PrimitiveKind kind) {
  switch (kind) {
    case PrimitiveKind::kPolygon:
      return "polygon";
    case PrimitiveKind::kLine:
      return "line";
    case PrimitiveKind::kVertex:
      return "vertex";
    case PrimitiveKind::kNone:
      break;
  }
  return "nothing";
}

const char* nameOf(BodyCondition condition) {
  if (condition == BodyCondition::kOutOfBounds) return " STOPPED at the world's end";
  return condition == BodyCondition::kNonFinite ? " STOPPED: its motion was not finite" : "";
}

void printTouch(const MirrorView& view, const TelemetrySample& sample) {
  const Vec3 hip_mm = sample.hip * kMilli;
  std::printf("hip %7.1f %7.1f %7.1f mm  force %5.2f N", hip_mm.x, hip_mm.y, hip_mm.z,
              glm::length(sample.force.written));
  if (const auto object = view.scene->find(sample.object); object) {
    std::printf("  %5.2f mm into %s, %s %u", sample.penetration_m * kMilli, object->name.c_str(),
                nameOf(sample.primitive.kind), sample.primitive.polygon);
  }
}

void printFault(const TelemetrySample& sample) {
  if (sample.fault == Fault::kNone) return;
  std::printf("  FAULT: %s%s", faultInWords(sample.fault, sample.device.fault), waitInWords(sample.wait_s).c_str());
}

void printForPeople(const MirrorView& view, const TelemetrySample& sample) {
  std::printf("tick %8llu  %6.0f Hz  missed %llu  revision %llu  ", static_cast<unsigned long long>(sample.tick),
              sample.servoRate_Hz, static_cast<unsigned long long>(sample.missedTicks),
              static_cast<unsigned long long>(sample.sceneRevision));
  printTouch(view, sample);
  for (const auto& [id, body] : view.bodies) {
    const auto object = view.scene->find(id);
    if (body.condition == BodyCondition::kAsleep || !object) continue;
    const Vec3 at_mm = body.pose.position * kMilli;
    std::printf("  %s at %.1f %.1f %.1f mm%s", object->name.c_str(), at_mm.x, at_mm.y, at_mm.z, nameOf(body.condition));
  }
  if (const auto object = view.scene->find(sample.largestEnergySource.object); object) {
    std::printf("  %s's %s gave %.3g mJ", object->name.c_str(), nameOf(sample.largestEnergySource.feature),
                sample.largestEnergySource.given_J * kMilli);
  }
  printFault(sample);
  if (view.secondHand) {
    const TelemetrySample& second = *view.secondHand;
    std::printf("\n  second hand  ");
    printTouch(view, second);
    printFault(second);
  }
  std::printf("\n");
  std::fflush(stdout);
}

void printForScripts(const MirrorView& view, const TelemetrySample& sample) {
  v1::Telemetry message;
  toWire(sample, message);
  if (view.secondHand) toWireOfSecondHand(*view.secondHand, message);
  for (const auto& [object, body] : view.bodies) toWire(body, *message.add_body());
  for (const ObjectDent& dent : view.dents) toWire(dent, *message.add_dent());
  for (const auto& [object, lattice] : view.shapes) {
    v1::DrivenShape& shape = *message.add_shape();
    shape.set_object(object);
    if (lattice) toWire(*lattice, *shape.mutable_lattice());
  }
  if (view.tool) toWire(*view.tool, *message.mutable_tool());
  std::cout << toJson(message).line() << std::endl;
}

using Clock = std::chrono::steady_clock;

Clock::time_point endOf(const WatchOptions& options) {
  if (!options.duration_s) return Clock::time_point::max();
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(*options.duration_s));
}

int watchEveryTick(const CommonOptions& common, const WatchOptions& options) {
  TickQueue queue;
  Connection connection(common, {.onTicks = [&queue](const v1::TelemetryBatch& batch) { queue.put(batch); }});
  if (const auto view = connection.open(); !view) return fail(kNoConnection, view.error());
  const auto end = endOf(options);
  TickGaps gaps;
  std::uint64_t ticks = 0;
  while (Clock::now() < end) {
    const auto taken = queue.take(std::min<Clock::duration>(end - Clock::now(), connection.timeout()));
    if (taken.empty() && Clock::now() < end) return fail(kNoConnection, connection.noAnswer().value());
    const auto view = connection.link().latest();
    for (const auto& [tick, tellsAll] : taken) {
      if (const auto gap = gaps.next(tick.tick(), tick.missed_ticks()))
        std::fprintf(stderr, "hapticctl: gap %s\n", gap->inWords().c_str());
      ++ticks;
      common.json ? void(std::cout << toJson(tick).line() << '\n') : printForPeople(*view, fromWire(tick));
    }
    std::cout.flush();
  }
  std::fprintf(stderr, "hapticctl: %llu ticks; %llu missed by the servo, %llu lost on the way\n",
               static_cast<unsigned long long>(ticks), static_cast<unsigned long long>(gaps.missed()),
               static_cast<unsigned long long>(gaps.lost()));
  return kDone;
}

}  // namespace

int watch(const CommonOptions& common, const WatchOptions& options) {
  if (options.everyTick) return watchEveryTick(common, options);
  Connection connection(common, {.telemetryRate_Hz = options.rate_Hz, .meshes = false, .datagrams = options.datagrams});
  auto view = connection.open();
  if (!view) return fail(kNoConnection, view.error());

  const auto end = endOf(options);
  const auto longest = std::max(connection.timeout(), std::chrono::nanoseconds(std::llround(2e9 / options.rate_Hz)));
  auto heard = Clock::now();
  std::uint64_t seen = 0;
  std::string said;
  while (Clock::now() < end) {
    const auto next = connection.link().waitUntil([seen](const MirrorView& v) { return v.samplesReceived > seen; },
                                                  std::min<Clock::duration>(end - Clock::now(), connection.timeout()));
    if (!next) {
      if (Clock::now() >= end) break;
      const bool isLive = connection.link().latest()->link == LinkState::kLive;
      if (isLive && Clock::now() - heard < longest) continue;  // samples may come seldom
      return fail(kNoConnection, connection.noAnswer().value());
    }
    heard = Clock::now();
    seen = next->samplesReceived;
    if (options.datagrams && next->linkText != said)
      std::fprintf(stderr, "hapticctl: %s\n", printable(next->linkText).c_str());
    said = next->linkText;
    common.json ? printForScripts(*next, *next->sample) : printForPeople(*next, *next->sample);
  }
  return kDone;
}

}  // namespace haptics
