#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace haptics {

/// A server that a person connected to.
struct RecentServer {
  std::string address;      ///< "HOST:PORT".
  std::string credentials;  ///< File; empty: none.

  bool operator==(const RecentServer&) const = default;
};

/// The servers that were connected to last, each address once, the newest first.
class RecentServers {
 public:
  static constexpr std::size_t kMax = 10;

  RecentServers() = default;
  /// Newest first, as list() gave them; what is beyond kMax, has no address or comes again is left out.
  explicit RecentServers(const std::vector<RecentServer>& list);

  /// Connected to now: it becomes the first one, with these credentials.
  void add(RecentServer server);
  [[nodiscard]] const std::vector<RecentServer>& list() const noexcept { return list_; }
  /// The credentials file last used for the address; empty: none, or the address is not known.
  [[nodiscard]] std::string credentialsOf(const std::string& address) const;

 private:
  std::vector<RecentServer> list_;
};

}  // namespace haptics
