#include "graphics_client/viewer/run_summary.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "common/json/json.h"
#include "common/telemetry/body_json.h"
#include "common/telemetry/hand_command.h"

namespace haptics {

double percentile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  const double rank = std::ceil(std::clamp(q, 0.0, 1.0) * static_cast<double>(values.size()));
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(std::max(rank, 1.0)) - 1;
  std::ranges::nth_element(values, nth);
  return *nth;
}

void RunSummary::addFrame(std::shared_ptr<const MirrorView> view, double age_s, double time_s) {
  if (frames_++ == 0) firstFrame_s_ = time_s;
  lastFrame_s_ = time_s;
  newest_ = std::move(view);
  if (newest_->link != LinkState::kLive) return;
  newestLive_ = newest_;
  if (newest_->sample) ages_ms_.add(age_s * 1e3);
}

std::optional<double> RunSummary::addContact(const MirrorView& shown) {
  std::optional<double> largest_m;
  for (std::size_t hand = 0; hand < kMaxLedHands; ++hand) {
    const TelemetrySample* sample = shown.link == LinkState::kLive ? shown.felt(hand) : nullptr;
    const auto error_m = sample != nullptr ? contactError_.of_m(shown, *sample) : std::nullopt;
    if (!error_m) continue;
    contactErrors_mm_.add(*error_m * 1e3);
    largest_m = std::max(largest_m.value_or(0), *error_m);
  }
  return largest_m;
}

void RunSummary::Newest::add(double value) {
  values.push_back(value);
  if (values.size() > kAgesKept) values.pop_front();
}

namespace {

Json spread(const std::deque<double>& newest) {
  const std::vector<double> values(newest.begin(), newest.end());
  return {{"p50", percentile(values, 0.5)}, {"p99", percentile(values, 0.99)}};
}

}  // namespace

std::string RunSummary::json() const {
  const double span_s = lastFrame_s_ - firstFrame_s_;
  std::optional<ContentHash> own;
  Json bodies = Json::array();
  if (newestLive_) {
    if (const auto root = recomputedRoot(*newestLive_)) own = *root;
    for (const auto& [id, body] : newestLive_->bodies) bodies.push(bodyJson(body));
  }
  Json summary = {
      {"viewer_frames", frames_},
      {"fps", span_s > 0 ? static_cast<double>(frames_ - 1) / span_s : 0.0},
      {"client_scene_hash", own ? own->hex() : ""},
      {"client_bodies", bodies},
      {"scene_revision", newestLive_ ? newestLive_->scene->revision() : 0},
      {"hashes_equal", own && newestLive_->hashesEqual && *own == newestLive_->scene->root()},
      {"telemetry_age_ms", spread(ages_ms_.values)},
      {"contact_error_mm", spread(contactErrors_mm_.values)},
      {"telemetry_by_datagram", newestLive_ && newestLive_->telemetryByDatagram},
      {"forged_datagrams", newest_ ? newest_->forgedDatagrams : 0},
      {"resyncs", newest_ ? newest_->resyncs : 0},
      {"state_resets", newest_ ? newest_->stateResets : 0},
  };
  if (newestLive_) {
    if (const auto deformed = deformedHash(*newestLive_)) summary.set("client_deformed_hash", deformed->hex());
    summary.set("client_dents", newestLive_->dents.size());
  }
  return summary.indented() + "\n";
}

}  // namespace haptics
