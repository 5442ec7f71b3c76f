#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "common/telemetry/added_wrench.h"
#include "graphics_client/export/export_session.h"
#include "graphics_client/script/connection.h"

// The verbs of hapticctl. Each prints its result on standard output (JSON when asked for), errors on standard error,
// and returns an ExitCode.
namespace haptics {

struct ApplyOptions {
  std::string scene;                                     ///< File, or "-" for standard input.
  std::map<std::string, std::filesystem::path> uploads;  ///< Local mesh files by the name that the scene gives them.
};

struct WatchOptions {
  double rate_Hz = 10;
  std::optional<double> duration_s;  ///< Without end.
  bool datagrams = false;            ///< By UDP where that goes.
  bool everyTick = false;            ///< All of them, and gaps named, in place of the newest at rate_Hz.
};

struct PushOptions {
  Wrench wrench;
  int hand = 1;  ///< 1 or 2.
  double duration_s = 1;
};

struct ExportOptions {
  std::filesystem::path recording;
  bool live = false;  ///< In place of a recording.
  std::filesystem::path out;
  ExportFormat format = ExportFormat::kHdf5;
  double duration_s = 10;  ///< Of a live session.
};

struct PlotOptions {
  std::filesystem::path recording;  ///< Or a session that was exported as HDF5.
  std::filesystem::path out;        ///< PNG or SVG.
  std::string title;                ///< Empty: of the recording.
};

/// Applies a transaction and waits until it is felt.
int apply(const CommonOptions& common, const ApplyOptions& options);
/// Prints the scene, or its object `name`.
int get(const CommonOptions& common, const std::string& name);
/// Prints telemetry samples as they come; those that come faster than they are printed are skipped, or, where every tick is
/// asked for, named.
int watch(const CommonOptions& common, const WatchOptions& options);
/// Adds a force to what the scene gives a hand, and prints what the hand had of it; a fault ends it.
int push(const CommonOptions& common, const PushOptions& options);
/// Prints the servo's and the server's figures.
int status(const CommonOptions& common);
/// Has the server record the last seconds, and prints where.
int dump(const CommonOptions& common);
/// Moves a hand's workspace and binds its buttons: what is set, the rest stays as it is.
int workspace(const CommonOptions& common, const v1::SetWorkspace& asked);
/// Fetches the whole scene anew, hashes every byte of it and compares with the server's root.
int verify(const CommonOptions& common);

/// Writes every tick of a recording, or of a running server, into a file that others read; no server needed for a recording.
int exportSession(const CommonOptions& common, const ExportOptions& options);
/// Draws a recording's forces, penetration, path, spectrum and energies; no server needed.
int plot(const CommonOptions& common, const PlotOptions& options);

/// Makes the credentials of a server, in a folder that has none.
int credentials(const CommonOptions& common, const std::filesystem::path& folder);

}  // namespace haptics
