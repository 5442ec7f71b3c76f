#pragma once

#include <bitset>
#include <set>
#include <string>
#include <vector>

#include "common/error/error.h"
#include "common/scene/scene.h"
#include "haptics/v1/envelope.pb.h"
#include "haptics/v1/scene.pb.h"

// What an edit does to objects, by their names: ids and revisions are others when an object is added again. An object's
// content is its record but for these two.
namespace haptics {

using PropertySet = std::bitset<64>;

/// An object that a transaction names.
struct EditedObject {
  std::string name;
  SceneVersion::Object before;  ///< Null: it is not there.
  PropertySet properties;       ///< That the transaction sets; all of an object that it adds or removes.
  bool isRemoved = false;       ///< After the transaction.
};
/// The objects in order of name. One that the scene does not have under the given id is left out.
[[nodiscard]] std::vector<EditedObject> objectsEditedBy(const v1::Transaction& transaction, const SceneVersion& scene);

/// An object before and after an edit; null where it is not there. The two differ in what the edit did and in nothing
/// that others did meanwhile.
struct ObjectChange {
  std::string name;
  SceneVersion::Object before, after;
};
using Changes = std::vector<ObjectChange>;

/// \param before  As the object stood before the edit, perhaps with properties that others have changed since.
/// \param after   As the edit's reply has it.
[[nodiscard]] ObjectChange changeOf(const EditedObject& edited, const SceneVersion::Object& before,
                                    SceneVersion::Object after);
/// Two successive edits as one. What comes back to what it was is no change.
[[nodiscard]] Changes joined(Changes first, const Changes& second);
[[nodiscard]] Changes reversed(Changes changes);
[[nodiscard]] bool isChange(const ObjectChange& change);

/// Refused: the scene's objects are not what they are before the changes, so that the changes would overwrite what
/// somebody else did. The field names the object. A residue may be another: the server itself changes it.
/// \param skipped  Objects that may stand otherwise by an edit of this user's own that is not undone.
[[nodiscard]] Result<void> checkApplies(const Changes& changes, const SceneVersion& scene,
                                        const std::set<std::string>& skipped);
/// Makes the changes, on condition that each object still stands as the scene has it. The changes apply to the scene.
[[nodiscard]] v1::Transaction transactionFor(const Changes& changes, const SceneVersion& scene);

}  // namespace haptics
