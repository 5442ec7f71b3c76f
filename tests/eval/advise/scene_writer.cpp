#include "tests/eval/advise/scene_writer.h"

#include <google/protobuf/text_format.h>

#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <stdexcept>

#include "common/text/plain_text.h"
#include "common/wire/convert.h"
#include "graphics_client/editing/named_assets.h"
#include "haptic_server/scene/asset_folders.h"
#include "tests/eval/advise/ply_file.h"
#include "tests/eval/advise/verdict.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/report.h"

namespace haptics::eval {
namespace {

namespace fs = std::filesystem;
namespace pb = google::protobuf;
using Tree = pb::TextFormat::ParseInfoTree;

std::string readText(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in) throw std::runtime_error(file.string() + ": cannot be read");
  return text;
}

/// Nothing to be done where the same bytes are there.
void writeNew(const fs::path& file, const std::string& bytes) {
  if (fs::exists(file)) {
    if (readText(file) == bytes) return;
    throw std::runtime_error("--apply: " + file.string() +
                             " is there already and holds something else; remove it, or name another folder");
  }
  fs::create_directories(file.parent_path());
  std::ofstream out(file, std::ios::binary);
  out << bytes;
  out.close();
  if (!out) throw std::runtime_error(file.string() + ": cannot be written");
}

/// A part of a text to be replaced.
struct Span {
  std::size_t begin = 0, end = 0;
};

/// As the tokenizer counts: lines and columns from 0, a tab up to the next multiple of 8.
std::size_t offsetOf(const std::string& text, pb::TextFormat::ParseLocation place) {
  constexpr int kTab = 8;
  std::size_t at = 0;
  for (int line = 0; line < place.line; ++line) at = text.find('\n', at) + 1;
  for (int column = 0; column < place.column; ++at) column += text[at] == '\t' ? kTab - column % kTab : 1;
  return at;
}

Span spanOf(const std::string& text, const Tree& tree, const pb::FieldDescriptor* field) {
  const auto range = tree.GetLocationRange(field, -1);
  return {offsetOf(text, range.start), offsetOf(text, range.end)};
}

/// A scene file: what it says, and where.
class SceneText {
 public:
  explicit SceneText(const fs::path& file) : text_(orThrow(plainLines(readText(file)))) {
    pb::TextFormat::Parser parser;
    parser.WriteLocationsTo(&tree_);
    if (!parser.ParseFromString(text_, &scene_)) throw std::runtime_error(file.string() + ": is no scene file");
  }
  /// Of an object, by the last operation that gives it one.
  void replaceMesh(const std::string& object, const std::string& file) {
    Given given = lastThatGives(object, "mesh", "remesh");
    replace(*given.where, given.field, "mesh { file: \"" + file + "\" }");
    given.holder->GetReflection()->ClearField(given.holder, given.field);  // no file is needed for it any more
  }
  /// Likewise, of a tool.
  void replaceSpacing(const std::string& tool, double spacing_m) {
    const Given given = lastThatGives(tool, "motion", "set_motion");
    const auto* inMotion = v1::Motion::descriptor()->FindFieldByName("tool");
    const Tree* where = given.where->GetTreeForNested(given.field, -1)->GetTreeForNested(inMotion, -1);
    std::ostringstream text;
    text.precision(17);
    text << "spacing_m: " << spacing_m;
    replace(*where, v1::Tool::descriptor()->FindFieldByName("spacing_m"), text.str());
  }
  void append(const std::string& operation) { appended_ += operation; }

  [[nodiscard]] std::string text() const {
    std::string edited = text_;
    for (auto at = replaced_.rbegin(); at != replaced_.rend(); ++at) {
      const auto& [span, with] = at->second;
      edited.replace(span.begin, span.end - span.begin, with);
    }
    return edited + appended_;
  }
  /// That are named still, below the asset folders.
  [[nodiscard]] std::vector<std::string> files() {
    std::vector<std::string> files;
    orThrow(forEachReference(scene_, [&files](const AssetReference& reference) -> Result<void> {
      if (!reference.file().empty()) files.push_back(reference.file());
      return {};
    }));
    return files;
  }

 private:
  struct Replacement {
    Span span;
    std::string with;
  };
  std::string text_;
  v1::Transaction scene_;
  Tree tree_;
  std::map<std::size_t, Replacement> replaced_;  // by where it begins
  std::string appended_;

