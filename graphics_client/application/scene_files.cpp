#include "graphics_client/application/scene_files.h"

#include <QFileDialog>
#include <QMessageBox>
#include <memory>
#include <utility>

#include "common/log/log.h"
#include "common/text/printable.h"
#include "graphics_client/editing/scene_file.h"

namespace haptics {
namespace {

const QString kScenes = "Scenes (*.scene)";

}  // namespace

SceneFiles::SceneFiles(QWidget* window, SceneEditor& editor) : window_(window), editor_(editor) {
  files_.setMaxThreadCount(1);
}

void SceneFiles::open() {
  auto* dialog = new QFileDialog(window_, "Open scene", {}, kScenes);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setFileMode(QFileDialog::ExistingFile);
  connect(dialog, &QFileDialog::fileSelected, this, [this](const QString& file) { open(file); });
  dialog->open();
}

void SceneFiles::open(const QString& file) {
  askBeforeLoss("Opening a scene", [this, file] {
    files_.start([this, file, view = editor_.view()] {
      auto edit = std::make_shared<Result<Edit>>(openScene(file.toStdString(), *view->scene));
      QMetaObject::invokeMethod(this, [this, file, edit, view] {
        if (!*edit) return fail("Open scene", edit->error());
        if (editor_.view()->epoch != view->epoch)
          return fail("Open scene", {file.toStdString(), "the server is another one by now; open it again"});
        editor_.open(std::move(**edit), [this, file] {
          file_ = file;
          logInfo("opened " + file.toStdString());
        });
      });
    });
  });
}

void SceneFiles::save(const std::function<void()>& then) {
  if (isRefused()) return;
  if (file_.isEmpty()) return saveAs(then);
  write(file_, editor_.view(), server_, then);
}

void SceneFiles::saveAs(const std::function<void()>& then) {
  if (isRefused()) return;
  askForFile([this, then](const QString& file) { write(file, editor_.view(), server_, then); });
}

void SceneFiles::askForFile(const std::function<void(const QString& file)>& chosen) {
  auto* dialog = new QFileDialog(window_, "Save scene as", {}, kScenes);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setAcceptMode(QFileDialog::AcceptSave);
  dialog->setDefaultSuffix("scene");
  dialog->selectFile(file_.isEmpty() ? "scene.scene" : file_);
  connect(dialog, &QFileDialog::fileSelected, this, chosen);
  dialog->open();
}

/// What is seen is not the server's scene.
bool SceneFiles::isRefused() {
  if (editor_.refusal().empty()) return false;
  emit said("save", QString::fromStdString(editor_.refusal()), true);
  return true;
}

void SceneFiles::write(const QString& file, const std::shared_ptr<const MirrorView>& view, int server,
                       const std::function<void()>& then) {
  const auto state = editor_.state();
  files_.start([this, file, then, state, server, view] {
    auto saved = std::make_shared<Result<void>>(saveScene(*view, file.toStdString()));
    QMetaObject::invokeMethod(this, [this, file, then, state, server, saved] {
      if (!*saved) return fail("Save scene", saved->error());
      logInfo("saved " + file.toStdString());
      emit said("save", file + " is written", false);
      if (server != server_) return;
      file_ = file;
      editor_.markSaved(state);
      if (!then) return;
      if (editor_.isSaved()) return then();
      emit said("save", "edits that the server has not answered yet are in no file", true);
    });
  });
}

void SceneFiles::askBeforeLoss(const QString& what, const std::function<void()>& then) {
  if (editor_.isSaved()) return then();
  auto* question = new QMessageBox(QMessageBox::Question, "Save the scene?",
                                   what + " leaves edits of yours behind that are in no file. Save the scene first?",
                                   QMessageBox::Save | QMessageBox::Discard | QMessageBox::Cancel, window_);
  question->setAttribute(Qt::WA_DeleteOnClose);
  question->setDefaultButton(QMessageBox::Save);
  logInfo("asks: " + question->text().toStdString());
  connect(question, &QMessageBox::finished, this, [this, then](int answer) {
    if (answer == QMessageBox::Save) save(then);
    if (answer == QMessageBox::Discard) then();
  });
  question->open();
}

void SceneFiles::follow() {
  const auto view = editor_.view();
  if (view->epoch == 0) return;
  const auto before = std::exchange(shown_, view);
  if (!before || before->epoch == view->epoch) return;
  const bool isSaved = editor_.isSaved();
  const int server = server_;
  emit restarted();
  const QString words = "The server was started anew, and its own scene is shown.";
  emit said("connection", words, false);
  if (isSaved) return;
  auto* question =
      new QMessageBox(QMessageBox::Question, "Save what was shown before?",
                      words + " Edits of yours that are in no file are not in it. Save the scene as it was before?",
                      QMessageBox::Save | QMessageBox::Discard, window_);
  question->setAttribute(Qt::WA_DeleteOnClose);
  question->setDefaultButton(QMessageBox::Save);
  logInfo("asks: " + question->text().toStdString());
  connect(question, &QMessageBox::finished, this, [this, before, server](int answer) {
    if (answer != QMessageBox::Save) return;
    askForFile([this, before, server](const QString& file) { write(file, before, server, {}); });
  });
  question->open();
}

void SceneFiles::fail(const QString& what, const Error& error) {
  const QString words = QString::fromStdString(printable(error.text()));
  emit said(what, words, true);
  auto* warning = new QMessageBox(QMessageBox::Warning, what, words, QMessageBox::Ok, window_);
  warning->setAttribute(Qt::WA_DeleteOnClose);
  warning->open();
}

}  // namespace haptics

#include "moc_scene_files.cpp"
