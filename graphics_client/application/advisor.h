#pragma once

#include <QProcess>
#include <QTemporaryDir>
#include <QThreadPool>
#include <QWidget>
#include <map>
#include <memory>
#include <string>

#include "common/error/error.h"
#include "common/scene/scene.h"
#include "graphics_client/mirror/mirror_view.h"

class QLabel;

namespace haptics {

/// Asks for advice on the scene, which `haptic_eval advise` gives in a process of its own. Shows how far that is, with a button
/// that ends it; hidden while there is nothing to do.
class Advisor : public QWidget {
  Q_OBJECT

 public:
  Advisor();
  ~Advisor() override { finish(); }

  /// On all objects of the view; one that is under way already goes on.
  void ask(const std::shared_ptr<const MirrorView>& view);
  void cancel();
  [[nodiscard]] bool isBusy() const { return asked_ != nullptr; }
  void finish();
  /// Empty: nobody asked, or the object is another one by now.
  [[nodiscard]] QString adviceOn(const ObjectRecord& object) const;

 signals:
  void said(const QString& what, const QString& words, bool isError);

 private:
  QLabel* what_;
  QThreadPool writer_;
  QProcess process_;
  std::unique_ptr<QTemporaryDir> folder_;         // of the one that is under way
  std::shared_ptr<const SceneVersion> asked_;     // likewise
  std::shared_ptr<const SceneVersion> answered_;  // that `advice_` is on
  std::map<std::string, std::string> advice_;

  void start(const Result<void>& saved);
  void takeAnswer(int exitCode, bool hasCrashed);
  void fail(const QString& why);
  void end();
};

}  // namespace haptics
