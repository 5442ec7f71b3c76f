#include "graphics_client/application/mesh_importer.h"

#include <QFileInfo>
#include <QHBoxLayout>
#include <QLabel>
#include <QMetaObject>
#include <QProgressBar>
#include <QPushButton>
#include <cmath>
#include <utility>

#include "graphics_client/application/printable_text.h"

namespace haptics {
namespace {

constexpr int kBarSteps = 1000;  // of the bar
constexpr int kBar_px = 160;

QString nameOf(const QString& file) { return text(QFileInfo(file).fileName().toStdString()); }

}  // namespace

MeshImporter::MeshImporter(ServerLink& link, SceneEditor& editor)
    : link_(link), editor_(editor), what_(new QLabel), bar_(new QProgressBar), cancel_(new QPushButton("Cancel")) {
  setObjectName("import");
  what_->setTextFormat(Qt::PlainText);
  bar_->setFixedWidth(kBar_px);
  cancel_->setObjectName("cancel import");
  cancel_->setFocusPolicy(Qt::TabFocus);
  connect(cancel_, &QPushButton::clicked, [this] { cancel(); });
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  for (QWidget* part : {static_cast<QWidget*>(what_), static_cast<QWidget*>(bar_), static_cast<QWidget*>(cancel_)}) {
    layout->addWidget(part);
  }
  hide();
}

void MeshImporter::finish() {
  if (!imports_.empty()) imports_.front()->stop.request_stop();
  imports_.clear();
  pool_.waitForDone();
}

bool MeshImporter::isUnderWay(const std::shared_ptr<Import>& import) const {
  return !imports_.empty() && imports_.front() == import;
}

void MeshImporter::import(const QString& file, std::function<Vec3(Vec3 size_m)> foot) {
  imports_.push_back(std::make_shared<Import>(Import{file, std::move(foot)}));
  if (imports_.size() == 1) begin();
}

void MeshImporter::begin() {
  const auto import = imports_.front();
  show("reading", std::nullopt);
  cancel_->setEnabled(true);
  cancel_->setToolTip("Ends the import; the scene stays as it is");
  pool_.start([this, import] {
    const auto mesh = std::make_shared<Result<LocalMesh>>(
        readMeshFileOfAnyUnit(import->file.toStdString(), import->stop.get_token()));
    QMetaObject::invokeMethod(this, [this, import, mesh] {
      if (isUnderWay(import)) upload(std::move(*mesh));
    });
  });
}

/// Callbacks come on the link's thread, which ends before this does.
void MeshImporter::upload(Result<LocalMesh> mesh) {
  if (!mesh) return fail(mesh.error().text());
  const auto import = imports_.front();
  import->report = mesh->report;
  import->mesh = mesh->asset.hash;
  show("sending", 0);
  link_.upload(mesh->asset.kind, std::move(mesh->asset.bytes),
               {[this, import](std::uint64_t sent_bytes, std::uint64_t total_bytes) {
                  const double share = static_cast<double>(sent_bytes) / static_cast<double>(total_bytes);
                  QMetaObject::invokeMethod(this, [this, import, share] {
                    if (!isUnderWay(import)) return;
                    share < 1 ? show("sending", share) : show("the server checks", std::nullopt);
                  });
                },
                [this, import](const v1::AssetUploadReply& reply) {
                  QMetaObject::invokeMethod(this, [this, import, reply] {
                    if (!isUnderWay(import)) return;
                    const auto sent = outcomeOf(reply, import->file.toStdString());
                    if (sent) return add();
                    fail(sent.error().text());
                  });
                }});
}

void MeshImporter::add() {
  const auto import = imports_.front();
  const MeshReport& report = import->report;
  const Vec3 middle = (report.boxMin_m + report.boxMax_m) / 2.0;
  show("adding", std::nullopt);
  cancel_->setEnabled(false);
  cancel_->setToolTip("The server has the mesh and adds it; Undo takes it back");
  const std::string name = objectNameOf(import->file.toStdString());
  editor_.addMesh(
      name, import->mesh, import->foot(report.boxMax_m - report.boxMin_m) - Vec3(middle.x, middle.y, report.boxMin_m.z),
      [this, import](const v1::EditProgress& progress) {
        const bool builds = progress.stage() == v1::EditProgress::STAGE_BUILDING;
        const QString what = progress.place() > 0 ? QString("waiting for the server, place %1").arg(progress.place())
                                                  : QString("adding");
        if (isUnderWay(import)) show(what, builds ? std::optional(progress.share()) : std::nullopt);
      },
      [this, import](const std::string& object, const Result<v1::Accepted>& outcome) {
        if (!isUnderWay(import)) return;
        if (!outcome) return fail(outcome.error().text());
        QString words = text(import->file.toStdString()) + ": " + text(import->report.text());
        for (const auto& remark : outcome->report()) words += '\n' + text(remark);
        next();
        emit imported(QString::fromStdString(object), words);
      });
}

bool MeshImporter::canCancel() const { return !imports_.empty() && cancel_->isEnabled(); }

void MeshImporter::cancel() {
  if (!canCancel()) return;
  const auto import = imports_.front();
  import->stop.request_stop();
  if (!import->mesh.isZero()) link_.cancelUpload(import->mesh);
  imports_.resize(1);
  fail("was cancelled; nothing was changed");
}

void MeshImporter::startAnew() {
  for (const auto& import : imports_) import->stop.request_stop();
  imports_.clear();
  hide();
}

void MeshImporter::fail(const std::string& why) {
  const QString file = nameOf(imports_.front()->file);
  next();
  emit failed(file, text(why));
}

void MeshImporter::next() {
  imports_.pop_front();
  hide();
  if (!imports_.empty()) begin();
}

void MeshImporter::show(const QString& stage, std::optional<double> share) {
  what_->setText(stage + " " + nameOf(imports_.front()->file));
  bar_->setRange(0, share ? kBarSteps : 0);
  bar_->setValue(share ? static_cast<int>(std::lround(kBarSteps * *share)) : 0);
  setVisible(true);
}

}  // namespace haptics

#include "moc_mesh_importer.cpp"
