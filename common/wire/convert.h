#pragma once

#include <string_view>
#include <vector>

#include "common/error/error.h"
#include "common/scene/scene.h"
#include "common/telemetry/added_wrench.h"
#include "common/telemetry/hand_command.h"
#include "common/telemetry/motion_state.h"
#include "common/telemetry/telemetry_sample.h"
#include "haptics/v1/envelope.pb.h"
#include "haptics/v1/scene.pb.h"
#include "haptics/v1/telemetry.pb.h"

// Between the wire's messages and the program's own types. Everything that comes from the wire is checked here: finite
// numbers, ranges, counts, known enum values, sizes of hashes; errors name the field's path
// ("operations[2].set_material.material.stiffness_N_per_m") and what would be right. Whether an object exists is the
// sequencer's question.
namespace haptics {

/// Limits on untrusted edits; above, the field is refused.
inline constexpr std::size_t kMaxOperations = 1000;
inline constexpr std::size_t kMaxNameLength = 64;
inline constexpr std::size_t kMaxPathLength = 255;
inline constexpr std::uint32_t kMaxSegments = 1024;  ///< A sphere has then 12.6 million triangles.
inline constexpr std::size_t kMaxSceneTextBytes = 4U << 20;
inline constexpr double kMaxCoordinate_m = 1e3;
inline constexpr double kMinLength_m = 1e-9;            ///< The square of an area is then a normal float.
inline constexpr double kMinWavelength_m = 1e-5;        ///< A tenth of what a finger can feel.
inline constexpr double kMinTextureAmplitude_m = 1e-9;  ///< A tenth of the finest ridge that a finger has felt.
inline constexpr double kMaxTextureAmplitude_m = 0.1;
inline constexpr double kMinGainK = 1e-3;
inline constexpr double kMaxGainK = 2;               ///< Paper, below Eq. (4b).
inline constexpr std::size_t kMaxFourierTerms = 64;  ///< Each costs the tick some 20 ns.
inline constexpr std::size_t kMaxCreases = 1000;
inline constexpr std::size_t kMaxLayers = 4;  ///< Of a field: each costs the tick what it costs alone.

/// Rotations come out normalised. Fields that this version does not know are refused: an edit that is half understood
/// must not be answered with "accepted".
[[nodiscard]] Result<Transaction> fromWire(const v1::Transaction& message);
/// Numbers are kept bit for bit (also a rotation's length), so that both sides hash the same.
[[nodiscard]] Result<ObjectRecord> fromWire(const v1::ObjectState& message);
[[nodiscard]] Result<Commit> fromWire(const v1::Commit& message);
/// Of a client that leads: position, normal and force are checked.
[[nodiscard]] Result<HandCommand> fromWire(const v1::HandTarget& message);
[[nodiscard]] Result<WorkspaceCommand> fromWire(const v1::SetWorkspace& message);
[[nodiscard]] Result<Wrench> fromWire(const v1::AddWrench& message);
[[nodiscard]] Result<ContentHash> hashFromWire(const std::string& bytes, const std::string& field);
[[nodiscard]] Result<AssetKind> assetKindFromWire(v1::AssetKind kind, const std::string& field);
/// Unknown enum values in telemetry are ignored (kNone); numbers are taken as they are, also non-finite ones.
[[nodiscard]] TelemetrySample fromWire(const v1::Telemetry& message);

void toWire(const ObjectRecord& record, v1::ObjectState& message);
void toWire(const HandCommand& command, v1::HandTarget& message);
void toWire(const Commit& commit, v1::Commit& message);
/// A number of v1::Material, of which its option `scalar` says unit and range.
[[nodiscard]] const google::protobuf::FieldDescriptor& materialScalar(std::string_view name);
[[nodiscard]] std::size_t wireSizeOf(const ObjectRecord& record);  ///< Bytes of its ObjectState.
void toWire(const TelemetrySample& sample,
            v1::Telemetry& message);  ///< No bodies, no dents. Reuses the message's memory.
/// The sample of a second hand, of the same tick, after the first's. What is not of a hand but of the servo is left out.
void toWireOfSecondHand(const TelemetrySample& sample, v1::Telemetry& message);
/// Nothing: the server has one hand.
[[nodiscard]] std::optional<TelemetrySample> secondHandFromWire(const v1::Telemetry& message);

void toWire(const EnergySource& source, v1::FeatureEnergy& message);
/// Nothing for a feature that this build does not know.
[[nodiscard]] std::optional<EnergySource> fromWire(const v1::FeatureEnergy& message);
void toWire(const Pose& pose, v1::Pose& message);
/// Bit for bit.
[[nodiscard]] Result<Pose> poseFromWire(const v1::Pose& message, const std::string& field);
/// The bodies that a sample tells of; those whose pose is no pose, and more than kMaxMovingBodies, are left out.
[[nodiscard]] std::vector<BodyState> bodiesFromWire(const v1::Telemetry& message);
void toWire(const BodyState& body, v1::BodyPose& message);
/// None where the message has none, or one with a number that cannot be.
[[nodiscard]] std::optional<ToolState> toolFromWire(const v1::Telemetry& message);
void toWire(const ToolState& tool, v1::ToolContact& message);
/// The dents that a sample tells of; what is no dent, and more than kMaxDentsOfAll, are left out.
[[nodiscard]] std::vector<ObjectDent> dentsFromWire(const v1::Telemetry& message);
void toWire(const ObjectDent& dent, v1::Dent& message);

/// A message in text format, in a file of plainLines(); a scene file is a Transaction. Errors name `origin`, line, column, the bad field and, where a
/// field is unknown, the fields that there are. Only the form is checked; fromWire checks the values.
[[nodiscard]] Result<void> parseMessageText(const std::string& file, const std::string& origin,
                                            google::protobuf::Message& message);
[[nodiscard]] Result<void> readMessageFile(const std::string& path, google::protobuf::Message& message);
[[nodiscard]] Result<v1::Transaction> parseSceneText(const std::string& text, const std::string& origin);
[[nodiscard]] Result<v1::Transaction> readSceneFile(const std::string& path);  ///< "-": standard input.

}  // namespace haptics
