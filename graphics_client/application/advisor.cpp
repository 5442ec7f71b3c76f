#include "graphics_client/application/advisor.h"

#include <QCoreApplication>
#include <QFile>
#include <QFileInfo>
#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QStandardPaths>
#include <utility>

#include "common/log/log.h"
#include "graphics_client/application/advice.h"
#include "graphics_client/application/printable_text.h"
#include "graphics_client/editing/scene_file.h"

namespace haptics {
namespace {

constexpr int kEndWithin_ms = 2000;

/// Beside this program, else where programs are.
QString evaluator() {
  const QFileInfo beside(QCoreApplication::applicationDirPath() + "/haptic_eval");
  return beside.isExecutable() ? beside.filePath() : QStandardPaths::findExecutable("haptic_eval");
}

}  // namespace

Advisor::Advisor() : what_(new QLabel) {
  setObjectName("advice");
  what_->setTextFormat(Qt::PlainText);
  auto* cancelling = new QPushButton("Cancel");
  cancelling->setObjectName("cancel advice");
  cancelling->setAccessibleName("Cancel advice");
  cancelling->setToolTip("Ends the trials; the scene stays as it is");
  cancelling->setFocusPolicy(Qt::TabFocus);
  connect(cancelling, &QPushButton::clicked, [this] { cancel(); });
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(what_);
  layout->addWidget(cancelling);
  connect(&process_, &QProcess::readyReadStandardError, [this] {
    const QStringList lines = QString::fromUtf8(process_.readAllStandardError()).split('\n', Qt::SkipEmptyParts);
    for (const QString& line : lines) {
      what_->setText("advice: " + text(line.toStdString()));
      logInfo(what_->text().toStdString());
    }
  });
  connect(&process_, qOverload<int, QProcess::ExitStatus>(&QProcess::finished),
          [this](int exitCode, QProcess::ExitStatus status) { takeAnswer(exitCode, status == QProcess::CrashExit); });
  hide();
}

void Advisor::ask(const std::shared_ptr<const MirrorView>& view) {
  if (asked_) return;
  folder_ = std::make_unique<QTemporaryDir>();
  if (!folder_->isValid()) return fail(folder_->errorString());
  asked_ = view->scene;
  what_->setText("advice: writing the scene ...");
  show();
  writer_.start([this, view, file = folder_->filePath("advised.scene").toStdString(), asked = asked_] {
    auto saved = std::make_shared<Result<void>>(saveScene(*view, file));
    QMetaObject::invokeMethod(this, [this, saved, asked] {
      if (asked_ == asked) start(*saved);
    });
  });
}

void Advisor::start(const Result<void>& saved) {
  if (!saved) return fail(text(saved.error().text()));
  const QString program = evaluator();
  if (program.isEmpty()) return fail("needs haptic_eval, which is not installed (package haptics-tools)");
  what_->setText("advice: trying the objects ...");
  process_.setWorkingDirectory(folder_->path());
  process_.setStandardOutputFile(QProcess::nullDevice());
  process_.start(program, {"advise", "advised.scene", "--out", "advice"});
  if (!process_.waitForStarted(kEndWithin_ms)) fail(process_.errorString());
}

/// Exit status 1 is advice too: that something fails.
void Advisor::takeAnswer(int exitCode, bool hasCrashed) {
  if (!asked_) return;  // it was cancelled
  QFile file(folder_->filePath("advice/advise.json"));
  if (hasCrashed || exitCode > 1 || !file.open(QIODevice::ReadOnly)) {
    return fail("haptic_eval advise ended with status " + QString::number(exitCode) + ", " + what_->text());
  }
  auto advice = adviceIn(file.readAll().toStdString());
  if (!advice) return fail(text(advice.error().text()));
  advice_ = *std::move(advice);
  answered_ = asked_;
  end();
  logInfo("advice is here");
  emit said("advice", "is beside the properties of each object", false);
}

void Advisor::cancel() {
  if (!asked_) return;
  end();
  logInfo("advice was cancelled");
  emit said("advice", "was cancelled", false);
}

void Advisor::finish() {
  if (asked_) end();
}

void Advisor::fail(const QString& why) {
  end();
  emit said("advice", why, true);
}

void Advisor::end() {
  asked_ = nullptr;
  hide();
  writer_.waitForDone();
  process_.terminate();
  if (!process_.waitForFinished(kEndWithin_ms)) process_.kill();
  process_.waitForFinished();
  folder_.reset();
}

QString Advisor::adviceOn(const ObjectRecord& object) const {
  const auto at = advice_.find(object.name);
  if (at == advice_.end()) return {};
  const SceneVersion::Object then = answered_->find(object.id);
  const bool isSame = then && then->mesh == object.mesh && then->material == object.material &&
                      then->motion == object.motion && then->deformation == object.deformation;
  return isSame ? text(at->second) : QString();
}

}  // namespace haptics

#include "moc_advisor.cpp"
