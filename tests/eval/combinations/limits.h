#pragma once

#include <array>
#include <string_view>

#include "tests/eval/combinations/pair.h"

namespace haptics::eval {

/// The most that a pair may come to, by what is measured.
struct Limit {
  Measure measure;
  double most;
  std::string_view shown;  ///< In words and in the picture's unit.
  double unit;             ///< Of the picture, in that of the measure.
  std::string_view why;
};

inline constexpr std::array<Limit, kMeasureNames.size()> kLimits{
    Limit{Measure::kBadTicks, 0, "bad ticks", 1, "a force is always finite, and there where the reference has one"},
    Limit{Measure::kStep_N, 0.03, "step, mN", 1e-3,
          "what the runtime lets an edit change the force by in a tick (30 N/s); a plain surface adds no step of its "
          "own"},
    Limit{Measure::kFalseForce_N, 0.01, "false > 100 Hz, mN", 1e-3,
          "a fifth of the least force that a hand notices, 0.05 N"},
    Limit{Measure::kForce, 0.01, "force, %", 1e-2, "a seventh of the 7 % that a hand notices (Pang et al. 1991)"},
    Limit{Measure::kDirection_deg, 0.25, "direction, deg", 1,
          "what shading leaves of a soft sphere of 1,728 triangles, whose facets differ by 7 degrees"},
    Limit{Measure::kHeight, 0.01, "height, %", 1e-2, "the paper's 4.3.1: the same contact point has the same height"},
    Limit{Measure::kFriction, 0.01, "friction, %", 1e-2, "Coulomb's law with the map's coefficient where it slides"},
    Limit{Measure::kLoop_J, 10e-6, "loop, uJ", 1e-6,
          "springs give back what they took; what rounding and one tick's steps leave is far less"},
    Limit{Measure::kTrajectory, 0.01, "trajectory, %", 1e-2,
          "Newton's law, integrated 20 times as finely; the runtime's own step is of first order"}};

[[nodiscard]] constexpr const Limit& limitOf(Measure measure) { return kLimits[static_cast<std::size_t>(measure)]; }

/// What must fail where something is switched off, and in one of which measures.
struct AblationCase {
  Ablation ablation;
  std::string_view name;
  std::string_view about;
  std::array<Measure, 2> measures;
  std::array<std::pair<Feature, Feature>, 7> pairs;
  std::size_t count;
};

inline constexpr std::array kAblations{
    AblationCase{
        Ablation::kFieldsAtDisplacedPoints,
        "fields_at_displaced_points",
        "texture and friction maps looked up at the displaced IHIP instead of the material point: their fields "
        "are replaced by displaced ones",
        {Measure::kHeight, Measure::kFriction},
        {{{Feature::kTexture, Feature::kSoftness},
          {Feature::kTexture, Feature::kPlastic},
          {Feature::kTexture, Feature::kLattice},
          {Feature::kFriction, Feature::kSoftness},
          {Feature::kFriction, Feature::kPlastic},
          {Feature::kFriction, Feature::kLattice}}},
        6},
    AblationCase{Ablation::kFacets,
                 "facets",
                 "soft bodies are built without shading normals",
                 {Measure::kDirection_deg, Measure::kFalseForce_N},
                 {{{Feature::kShading, Feature::kSoftness}, {Feature::kShading, Feature::kPlastic}}},
                 2},
    AblationCase{Ablation::kMuAtIhip,
                 "mu_at_ihip",
                 "friction's coefficients follow the IHIP while it sticks: the stick-slip law beside the step, edited "
                 "in each tick",
                 {Measure::kLoop_J, Measure::kLoop_J},
                 {{{Feature::kTexture, Feature::kFriction},
                   {Feature::kShading, Feature::kFriction},
                   {Feature::kFriction, Feature::kSoftness},
                   {Feature::kFriction, Feature::kPlastic},
                   {Feature::kFriction, Feature::kLattice}}},
                 5},
    AblationCase{Ablation::kFirstNormal,
                 "first_normal",
                 "friction in a groove from the sum of the forces and the first body's coefficient: computed from "
                 "telemetry",
                 {Measure::kFriction, Measure::kFriction},
                 {{{Feature::kFriction, Feature::kSeveral}}},
                 1}};

}  // namespace haptics::eval
