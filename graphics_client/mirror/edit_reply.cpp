#include "graphics_client/mirror/edit_reply.h"

#include <string>

namespace haptics {

Result<v1::Accepted> outcomeOf(const v1::EditReply& reply) {
  if (reply.has_accepted()) return reply.accepted();
  if (reply.has_rejected()) return refused(reply.rejected().field(), reply.rejected().reason());
  std::string now;
  for (const auto& object : reply.conflict().current()) {
    now += "; \"" + object.name() + "\" is at revision " + std::to_string(object.revision());
  }
  return refused("preconditions", reply.conflict().reason() + now);
}

}  // namespace haptics
