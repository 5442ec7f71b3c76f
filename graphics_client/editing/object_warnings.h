#pragma once

#include <map>
#include <string>
#include <vector>

#include "haptics/v1/envelope.pb.h"

namespace haptics {

/// What the server warned of in its replies to this user's edits, by object.
class ObjectWarnings {
 public:
  /// Takes in the warnings of a reply. Of an object of which only pose or colour are others than before, it says none,
  /// and those from before hold.
  void add(const v1::Accepted& accepted);
  /// Without the object's name.
  [[nodiscard]] const std::vector<std::string>& of(const std::string& object) const;

 private:
  struct Known {
    std::string warnedOf;  // the object's properties but for pose and colour, serialised
    std::vector<std::string> warnings;
  };
  std::map<std::string, Known> known_;
};

}  // namespace haptics
