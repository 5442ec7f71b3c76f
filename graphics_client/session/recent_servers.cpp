#include "graphics_client/session/recent_servers.h"

#include <algorithm>
#include <utility>

namespace haptics {

RecentServers::RecentServers(const std::vector<RecentServer>& list) {
  for (auto server = list.rbegin(); server != list.rend(); ++server) {
    if (!server->address.empty()) add(*server);
  }
}

void RecentServers::add(RecentServer server) {
  std::erase_if(list_, [&](const RecentServer& known) { return known.address == server.address; });
  list_.insert(list_.begin(), std::move(server));
  if (list_.size() > kMax) list_.pop_back();
}

std::string RecentServers::credentialsOf(const std::string& address) const {
  const auto known = std::ranges::find(list_, address, &RecentServer::address);
  return known == list_.end() ? std::string() : known->credentials;
}

}  // namespace haptics