  /// A field of an operation, and where the operation's text is.
  struct Given {
    pb::Message* holder;
    const pb::FieldDescriptor* field;
    const Tree* where;
  };
  /// The last operation that gives an object this: one that adds it, or this one.
  Given lastThatGives(const std::string& object, const char* what, const char* operationName) {
    for (int i = scene_.operations_size() - 1; i >= 0; --i) {
      v1::Operation& operation = *scene_.mutable_operations(i);
      const auto* given = operation.GetDescriptor()->FindFieldByName(operationName);
      const pb::Reflection& reflection = *operation.GetReflection();
      const bool isAdded = operation.has_add() && operation.add().name() == object;
      if (!isAdded && !reflection.HasField(operation, given)) continue;
      const auto* of = isAdded ? operation.GetDescriptor()->FindFieldByName("add") : given;
      pb::Message* holder = reflection.MutableMessage(&operation, of);
      const auto* field = holder->GetDescriptor()->FindFieldByName(what);
      if (!isAdded && nameIn(*holder) != object) continue;
      if (!holder->GetReflection()->HasField(*holder, field)) continue;
      const Tree* where = tree_.GetTreeForNested(scene_.GetDescriptor()->FindFieldByName("operations"), i);
      return {holder, field, where->GetTreeForNested(of, -1)};
    }
    throw std::runtime_error("--apply: no operation gives object \"" + object + "\" a " + what +
                             " by its name; name it in " + operationName + ", not its id");
  }
  static std::string nameIn(const pb::Message& holder) {
    const auto* object = holder.GetDescriptor()->FindFieldByName("object");
    return static_cast<const v1::ObjectRef&>(holder.GetReflection()->GetMessage(holder, object)).name();
  }
  void replace(const Tree& where, const pb::FieldDescriptor* field, std::string with) {
    const Span span = spanOf(text_, where, field);
    replaced_[span.begin] = {span, std::move(with)};
  }
};

std::string materialOperation(const std::string& object, const MaterialOption& option) {
  std::ostringstream text;
  text.precision(17);
  text << "\n# Its own stiffness and damping are not steady.\noperations {\n  set_material {\n    object { name: \""
       << object << "\" }\n    material { stiffness_N_per_m: " << option.stiffness_N_per_m
       << " damping_Ns_per_m: " << option.damping_Ns_per_m << " }\n  }\n}\n";
  return text.str();
}

/// The written scene has to hold what was judged.
std::vector<LoadedObject> readWritten(const SceneAdvice& advice, const fs::path& file) {
  auto objects = orThrow(loadScene(file.string(), {}));
  if (advice.tool && advice.tool->replacesSpacing()) {
    const auto tool = std::ranges::find_if(objects, &LoadedObject::held);
    const double advised_m = advice.tool->candidates[advice.tool->advised].spacing_m;
    if (tool == objects.end() || tool->motion->tool->spacing_m != advised_m)
      throw std::runtime_error(file.string() + ": the tool has another spacing than was judged");
  }
  for (const ObjectAdvice& object : advice.objects) {
    if (!object.verdict.use) continue;
    const auto written = std::ranges::find(objects, object.name, &LoadedObject::name);
    if (written != objects.end() && *written->mesh == *object.mesh().mesh) continue;
    throw std::runtime_error(file.string() + ": object \"" + object.name + "\" has another mesh than was judged");
  }
  return objects;
}

}  // namespace

void checkApply(const fs::path& scene, const fs::path& folder) {
  if (!fs::is_regular_file(scene)) {
    throw std::runtime_error("--apply: " + scene.string() +
                             " is no file that could be written anew; give a scene file");
  }
  const fs::path file = folder / scene.filename();
  if (!fs::exists(file)) return;
  throw std::runtime_error("--apply: " + file.string() +
                           " is there already and is not replaced; remove it, or name another folder");
}

std::vector<LoadedObject> writeAdvised(const SceneAdvice& advice, const fs::path& scene,
                                       const std::vector<fs::path>& assets, const fs::path& folder) {
  SceneText text(scene);
  std::vector<fs::path> folders{fs::absolute(scene).parent_path()};
  folders.insert(folders.end(), assets.begin(), assets.end());
  makeFolder(folder);
  if (advice.tool && advice.tool->replacesSpacing()) {
    text.replaceSpacing(advice.tool->name, advice.tool->candidates[advice.tool->advised].spacing_m);
  }
  for (const ObjectAdvice& object : advice.objects) {
    if (object.verdict.use) {
      text.replaceMesh(object.name, meshFileOf(object));
      writeNew(folder / meshFileOf(object), plyOf(*object.mesh().mesh));
    }
    if (!object.judged() || object.ownOption().steadyFrom()) continue;
    const MaterialOption& option = advice.optionOf(object);
    if (option.steadyFrom()) text.append(materialOperation(object.name, option));
  }
  for (const std::string& name : text.files()) {
    const LocatedFile found = orThrow(AssetFolders(folders).locate(name, scene.string()));
    writeNew(folder / name, readText(found.file));
  }
  const fs::path file = folder / scene.filename();
  writeNew(file, text.text());
  return readWritten(advice, file);
}

}  // namespace haptics::eval
