#include "graphics_client/application/scene_editor.h"

#include <QMetaObject>
#include <utility>

#include "common/assets/asset_content.h"
#include "common/text/printable.h"
#include "common/wire/convert.h"
#include "graphics_client/editing/scene_file.h"
#include "graphics_client/editing/scene_text.h"

namespace haptics {
namespace {

constexpr double kSize_m = SceneEditor::kSize_m;

/// @return Its height, metres.
double generate(const std::string& kind, v1::MeshSource& mesh) {
  if (kind == "sphere") mesh.mutable_sphere()->set_radius_m(kSize_m / 2);
  if (kind == "box") {
    v1::Vector3& size = *mesh.mutable_box()->mutable_size_m();
    size.set_x(kSize_m);
    size.set_y(kSize_m);
    size.set_z(kSize_m);
  }
  if (kind == "cylinder") {
    mesh.mutable_cylinder()->set_radius_m(kSize_m / 2);
    mesh.mutable_cylinder()->set_height_m(kSize_m);
  }
  if (kind == "torus") {
    mesh.mutable_torus()->set_major_radius_m(kSize_m / 3);
    mesh.mutable_torus()->set_minor_radius_m(kSize_m / 6);
    return kSize_m / 3;
  }
  return kSize_m;
}

/// The server's warnings, without what it tells of meshes and fields.
QString wordsOf(const v1::Accepted& accepted) {
  QString words = "done";
  for (const std::string& line : accepted.report()) {
    if (line.find(": warning: ") != std::string::npos) words += "\n" + QString::fromStdString(printable(line));
  }
  return words;
}

QString listed(const std::set<std::string>& objects) {
  return objects.size() == 1 ? QString::fromStdString(printable(*objects.begin()))
                             : QString("%1 objects").arg(objects.size());
}

}  // namespace

SceneEditor::SceneEditor(QObject* window, ServerLink& link, Say say, Accepted accepted, std::function<void()> changed)
    : window_(window),
      link_(link),
      say_(std::move(say)),
      accepted_(std::move(accepted)),
      history_(port(std::move(changed))) {}

/// Callbacks come on the link's thread, which ends before the application does.
EditPort SceneEditor::port(std::function<void()> changed) {
  const auto here = [this](auto callback) -> decltype(callback) {
    if (!callback) return nullptr;
    return [this, callback, server = std::weak_ptr(server_)](const auto&... arguments) {
      QMetaObject::invokeMethod(window_, [callback, server, arguments...] {
        if (!server.expired()) callback(arguments...);
      });
    };
  };
  return {.view = [this] { return link_.latest(); },
          .submit =
              [this, here](v1::Transaction transaction, EditCallbacks callbacks) {
                if (!refusal_.empty()) {
                  v1::EditReply reply;
                  reply.mutable_rejected()->set_reason(refusal_);
                  return here(std::move(callbacks.replied))(reply);
                }
                link_.submit(std::move(transaction), {.replied = here(std::move(callbacks.replied)),
                                                      .live = here(std::move(callbacks.live)),
                                                      .stateLost = here(std::move(callbacks.stateLost)),
                                                      .progress = here(std::move(callbacks.progress))});
              },
          .upload =
              [this, here](const AssetContent& content, UploadCallbacks callbacks) {
                if (!refusal_.empty()) {
                  v1::AssetUploadReply reply;
                  reply.set_reason(refusal_);
                  return here(std::move(callbacks.finished))(reply);
                }
                UploadCallbacks answers{.progress = here(std::move(callbacks.progress)),
                                        .finished = here(std::move(callbacks.finished))};
                encoding_.start([this, content, answers = std::move(answers)] {
                  link_.upload(kindOf(content), canonicalBytes(content).copy(), answers);
                });
              },
          .changed = std::move(changed)};
}

EditDone SceneEditor::said(const QString& edit) {
  return [this, edit](const Result<v1::Accepted>& outcome) {
    say_(edit, outcome ? wordsOf(*outcome) : QString::fromStdString(printable(outcome.error().text())), !outcome);
    if (outcome) accepted_(*outcome);
  };
}

void SceneEditor::drag(const QString& edit, const Edit& value) {
  if (!drag_ || dragged_ != edit) {
    dragged_ = edit;
    drag_.emplace(history_, edit.toStdString(), said(edit));
  }
  drag_->set(value);
}

void SceneEditor::submit(const QString& edit, v1::Operation operation) {
  Edit made;
  *made.transaction.add_operations() = std::move(operation);
  submit(edit, std::move(made));
}

void SceneEditor::submit(const QString& edit, Edit made) {
  made.text = edit.toStdString();
  history_.submit(std::move(made), said(edit));
}

std::string SceneEditor::freeName(const SceneVersion& scene, const std::string& wanted) {
  std::string name = wanted;
  for (int i = 2; scene.find(name) || given_.contains(name); ++i) name = wanted + "-" + std::to_string(i);
  given_.insert(name);
  return name;
}

std::string SceneEditor::add(const std::string& kind, Vec3 foot) {
  v1::Operation operation;
  v1::AddObject& add = *operation.mutable_add();
  add.set_name(freeName(*link_.latest()->scene, kind));
  const double height_m = generate(kind, *add.mutable_mesh());
  v1::Vector3& position = *add.mutable_pose()->mutable_position();
  position.set_x(foot.x);
  position.set_y(foot.y);
  position.set_z(foot.z + height_m / 2);
  std::string name = add.name();
  submit("add " + QString::fromStdString(name), std::move(operation));
  return name;
}

void SceneEditor::addMesh(const std::string& wantedName, const ContentHash& mesh, Vec3 position_m,
                          std::function<void(const v1::EditProgress&)> progress,
                          std::function<void(const std::string& name, const Result<v1::Accepted>&)> done) {
  Edit edit;
  v1::AddObject& add = *edit.transaction.add_operations()->mutable_add();
  add.set_name(freeName(*link_.latest()->scene, wantedName));
  add.mutable_mesh()->set_asset(mesh.asBytes());
  v1::Vector3& position = *add.mutable_pose()->mutable_position();
  position.set_x(position_m.x);
  position.set_y(position_m.y);
  position.set_z(position_m.z);
  edit.text = "import " + add.name();
  edit.progress = std::move(progress);
  const std::string name = add.name();
  history_.submit(std::move(edit),
                  [name, done = std::move(done)](const Result<v1::Accepted>& outcome) { done(name, outcome); });
}

void SceneEditor::duplicate(const std::set<std::string>& objects) {
  std::map<std::string, std::string> names;
  Edit made;
  for (const std::string& object : objects) {
    const auto& [of, name] = *names.emplace(object, freeName(*link_.latest()->scene, object)).first;
    made.of.insert({of, name});
  }
  made.compose = [names](const MirrorView& view) -> Result<v1::Transaction> {
    v1::Transaction transaction;
    for (const auto& [object, name] : names) {
      const auto record = view.scene->find(object);
      if (!record) return refused("", "there is no " + object);
      v1::AddObject& add = *transaction.add_operations()->mutable_add();
      add = additionOf(*record);
      add.set_name(name);
      v1::Vector3& position = *add.mutable_pose()->mutable_position();
      position.set_x(position.x() + kSize_m);
    }
    return transaction;
  };
  submit("duplicate " + listed(objects), std::move(made));
}

void SceneEditor::remove(const std::set<std::string>& objects) {
  Edit made;
  for (const std::string& object : objects)
    made.transaction.add_operations()->mutable_remove()->mutable_object()->set_name(object);
  submit("delete " + listed(objects), std::move(made));
}

void SceneEditor::rename(const std::string& object, const std::string& wanted, const std::function<void()>& done) {
  const QString edit = "rename " + QString::fromStdString(printable(object));
  const Composer compose = [object, wanted](const MirrorView& view) -> Result<v1::Transaction> {
    const auto record = view.scene->find(object);
    if (!record) return refused("", "there is no such object");
    v1::Transaction transaction;
    transaction.add_operations()->mutable_remove()->mutable_object()->set_name(object);
    v1::AddObject& add = *transaction.add_operations()->mutable_add();
    add = additionOf(*record);
    add.set_name(wanted);
    return transaction;
  };
  Edit made{.text = edit.toStdString(), .compose = compose, .of = {object, wanted}};
  history_.submit(std::move(made), [done, say = said(edit)](Result<v1::Accepted> outcome) {
    if (outcome) done();
    if (!outcome && outcome.error().field.ends_with(".name")) outcome.error().field = "name";
    say(outcome);
  });
}

void SceneEditor::open(Edit edit, const std::function<void()>& done) {
  const int removals = removalsBefore(edit);
  history_.submit(std::move(edit), [this, done, removals, say = said("open")](Result<v1::Accepted> outcome) {
    if (!outcome) outcome.error() = asInFile(std::move(outcome).error(), removals);
    say(outcome);
    if (!outcome) return;
    markSaved(state());
    done();
  });
}

void SceneEditor::advance() {
  history_.advance();
  if (history_.isSettled()) given_.clear();
}

void SceneEditor::startAnew() {
  given_.clear();
  server_ = std::make_shared<int>();
  finishDrag();
  history_.clear();
}

}  // namespace haptics
